//! An axis with ticks of our own choice, linear or logarithmic.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// A range with its ticks and their labels.
#[derive(Clone)]
pub(crate) struct Axis {
    pub(crate) name: &'static str,
    pub(crate) range: (f64, f64),
    pub(crate) ticks: Vec<f64>,
    pub(crate) logarithmic: bool,
}

impl Axis {
    /// Powers of ten from `10^from` to `10^to`, with a tick where `every` divides the exponent.
    pub(crate) fn decades(name: &'static str, from: i32, to: i32, every: i32) -> Self {
        let ticks = (from..=to).filter(|tick| tick % every == 0);
        Self {
            name,
            range: (10_f64.powi(from), 10_f64.powi(to)),
            ticks: ticks.map(|tick| 10_f64.powi(tick)).collect(),
            logarithmic: true,
        }
    }

    /// From 1, 2 or 5 times a power of ten to another, with ticks there or, if those are many, at the
    /// powers of ten alone.
    pub(crate) fn around(name: &'static str, values: impl Iterator<Item = f64>) -> Self {
        let values = values.filter(|value| *value > 0.0);
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (from, to) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let steps = (from..=to).flat_map(|k| [1.0, 2.0, 5.0].map(|step| step * 10_f64.powi(k)));
        let steps: Vec<f64> = steps.collect();
        let first = steps.iter().rposition(|&step| step <= low * 1.0001).unwrap_or(0);
        let last = steps.iter().position(|&step| step >= high * 0.9999);
        let steps = &steps[first..=last.unwrap_or(steps.len() - 1)];
        let every = if steps.len() > 8 { "1" } else { "" };
        let ticks = steps.iter().filter(|step| format!("{step:e}").starts_with(every));
        Self {
            name,
            range: (steps[0], steps[steps.len() - 1]),
            ticks: ticks.copied().collect(),
            logarithmic: true,
        }
    }

    fn scaled(&self, value: f64) -> f64 {
        let value = value.clamp(self.range.0, self.range.1);
        if self.logarithmic { value.ln() } else { value }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// Values beyond the range stand at its end.
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (low, high) = (self.scaled(self.range.0), self.scaled(self.range.1));
        let part = (self.scaled(*value) - low) / (high - low);
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        if !self.logarithmic || (0.01..1e5).contains(value) {
            format!("{}", (value * 1e6).round() / 1e6)
        } else {
            format!("{value:e}")
        }
    }
}
