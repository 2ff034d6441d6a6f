//! What is drawn of the races: error against time and iterations, profile, f32 against f64.

use crate::axis::Axis;
use crate::chart::{Look, Marker, Panel, Picture, Series};
use crate::contestant::{Id, Kind, Precision};
use crate::measure::Rung;
use crate::race::{LEVELS, Race};
use plotters::style::RGBColor;

/// Scenes that show where the methods differ.
pub(crate) const TELLING: [&str; 6] = [
    "box_slide_spin",
    "go2_trot_mixed",
    "allegro_heavy_box",
    "stack3_1_10_100",
    "slope_box_limit",
    "tall_box_high_mu_tipping",
];

/// Contestants of the pictures, in the order of the legend.
const SHOWN: [Id; 8] = [
    Kind::Default.double(),
    Kind::Default.single(),
    Kind::Restart.double(),
    Kind::Fast.double(),
    Kind::Plain.double(),
    Kind::GaussSeidel.double(),
    Kind::AlartCurnier.double(),
    Kind::OuterLoop.double(),
];

/// Lightness falls with interest, so that grey tells as much as colour.
pub(crate) fn look(id: Id) -> Look {
    let (color, marker, dash, width) = match (id.kind, id.precision) {
        (Kind::Default, Precision::F64) => ((0, 0, 0), Marker::Disc, None, 2),
        (Kind::Default, Precision::F32) => ((0, 60, 160), Marker::Ring, Some((7, 4)), 2),
        (Kind::Restart, _) => ((0, 110, 80), Marker::Triangle, None, 1),
        (Kind::Fast, _) => ((120, 150, 60), Marker::Plus, Some((2, 4)), 1),
        (Kind::Plain, _) => ((110, 160, 150), Marker::Cross, Some((6, 3)), 1),
        (Kind::GaussSeidel, _) => ((205, 85, 0), Marker::Square, None, 1),
        (Kind::AlartCurnier, _) => ((130, 30, 130), Marker::Diamond, Some((9, 3)), 1),
        (Kind::Relaxation | Kind::OuterLoop, _) => ((140, 140, 140), Marker::Frame, Some((3, 3)), 1),
    };
    Look { color: RGBColor(color.0, color.1, color.2), marker, dash, width }
}

fn error_axis() -> Axis {
    Axis::decades("error, dimensionless", -15, 0, 3)
}

/// One panel a telling scene, `abscissa` of a rung on the x axis.
fn by_rung<'a>(
    races: &[Race],
    title: &'a str,
    axis: &'static str,
    abscissa: impl Fn(&Rung) -> f64,
) -> Picture<'a> {
    let panels = TELLING.iter().filter_map(|name| {
        let race = races.iter().find(|race| race.scene.name == *name)?;
        let points = |id| -> Vec<(f64, f64)> {
            let rungs = race.run(id).into_iter().flat_map(|run| &run.rungs);
            rungs.map(|rung| (abscissa(rung), rung.error)).collect()
        };
        let series: Vec<Series> = SHOWN
            .map(|id| Series { name: id.name(), look: look(id), points: points(id), joined: true })
            .into();
        let values = series.iter().flat_map(|s| &s.points).map(|point| point.0);
        Some(Panel {
            title: format!("{name}: {} dofs, {} contacts", race.scene.n_dof, race.scene.n_contacts),
            x: Axis::around(axis, values),
            y: error_axis(),
            series,
            marker_gap: 7,
        })
    });
    Picture { title, columns: 3, panel: (440, 330), panels: panels.collect() }
}

pub(crate) fn error_against_time(races: &[Race]) -> Picture<'static> {
    by_rung(races, "Error really reached against time of the solve", "time, µs", |rung| {
        rung.time.least / 1e3
    })
}

pub(crate) fn error_against_iterations(races: &[Race]) -> Picture<'static> {
    by_rung(
        races,
        "Error really reached against iterations or sweeps",
        "iterations, a Newton or interior-point step counted as ten",
        |rung| rung.effort.work().max(1) as f64,
    )
}

/// Share of the scenes that a contestant solves within a factor of the fastest on each.
pub(crate) fn performance_profile<'a>(races: &[Race], title: &'a str) -> Picture<'a> {
    const FACTOR: f64 = 1000.0;
    let panels = LEVELS.map(|level| {
        let best = |race: &Race| {
            let times = SHOWN.iter().filter_map(|&id| race.time(id, level, false));
            times.fold(f64::INFINITY, f64::min)
        };
        let series = SHOWN.iter().filter_map(|&id| {
            let ratios = races.iter().filter_map(|race| {
                let time = race.time(id, level, false)?;
                Some(time / best(race))
            });
            let mut ratios: Vec<f64> = ratios.filter(|&ratio| ratio <= FACTOR).collect();
            ratios.sort_unstable_by(f64::total_cmp);
            let share = |count: usize| 100.0 * count as f64 / races.len() as f64;
            let mut points = Vec::new();
            for (count, &ratio) in ratios.iter().enumerate() {
                points.extend([(ratio, share(count)), (ratio, share(count + 1))]);
            }
            points.push((FACTOR, share(ratios.len())));
            (!ratios.is_empty()).then(|| Series { name: id.name(), look: look(id), points, joined: true })
        });
        Panel {
            title: format!("error at most {level:e}"),
            x: Axis::decades("time / time of the fastest on the same scene", 0, 3, 1),
            y: Axis {
                name: "scenes solved, %",
                range: (0.0, 100.0),
                ticks: (0..=5).map(|k| 20.0 * f64::from(k)).collect(),
                logarithmic: false,
            },
            series: series.collect(),
            marker_gap: 28,
        }
    });
    Picture { title, columns: 3, panel: (440, 380), panels: panels.into() }
}

/// A point a scene: time in f32 over time in f64, to what f32 reaches.
pub(crate) fn single_against_double(races: &[Race]) -> Picture<'static> {
    let methods = [
        (Kind::Default, Marker::Disc, (0, 0, 0)),
        (Kind::Restart, Marker::Triangle, (0, 110, 80)),
        (Kind::GaussSeidel, Marker::Frame, (205, 85, 0)),
    ];
    let panels = [1e-3, 1e-4].map(|level| {
        let mut series: Vec<Series> = methods
            .iter()
            .map(|&(kind, marker, (r, g, b))| {
                let points = races.iter().filter_map(|race| {
                    let time = |id| Some(race.time(id, level, false)? / 1e3);
                    Some((time(kind.double())?, time(kind.single())?))
                });
                Series {
                    name: kind.name().to_owned(),
                    look: Look { color: RGBColor(r, g, b), marker, dash: None, width: 1 },
                    points: points.collect(),
                    joined: false,
                }
            })
            .collect();
        let both = |s: &Series| s.points.iter().flat_map(|&(x, y)| [x, y]).collect::<Vec<_>>();
        let values: Vec<f64> = series.iter().flat_map(both).collect();
        let axis = |name| Axis::around(name, values.iter().copied());
        let (x, y) = (axis("time in f64, µs"), axis("time in f32, µs"));
        let diagonal = |name: &str, factor: f64, dash| Series {
            name: name.to_owned(),
            look: Look { color: RGBColor(120, 120, 120), marker: Marker::None, dash, width: 1 },
            points: vec![
                (x.range.0 * factor.max(1.0), x.range.0 * factor.max(1.0) / factor),
                (x.range.1, x.range.1 / factor),
            ],
            joined: true,
        };
        series.push(diagonal("equally fast", 1.0, None));
        series.push(diagonal("f32 twice as fast", 2.0, Some((6, 4))));
        Panel { title: format!("error at most {level:e}, a marker a scene"), x, y, series, marker_gap: 0 }
    });
    Picture {
        title: "f32 against f64: below the line f32 is faster",
        columns: 2,
        panel: (560, 440),
        panels: panels.into(),
    }
}
