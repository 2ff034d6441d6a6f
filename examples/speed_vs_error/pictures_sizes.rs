//! What is drawn besides the races: time against size, and instructions on a microcontroller.

use crate::axis::Axis;
use crate::chart::{Look, Marker, Panel, Picture, Series};
use crate::contestant::{Kind, Precision};
use crate::instructions::{Counts, Firmware};
use crate::pictures::look;
use crate::scaling::{self, Scaling, Size};
use plotters::style::RGBColor;

/// `(size, time)` of preparations or solves.
pub(crate) fn points(sizes: &[Size], time: impl Fn(&Size) -> f64) -> Vec<(f64, f64)> {
    let point = |size: &Size| (size.count as f64, time(size) / 1e3);
    sizes.iter().map(point).collect()
}

fn series(scalings: &[Scaling], of: impl Fn(&Scaling) -> &Vec<Size>) -> Vec<Series> {
    let mut all = Vec::new();
    for scaling in scalings {
        let (precision, gray) = match scaling.id.precision {
            Precision::F64 => ("f64", 0),
            Precision::F32 => ("f32", 110),
        };
        let look = |marker, dash| Look { color: RGBColor(gray, gray, gray), marker, dash, width: 2 };
        let sizes = of(scaling);
        let (prepare, solve) = match scaling.id.precision {
            Precision::F64 => (Marker::Square, Marker::Disc),
            Precision::F32 => (Marker::Frame, Marker::Ring),
        };
        all.push(Series {
            name: format!("prepare, {precision}"),
            look: look(prepare, Some((7, 4))),
            points: points(sizes, |size| size.prepare),
            joined: true,
        });
        all.push(Series {
            name: format!("solve to {:e}, {precision}", scaling::TOLERANCE),
            look: look(solve, None),
            points: points(sizes, |size| size.solve),
            joined: true,
        });
    }
    all
}

fn sizes_axis(name: &'static str, ticks: &[usize]) -> Axis {
    let ticks: Vec<f64> = ticks.iter().map(|&tick| tick as f64).collect();
    Axis { name, range: (ticks[0] * 0.9, ticks[ticks.len() - 1] * 1.1), ticks, logarithmic: true }
}

/// "f64: prepare n^1.2, solve n^0.9; ..."
fn fits(title: &str, scalings: &[Scaling], of: impl Fn(&Scaling) -> &Vec<Size>) -> String {
    let fit = |scaling: &Scaling| {
        let exponent = |time: fn(&Size) -> f64| scaling::exponent(&points(of(scaling), time));
        let precision = match scaling.id.precision {
            Precision::F64 => "f64",
            Precision::F32 => "f32",
        };
        format!(
            "{precision} prepare n^{:.1}, solve n^{:.1}",
            exponent(|size| size.prepare),
            exponent(|size| size.solve)
        )
    };
    let fits: Vec<String> = scalings.iter().map(fit).collect();
    format!("{title}: {}", fits.join("; "))
}

pub(crate) fn time_against_size(scalings: &[Scaling]) -> Picture<'static> {
    let times = |axis: fn(&Scaling) -> &Vec<Size>| {
        let series = series(scalings, axis);
        let values: Vec<f64> = series.iter().flat_map(|s| &s.points).map(|p| p.1).collect();
        (series, Axis::around("time, µs", values.into_iter()))
    };
    let panel = |title: &str, axis: fn(&Scaling) -> &Vec<Size>, x: Axis| {
        let (series, y) = times(axis);
        Panel { title: fits(title, scalings, axis), x, y, series, marker_gap: 0 }
    };
    Picture {
        title: "Default method, random scenes, geometric means: time against size",
        columns: 2,
        panel: (640, 430),
        panels: vec![
            panel(
                &format!("{} dofs", scaling::FIXED_DOFS),
                |scaling| &scaling.contacts,
                sizes_axis("contacts n", &scaling::CONTACTS),
            ),
            panel(
                &format!("{} contacts", scaling::FIXED_CONTACTS),
                |scaling| &scaling.dofs,
                sizes_axis("dofs n", &scaling::DOFS),
            ),
        ],
    }
}

/// One panel a firmware scene.
pub(crate) fn error_against_instructions(firmware: &[Firmware]) -> Picture<'static> {
    let panels = firmware.iter().map(|scene| {
        let mut series = Vec::new();
        let methods = [(Kind::Default, &scene.default), (Kind::GaussSeidel, &scene.gauss_seidel)];
        for (kind, Counts { prepare, points }) in methods {
            let solid = Look { dash: None, ..look(kind.double()) };
            let open = Look {
                marker: match solid.marker {
                    Marker::Disc => Marker::Ring,
                    _ => Marker::Frame,
                },
                dash: Some((5, 4)),
                ..solid
            };
            series.push(Series {
                name: format!("{}, solve", kind.name()),
                look: solid,
                points: points.clone(),
                joined: true,
            });
            series.push(Series {
                name: format!("{}, prepare and solve", kind.name()),
                look: open,
                points: points.iter().map(|(x, y)| (x + prepare, *y)).collect(),
                joined: true,
            });
        }
        let values = series.iter().flat_map(|s| &s.points).map(|point| point.0);
        let title = match scene.gauss_seidel.points.len() {
            0 => format!("{}: Gauss-Seidel fails", scene.title),
            _ => scene.title.to_owned(),
        };
        Panel {
            title,
            x: Axis::around("instructions", values),
            y: Axis::decades("error at most", -6, -2, 1),
            series,
            marker_gap: 0,
        }
    });
    Picture {
        title: "Instructions on a Cortex-M4F (emulated), f32, cold start",
        columns: 2,
        panel: (560, 300),
        panels: panels.collect(),
    }
}
