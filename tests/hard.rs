//! Hard scenes, made by hand and drawn at random: the kernel says that it solved each, and a stranger measures that
//! it did.

mod by_hand;

use crate::support::check::{self, DRAWN_F64, F32, F64};
use testbed::generate::{Class, draw, solvable};
use testbed::kernel::smallest;
use testbed::scene_file::SceneFile;
use testbed::solve::Answer;

/// `name: scenes, error to be reached in f64, and in f32`
macro_rules! solved {
    ($($name:ident: $scenes:expr, $double:expr, $single:expr;)*) => {
        $(mod $name {
            use super::*;

            #[test]
            fn in_f64() {
                check::solved(smallest::<f64>, $scenes, $double);
            }

            #[test]
            fn in_f32() {
                check::solved(smallest::<f32>, $scenes, $single);
            }
        })*
    };
}

solved! {
    point_on_a_slope: by_hand::point_on_a_slope(), F64, F32;
    slopes_at_the_friction_angle: solvable(Class::Slope, 60), F64, F32;
    point_in_a_corner: by_hand::point_in_a_corner(), F64, F32;
    friction_from_0_to_10: solvable(Class::MixedFriction, 60), F64, F32;
    same_floor_three_times: by_hand::same_floor_three_times(), F64, F32;
    redundant_contacts: solvable(Class::Redundant, 60), DRAWN_F64, F32;
    heavy_on_light: by_hand::heavy_on_light(), F64, F32;
    stacks: solvable(Class::Stack, 48), F64, F32;
    hands: solvable(Class::Hand, 48), F64, F32;
    sliding_rod: by_hand::sliding_rod(), F64, F32;
    painleve_rods: solvable(Class::Painleve, 60), F64, F32;
    point_in_a_groove: by_hand::point_in_a_groove(), F64, F32;
    wedges: solvable(Class::Wedge, 60), F64, F32;
    point_over_a_floor: by_hand::point_over_a_floor(), F64, F32;
    no_load: solvable(Class::Unloaded, 36), F64, F32;
    all_open: solvable(Class::Open, 36), F64, F32;
    point_in_other_units: by_hand::point_in_other_units(), F64, F32;
    one_dof: solvable(Class::OneDof, 48), F64, F32;
    narrow_walls: by_hand::narrow_walls(), F64, F32;
}

/// One scene of 60 stays unsolved in f32, and nothing else is said of it.
#[test]
fn belts_impacts_and_drawn_narrow_walls() {
    for class in [Class::Moving, Class::Narrow] {
        let scenes = || solvable(class, 60);
        check::solved(smallest::<f64>, scenes(), DRAWN_F64);
        check::honest(smallest::<f32>, scenes(), F32, 59);
    }
}

/// A mass matrix of condition 1e10, rounded to f32, need not be positive definite.
#[test]
fn near_singular_mass() {
    let scenes = |count| solvable(Class::NearSingular, count);
    check::solved(smallest::<f64>, scenes(48), DRAWN_F64);
    check::honest(smallest::<f32>, scenes(200), F32, 50);
}

/// Entries from 1e-12 to 1e12: some leave the range of f32.
#[test]
fn other_units() {
    let scenes = |count| solvable(Class::Scaled, count);
    check::solved(smallest::<f64>, scenes(60), DRAWN_F64);
    check::honest(smallest::<f32>, scenes(200), F32, 180);
}

/// Proofs that any solution is a billion times faster than the walls, in f32 a thousand times.
#[test]
fn closing_walls_are_proved_infeasible() {
    let proved =
        |factor| move |answer: Answer| matches!(answer, Answer::Infeasible { proof } if proof >= factor);
    let drawn = || (0..60).map(|index| draw(Class::Squeeze, 1, index).0);
    let double = |scenes: Vec<SceneFile>| {
        check::all(smallest::<f64>, scenes, F64, |outcome| proved(1e9)(outcome.answer));
    };
    double(by_hand::closing_walls().collect());
    double(drawn().collect());
    check::all(smallest::<f32>, by_hand::closing_walls(), F32, |outcome| proved(1e3)(outcome.answer));
    // A proof is not always to be had from rounded Jacobians; what is said is true.
    let (mut proofs, mut scenes) = (0, 0);
    check::all(smallest::<f32>, drawn(), F32, |outcome| {
        scenes += 1;
        proofs += usize::from(proved(1e3)(outcome.answer));
        match outcome.answer {
            Answer::Infeasible { proof } => proof >= 1e3,
            Answer::Solved => outcome.error <= F32,
            Answer::Unsolved | Answer::Refused(_) => true,
        }
    });
    assert!(proofs >= 36, "{proofs} of {scenes} proved");
}
