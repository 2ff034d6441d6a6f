//! Tests that run long, in one program, a module for each subject: what they share is compiled and linked once. Those that hardly run are in
//! `small`.

#[allow(dead_code, reason = "shared with `small`")]
mod support;

mod anytime;
mod belts;
mod budget;
mod derivative;
mod equivalence;
mod fuzz;
mod hard;
mod long_runs;
mod mixed_scenes;
mod phases;
mod rest;
mod rest_kept;
mod rows_physics;
mod scene_files;
mod scenes;
mod sequences;
mod start;
mod sweeps;
mod time_stepping;
mod velocities;
