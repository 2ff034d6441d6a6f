//! The error of a solution with joint rows as somebody else would measure it, and proofs: in f64, from the file as given.

use crate::measure::project;
use crate::mixed::{Friction, MixedFile};
use nalgebra::{DMatrix, DVector};

/// A file brought into scaled rows.
struct Rows {
    /// Cone coefficients, and the scales of all contact rows.
    mu: Vec<f64>,
    scales: DVector<f64>,
    h: DMatrix<f64>,
    w: DVector<f64>,
    compliance: DVector<f64>,
    j: DMatrix<f64>,
    /// `L⁻¹ Hᵀ` and `L⁻¹ Jᵀ` with `M = L Lᵀ`.
    xh: DMatrix<f64>,
    xj: DMatrix<f64>,
    /// `L⁻¹ M v_free`
    y: DVector<f64>,
    v_free: DVector<f64>,
}

fn rows(file: &MixedFile) -> Option<Rows> {
    let (n, d) = (file.n_dof, file.dim);
    let cholesky = file.mass().cholesky()?;
    let mut scales = DVector::from_element(d * file.n_contacts, 1.0);
    let mut compliance = DVector::zeros(d * file.n_contacts);
    let mut coefficients = Vec::new();
    for (i, mu) in file.mu.iter().enumerate() {
        let coefficient = match mu {
            Friction::Isotropic(mu) => *mu,
            Friction::Rows(list) => {
                let largest = list.iter().take(2).fold(0.0_f64, |m, &mu| m.max(mu));
                let largest = if largest > 0.0 { largest } else { 1.0 };
                for (k, mu) in list.iter().enumerate() {
                    scales[i * d + 1 + k] = mu / largest;
                }
                largest
            }
        };
        coefficients.push(coefficient);
        let [normal, tangential] = file.compliance.get(i).copied().unwrap_or_default();
        compliance[i * d] = normal;
        for k in 1..d {
            let t = scales[i * d + k];
            let spins = if t > 0.0 { tangential } else { 0.0 };
            compliance[i * d + k] = if k < 3 { tangential * t * t } else { spins };
        }
    }
    let h = DMatrix::from_fn(d * file.n_contacts, n, |i, j| scales[i] * file.h[i][j]);
    let w = DVector::from_fn(d * file.n_contacts, |i, _| scales[i] * file.w[i]);
    let j = DMatrix::from_fn(file.joints.len(), n, |i, j| file.joints[i].row[j]);
    let lower = cholesky.l();
    let minus_f = -DVector::from_column_slice(&file.f);
    Some(Rows {
        mu: coefficients,
        xh: lower.solve_lower_triangular(&h.transpose())?,
        xj: lower.solve_lower_triangular(&j.transpose())?,
        y: lower.solve_lower_triangular(&minus_f)?,
        v_free: cholesky.solve(&minus_f),
        scales,
        h,
        w,
        compliance,
        j,
    })
}

fn bounds(file: &MixedFile, j: usize) -> (f64, f64) {
    let joint = &file.joints[j];
    match joint.kind.as_str() {
        "limit" => (0.0, f64::INFINITY),
        "equality" => (f64::NEG_INFINITY, f64::INFINITY),
        _ => (
            joint.lower.unwrap_or(f64::NAN),
            joint.upper.unwrap_or(f64::NAN),
        ),
    }
}

fn ratio(x: f64, y: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / y }
}

/// `Π_K(r - alpha û)` of a contact, from `r` and `u`.
fn projected(mu: f64, alpha: f64, r: &[f64], u: &[f64]) -> Vec<f64> {
    let slip = u[1..].iter().map(|x| x * x).sum::<f64>().sqrt();
    let push = r.iter().zip(u).enumerate();
    let push: Vec<f64> = push
        .map(|(k, (r, u))| r - alpha * (u + if k == 0 { mu * slip } else { 0.0 }))
        .collect();
    project(&push, mu)
}

/// The error of the dynamics in both norms; `least` are the last two terms of `S²`.
fn dynamics(
    file: &MixedFile,
    rows: &Rows,
    (v, r, lambda): (&DVector<f64>, &DVector<f64>, &DVector<f64>),
    least: f64,
) -> [f64; 2] {
    let mass = file.mass();
    let (inertia, f) = (&mass * v, DVector::from_column_slice(&file.f));
    let h = DMatrix::from_fn(r.len(), file.n_dof, |i, j| file.h[i][j]);
    let pushed = h.transpose() * r + rows.j.transpose() * lambda;
    let weights = mass.diagonal().map(|m| 1.0 / m.sqrt());
    let heaviest = mass.diagonal().max().sqrt();
    let norms = [
        (DVector::from_element(file.n_dof, 1.0), heaviest),
        (weights, 1.0),
    ];
    norms.map(|(g, unit)| {
        let size = |x: &DVector<f64>| g.component_mul(x).norm();
        let gap = &inertia + &f - &pushed;
        let sizes = [
            size(&f),
            size(&inertia),
            size(&pushed),
            1e-2 * least.sqrt() * unit,
        ];
        ratio(size(&gap), sizes.into_iter().fold(0.0, f64::max))
    })
}

/// The largest of the errors of contacts, joint rows and dynamics. ("Joint rows" in `src/guide/rows.md` defines them.)
pub fn error(file: &MixedFile, v: &[f64], r: &[f64], lambda: &[f64]) -> f64 {
    let Some(rows) = rows(file) else {
        return f64::INFINITY;
    };
    let d = file.dim;
    let (v, r) = (DVector::from_row_slice(v), DVector::from_row_slice(r));
    let lambda = DVector::from_row_slice(lambda);
    let scaled = r.zip_map(&rows.scales, |r, t| if t > 0.0 { r / t } else { 0.0 });
    let stray: f64 = r
        .iter()
        .zip(&rows.scales)
        .filter(|(_, t)| **t == 0.0)
        .map(|(r, _)| r * r)
        .sum();
    let u = &rows.h * &v + &rows.w + rows.compliance.component_mul(&scaled);
    let q = rows.xh.transpose() * &rows.y + &rows.w;
    let (mut off, mut alone, mut floor, mut energy) = (stray, 0.0, 0.0, 0.0);
    for i in 0..file.n_contacts {
        let own = i * d..i * d + d;
        let trace: f64 = own
            .clone()
            .map(|k| rows.xh.column(k).norm_squared() + rows.compliance[k])
            .sum();
        let alpha = if trace > 0.0 { d as f64 / trace } else { 0.0 };
        let slice = |x: &DVector<f64>| x.as_slice()[own.clone()].to_vec();
        let (ri, ui, qi) = (slice(&scaled), slice(&u), slice(&q));
        let nearest = projected(rows.mu[i], alpha, &ri, &ui);
        off += ri
            .iter()
            .zip(nearest)
            .map(|(r, x)| (r - x).powi(2))
            .sum::<f64>();
        let first = projected(rows.mu[i], alpha, &vec![0.0; d], &qi);
        let square: f64 = first.iter().map(|x| x * x).sum();
        alone += square;
        energy += ratio(square, alpha);
        for k in own.clone() {
            let w = if k % d == 0 {
                rows.w[k].min(0.0)
            } else {
                rows.w[k]
            };
            let speed = rows
                .h
                .row(k)
                .iter()
                .zip(&rows.v_free)
                .map(|(h, v)| (h * v).abs())
                .sum::<f64>();
            floor += (1e-2 * alpha * (speed + w.abs())).powi(2);
        }
    }
    let contacts = ratio(off.sqrt(), scaled.norm().max(alone.max(floor).sqrt()));
    let mut off = 0.0;
    for (j, joint) in file.joints.iter().enumerate() {
        let (lower, upper) = bounds(file, j);
        let inertia = rows.xj.column(j).norm_squared() + joint.compliance;
        let s = rows.j.row(j).dot(&v.transpose()) + joint.offset + joint.compliance * lambda[j];
        let s_free = rows.xj.column(j).dot(&rows.y) + joint.offset;
        if inertia > 0.0 {
            off += inertia * (lambda[j] - (lambda[j] - s / inertia).clamp(lower, upper)).powi(2);
            energy += inertia * (-s_free / inertia).clamp(lower, upper).powi(2);
        } else if s > 0.0 && lower.is_infinite() || s < 0.0 && upper.is_infinite() {
            return f64::INFINITY;
        }
    }
    let net = &rows.xh * &scaled + &rows.xj * &lambda;
    let mut work = net.norm_squared() + scaled.component_mul(&scaled).dot(&rows.compliance);
    work += lambda
        .iter()
        .zip(&file.joints)
        .map(|(l, joint)| joint.compliance * l * l)
        .sum::<f64>();
    let least = f64::max(energy, 1e-4 * rows.y.norm_squared());
    let joints = ratio(off.sqrt(), work.max(least).sqrt());
    let dynamics = dynamics(file, &rows, (&v, &r, &lambda), least);
    let errors = [contacts, joints, dynamics[0], dynamics[1]];
    if errors.iter().all(|error| error.is_finite()) {
        errors.into_iter().fold(0.0, f64::max)
    } else {
        f64::INFINITY
    }
}

/// Does `d`, one a contact and one a joint row, prove that there is no velocity? Not negative on rigid normals and limits, free
/// on rigid equalities and zero elsewhere, with `H_Nᵀ d + Jᵀ d = 0` and `w_N · d + offset · d < 0`.
pub fn proves(file: &MixedFile, normals: &[f64], joints: &[f64]) -> bool {
    let Some(rows) = rows(file) else {
        return false;
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
        add(
            &rows.xh.column(i * file.dim).into_owned(),
            file.w[i * file.dim],
            d,
        );
    }
    for (j, (joint, &d)) in file.joints.iter().zip(joints).enumerate() {
        let allowed = match joint.kind.as_str() {
            "limit" => d >= 0.0,
            "equality" => true,
            _ => d == 0.0,
        };
        if !allowed || joint.compliance > 0.0 && d != 0.0 {
            return false;
        }
        add(&rows.xj.column(j).into_owned(), joint.offset, d);
    }
    power < 0.0 && sum.norm() <= 1e-7 * size
}
