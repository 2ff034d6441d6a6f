//! Every helper of `time_stepping`, and the frame of a contact.

use crate::proof::take;
use core::hint::black_box;
use nalgebra::{SMatrix, SVector};
use stiction::time_stepping::{
    ClosedLoop, DryFriction, Gap, JointLimit, Motor, Restitution, Spring, StaticFriction, Suction,
    free_impulse, moving_surface,
};
use stiction::{Contact, Error, JointRow, Real, contact_frame};

/// A joint row of each kind.
pub(crate) fn rows<T: Real, const N: usize>() -> [Result<JointRow<T, N>, Error>; 4] {
    let row: SVector<T, N> = black_box(SVector::zeros());
    let [a, b, c, d] = black_box([T::ONE; 4]);
    let limit = black_box(JointLimit { distance: a, recovery: b, reach: c });
    let motor = black_box(Motor { stiffness: a, damping: b, feedforward: c, limit: d, ahead: a, target: b });
    let closed = black_box(ClosedLoop { drift: a, recovery: b });
    [
        limit.row(row, d, 0),
        black_box(DryFriction { torque: a }).row(row, b, 1),
        motor.row(row, c, 2),
        closed.row(-row, c, 3),
    ]
}

/// Those of contacts with friction.
pub(crate) fn call<T: Real, const N: usize, const D: usize>() {
    let [a, b, c, d] = black_box([T::ONE; 4]);
    let mass: SMatrix<T, N, N> = black_box(SMatrix::identity());
    let jacobian: SMatrix<T, D, N> = black_box(SMatrix::zeros());
    let mut push: SVector<T, N> = black_box(SVector::zeros());
    black_box(free_impulse(&mass, &push, &push, a));
    black_box(moving_surface(&jacobian, &push));

    let gap = black_box(Gap { distance: a, recovery: b, reach: c });
    take(gap.offset(d));
    take(black_box(Gap::default()).offset(d));
    let spring = black_box(Spring { stiffness: a, relaxation: b });
    take(spring.compliance(c));
    take(spring.offset(&gap, c));
    let restitution = black_box(Restitution { coefficient: a, threshold: b });
    take(restitution.offset(c, d));
    let suction = black_box(Suction { force: a, touches: black_box(true) });
    take(suction.push_back(&jacobian, b, &mut push));
    let impulse: SVector<T, D> = black_box(SVector::zeros());
    take(suction.impulse(&impulse, b));
    let friction = black_box(StaticFriction { at_rest: a, sliding: b });
    black_box(friction.mu(black_box(None)));

    let normal: SVector<T, D> = black_box(SVector::zeros());
    take(contact_frame(&normal));
    take(Contact::<T, N, D>::at_point(&normal, &jacobian, a, 0));
    for row in [
        JointLimit::default().row(push, black_box(a), 0),
        Motor::default().row(push, black_box(a), 0),
        ClosedLoop::default().row(push, black_box(a), 0),
    ] {
        take(row);
    }
}

/// A contact without tangents, and one that resists spin and rolling, in space.
pub(crate) fn call_spatial<T: Real, const N: usize>() {
    let normal: SVector<T, 3> = black_box(SVector::zeros());
    let jacobian: SMatrix<T, 3, N> = black_box(SMatrix::zeros());
    let contact = Contact::<T, N, 1>::at_point(&normal, &jacobian, T::ZERO, 0);
    take(contact);
    take(Contact::<T, N, 6>::at_patch(&normal, &jacobian, &jacobian, 0));
}
