//! Shares out a wanted wrench over the four feet of a standing quadruped: with friction cones by this crate, and as a quadratic
//! programme with four-sided pyramids by Clarabel.
//!
//! `min ½ |A f - b|²_S + ½ α |f|²` over foot forces `f` in their cones, as "Sharing out forces" in the guide has it. The
//! wrench `b` carries the weight and pushes sideways. Asked is, direction by direction, how large a push is shared out, what a floor makes of
//! forces of the pyramid around the cone, and what a tick costs. Before that `grasps` asks how far the forces of a control loop are from the
//! least ones, on random grasps with and without limits of torque.
//!
//! `cargo run --release -p forces [FILE.svg]`

mod grasps;
mod judge;
mod programme;
mod recipe;
mod scene;

use judge::{missed, objective, on_floor, reach, worst_foot};
use nalgebra::{SMatrix, SVector, vector};
use pictures::{curve, panel};
use programme::{Programme, Shape};
use scene::{MU, WEIGHT};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;
use stiction::Kernel;

/// `α`: what small foot forces are worth beside an exact wrench.
const ALPHA: f64 = 1e-3;

/// Foot forces (N), foot by foot, normal first.
type Forces = SVector<f64, 12>;
/// Force (N) and moment (N·m) on the body.
type Wrench = SVector<f64, 6>;
/// `A`, which maps foot forces to their wrench about the centre of mass.
type Grasp = SMatrix<f64, 6, 12>;
type Cones = Kernel<f64, 6, 3, 4, 0, 4>;

/// Carries the weight and pushes with so much of what friction holds, at an angle in degrees.
fn wanted(push: f64, angle: f64) -> Wrench {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let push = push * MU * WEIGHT;
    vector![push * cosine, push * sine, WEIGHT, 0.0, 0.0, 0.0]
}

/// By this crate; the free impulse is `-b`.
fn share(cones: &mut Cones, b: &Wrench, tolerance: f64) -> Forces {
    let solution = cones.solve(&-b, &scene::settings(tolerance));
    let solution = solution.expect("the data is finite");
    assert!(solution.is_solved(), "{}", solution.status);
    Forces::from_iterator(solution.contacts.iter().flat_map(|foot| foot.impulse.data.0[0]))
}

/// Median time of a tick, µs: one for each whole angle.
fn time(mut tick: impl FnMut(f64)) -> f64 {
    let mut times: Vec<_> = (0..360_u32)
        .map(|angle| {
            let start = Instant::now();
            tick(f64::from(angle));
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn main() -> Result<(), Box<dyn Error>> {
    grasps::compare()?;
    let mut filled = Cones::new();
    scene::fill(filled.scene_mut(), ALPHA, MU)?;
    let mut grasp = Grasp::zeros();
    for (i, foot) in filled.scene().contacts().iter().enumerate() {
        grasp.fixed_columns_mut::<3>(3 * i).copy_from(&foot.jacobian.transpose());
    }
    let programme = |shape| {
        let programme = Programme::new(&grasp, shape);
        move |b: &Wrench| programme.solve(b, 1e-8)
    };
    let exactly = Programme::new(&grasp, Shape::Cone);
    let [outer, inner] = [Shape::Outer, Shape::Inner].map(programme);

    println!("       largest push (mu m g)   0.9 by the outer pyramid");
    println!("angle   cone  outer  inner   worst foot  missed on a floor");
    let mut cones = filled.clone();
    let [mut circle, mut around, mut within, mut asked, mut held] = [const { Vec::new() }; 5];
    let mut excess = [0.0_f64; 2];
    for angle in (0..=360).step_by(3) {
        let degrees = f64::from(angle);
        let b = wanted(0.9, degrees);
        let (ours, theirs, pyramid) = (share(&mut cones, &b, 1e-10), exactly.solve(&b, 1e-13), outer(&b));
        let [least, other] = [&ours, &theirs].map(|forces| objective(&grasp, forces, &b));
        excess = [excess[0].max(other / least - 1.0), excess[1].max(1.0 - other / least)];
        held.push((degrees, worst_foot(&ours)));
        asked.push((degrees, worst_foot(&pyramid)));
        circle.push((degrees, reach(&grasp, degrees, |b| share(&mut cones, b, 1e-6))));
        around.push((degrees, reach(&grasp, degrees, &outer)));
        within.push((degrees, reach(&grasp, degrees, &inner)));
        if angle % 15 == 0 && angle <= 90 {
            let reached = [&circle, &around, &within].map(|reached| reached[reached.len() - 1].1);
            let [circle, around, within] = reached;
            let slipping = missed(&grasp, &on_floor(&pyramid), &b);
            println!(
                "{angle:4}°  {circle:.3}  {around:.3}  {within:.3}   {:10.3}  {slipping:17.3}",
                worst_foot(&pyramid)
            );
        }
    }
    let [higher, lower] = excess;
    println!("with cones Clarabel's objective is higher by at most {higher:.0e}, lower by {lower:.0e}\n");

    println!("µs a tick:  cones, cold  warm   Clarabel: cones  pyramids   work, cold and warm");
    for push in [0.3, 0.6, 0.9, 1.2] {
        let (mut works, mut cones) = ([0; 2], filled.clone());
        let times = [
            time(|angle| {
                let mut cold = filled.clone();
                black_box(share(&mut cold, &wanted(push, angle), 1e-6));
                works[0] += cold.solution().work.total();
            }),
            time(|angle| {
                black_box(share(&mut cones, &wanted(push, angle), 1e-6));
                works[1] += cones.solution().work.total();
            }),
            time(|angle| _ = black_box(programme(Shape::Cone)(&wanted(push, angle)))),
            time(|angle| _ = black_box(programme(Shape::Outer)(&wanted(push, angle)))),
        ];
        let [cold, warm, cone, pyramid] = times;
        let [colds, warms] = works.map(|work| work / 360);
        println!(
            "push {push}         {cold:5.1} {warm:5.1}             {cone:5.1}     {pyramid:5.1}   {colds:3} {warms:3}"
        );
    }

    pictures::draw(
        "forces",
        &[
            panel(
                "The largest push that is shared out",
                "direction (degrees)",
                "push / (mu m g)",
                [
                    curve("friction cones", circle),
                    curve("pyramids around them", around),
                    curve("pyramids within them", within),
                ],
            ),
            panel(
                "What the foot is asked for that is asked for most, at 0.9",
                "direction (degrees)",
                "|f_T| / (mu f_N)",
                [curve("friction cones", held), curve("pyramids around them", asked)],
            ),
        ],
    )
}
