//! Draws what the robot did: a filmstrip with the forces on its feet, and forces and slip over time.

use crate::robot::LEGS;
use crate::world::{EDGE, RISE, STEP, Tick};
use nalgebra::{Vector3, vector};
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use stiction::ContactMode;

const STICK: RGBColor = RGBColor(31, 119, 180);
const SLIP: RGBColor = RGBColor(230, 110, 10);
const PUSH: RGBColor = RGBColor(180, 30, 40);
const GROUND: RGBColor = RGBColor(215, 210, 200);
const BAND: RGBColor = RGBColor(238, 238, 232);
const TORSO: RGBColor = RGBColor(200, 205, 215);
const NEAR: RGBColor = RGBColor(40, 40, 45);
const FAR: RGBColor = RGBColor(165, 165, 175);
/// Length of an arrow (m/N).
const ARROW: f64 = 3e-3;
/// Ticks that are drawn as one.
const BIN: usize = 10;

/// What is drawn, and when (s).
const MOMENTS: [(f64, &str); 10] = [
    (0.0, "dropped"),
    (0.16, "lands"),
    (1.4, "stands"),
    (1.6, "is pushed and slides"),
    (2.5, "stands again"),
    (3.4, "trots"),
    (4.9, "a foot on the step"),
    (6.0, "hind feet follow"),
    (8.1, "trots on"),
    (9.9, "stands on the step"),
];

type Drawn = Result<(), Box<dyn Error>>;

fn colour(slips: bool) -> RGBColor {
    if slips { SLIP } else { STICK }
}

/// The robot from its right side, with a push at each time (N).
pub(crate) fn film(file: &Path, ticks: &[Tick], push: fn(f64) -> Vector3<f64>) -> Drawn {
    let root = SVGBackend::new(file, (1250, 520)).into_drawing_area();
    root.fill(&WHITE)?;
    let title = "Forces on feet that stick (blue) and slip (orange), and a push (red)";
    let root = root.titled(title, ("sans-serif", 20))?;
    for (area, (time, text)) in root.split_evenly((2, 5)).iter().zip(MOMENTS) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let tick = &ticks[(time / STEP).round() as usize];
        let (left, right) = (tick.place.x - 0.29, tick.place.x + 0.29);
        let mut chart = ChartBuilder::on(area)
            .caption(format!("{time:.2} s: {text}"), ("sans-serif", 15))
            .margin(4)
            .build_cartesian_2d(left..right, -0.05..0.44)?;
        let floor = |from, to, top| Rectangle::new([(from, -0.05), (to, top)], GROUND.filled());
        let edge = EDGE.clamp(left, right);
        chart.draw_series([floor(left, edge, 0.0), floor(edge, right, RISE)])?;
        let leg = |leg: usize, colour: RGBColor| {
            PathElement::new(tick.legs[leg].map(flat).to_vec(), colour.stroke_width(4))
        };
        let corners = [[-0.18, -0.05], [-0.18, 0.05], [0.18, 0.05], [0.18, -0.05]];
        let torso = corners.map(|[x, z]| flat(tick.place + tick.turn * vector![x, 0.0, z]));
        chart.draw_series([leg(0, FAR), leg(2, FAR)])?;
        chart.draw_series([Polygon::new(torso, TORSO.filled())])?;
        chart.draw_series([leg(1, NEAR), leg(3, NEAR)])?;
        for (leg, foot) in tick.legs.iter().zip(&tick.feet) {
            chart.draw_series([Circle::new(flat(leg[3]), 7, NEAR.filled())])?;
            let slips = foot.mode == ContactMode::Slip;
            let from = leg[3] - Vector3::z() * 0.018;
            chart.draw_series(arrow(from, foot.force, colour(slips)))?;
        }
        let push = push(time);
        chart.draw_series(arrow(tick.place - push * ARROW / 2.0, push, PUSH))?;
    }
    Ok(root.present()?)
}

/// From the side: ahead, and up.
fn flat(point: Vector3<f64>) -> (f64, f64) {
    (point.x, point.z)
}

type Line = PathElement<(f64, f64)>;

/// An arrow for a force of at least a newton.
fn arrow(from: Vector3<f64>, force: Vector3<f64>, colour: RGBColor) -> Vec<Line> {
    if force.norm() < 1.0 {
        return Vec::new();
    }
    let (to, back) = (from + force * ARROW, -force / force.norm() * 0.018);
    let side = Vector3::y().cross(&back) * 0.6;
    let lines = [vec![from, to], vec![to + back + side, to, to + back - side]];
    let flat = lines.map(|line| line.into_iter().map(flat).collect::<Vec<_>>());
    flat.map(|line| Line::new(line, colour.stroke_width(3)))
        .into()
}

/// Normal forces of the feet, coloured by what they do, and how fast they slip; `bands` have names.
pub(crate) fn plots(file: &Path, ticks: &[Tick], bands: &[(Range<f64>, &'static str)]) -> Drawn {
    #[allow(clippy::cast_precision_loss)]
    let time = |bin: usize| STEP * (bin * BIN) as f64;
    let mean = |bin: &[Tick], what: &dyn Fn(&Tick) -> f64| {
        bin.iter().map(what).sum::<f64>() * STEP / time(1)
    };
    let root = SVGBackend::new(file, (1000, 720)).into_drawing_area();
    root.fill(&WHITE)?;
    let title = "Normal forces of feet that stick (blue) and slip (orange)";
    let root = root.titled(title, ("sans-serif", 20))?;
    for (row, area) in root.split_evenly((5, 1)).iter().enumerate() {
        let leg = LEGS.get(row).map(|leg| (format!("{leg} (N)"), 130.0));
        let (name, high) = leg.unwrap_or(("fastest slip (m/s)".into(), 0.8));
        let mut chart = ChartBuilder::on(area)
            .margin_right(14)
            .margin_top(8)
            .x_label_area_size(if row < 4 { 0 } else { 36 })
            .y_label_area_size(64)
            .build_cartesian_2d(0.0..time(ticks.len() / BIN), 0.0..high)?;
        for (band, text) in bands {
            let corners = [(band.start, 0.0), (band.end, high)];
            chart.draw_series([Rectangle::new(corners, BAND.filled())])?;
            let (text, at) = (if row == 0 { text } else { "" }, (band.start + 0.03, high));
            chart.draw_series([Text::new(text, at, ("sans-serif", 14))])?;
        }
        let mesh = &mut chart.configure_mesh();
        mesh.disable_mesh()
            .x_desc("time (s)")
            .y_desc(name)
            .y_labels(4);
        mesh.label_style(("sans-serif", 13)).draw()?;
        let bins = || ticks.chunks(BIN).enumerate();
        if row == 4 {
            let fastest = |tick: &Tick| tick.feet.iter().map(|foot| foot.slip).fold(0.0, f64::max);
            let line = bins().map(|(at, bin)| (time(at), mean(bin, &fastest).min(high)));
            chart.draw_series([Line::new(line.collect::<Vec<_>>(), SLIP)])?;
            continue;
        }
        let slips = |tick: &Tick| f64::from(u8::from(tick.feet[row].mode == ContactMode::Slip));
        let force = |bin| mean(bin, &|tick| tick.feet[row].force.z).min(high);
        let forces = bins().map(|(at, bin)| (time(at), force(bin), mean(bin, &slips) > 0.5));
        for run in forces.collect::<Vec<_>>().chunk_by(|a, b| a.2 == b.2) {
            let (from, last) = (run[0], run[run.len() - 1]);
            let to = last.0 + time(1);
            let mut outline: Vec<_> = run.iter().map(|&(time, force, _)| (time, force)).collect();
            outline.extend([(to, last.1), (to, 0.0), (from.0, 0.0)]);
            chart.draw_series([Polygon::new(outline, colour(from.2).filled())])?;
        }
    }
    Ok(root.present()?)
}
