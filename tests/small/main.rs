//! Tests of small scenes, in one program: of many sizes, which are compiled without optimisation, for they hardly run.

#[allow(dead_code, reason = "shared with the tests that run long")]
#[path = "../support/mod.rs"]
mod support;

mod alloc;
mod cone;
mod delassus;
mod derivative;
mod edits;
mod errors;
mod factor;
mod forces;
mod helpers;
mod jams;
mod kernel;
mod large_friction;
mod limits;
mod loads;
mod parameters;
mod physics;
mod promise;
mod resume;
mod rows;
mod squeezes;
mod surfaces;
mod tray;
mod units;
mod warm_start;
mod wheels;
mod zero_columns;
