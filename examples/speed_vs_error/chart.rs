//! Panels with one legend, drawn so that they can be read in grey.

use crate::axis::Axis;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Colour, marker and dashes together tell a series.
#[derive(Clone, Copy)]
pub(crate) struct Look {
    pub(crate) color: RGBColor,
    pub(crate) marker: Marker,
    /// Length and gap of the dashes in pixels; none for a solid line.
    pub(crate) dash: Option<(i32, i32)>,
    pub(crate) width: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Disc,
    Ring,
    Square,
    Frame,
    Triangle,
    Diamond,
    Cross,
    Plus,
    None,
}

pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) look: Look,
    pub(crate) points: Vec<(f64, f64)>,
    /// Draw the line between the points.
    pub(crate) joined: bool,
}

pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) series: Vec<Series>,
    /// Pixels between the markers of a line, at least.
    pub(crate) marker_gap: i32,
}

/// Panels side by side, `columns` in a row, under one title and above one legend.
pub(crate) struct Picture<'a> {
    pub(crate) title: &'a str,
    pub(crate) columns: usize,
    pub(crate) panel: (u32, u32),
    pub(crate) panels: Vec<Panel>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Failure = Box<dyn std::error::Error>;

const FONT: &str = "sans-serif";
const LEGEND: (usize, u32) = (4, 22); // entries a row, height of a row

/// The marker of a look, around its point.
fn marker(look: Look, at: (i32, i32)) -> Vec<(Vec<(i32, i32)>, bool)> {
    let (x, y) = at;
    let shift = |points: &[(i32, i32)]| points.iter().map(|(a, b)| (x + a, y + b)).collect();
    match look.marker {
        Marker::Square => vec![(shift(&[(-4, -4), (4, -4), (4, 4), (-4, 4)]), true)],
        Marker::Frame => vec![(shift(&[(-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)]), false)],
        Marker::Triangle => vec![(shift(&[(0, -5), (5, 4), (-5, 4)]), true)],
        Marker::Diamond => vec![(shift(&[(0, -5), (5, 0), (0, 5), (-5, 0), (0, -5)]), false)],
        Marker::Cross => vec![(shift(&[(-4, -4), (4, 4)]), false), (shift(&[(-4, 4), (4, -4)]), false)],
        Marker::Plus => vec![(shift(&[(-5, 0), (5, 0)]), false), (shift(&[(0, -5), (0, 5)]), false)],
        Marker::Disc | Marker::Ring | Marker::None => Vec::new(),
    }
}

fn draw_marker(area: &Area<'_>, look: Look, at: (i32, i32)) -> Result<(), Failure> {
    match look.marker {
        Marker::Disc => area.draw(&Circle::new(at, 4, look.color.filled()))?,
        Marker::Ring => area.draw(&Circle::new(at, 4, look.color.stroke_width(1)))?,
        _ => {}
    }
    for (points, filled) in marker(look, at) {
        if filled {
            area.draw(&Polygon::new(points, look.color.filled()))?;
        } else {
            area.draw(&PathElement::new(points, look.color.stroke_width(1)))?;
        }
    }
    Ok(())
}

fn draw_line(area: &Area<'_>, look: Look, points: Vec<(i32, i32)>) -> Result<(), Failure> {
    let style = look.color.stroke_width(look.width);
    match look.dash {
        Some((size, gap)) => {
            area.draw(&plotters::element::DashedPathElement::new(points, size, gap, style))?;
        }
        None => area.draw(&PathElement::new(points, style))?,
    }
    Ok(())
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Result<(), Failure> {
    let (x, y) = (&panel.x, &panel.y);
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, (FONT, 17))
        .margin(8)
        .margin_right(18)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .x_desc(x.name)
        .y_desc(y.name)
        .x_labels(x.ticks.len())
        .y_labels(y.ticks.len())
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 15))
        .bold_line_style(RGBColor(210, 210, 210))
        .light_line_style(TRANSPARENT)
        .draw()?;
    let screen = area.use_screen_coord();
    let inside = |&&(a, b): &&(f64, f64)| a.is_finite() && b.is_finite();
    for series in &panel.series {
        let points = series.points.iter().filter(inside);
        let pixels: Vec<(i32, i32)> = points.map(|&(a, b)| chart.backend_coord(&(a, b))).collect();
        if series.joined && pixels.len() > 1 {
            draw_line(&screen, series.look, pixels.clone())?;
        }
        let mut last = None;
        for at in pixels {
            let near = |last: (i32, i32)| (last.0 - at.0).abs().max((last.1 - at.1).abs()) < panel.marker_gap;
            if !(series.joined && last.is_some_and(near)) {
                draw_marker(&screen, series.look, at)?;
                last = Some(at);
            }
        }
    }
    Ok(())
}

/// Each name once, in the order of its first panel.
fn draw_legend(area: &Area<'_>, panels: &[Panel]) -> Result<(), Failure> {
    let mut entries: Vec<&Series> = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series) {
        if entries.iter().all(|entry| entry.name != series.name) {
            entries.push(series);
        }
    }
    let cells = area.split_evenly((entries.len().div_ceil(LEGEND.0), LEGEND.0));
    for (series, area) in entries.into_iter().zip(&cells) {
        let (left, middle) = (16, 11);
        if series.joined {
            draw_line(area, series.look, vec![(left, middle), (left + 44, middle)])?;
        }
        draw_marker(area, series.look, (left + 22, middle))?;
        let style = (FONT, 15).into_font().color(&BLACK);
        area.draw(&Text::new(series.name.clone(), (left + 52, middle - 8), style))?;
    }
    Ok(())
}

/// Writes the picture as SVG.
pub(crate) fn draw(path: &Path, picture: &Picture<'_>) -> Result<(), Failure> {
    let names: std::collections::BTreeSet<&str> = picture
        .panels
        .iter()
        .flat_map(|panel| panel.series.iter().map(|series| series.name.as_str()))
        .collect();
    let legend = names.len().div_ceil(LEGEND.0) as u32 * LEGEND.1 + 10;
    let rows = picture.panels.len().div_ceil(picture.columns);
    let (width, height) = picture.panel;
    let size = (width * picture.columns as u32, 34 + height * rows as u32 + legend);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let (title, rest) = root.split_vertically(34);
    title.titled(picture.title, (FONT, 20))?;
    let (panels, legend) = rest.split_vertically(height * rows as u32);
    let areas = panels.split_evenly((rows, picture.columns));
    for (area, panel) in areas.iter().zip(&picture.panels) {
        draw_panel(area, panel)?;
    }
    draw_legend(&legend, &picture.panels)?;
    root.present()?;
    Ok(())
}
