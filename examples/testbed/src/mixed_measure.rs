//! The error of a solution with joint rows as somebody else would measure it, and proofs, from the file as given.

use crate::judge::{self, Wide};
use crate::mixed::{Friction, Joint, MixedFile};
use nalgebra::DVector;

/// A scene of contacts and joint rows, to be judged at the impulses `lambda`. (A limit that is given to the solve and does not push is no row
/// of the scene.)
fn judged(file: &MixedFile, lambda: &[f64]) -> judge::Scene {
    let d = file.dim;
    let contact = |(i, mu): (usize, &Friction)| {
        let mut scales = vec![Wide::from(1.0); d];
        let soft = file.compliance.get(i).copied().unwrap_or_default();
        let coefficient = match mu {
            Friction::Isotropic(mu) if *mu > 0.0 => Wide::from(*mu),
            Friction::Rows(list) if list.iter().any(|&mu| mu > 0.0) => {
                let largest = list.iter().take(2).fold(0.0_f64, |m, &mu| m.max(mu));
                let largest = Wide::from(if largest > 0.0 { largest } else { 1.0 });
                for (scale, &mu) in scales.iter_mut().skip(1).zip(list) {
                    *scale = judge::ratio(Wide::from(mu), largest);
                }
                largest
            }
            // Without friction spin and roll do not count.
            _ => {
                scales.iter_mut().skip(3).for_each(|scale| *scale = judge::zero());
                judge::zero()
            }
        };
        let [normal, tangential] = soft;
        let compliance = |k: usize| match k {
            0 => Wide::from(normal),
            1 | 2 => scales[k] * scales[k] * tangential,
            _ if scales[k] > judge::zero() => Wide::from(tangential),
            _ => judge::zero(),
        };
        let offsets = judge::wide(&file.w[i * d..(i + 1) * d]);
        judge::Contact {
            rows: file.h[i * d..(i + 1) * d].iter().map(|row| judge::wide(row)).collect(),
            offset: offsets.iter().zip(&scales).map(|(&w, &scale)| scale * w).collect(),
            compliance: (0..d).map(compliance).collect(),
            scales,
            mu: coefficient,
            shift: coefficient,
        }
    };
    let row = |joint: &Joint| judge::Row {
        entries: judge::wide(&joint.row),
        offset: Wide::from(joint.offset),
        compliance: Wide::from(joint.compliance),
        bounds: match joint.kind.as_str() {
            "limit" => [Some(0.0), None],
            "equality" => [None, None],
            _ => [joint.lower, joint.upper],
        },
    };
    let is_soft = file.compliance.iter().flatten().any(|&soft| soft > 0.0);
    let has_shapes = file.mu.iter().any(|mu| matches!(mu, Friction::Rows(_)));
    let mut joints = file.joints.iter().zip(lambda);
    let has_rows =
        joints.any(|(joint, &impulse)| file.limits_inside || joint.kind != "limit" || impulse != 0.0);
    judge::Scene {
        mass: file.mass.iter().map(|row| judge::wide(row)).collect(),
        push: file.f.iter().map(|&f| Wide::from(-f)).collect(),
        contacts: file.mu.iter().enumerate().map(contact).collect(),
        rows: file.joints.iter().map(row).collect(),
        is_mixed: is_soft || has_shapes || has_rows,
    }
}

/// The largest of the errors of contacts, joint rows and dynamics, computed with twice the digits of f64. ("Joint rows" in
/// `src/guide/error.md` defines them.) Infinite if an impulse is outside of its bounds.
pub fn error(file: &MixedFile, v: &[f64], r: &[f64], lambda: &[f64]) -> f64 {
    let r: Vec<_> = r.chunks(file.dim).map(<[f64]>::to_vec).collect();
    let mut scene = judged(file, lambda);
    let error = scene.error(v, &r, lambda);
    if scene.is_mixed || scene.rows.is_empty() {
        return error;
    }
    // A limit that does not push may have been reached on the way: then it is a joint row.
    scene.is_mixed = true;
    error.min(scene.error(v, &r, lambda))
}

/// Does `d`, one a contact and one a joint row, prove that there is no velocity? Not negative on rigid normals and limits, free
/// on rigid equalities and zero elsewhere, with `H_Nᵀ d + Jᵀ d = 0` and `w_N · d + offset · d < 0`.
pub fn proves(file: &MixedFile, normals: &[f64], joints: &[f64]) -> bool {
    let Some(cholesky) = file.mass().cholesky() else {
        return false;
    };
    let whitened = |row: &[f64]| {
        let solved = cholesky.l().solve_lower_triangular(&DVector::from_column_slice(row));
        solved.unwrap_or_else(|| DVector::zeros(file.n_dof))
    };
    let mut sum = DVector::zeros(file.n_dof);
    let (mut size, mut power) = (0.0, 0.0);
    let mut add = |x: &DVector<f64>, offset: f64, d: f64| {
        sum += x * d;
        size += d.abs() * if x.norm() > 0.0 { x.norm() } else { 1.0 };
        power += offset * d;
    };
    for (i, &d) in normals.iter().enumerate() {
        let soft = file.compliance.get(i).is_some_and(|r| r[0] > 0.0);
        if d < 0.0 || soft && d != 0.0 {
            return false;
        }
        add(&whitened(&file.h[i * file.dim]), file.w[i * file.dim], d);
    }
    for (joint, &d) in file.joints.iter().zip(joints) {
        let allowed = match joint.kind.as_str() {
            "limit" => d >= 0.0,
            "equality" => true,
            _ => d == 0.0,
        };
        if !allowed || joint.compliance > 0.0 && d != 0.0 {
            return false;
        }
        add(&whitened(&joint.row), joint.offset, d);
    }
    power < 0.0 && sum.norm() <= 1e-7 * size
}
