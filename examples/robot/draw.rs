//! Draws what happened: a filmstrip with the forces of contacts, and forces and slip over time.

use crate::collide::vector;
use crate::{Body, Failure, STEP, Tick};
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use plotters::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;
use std::path::Path;
use stiction::ContactMode;

const STICK: RGBColor = RGBColor(31, 119, 180);
const SLIP: RGBColor = RGBColor(230, 110, 10);
const PUSH: RGBColor = RGBColor(180, 30, 40);
const GROUND: RGBColor = RGBColor(215, 210, 200);
const BAND: RGBColor = RGBColor(238, 238, 232);
/// Shapes of the first tree, and of others.
const SHAPES: [RGBColor; 2] = [RGBColor(200, 205, 215), RGBColor(190, 220, 195)];
const NEAR: RGBColor = RGBColor(40, 40, 45);
const FAR: RGBColor = RGBColor(165, 165, 175);
/// Ticks that are drawn as one.
const BIN: usize = 10;

/// A filmstrip: the world as it is seen along y, from the right.
pub struct Film<'a> {
    /// What is drawn, and when (s); five in a row.
    pub moments: &'a [(f64, &'a str)],
    /// The middle of a picture (m).
    pub middle: fn(&Tick) -> f64,
    /// Width and height of a picture (m).
    pub size: [f64; 2],
    /// The height of its lower edge (m).
    pub bottom: f64,
    /// Length of arrows (m/N).
    pub arrow: f64,
}

/// A curve below the forces.
pub struct Curve<'a> {
    /// What it is, with its unit.
    pub name: &'a str,
    /// The largest value drawn.
    pub high: f64,
    /// The value of a tick.
    pub value: &'a dyn Fn(&Tick) -> f64,
}

type Line = PathElement<(f64, f64)>;

fn colour(slips: bool) -> RGBColor {
    if slips { SLIP } else { STICK }
}

/// From the side: ahead, and up.
fn flat(point: Vector3<f64>) -> (f64, f64) {
    (point.x, point.z)
}

/// Draws a filmstrip of bodies, with forces of contacts and pushes as arrows.
pub fn film(file: &Path, bodies: &[Body], ticks: &[Tick], film: &Film) -> Result<(), Failure> {
    let [width, height] = film.size;
    let rows = film.moments.len().div_ceil(5);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let high = 28 + (242.0 * height / width) as u32;
    let size = (1250, 30 + high * u32::try_from(rows)?);
    let root = SVGBackend::new(file, size).into_drawing_area();
    root.fill(&WHITE)?;
    let title = "Forces of contacts that stick (blue) and slip (orange), and pushes (red)";
    let root = root.titled(title, ("sans-serif", 20))?;
    for (area, (time, text)) in root.split_evenly((rows, 5)).iter().zip(film.moments) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let tick = &ticks[(time / STEP).round() as usize];
        let left = (film.middle)(tick) - width / 2.0;
        let mut chart = ChartBuilder::on(area)
            .caption(format!("{time:.2} s: {text}"), ("sans-serif", 15))
            .margin(4)
            .build_cartesian_2d(left..left + width, film.bottom..film.bottom + height)?;
        let inside = |(x, z): (f64, f64)| {
            let z = z.clamp(film.bottom, film.bottom + height);
            (x.clamp(left, left + width), z)
        };
        let bones = |near: bool| {
            let side = move |[a, b]: &&[Vector3<f64>; 2]| {
                (a.y + b.y < 2.0 * tick.push[0].y + 1e-3) == near
            };
            let style = if near { NEAR } else { FAR }.stroke_width(4);
            let line =
                move |bone: &[Vector3<f64>; 2]| Line::new(bone.map(|end| inside(flat(end))), style);
            tick.bones.iter().filter(side).map(line)
        };
        chart.draw_series(bones(false))?;
        for (body, pose) in bodies.iter().zip(&tick.poses) {
            let outline = outline(body, pose).into_iter().map(inside);
            let outline: Vec<_> = outline.collect();
            if body.tree == Body::GROUND {
                chart.draw_series([Polygon::new(outline, GROUND.filled())])?;
                continue;
            }
            let edge = Line::new(outline.clone(), FAR);
            chart.draw_series([Polygon::new(outline, SHAPES[body.tree.min(1)].filled())])?;
            chart.draw_series([edge])?;
        }
        chart.draw_series(bones(true))?;
        for touch in &tick.touches {
            let colour = colour(touch.mode == ContactMode::Slip);
            chart.draw_series(arrow(touch.place, touch.force, film, colour))?;
        }
        let [place, push] = tick.push;
        chart.draw_series(arrow(place - push * film.arrow / 2.0, push, film, PUSH))?;
    }
    Ok(root.present()?)
}

/// The outline of a convex shape, as it is seen along y.
fn outline(body: &Body, pose: &Pose) -> Vec<(f64, f64)> {
    let directions = (0..=48).map(|turn| ((f64::from(turn) + 0.5) * TAU / 48.0).sin_cos());
    let directions = directions.map(|(x, z)| Vector::new(x, 0.0, z));
    let shape = body.shape.as_support_map();
    let points = shape.map(|shape| directions.map(|to| vector(shape.support_point(pose, to))));
    points.into_iter().flatten().map(flat).collect()
}

/// An arrow for a force, unless it is shorter than 3 mm.
fn arrow(from: Vector3<f64>, force: Vector3<f64>, film: &Film, colour: RGBColor) -> Vec<Line> {
    let arrow = force * film.arrow;
    if arrow.norm() < 3e-3 {
        return Vec::new();
    }
    let head = (film.size[0] * 0.03).min(arrow.norm() / 2.0);
    let (to, back) = (from + arrow, -arrow.normalize() * head);
    let side = Vector3::y().cross(&back) * 0.6;
    let lines = [vec![from, to], vec![to + back + side, to, to + back - side]];
    let flat = lines.map(|line| line.into_iter().map(flat).collect::<Vec<_>>());
    flat.map(|line| Line::new(line, colour.stroke_width(3)))
        .into()
}

/// Draws the normal forces on links up to `high` (N), coloured by what their contacts do, and a curve below; `bands` have
/// names.
pub fn plots(
    file: &Path,
    bodies: &[Body],
    ticks: &[Tick],
    links: &[&str],
    high: f64,
    curve: &Curve,
    bands: &[(Range<f64>, &'static str)],
) -> Result<(), Failure> {
    #[allow(clippy::cast_precision_loss)]
    let time = |bin: usize| STEP * (bin * BIN) as f64;
    let mean = |bin: &[Tick], what: &dyn Fn(&Tick) -> f64| {
        bin.iter().map(what).sum::<f64>() * STEP / time(1)
    };
    let root = SVGBackend::new(file, (1000, 60 + 132 * u32::try_from(links.len() + 1)?))
        .into_drawing_area();
    root.fill(&WHITE)?;
    let title = "Normal forces of contacts that stick (blue) and slip (orange)";
    let root = root.titled(title, ("sans-serif", 20))?;
    for (row, area) in root.split_evenly((links.len() + 1, 1)).iter().enumerate() {
        let link = links.get(row);
        let (name, high) = link.map_or((curve.name.into(), curve.high), |link| {
            (format!("{link} (N)"), high)
        });
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .margin_right(16)
            .x_label_area_size(if link.is_some() { 0 } else { 36 })
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
        let Some(link) = link else {
            let line = bins().map(|(at, bin)| (time(at), mean(bin, curve.value).min(high)));
            chart.draw_series([Line::new(line.collect::<Vec<_>>(), SLIP)])?;
            continue;
        };
        let normal = |slips: bool| {
            move |tick: &Tick| {
                let touches = tick.touches_of(bodies, link);
                let counted = touches.filter(|touch| !slips || touch.mode == ContactMode::Slip);
                counted.map(|touch| touch.normal).sum()
            }
        };
        let of = |bin| {
            let force = mean(bin, &normal(false));
            (force.min(high), mean(bin, &normal(true)) > force / 2.0)
        };
        let forces = bins().map(|(at, bin)| (time(at), of(bin)));
        for run in forces.collect::<Vec<_>>().chunk_by(|a, b| a.1.1 == b.1.1) {
            let ((from, (_, slips)), (last, (force, _))) = (run[0], run[run.len() - 1]);
            let to = last + time(1);
            let mut outline: Vec<_> = run
                .iter()
                .map(|&(time, (force, _))| (time, force))
                .collect();
            outline.extend([(to, force), (to, 0.0), (from, 0.0)]);
            chart.draw_series([Polygon::new(outline, colour(slips).filled())])?;
        }
    }
    Ok(root.present()?)
}
