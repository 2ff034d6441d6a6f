//! What was found, as plain tests.
#![allow(clippy::unreadable_literal)] // as they were found

use super::kind::Contacts;
use super::mixed::{Mixed, Rolling};
use super::steps::Budget;
use super::steps::Step::{Friction, Jacobian, Mass, Push, PushOn, PushRow, Reset, Resume, Solve};
use super::{Machine, limits};
use crate::support::sizes::{block, joints};
use nalgebra::{SMatrix, SVector, matrix, vector};
use stiction::{AdmmFactor, AdmmSolver, Contact, Error, Factor, Kernel, Settings, Solver};

/// Squares of the impulses to expect overflow: nothing is solved, but what is said is made of numbers.
#[test]
fn a_push_beyond_all_squares_gives_numbers() -> Result<(), Error> {
    let mut kernel = Kernel::<f64, 3, 3, 3>::new();
    let scene = kernel.scene_mut();
    scene.set_mass(&matrix![1.252_279, 0.0, 0.0; 0.0, 0.012_399, 0.0; 0.0, 0.0, 0.012_399])?;
    scene.push(&Contact {
        jacobian: matrix![
            0.0, 1.0, -1.004_497_572_191_590_7;
            0.0, 0.0, -1.200_548_914_731_759;
            0.350_631_397_096_667_1, 0.0, 0.0],
        offset: SVector::zeros(),
        mu: 0.0,
        key: 0,
    })?;
    let push = vector![0.0, -7.904_247_334_010_491e154, 0.0];
    let solution = kernel.solve(&push, &Settings::new(1e-9))?;
    assert!(!solution.is_solved());
    let impulses = solution.contacts.iter().flat_map(|contact| contact.impulse.iter());
    assert!(impulses.chain(&solution.velocity).all(|x| x.is_finite()));
    Ok(())
}

/// As many numbers as a step has, the last ones 0.
fn x(first: &[f64]) -> Vec<f64> {
    let mut numbers = first.to_vec();
    numbers.resize(25, 0.0);
    numbers
}

/// `mu` of 740 makes much of the rounding of a tangential velocity.
#[rustfmt::skip]
#[test]
fn what_rounding_hides_adds_to_the_error() {
    Machine::<f32, 3, 3, 3, 0, 0, Contacts>::run(&[
        Mass(x(&[-1.583591737080326, -0.9658260387186285, -1.0, 0.0, 0.026399904748452843, 1.0948133543024854, 0.0, 0.0, 0.5189435549053397]), false),
        Push(x(&[1.9803086853282255, -0.7308775310744455, -1.2011677980238635, -0.8993885420561415, -1.0, 1.8608866295700728, 1.0, -0.523096918656791, -1.3826930521908989, 0.16943150611832838, -1.5632038357968274, 1.4243721437745809]), 740.1684912092335, 0),
        Solve(x(&[-1.351156082075636, 0.6552778988707735, 1.5465688286515078]), Budget { work: 2000, tolerance: 0.0001, relaxed: false, }),
        Solve(x(&[]), Budget { work: 2000, tolerance: 1e-9, relaxed: false, })
    ]);
}

/// Velocities were corrected by the rounding of 1e45, and the work of later impulses was taken from them.
#[rustfmt::skip]
#[test]
fn a_glitch_of_1e45_misleads_no_later_solve() {
    Machine::<f64, 3, 3, 4, 6, 4, Mixed>::run(&[
        Mass(x(&[0.8194268272254307, -0.3879757745454079, -0.11700068388422108, 0.0, -0.9713051196393891, 0.24349204887415887, 0.0, 0.0, -0.893741945225507]), false),
        Push(x(&[-0.5909313180068164, 1.424425254319236, 0.0, 0.942578421829609, 0.0, 1.0741892490153588, 0.20736050564541342, -0.9282081893341084, 0.053567215374140366]), 1.1711575055487398, 0),
        PushRow(x(&[0.0, -0.8756862956906004]), ( 2, 0.0, 0.6086845438722791), 0.21725030376635424, 0),
        Reset,
        Push(x(&[0.6401591011552774, 1.81631259111544, -0.8284831258010659, -1.969415615867161, 0.7741594546575962, -1.0, 0.8319116538041096, 0.0, 1.5170043153986739]), 1.4985398788665227, 0),
        Reset,
        PushRow(x(&[-1.0, 1.0310051721375668, 1.1813984094153112]), ( 2, -0.7497105728511586, 0.0), 0.0, 0),
        Reset,
        Reset,
        Jacobian( 3, x(&[])),
        Resume(x(&[9.982167284416664e44, -1.0000000000000001e45, 1.6771802824616396e43]), Budget { work: 1, tolerance: 1e-9, relaxed: false, }),
        Solve(x(&[0.0, 1.8377820974445767]), Budget { work: 2000, tolerance: 1e-9, relaxed: false, }),
        Solve(x(&[]), Budget { work: 2000, tolerance: 1e-9, relaxed: false, })
    ]);
}

/// The same, with the limits of a solve.
#[rustfmt::skip]
#[test]
fn a_glitch_of_1e52_misleads_no_solve_with_limits() {
    limits::run::<f64, 3, 4, 6>(&[
        Mass(x(&[-1.5397036824005719, 0.47718675648405273, 0.0, 0.0, 1.3198239845641573, 0.18259509349568348, 0.0, 0.0, 1.0]), false),
        Push(x(&[-1.7689587335859693, -1.8060277616507139, 0.0, 0.3332659131062118, -0.3090766016375348, 1.0, 1.0806221258432176, 1.7837124972733447, -1.7485801588304537]), 0.7861837522274986, 0),
        PushRow(x(&[-0.3609059671877662, 0.060438414127263584, 1.0]), ( 2, -0.9660590451043438, 0.0), 0.3081963210799245, 0),
        Solve(x(&[0.0, 7.279736045488814e51, 1.460723838645764e52]), Budget { work: 2000, tolerance: 0.5, relaxed: false, }),
        PushRow(x(&[0.0, 0.0, 1.6286179318162404]), ( 1, 0.0, 0.0), 0.0, 0),
        Solve(x(&[0.0, -1.809076000592131]), Budget { work: 2000, tolerance: 1e-9, relaxed: false, })
    ]);
}

/// A surface that rolls and does not rub had a compliance that depended on `set_friction`.
#[rustfmt::skip]
#[test]
fn the_friction_of_a_surface_that_has_none_is_not_replaced() {
    let mut rolls = x(&[0.0, 0.0, 0.13702746339388588]);
    rolls[23] = 0.29690081515778716;
    Machine::<f64, 6, 6, 4, 6, 4, Rolling>::run(&[
        Mass(x(&[0.0, 1.71236889031691]), false),
        PushOn(rolls, vec![0.0, 0.0, 0.0, 0.0, 1.1497405646132748, 0.0, 0.8091341715208179], 0),
        Friction(0, 1.1180643297792927),
        Solve(x(&[0.0, 0.0, -0.8357488011050795]), Budget { work: 1, tolerance: 1e-9, relaxed: false, }),
        Solve(x(&[]), Budget { work: 2000, tolerance: 1e-9, relaxed: false, })
    ]);
}

/// Without joint rows, too, a scene with room for them keeps its promise.
#[rustfmt::skip]
#[test]
fn contacts_alone_are_solved_where_there_is_room_for_joint_rows() {
    Machine::<f32, 3, 3, 4, 6, 4, Mixed>::run(&[
        Mass(x(&[1.8563406526636779,0.0,0.3736062390990114,0.0,0.0,0.0,0.0,0.0,1.1909231065537529]), false),
        Push(x(&[-0.7391231956236529,-0.5594581943203132,-1.0,0.0,-1.6734019915430676,-0.495119869064401,0.6902294021291767,-1.8324426198675745,1.0,-1.2658894258325732,-0.38912059525915915,1.1362140196423591]), 0.3440127528788473, 0),
        Push(x(&[-0.09258822944070272,-1.0,1.571484418239318,1.0,-1.1407566043967228,-0.7289909653180521,-0.639524875895435,-1.5381299596952278,0.6103604719702851,-0.9923928245474715,-1.0,1.0]),0.9982584058945769,0),
        Solve(x(&[0.9765681948294758,-0.5069576692527655,1.0857402666821203]),Budget{work:51,tolerance:1e-9,relaxed:true}),
        Push(x(&[0.7776165778867422,1.0551539684274063,0.0,-0.25091822911222544,0.6191657898009932,1.0,-1.1746772502289888,1.8100984107934293,0.5561703798214152,-1.0,1.0]),0.8847843247921534,0),
        Solve(x(&[0.9195337418984909]),Budget{work:2000,tolerance:0.0001,relaxed:false}),
        Resume(x(&[]),Budget{work:2000,tolerance:1e-9,relaxed:false}),
        Solve(x(&[]),Budget{work:2000,tolerance:1e-9,relaxed:false}),
    ]);
}

/// The impulse that is asked for vanishes in this number type: none was found, and nothing is solved.
#[test]
fn an_impulse_that_vanishes_is_no_solution() -> Result<(), Error> {
    let mut scene = block::Scene::<f32>::new();
    scene.set_mass(&SMatrix::identity())?;
    let jacobian = matrix![1e18, 0.0; 0.0, 1e18];
    scene.push(&Contact { jacobian, offset: vector![0.0, 0.0], mu: 0.0, key: 0 })?;
    let (factor, push) = (AdmmFactor::new(&scene)?, vector![-1e-30, 0.0]);
    let (mut solver, mut admm) = (Solver::new(), AdmmSolver::new());
    let settings = Settings::new(1e-4);
    let solution = solver.solve(&scene, factor.factor(), &push, &settings)?;
    assert!(!solution.is_solved(), "{solution:?}");
    let solution = admm.solve(&scene, &factor, &push, &settings)?;
    assert!(!solution.is_solved(), "{solution:?}");
    Ok(())
}

/// A mass whose reciprocal overflows is the culprit, and not a contact that does not feel it.
#[test]
fn a_mass_that_vanishes_is_named() -> Result<(), Error> {
    let mut scene = joints::Scene::<f32>::new();
    scene.set_mass(&matrix![1.0, 0.0; 0.0, 1e-40])?;
    scene.push(&Contact { jacobian: matrix![1.0, 0.0], offset: vector![0.0], mu: 0.0, key: 0 })?;
    let refused = Factor::new(&scene).err();
    assert_eq!(refused, Some(Error::MassNotPositiveDefinite { dof: 1 }));
    Ok(())
}
