//! Softness that a user asks for: springs with dampers in contacts and equalities.
//!
//! A spring of stiffness `k` with a damper `k τ` is implicit over a step `h`: its force is `-k (gap + h u) - k τ (u + outside)`, as the
//! gap has what moves from outside in it, and the velocity `u` has not. So the impulse is `-(u + offset) / R`, with the compliance
//! `R = 1 / (k h (h + τ))` and the offset `(gap + τ outside) / (h + τ)`.

use super::ffi::{ContactRef, Model};
use std::collections::HashMap;

/// Compliances (m/N): that of all, and whether `solref` comes before it; those of pairs of geoms, the smaller first, and of equalities.
pub(super) type Given = (f64, bool, HashMap<(usize, usize), f64>, HashMap<usize, f64>);

/// A spring with a damper.
#[derive(Clone, Copy)]
pub(super) struct Spring {
    /// `1 / k` (m/N).
    compliance: f64,
    /// `τ` (s).
    relaxation: f64,
}

impl Spring {
    /// A spring without a damper; `None` if it is rigid.
    fn new(compliance: f64) -> Option<Self> {
        (compliance > 0.0).then_some(Self { compliance, relaxation: 0.0 })
    }

    /// MuJoCo's direct form, `(-k, -k τ)`; `None` if it is of another one.
    fn direct([stiffness, damping]: [f64; 2]) -> Option<Self> {
        let is_direct = stiffness < 0.0 && damping <= 0.0;
        is_direct.then(|| Self { compliance: -1.0 / stiffness, relaxation: damping / stiffness })
    }

    /// Velocity per impulse (1/kg).
    pub(super) fn compliance(self, h: f64) -> f64 {
        self.compliance / (h * (h + self.relaxation))
    }

    /// The velocity with which it closes what is open (m/s).
    pub(super) fn offset(self, gap: f64, outside: f64, h: f64) -> f64 {
        (gap + self.relaxation * outside) / (h + self.relaxation)
    }
}

/// The springs of a model.
#[derive(Clone)]
pub(super) struct Springs(pub(super) Given);

impl Springs {
    pub(super) fn of_contact(&self, contact: ContactRef<'_>) -> Option<Spring> {
        let [one, other] = contact.geoms();
        self.of(self.0.2.get(&(one.min(other), one.max(other))), || contact.solref())
    }

    pub(super) fn of_equality(&self, model: &Model, equality: usize) -> Option<Spring> {
        self.of(self.0.3.get(&equality), || model.eq_solref()[equality])
    }

    fn of(&self, named: Option<&f64>, solref: impl FnOnce() -> [f64; 2]) -> Option<Spring> {
        let &Self((all, reads_solref, ..)) = self;
        let direct = || reads_solref.then(solref).and_then(Spring::direct);
        named.map_or_else(|| direct().or(Spring::new(all)), |&own| Spring::new(own))
    }
}
