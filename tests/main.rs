//! All tests in one program, a module for each subject: what they share is compiled and linked once.

mod support;

mod alloc;
mod belts;
mod budget;
mod cone;
mod delassus;
mod edits;
mod equivalence;
mod errors;
mod factor;
mod forces;
mod fuzz;
mod hard;
mod helpers;
mod jams;
mod kernel;
mod limits;
mod long_runs;
mod parameters;
mod phases;
mod physics;
mod promise;
mod rest;
mod resume;
mod rows;
mod rows_physics;
mod scenes;
mod sequences;
mod start;
mod surfaces;
mod sweeps;
mod time_stepping;
mod units;
mod warm_start;
mod zero_columns;
