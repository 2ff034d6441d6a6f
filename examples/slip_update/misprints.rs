//! What the note's misprints cost.

use crate::library::{self, Method};
use crate::note::{Acceleration, Printed, Slip, Variant};
use crate::{CAP, by_note, heading, row};
use testbed::scene_file::SceneFile;

pub(crate) fn tables(scenes: &[SceneFile]) {
    heading(
        "The note as printed (`s` at every iteration, of `ũ`)",
        "| method | as printed | solved to 1e-3 | median | 90 % | solved to 1e-6 | median | 90 % |",
    );
    let nothing = Printed::default();
    let step_2 = Printed { step_2: true, ..nothing };
    let extrapolation = Printed { extrapolation: true, ..nothing };
    let restart = Printed { restart: true, ..nothing };
    let both = Printed { step_2: true, ..extrapolation };
    let all = Printed { restart: true, ..both };
    let rows = [
        (Method::Fast, Acceleration::Fast, "nothing: the library", nothing),
        (Method::Fast, Acceleration::Fast, "step 2 (`ũ`)", step_2),
        (Method::Fast, Acceleration::Fast, "steps 6-7 (from `û`, `ζ̂`)", extrapolation),
        (Method::Fast, Acceleration::Fast, "all", both),
        (Method::Restart, Acceleration::Restart, "nothing: the library", nothing),
        (Method::Restart, Acceleration::Restart, "steps 10-13 (restart from the previous)", restart),
        (Method::Restart, Acceleration::Restart, "step 2 (`ũ`)", step_2),
        (Method::Restart, Acceleration::Restart, "steps 7-8 (from `û`, `ζ̂`)", extrapolation),
        (Method::Restart, Acceleration::Restart, "all", all),
    ];
    for (method, acceleration, what, printed) in rows {
        let variant = Variant { acceleration, slip: Slip::Projected, printed };
        let run = |tolerance| by_note(scenes, variant, tolerance, CAP);
        row(library::name(method), what, run);
    }
}
