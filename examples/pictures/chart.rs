//! Draws what a simulation did as SVG.
#![allow(missing_docs, clippy::missing_errors_doc, clippy::must_use_candidate)] // a tool of this repository

use plotters::prelude::*;
use std::error::Error;
use std::path::PathBuf;

/// A curve in colour, or black points such as those of an analytic answer; without a label it is not
/// in the legend.
pub struct Series {
    pub label: &'static str,
    pub points: Vec<(f64, f64)>,
    pub dots: bool,
}

const COLOURS: [RGBColor; 7] = [
    RGBColor(31, 119, 180),
    RGBColor(230, 110, 10),
    RGBColor(44, 140, 44),
    RGBColor(148, 80, 190),
    RGBColor(200, 30, 60),
    RGBColor(20, 170, 190),
    RGBColor(130, 95, 70),
];

/// One diagram with its axes, units included.
pub struct Panel {
    pub title: &'static str,
    pub x: &'static str,
    pub y: &'static str,
    pub series: Vec<Series>,
}

pub fn panel(
    title: &'static str,
    x: &'static str,
    y: &'static str,
    series: impl IntoIterator<Item = Series>,
) -> Panel {
    let series = series.into_iter().collect();
    Panel { title, x, y, series }
}

pub fn curve(label: &'static str, points: Vec<(f64, f64)>) -> Series {
    Series { label, points, dots: false }
}

/// At most forty of the points.
pub fn dots(label: &'static str, points: Vec<(f64, f64)>) -> Series {
    let every = points.len() / 40 + 1;
    let points = points.into_iter().step_by(every).collect();
    Series { label, points, dots: true }
}

/// Draws panels one below the other, into the file named by the first argument or else into
/// `target/NAME.svg`, and says where.
pub fn draw(name: &str, panels: &[Panel]) -> Result<(), Box<dyn Error>> {
    let folder = testbed::scene_file::repository().join("target");
    std::fs::create_dir_all(&folder)?;
    let default = folder.join(name).with_extension("svg");
    let path = std::env::args_os().nth(1).map_or(default, PathBuf::from);
    let size = (900, 360 * u32::try_from(panels.len())?);
    let root = SVGBackend::new(&path, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((panels.len(), 1)).iter().zip(panels) {
        let (left, legend) = area.split_horizontally(720);
        let points = || panel.series.iter().flat_map(|series| &series.points);
        let x = range(points().map(|p| p.0), 0.0);
        let y = range(points().map(|p| p.1), 0.06);
        let mut chart = ChartBuilder::on(&left)
            .caption(panel.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(70)
            .build_cartesian_2d(x, y)?;
        let mesh = &mut chart.configure_mesh();
        mesh.x_desc(panel.x).y_desc(panel.y).light_line_style(WHITE);
        mesh.label_style(("sans-serif", 14));
        mesh.axis_desc_style(("sans-serif", 15)).draw()?;

        let mut colours = COLOURS.iter().cycle();
        let mut line = 60;
        for series in &panel.series {
            let points = series.points.iter().copied();
            let next = if series.dots { None } else { colours.next() };
            let colour = *next.unwrap_or(&BLACK);
            if series.dots {
                chart.draw_series(points.map(|point| Circle::new(point, 3, colour)))?;
            } else {
                chart.draw_series(LineSeries::new(points, colour.stroke_width(2)))?;
            }
            if series.label.is_empty() {
                continue;
            }
            if series.dots {
                legend.draw(&Circle::new((9, line), 3, colour))?;
            } else {
                let ends = [(0, line), (18, line)];
                legend.draw(&PathElement::new(ends, colour.stroke_width(2)))?;
            }
            let style = ("sans-serif", 14).into_font();
            legend.draw(&Text::new(series.label, (26, line - 8), style))?;
            line += 22;
        }
    }
    root.present()?;
    println!("drawn in {}", path.display());
    Ok(())
}

/// From the smallest to the largest, with a share of the difference to spare.
fn range(values: impl Iterator<Item = f64>, spare: f64) -> std::ops::Range<f64> {
    let limits = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.fold(limits, |(low, high), x| (low.min(x), high.max(x)));
    let spare = spare * (high - low).max(1e-9);
    low - spare..high + spare
}
