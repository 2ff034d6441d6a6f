//! Draws what happened: a filmstrip with the forces of contacts, and forces and slip over time.

use crate::collide::vector;
use crate::report::save;
use crate::{Body, Failure, STEP, Tick, Touch, World};
use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use plotters::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;
use stiction::ContactMode;

const STICK: RGBColor = RGBColor(31, 119, 180);
const SLIP: RGBColor = RGBColor(230, 110, 10);
const PUSH: RGBColor = RGBColor(180, 30, 40);
const GROUND: RGBColor = RGBColor(215, 210, 200);
const BAND: RGBColor = RGBColor(238, 238, 232);
/// Shapes of each tree.
const SHAPES: [RGBColor; 3] = [RGBColor(200, 205, 215), RGBColor(190, 220, 195), RGBColor(225, 205, 180)];
const NEAR: RGBColor = RGBColor(40, 40, 45);
const FAR: RGBColor = RGBColor(165, 165, 175);
/// Ticks that are drawn as one.
const BIN: u32 = 10;

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

/// A curve below the forces: its name with the unit, the largest value drawn, and the value of a tick.
pub type Curve<'a> = (&'a str, f64, &'a dyn Fn(&Tick) -> f64);

type Line = PathElement<(f64, f64)>;

impl<const N: usize, const C: usize, const R: usize> World<N, C, R> {
    /// Draws a filmstrip into the file of a name, with forces of contacts and pushes as arrows.
    pub fn film(&self, name: &str, ticks: &[Tick], film: &Film) -> Result<(), Failure> {
        let [width, height] = film.size;
        let rows = film.moments.len().div_ceil(5);
        let high = 28 + pixels(242.0 * height / width);
        let file = save(name)?;
        let size = (1250, 30 + high * u32::try_from(rows)?);
        let root = SVGBackend::new(&file, size).into_drawing_area();
        root.fill(&WHITE)?;
        let title = "Forces of contacts that stick (blue) and slip (orange), and pushes (red)";
        let root = root.titled(title, ("sans-serif", 20))?;
        for (area, (time, text)) in root.split_evenly((rows, 5)).iter().zip(film.moments) {
            let tick = &ticks[pixels(time / STEP) as usize];
            let left = (film.middle)(tick) - width / 2.0;
            let mut chart = ChartBuilder::on(area)
                .caption(format!("{time:.2} s: {text}"), ("sans-serif", 15))
                .margin(4)
                .build_cartesian_2d(left..left + width, film.bottom..film.bottom + height)?;
            let inside = |point: Vector3<f64>| {
                let z = point.z.clamp(film.bottom, film.bottom + height);
                (point.x.clamp(left, left + width), z)
            };
            let bones = |near: bool| {
                let middle = tick.push[0].y + 1e-3;
                let side = move |[a, b]: &&[Vector3<f64>; 2]| (a.y + b.y < 2.0 * middle) == near;
                let style = if near { NEAR } else { FAR }.stroke_width(4);
                let line = move |bone: &[Vector3<f64>; 2]| Line::new(bone.map(inside), style);
                tick.bones.iter().filter(side).map(line)
            };
            chart.draw_series(bones(false))?;
            for (body, pose) in self.bodies.iter().zip(&tick.poses) {
                let outline: Vec<_> = outline(body, pose).into_iter().map(inside).collect();
                let shape = SHAPES.get(body.tree);
                let colour = shape.unwrap_or(&GROUND).filled();
                chart.draw_series([Polygon::new(outline.clone(), colour)])?;
                chart.draw_series(shape.map(|_| Line::new(outline, FAR)))?;
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

    /// Draws normal forces on links up to `high` (N) into the file of a name, coloured by what their contacts do, and a curve below;
    /// `bands` of time (s) have names.
    pub fn plots(
        &self,
        name: &str,
        ticks: &[Tick],
        (links, high): (&[&str], f64),
        (curve, most, value): Curve,
        bands: &[(Range<f64>, &'static str)],
    ) -> Result<(), Failure> {
        if let Some(link) = links.iter().find(|link| !self.bodies.iter().any(|body| body.name == **link)) {
            return Err(format!("no link {link} has a shape").into());
        }
        let time = |bin: u32| STEP * f64::from(BIN * bin);
        let bins: Vec<_> = (0..).map(time).zip(ticks.chunks(BIN as usize)).collect();
        let mean =
            |bin: &[Tick], what: &dyn Fn(&Tick) -> f64| bin.iter().map(what).sum::<f64>() * STEP / time(1);
        let (file, rows) = (save(name)?, links.len() + 1);
        let size = (1000, 60 + 132 * u32::try_from(rows)?);
        let root = SVGBackend::new(&file, size).into_drawing_area();
        root.fill(&WHITE)?;
        let title = "Normal forces of contacts that stick (blue) and slip (orange)";
        let root = root.titled(title, ("sans-serif", 20))?;
        for (row, area) in root.split_evenly((rows, 1)).iter().enumerate() {
            let link = links.get(row);
            let forces = link.map(|link| (format!("{link} (N)"), high, 0));
            let (name, high, below) = forces.unwrap_or((curve.into(), most, 36));
            let mut chart = ChartBuilder::on(area)
                .margin(8)
                .margin_right(16)
                .x_label_area_size(below)
                .y_label_area_size(64)
                .build_cartesian_2d(0.0..STEP * f64::from(u32::try_from(ticks.len())?), 0.0..high)?;
            for (band, text) in bands {
                let corners = [(band.start, 0.0), (band.end, high)];
                chart.draw_series([Rectangle::new(corners, BAND.filled())])?;
                let (text, at) = (if row == 0 { text } else { "" }, (band.start + 0.03, high));
                chart.draw_series([Text::new(text, at, ("sans-serif", 14))])?;
            }
            let mesh = &mut chart.configure_mesh();
            mesh.disable_mesh().x_desc("time (s)").y_desc(name).y_labels(4);
            mesh.label_style(("sans-serif", 13)).draw()?;
            let Some(link) = link else {
                let line = bins.iter().map(|(at, bin)| (*at, mean(bin, value).min(high)));
                chart.draw_series([Line::new(line.collect::<Vec<_>>(), SLIP)])?;
                continue;
            };
            let of = |(at, bin): &(f64, &[Tick])| {
                let slips = |touch: &&Touch| touch.mode == ContactMode::Slip;
                let force = mean(bin, &|tick| self.touches(tick, link).map(|touch| touch.normal).sum());
                let slipping =
                    |tick: &Tick| self.touches(tick, link).filter(slips).map(|touch| touch.normal).sum();
                (*at, force.min(high), mean(bin, &slipping) > force / 2.0)
            };
            for run in bins.iter().map(of).collect::<Vec<_>>().chunk_by(|a, b| a.2 == b.2) {
                let (from, last) = (run[0], run[run.len() - 1]);
                let to = last.0 + time(1);
                let mut outline: Vec<_> = run.iter().map(|&(at, force, _)| (at, force)).collect();
                outline.extend([(to, last.1), (to, 0.0), (from.0, 0.0)]);
                chart.draw_series([Polygon::new(outline, colour(from.2).filled())])?;
            }
        }
        Ok(root.present()?)
    }

    /// Contacts of a link in a tick.
    pub fn touches<'a>(&'a self, tick: &'a Tick, link: &'a str) -> impl Iterator<Item = &'a Touch> {
        let has = move |touch: &&Touch| touch.pair.iter().any(|&body| self.bodies[body].name == link);
        tick.touches.iter().filter(has)
    }
}

/// A positive number, rounded.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn pixels(number: f64) -> u32 {
    number.round() as u32
}

fn colour(slips: bool) -> RGBColor {
    if slips { SLIP } else { STICK }
}

/// The outline of a convex shape, as it is seen along y.
fn outline(body: &Body, pose: &Pose) -> Vec<Vector3<f64>> {
    let directions = (0..=48).map(|turn| ((f64::from(turn) + 0.5) * TAU / 48.0).sin_cos());
    let directions = directions.map(|(x, z)| Vector::new(x, 0.0, z));
    let shape = body.shape.as_support_map();
    let points = shape.map(|shape| directions.map(|to| vector(shape.support_point(pose, to))));
    points.into_iter().flatten().collect()
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
    let flat = lines.map(|line| line.iter().map(|point| (point.x, point.z)).collect::<Vec<_>>());
    flat.map(|line| Line::new(line, colour.stroke_width(3))).into()
}
