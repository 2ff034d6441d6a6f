//! Factors that are hard to compute, or were of another scene.

use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{
    AdmmFactor, Contact, Error, Factor, JointRow, RowLaw, Scene, Settings, Solver, Status, Work,
};

/// A feather twice on the floor beside five blocks: too light for the penalty of all.
#[test]
fn masses_too_unlike_for_a_resolvent_are_solved_all_the_same() -> Result<(), Error> {
    let masses = SVector::<f32, 12>::from_fn(|dof, _| if dof < 2 { 1e-8 } else { 1.0 });
    let mut scene = Scene::<f32, 12, 2, 7>::new();
    scene.set_mass(&SMatrix::from_diagonal(&masses))?;
    for (key, body) in (0..).zip([0, 0, 1, 2, 3, 4, 5]) {
        let mut jacobian = SMatrix::<f32, 2, 12>::zeros();
        (jacobian[(0, 2 * body + 1)], jacobian[(1, 2 * body)]) = (1.0, 1.0);
        scene.push(&Contact {
            jacobian,
            offset: SVector::zeros(),
            mu: 0.5,
            key,
        })?;
    }
    let refused = AdmmFactor::new(&scene).err();
    assert_eq!(refused, Some(Error::InvalidPenalty));
    let mut factor = Factor::empty();
    factor.prepare(&scene)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&scene, &factor, &-masses, &Settings::new(1e-4))?;
    assert_eq!(solution.status, Status::Solved);
    Ok(())
}

/// Where `W` overflows, at one contact among others, nothing can be said of its error.
#[test]
fn an_infinite_delassus_operator_is_refused() -> Result<(), Error> {
    let mut scene = Scene::<f32, 2, 1, 2>::new();
    scene.set_mass(&SMatrix::from_diagonal(&vector![1.0, 1e-12]))?;
    for (key, jacobian) in (0..).zip([matrix![1.0, 0.0], matrix![0.0, 1e14]]) {
        scene.push(&Contact {
            jacobian,
            offset: vector![0.0],
            mu: 0.0,
            key,
        })?;
    }
    let mut factor = Factor::empty();
    assert_eq!(
        factor.prepare(&scene),
        Err(Error::DelassusOutOfRange { contact: 1 })
    );
    assert_eq!(factor.contacts(), 0);
    Ok(())
}

/// A factor that was of more contacts has nothing of them left.
#[test]
fn walls_are_proved_to_close_with_a_factor_that_was_another_scene_s() -> Result<(), Error> {
    let scene = |normals: &[[f64; 2]], offset| -> Result<_, Error> {
        let mut scene = Scene::<f64, 2, 2, 4>::new();
        scene.set_mass(&SMatrix::identity())?;
        for (key, &[x, y]) in (0..).zip(normals) {
            scene.push(&Contact {
                jacobian: matrix![x, y; y, -x],
                offset: vector![offset, 0.0],
                mu: 0.3,
                key,
            })?;
        }
        Ok(scene)
    };
    let mut factor = Factor::empty();
    factor.prepare(&scene(
        &[[1.0, 0.0], [1.0, 0.0], [-3.0, 0.0], [-3.0, 0.0]],
        0.0,
    )?)?;
    let walls = scene(&[[1.0, 0.0], [-1.0, 0.0]], -1.0)?;
    factor.prepare(&walls)?;
    let mut solver = Solver::new();
    let solution = solver.solve(&walls, &factor, &vector![-0.1, -0.05], &Settings::default())?;
    assert_eq!(solution.status, Status::Infeasible);
    Ok(())
}

/// Of contacts and joint rows: a scene and a factor from numbers solve to the same bits, and those that are not full have none.
#[test]
fn a_factor_of_joint_rows_goes_by_way_of_its_numbers() -> Result<(), Error> {
    let mass = matrix![2.0, 0.3, 0.0; 0.3, 1.0, 0.1; 0.0, 0.1, 0.5];
    let contact = Contact {
        jacobian: matrix![0.0, 1.0, 0.2; 1.0, 0.0, -0.4],
        offset: vector![0.01, 0.0],
        mu: 0.5,
        key: 3,
    };
    let (lower, upper) = (-0.05, 0.05);
    let rows = [(RowLaw::Limit, 0.0), (RowLaw::Box { lower, upper }, 0.25)];
    let rows = rows.map(|(law, compliance)| JointRow {
        row: vector![0.3, -0.2, 1.0],
        offset: -0.02,
        law,
        compliance,
        key: 4,
    });
    let mut scene = Scene::<f64, 3, 2, 1, 2>::new();
    scene.set_mass(&mass)?;
    scene.push(&contact)?;
    scene.push_row(&rows[0])?;
    assert!(Factor::new(&scene)?.parts().is_none());
    scene.push_row(&rows[1])?;
    let factor = Factor::new(&scene)?;
    let parts = factor.parts().expect("all places are taken");
    let baked = (
        Scene::<_, 3, 2, 1, 2>::from_parts(mass, [contact], rows),
        Factor::from_parts(&parts),
    );
    let [mut one, mut other] = [Solver::new(), Solver::new()];
    for push in [vector![0.5, -0.4, 0.1], vector![0.6, -0.5, -0.1]] {
        let settings = Settings::new(1e-10);
        let one = one.solve(&scene, &factor, &push, &settings)?;
        let other = other.solve(&baked.0, &baked.1, &push, &settings)?;
        assert!(one.is_solved());
        assert_eq!((one.velocity, one.work), (other.velocity, other.work));
        assert_eq!(one.contacts[..], other.contacts[..]);
        assert_eq!(one.rows[..], other.rows[..]);
    }
    Ok(())
}

/// What a scene of constants says of its rows was checked by nobody.
#[test]
fn a_row_of_constants_that_cannot_be_is_refused() {
    let between = |lower, upper| RowLaw::Box { lower, upper };
    let row = |law, compliance| JointRow {
        row: vector![1.0],
        offset: 0.0,
        law,
        compliance,
        key: 0,
    };
    let (bounds, compliance) = (
        Error::InvalidBounds { row: 1 },
        Error::InvalidRowCompliance { row: 1 },
    );
    let good = row(RowLaw::Limit, 0.0);
    for (bad, error) in [
        (row(between(1.0, -1.0), 0.0), bounds),
        (row(between(f64::NAN, 1.0), 0.0), bounds),
        (row(between(-1.0, f64::NAN), 0.0), bounds),
        (row(between(-1.0, f64::INFINITY), 0.0), bounds),
        (row(RowLaw::Limit, -0.1), compliance),
        (row(RowLaw::Equality, f64::NAN), compliance),
    ] {
        let rows = [good.clone(), bad];
        let scene = Scene::<f64, 1, 1, 0, 2>::from_parts(matrix![1.0], [], rows);
        let mut factor = Factor::empty();
        if factor.prepare(&scene).is_ok() {
            let mut solver = Solver::new();
            let refused = solver.solve(&scene, &factor, &vector![0.0], &Settings::default());
            assert_eq!(refused.err(), Some(error));
        }
    }
}

/// Numbers from outside may be too large to be added up.
#[test]
fn numbers_from_outside_do_not_overflow() -> Result<(), Error> {
    let mut scene = Scene::<f64, 1, 1, 1>::new();
    scene.set_mass(&matrix![2.0])?;
    scene.push(&Contact {
        jacobian: matrix![1.0],
        offset: vector![0.0],
        mu: 0.0,
        key: 0,
    })?;
    let factor = Factor::new(&scene)?;
    assert_eq!((factor.contacts(), factor.rows()), (1, 0));
    let mut parts = factor.parts().expect("all places are taken");
    parts.moved = usize::MAX;
    let (factor, mut solver) = (Factor::from_parts(&parts), Solver::new());
    let solution = solver.solve(&scene, &factor, &vector![-1.0], &Settings::default())?;
    assert_eq!(solution.status, Status::Solved);
    let most = usize::MAX;
    let work = Work {
        iterations: most,
        sweeps: most,
        chord_steps: most,
        newton_steps: most,
        proof_searches: most,
    };
    assert_eq!(work.total(), most);
    Ok(())
}
