//! Solutions survive a way through text, bit by bit.

use nalgebra::{Matrix2, matrix, vector};
use stiction::{Contact, Error, Factor, Scene, Settings, Solution, Solver};

#[test]
fn a_solution_is_read_back_as_it_was_written() -> Result<(), Error> {
    let mut scene = Scene::<f64, 2, 2, 1>::new();
    scene.set_mass(&(Matrix2::identity() * 3.0))?;
    scene.push(&Contact {
        jacobian: matrix![0.0, 1.0; 1.0, 0.0],
        offset: vector![0.0, 0.0],
        mu: 0.3,
        key: 0,
    })?;
    let factor = Factor::new(&scene)?;
    let mut solver = Solver::new();
    let settings = Settings::new(1e-9);
    let solution = solver.solve(&scene, &factor, &vector![0.7, -0.1], &settings)?;

    let text = serde_json::to_string(solution).unwrap();
    let read: Solution<f64, 2, 2, 1> = serde_json::from_str(&text).unwrap();
    assert_eq!(read.velocity, solution.velocity);
    assert_eq!(read.contacts, solution.contacts);
    assert_eq!(read.status, solution.status);

    let text = serde_json::to_string(&settings).unwrap();
    assert_eq!(
        serde_json::from_str::<Settings<f64>>(&text).unwrap(),
        settings
    );
    let text = serde_json::to_string(&Error::InvalidPenalty).unwrap();
    assert_eq!(
        serde_json::from_str::<Error>(&text).unwrap(),
        Error::InvalidPenalty
    );
    Ok(())
}
