//! Scenes with joint rows, from files and drawn: what is solved, and what is said of it.
#![allow(clippy::float_cmp)] // a bound, to the last bit

use stiction::{Real, Settings, Status};
use testbed::format;
use testbed::generate;
use testbed::kernel::Answer;
use testbed::mixed::{self, Joint, MixedFile, Times};
use testbed::{mixed_measure, scene_file};

/// The bundled scenes with joint rows, compliance or shapes of friction.
fn files() -> Vec<MixedFile> {
    let paths = scene_file::json_files(&scene_file::repository().join("tests/mixed"));
    let read = |path: std::path::PathBuf| format::read(&path).expect("it can be read");
    let files: Vec<_> = paths.into_iter().flat_map(read).collect();
    assert_eq!(files.len(), 13);
    files
}

type Solve = fn(&MixedFile, &Settings<f64>, u32) -> Result<(Answer, Times), String>;

/// The largest work of the bundled scenes to a tolerance, all of which are solved, or proved infeasible.
fn work<T: Real>(solve: Solve, tolerance: f64) -> usize {
    let mut most = 0;
    for file in files() {
        let (answer, _) = solve(&file, &Settings::new(tolerance), 1).expect("a size is compiled");
        if file.name.starts_with("infeasible") {
            assert_eq!(answer.status, Status::Infeasible, "{}", file.name);
            let (normals, joints) = (&answer.certificate, &answer.certificate_lambda);
            assert!(mixed_measure::proves(&file, normals, joints), "{}", file.name);
            continue;
        }
        let file = file.rounded::<T>();
        let error = mixed_measure::error(&file, &answer.v, &answer.r, &answer.lambda);
        assert_eq!(answer.status, Status::Solved, "{}: {error:.1e}", file.name);
        assert!(error <= tolerance, "{}: {error:.1e}", file.name);
        assert!(answer.error >= error * 0.99, "{}: {} {error}", file.name, answer.error);
        most = most.max(answer.work.total());
    }
    most
}

#[test]
fn bundled_scenes_are_solved_in_double_precision() {
    assert!(work::<f64>(mixed::solve::<f64>, 1e-9) <= 160);
    assert!(work::<f64>(mixed::solve::<f64>, 1e-4) <= 160);
}

#[test]
fn bundled_scenes_are_solved_in_single_precision() {
    assert!(work::<f32>(mixed::solve::<f32>, 1e-4) <= 130);
}

/// Bounds are scaled for the method, and an impulse at its bound is written as it was given.
#[test]
fn an_impulse_lies_within_its_bounds_to_the_last_bit() {
    let joint = |kind: &str, offset: f64, bound: f32| Joint {
        kind: kind.to_owned(),
        row: vec![1.0],
        offset,
        lower: Some(f64::from(-bound)),
        upper: Some(f64::from(bound)),
        compliance: 0.0,
    };
    let mut reached = 0;
    for k in 0..400_u16 {
        let scale = 1.0 + f32::from(k) / 400.0;
        let file = MixedFile {
            name: String::new(),
            n_dof: 1,
            n_contacts: 0,
            dim: 3,
            mass: vec![vec![f64::from(0.176_375_69_f32 * scale)]],
            h: Vec::new(),
            f: vec![-f64::from(0.198_515_74_f32)],
            w: Vec::new(),
            mu: Vec::new(),
            joints: vec![joint("box", -1.0, 74.886_39 * scale), joint("equality", 0.0, 0.0)],
            compliance: Vec::new(),
            keys: Vec::new(),
            time_step: None,
            limits_inside: true,
        };
        let settings = Settings::new(1e-4);
        let solved = mixed::solve::<f32>(&file, &settings, 1);
        let (answer, _) = solved.expect("a size is compiled");
        let error = mixed_measure::error(&file, &answer.v, &answer.r, &answer.lambda);
        let is_solved = answer.status == Status::Solved;
        assert!(!is_solved || error <= f64::from(1e-4_f32), "{k}: {error:e}");
        let upper = file.joints[0].upper.expect("a box");
        assert!(answer.lambda[0].abs() <= upper, "{k}: beyond its bound");
        reached += usize::from(is_solved && answer.lambda[0] == upper);
    }
    assert!(reached > 50, "{reached} of 400 at their bounds");
}

/// One rigid contact of one coefficient and no joint row, pushed with a surface, on masses of condition 1e10: momenta are compared
/// with those that there are, as of any other contact.
#[test]
fn a_rigid_surface_loosens_no_dynamics() {
    let tolerance = f64::from(1e-4_f32);
    let settings = Settings { budget: 2_000, ..Settings::new(1e-4) };
    for (index, step) in [(46_630, 3), (55_420, 0), (83_973, 2)] {
        let files = generate::time_steps(4, index);
        let answers = mixed::solve_all::<f32>(&files, &settings);
        let file = files[step].rounded::<f32>();
        let is_soft = file.compliance.iter().flatten().any(|&soft| soft > 0.0);
        assert!(file.n_contacts == 1 && file.joints.is_empty() && !is_soft);
        let answer = answers[step].as_ref().expect("numbers in range");
        let error = mixed_measure::error(&file, &answer.v, &answer.r, &answer.lambda);
        let is_solved = answer.status == Status::Solved;
        assert!(!is_solved || error <= tolerance, "{index}: {error:e}");
    }
}
