//! Sweeps of the position pass, in coordinates in which all masses are one: a line costs as much as there are velocities.

use super::asked::{Demand, Grip};
use super::inertia::Inertia;
use super::rows::{Kind, Row};
use super::touch::{Touch, dot};
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;

/// The most sweeps, and after how many it is asked whether these will be enough.
const SWEEPS: usize = 200;
const FIRST: usize = 20;

/// The most lines that are held at once, and how fast what does not press may be entered, over the fastest motion: that is rounding.
const MOST_HELD: usize = 48;
const ENTERED: f64 = 1e-9;

/// A line on the way: what an impulse along it moves, and what has been done.
struct Line {
    stiffness: f64,
    compliance: f64,
    offset: f64,
    impulse: f64,
    start: f64,
}

/// What bounds lines.
enum Law {
    /// A normal, and behind it tangents that are stretched so that the normal impulse bounds them.
    Contact {
        /// How many: none or two.
        tangents: usize,
        /// The largest stiffness of a direction between the two.
        stiffness: f64,
        /// What touches.
        geoms: [usize; 2],
    },
    /// A row.
    Row {
        /// The least impulse that its law allows.
        least: f64,
    },
}

/// The lines of an island.
#[derive(Default)]
pub(super) struct Settler {
    n: usize,
    matrix: Vec<f64>,
    lines: Vec<Line>,
    laws: Vec<Law>,
    motion: Vec<f64>,
}

impl Settler {
    /// Begins an island of so many velocities.
    pub(super) fn begin(&mut self, velocities: usize) {
        self.n = velocities;
        self.matrix.clear();
        self.lines.clear();
        self.laws.clear();
    }

    /// Adds a line: a row, stretched, with its offset and its compliance before that.
    fn line(
        &mut self,
        (inertia, dofs): (&Inertia, &[usize]),
        row: &[f64],
        (stretch, offset, compliance, start): (f64, f64, f64, f64),
    ) {
        let first = self.matrix.len();
        inertia.to_unit(dofs, row, &mut self.matrix);
        let own = &mut self.matrix[first..];
        for own in own.iter_mut() {
            *own *= stretch;
        }
        let compliance = compliance * stretch * stretch;
        let stiffness = dot(own, own) + compliance;
        self.lines.push(Line { stiffness, compliance, offset, impulse: start, start });
    }

    /// Adds the lines of a contact.
    pub(super) fn contact(
        &mut self,
        place: (&Inertia, &[usize]),
        touch: &Touch,
        demand: &Demand,
        grip: &Grip,
    ) {
        let nv = touch.rows.len() / touch.dim;
        let mut rows = touch.rows.chunks_exact(nv);
        if let Some(row) = rows.next() {
            self.line(place, row, (1.0, demand.offset, demand.compliance, grip.start));
        }
        let first = self.lines.len();
        if grip.rubs && touch.dim > 1 && touch.mu() > 0.0 {
            for ((row, &mu), slip) in rows.zip(&touch.friction[..2]).zip(grip.slip) {
                self.line(place, row, (mu, mu * slip, grip.compliance, 0.0));
            }
        }
        let tangents = self.lines.len() - first;
        let own: Vec<_> = (first..self.lines.len()).map(|i| &self.matrix[i * self.n..][..self.n]).collect();
        let stiffness = match (&self.lines[first..], &own[..]) {
            ([one, other], [a, b]) => {
                let half = 0.5 * (one.stiffness - other.stiffness);
                0.5 * (one.stiffness + other.stiffness) + half.hypot(dot(a, b))
            }
            _ => 0.0,
        };
        self.laws.push(Law::Contact { tangents, stiffness, geoms: touch.face.geoms });
    }

    /// Adds the line of a row.
    pub(super) fn row(&mut self, place: (&Inertia, &[usize]), row: &Row, demand: &Demand) {
        self.line(place, &row.jacobian, (1.0, demand.offset, demand.compliance, 0.0));
        let least = if row.kind == Kind::Equality { -f64::INFINITY } else { 0.0 };
        self.laws.push(Law::Row { least });
    }

    /// Stops at once what presses or closes, and keeps the rest as it is; `false` if that is not the answer: something would pull, slip or
    /// be entered.
    pub(super) fn hold(&mut self) -> bool {
        self.motion.clear();
        self.motion.resize(self.n, 0.0);
        let mut held = Vec::new();
        self.each_law(|law, lines, i| match *law {
            Law::Contact { tangents, .. } if lines[i].start > 0.0 || lines[i].offset < 0.0 => {
                held.extend(i..=i + tangents);
            }
            Law::Row { least } if least < 0.0 || lines[i].offset < 0.0 => held.push(i),
            _ => {}
        });
        if held.is_empty() || held.len() > MOST_HELD {
            return false;
        }
        let row = |i: usize| &self.matrix[i * self.n..][..self.n];
        let mut system = DMatrix::from_fn(held.len(), held.len(), |i, j| dot(row(held[i]), row(held[j])));
        held.iter().enumerate().for_each(|(i, &line)| system[(i, i)] += self.lines[line].compliance);
        let asked = DVector::from_iterator(held.len(), held.iter().map(|&line| -self.lines[line].offset));
        let Some(factor) = system.cholesky() else {
            return false;
        };
        for (&line, change) in held.iter().zip(&factor.solve(&asked)) {
            self.set(line, self.lines[line].start + change);
        }
        let slowest = -ENTERED * self.motion.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let (mut holds, mut faces) = (true, HashMap::new());
        self.each_law(|law, lines, i| {
            let opens =
                || dot(&self.matrix[i * self.n..][..self.n], &self.motion) + lines[i].offset >= slowest;
            let rub = |tangents| {
                if tangents == 2 { lines[i + 1].impulse.hypot(lines[i + 2].impulse) } else { 0.0 }
            };
            match *law {
                Law::Contact { tangents, geoms, .. } if lines[i].start > 0.0 => {
                    // Which corner of a face bears is for the velocity pass to say.
                    let [press, rubs] = faces.entry(geoms).or_insert([0.0; 2]);
                    *press += lines[i].impulse;
                    *rubs += rub(tangents);
                }
                Law::Contact { tangents, .. } if lines[i].offset < 0.0 => {
                    holds &= rub(tangents) <= lines[i].impulse;
                }
                Law::Row { least } if least < 0.0 => {}
                Law::Row { .. } if lines[i].offset < 0.0 => holds &= lines[i].impulse >= 0.0,
                Law::Contact { .. } | Law::Row { .. } => holds &= opens(),
            }
        });
        holds &= faces.values().all(|&[press, rub]| rub <= press);
        if !holds {
            self.lines.iter_mut().for_each(|line| line.impulse = line.start);
        }
        holds
    }

    /// Tells each law with all lines, and where its own begin.
    fn each_law(&self, mut tell: impl FnMut(&Law, &[Line], usize)) {
        let mut i = 0;
        for law in &self.laws {
            tell(law, &self.lines, i);
            i += match law {
                Law::Contact { tangents, .. } => 1 + tangents,
                Law::Row { .. } => 1,
            };
        }
    }

    /// The impulse that would stop a line of this stiffness.
    fn wanted(&self, i: usize, stiffness: f64) -> f64 {
        let line = &self.lines[i];
        if stiffness <= 0.0 {
            return 0.0; // nothing moves it
        }
        let speed = dot(&self.matrix[i * self.n..][..self.n], &self.motion) + line.offset;
        line.impulse - (speed + line.compliance * (line.impulse - line.start)) / stiffness
    }

    /// Sets an impulse; the square of what that changes, in the metric of the line alone.
    fn set(&mut self, i: usize, impulse: f64) -> f64 {
        let line = &mut self.lines[i];
        let change = impulse - line.impulse;
        line.impulse = impulse;
        if change == 0.0 {
            return 0.0;
        }
        let row = &self.matrix[i * self.n..][..self.n];
        for (v, a) in self.motion.iter_mut().zip(row) {
            *v += change * a;
        }
        change * change * line.stiffness
    }

    /// Sweeps until what is left to do is a share of what was done; `false` if it takes too long.
    pub(super) fn sweep(&mut self, tolerance: f64) -> bool {
        self.motion.clear();
        self.motion.resize(self.n, 0.0);
        let mut last = f64::INFINITY;
        for done in 0..SWEEPS {
            let change = self.sweep_once();
            let size: f64 =
                (self.lines.iter()).map(|line| line.stiffness * (line.impulse - line.start).powi(2)).sum();
            // What further sweeps would change at this rate.
            let (rate, most) = (change / last, tolerance * size.sqrt());
            let left = |change: f64| change * rate / (1.0 - rate);
            if change == 0.0 || (done > 0 && rate < 1.0 && left(change) <= most) {
                return true;
            }
            #[allow(clippy::cast_precision_loss)] // of a few hundred
            let later = change * rate.powf((SWEEPS - done) as f64);
            if done > FIRST && (rate >= 1.0 || left(later) > most) {
                return false;
            }
            last = change;
        }
        false
    }

    /// Goes over all lines once; how much that changes, in the metric of the lines alone.
    fn sweep_once(&mut self) -> f64 {
        let (mut i, mut change) = (0, 0.0);
        for law in 0..self.laws.len() {
            match self.laws[law] {
                Law::Contact { tangents, stiffness, .. } => {
                    let normal = self.wanted(i, self.lines[i].stiffness).max(0.0);
                    // What is open stays so.
                    if normal > 0.0 || self.lines[i].impulse > 0.0 {
                        change += self.set(i, normal);
                        if tangents == 2 {
                            let wanted = [i + 1, i + 2].map(|line| self.wanted(line, stiffness));
                            let length = wanted[0].hypot(wanted[1]);
                            let share = if length > normal { normal / length } else { 1.0 };
                            change += self.set(i + 1, share * wanted[0]);
                            change += self.set(i + 2, share * wanted[1]);
                        }
                    }
                    i += 1 + tangents;
                }
                Law::Row { least } => {
                    let wanted = self.wanted(i, self.lines[i].stiffness);
                    change += self.set(i, wanted.max(least));
                    i += 1;
                }
            }
        }
        change.sqrt()
    }

    /// Writes the motion.
    pub(super) fn write(&mut self, (inertia, dofs): (&Inertia, &[usize]), correction: &mut [f64]) {
        inertia.back_from_unit(dofs, &mut self.motion, |dof, z| correction[dof] = z);
    }
}
