//! The stored factor: what depends on `M` and `H` alone, computed once and reused by every solve.
//!
//! The note factorises `A = M + rho HᵀH` and solves with it at each iteration (step 2). With the
//! Delassus operator `W = H M⁻¹ Hᵀ` the same step is one symmetric product in contact space:
//! `H A⁻¹ = B H M⁻¹` with the resolvent `B = (I + rho W)⁻¹ = I - rho H A⁻¹ Hᵀ`, so that
//!
//! `H vᵏ⁺¹ + b = y + B (q + S - y)`, `y = û - ζ̂`, `q = H v_free + w`, `S_i = mu_i s_i e_N`.
//!
//! That needs `(D·C)²` multiplications against `N² + 2·N·D·C` through the factor of `A`, and a new
//! `rho` never touches the `N × N` factor again.

use crate::cholesky::{factorise, opaque, opaque_mut, rolled};
use crate::contact_space::{ContactMatrix, ContactVector, block, inverse, multiply_transposed};
use crate::residual::larger;
use crate::resolvent::{Resolvent, is_usable};
use crate::substitution::{Scaled, solve_lower, solve_upper, solve_upper_block};
use crate::support::{GROUP, Support, add_columns, add_products};
use crate::{Error, Real, Scene};
use heapless::Vec;

/// Cholesky factor of the mass matrix, Delassus operator and resolvent of a scene.
///
/// Read-only once computed; it may outlive any number of solves and stand in a `static`. Friction
/// coefficients, offsets and the free impulse are no part of it.
#[derive(Clone, Debug)]
pub struct Factor<T, const N: usize, const D: usize, const C: usize> {
    contacts: usize,
    /// How many dofs contacts move.
    moved: usize,
    penalty: T,
    /// How far rounding may have moved `W`, relative to it.
    uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`.
    mass: [[T; N]; N],
    /// `X_i`, `Uᵀ D⁻¹ X_i = H_iᵀ`
    whitened: [[[T; D]; N]; C],
    /// Of the `X_iᵀ`.
    supports: [Support; C],
    /// `W = H M⁻¹ Hᵀ`.
    delassus: ContactMatrix<T, D, C>,
    /// `W_ii⁻¹`; zero where that is singular, or nearly so.
    effective_mass: [[[T; D]; D]; C],
    resolvent: Resolvent<T, D, C>,
    /// Is the resolvent that of `W` and the penalty?
    is_complete: bool,
}

/// The numbers of a [`Factor`] of `C` contacts, to be written down on the host and read by firmware.
///
/// Blocks of `D` rows a contact; matrices row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorParts<T, const N: usize, const D: usize, const C: usize> {
    /// How many dofs contacts move.
    pub moved: usize,
    /// The default penalty `rho`.
    pub penalty: T,
    /// A bound on the rounding of `W`, relative to it.
    pub uncertainty: T,
    /// `M = Uᵀ D⁻¹ U`: below the diagonal `U`, which has `D` on its diagonal, and there `D⁻¹`; the
    /// upper triangle is not used.
    pub mass: [[T; N]; N],
    /// `X_i` of each contact, with `Uᵀ D⁻¹ X_i = H_iᵀ`.
    pub whitened: [[[T; D]; N]; C],
    /// `W = H M⁻¹ Hᵀ`.
    pub delassus: [[[[T; D]; C]; D]; C],
    /// The effective mass `W_ii⁻¹` of each contact; zero where `W_ii` is singular or nearly so, or `D > 3`.
    pub effective_mass: [[[T; D]; D]; C],
    /// `(I + R W)⁻¹`.
    pub resolvent: [[[[T; D]; C]; D]; C],
    /// The diagonal of `R`, one penalty a contact.
    pub penalties: [T; C],
}

impl<T: Real, const N: usize, const D: usize, const C: usize> Factor<T, N, D, C> {
    /// A factor from numbers that [`Self::parts`] gave, to stand in a `static`.
    ///
    /// Nothing is checked. With the numbers of another scene nothing that a solve says holds: the
    /// steps `alpha_i` that its error is measured in, and bounds on rounding, are those of `W`.
    #[must_use]
    pub const fn from_parts(parts: &FactorParts<T, N, D, C>) -> Self {
        Self {
            contacts: C,
            moved: parts.moved,
            penalty: parts.penalty,
            uncertainty: parts.uncertainty,
            mass: parts.mass,
            whitened: parts.whitened,
            supports: [Support::all(); C],
            delassus: parts.delassus,
            effective_mass: parts.effective_mass,
            resolvent: Resolvent {
                penalties: parts.penalties,
                matrix: parts.resolvent,
            },
            is_complete: true,
        }
    }

    /// The numbers of this factor; `None` unless it is of `C` contacts and has its resolvent.
    #[must_use]
    pub fn parts(&self) -> Option<FactorParts<T, N, D, C>> {
        (self.contacts == C && self.is_complete).then_some(FactorParts {
            moved: self.moved,
            penalty: self.penalty,
            uncertainty: self.uncertainty,
            mass: self.mass,
            whitened: self.whitened,
            delassus: self.delassus,
            effective_mass: self.effective_mass,
            resolvent: self.resolvent.matrix,
            penalties: self.resolvent.penalties,
        })
    }

    /// An empty factor, to be filled by [`Self::compute`]: all zeros, so that a `static` of it takes
    /// no flash.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            contacts: 0,
            moved: 0,
            penalty: T::ZERO,
            uncertainty: T::ZERO,
            mass: [[T::ZERO; N]; N],
            whitened: [[[T::ZERO; D]; N]; C],
            supports: [Support::none(); C],
            delassus: [[[[T::ZERO; D]; C]; D]; C],
            effective_mass: [[[T::ZERO; D]; D]; C],
            resolvent: Resolvent::empty(),
            is_complete: false,
        }
    }

    /// Factorises a scene with the default penalty.
    ///
    /// # Errors
    /// As [`Self::compute`].
    pub fn new(scene: &Scene<T, N, D, C>) -> Result<Self, Error> {
        let mut factor = Self::empty();
        factor.compute(scene)?;
        Ok(factor)
    }

    /// Factorises a scene in place, with the default penalty; see [`Self::penalty`].
    ///
    /// For a scene that is solved many times, by any method. Where `M` or `H` change before the next
    /// solve, [`Self::update`] is cheaper.
    ///
    /// # Errors
    /// [`Error::MassNotPositiveDefinite`]; [`Error::InvalidPenalty`] if `HᵀH / M` or `W` overflows, or is
    /// spread so wide that `I + rho W` is singular in this number type.
    pub fn compute(&mut self, scene: &Scene<T, N, D, C>) -> Result<(), Error> {
        self.update(scene)?;
        let result = self.set_penalty(self.penalty);
        if result.is_err() {
            self.contacts = 0;
        }
        result
    }

    /// Factorises a scene in place for one solve by [`crate::Solver`]: without the resolvent, which is
    /// up to three fifths of the work (the more, the more contact rows a dof), and which most solves
    /// do without.
    ///
    /// A solve that needs it computes it for itself, and its solution has the same bits: a cold start where contacts have
    /// more rows than they move dofs and may slip or hold, or sweeps or a guess that fail. [`crate::AdmmSolver`]
    /// always needs it; it takes the factor after [`Self::set_penalty`].
    ///
    /// # Errors
    /// [`Error::MassNotPositiveDefinite`]; [`Error::InvalidPenalty`] if `HᵀH / M` or `W` overflows.
    pub fn update(&mut self, scene: &Scene<T, N, D, C>) -> Result<(), Error> {
        self.is_complete = false;
        self.compute_delassus(scene)?;
        (self.penalty, self.moved) = default_penalty(scene);
        if is_usable(self.penalty)
            && (0..self.contacts).all(|contact| self.trace(contact).is_finite())
        {
            return Ok(());
        }
        self.contacts = 0;
        Err(Error::InvalidPenalty)
    }

    /// Replaces the penalty `rho` (kg): one factorisation of `I + rho W`, none of `M`.
    ///
    /// # Errors
    /// [`Error::InvalidPenalty`] if `rho` is not positive and finite, or so large that
    /// `I + rho W` is singular in this number type. The factor keeps its old penalty.
    pub fn set_penalty(&mut self, penalty: T) -> Result<(), Error> {
        let (delassus, contacts) = (&self.delassus, self.contacts);
        let result = self.resolvent.compute(delassus, contacts, &[penalty; C]);
        if result.is_ok() {
            self.penalty = penalty;
            self.is_complete = true;
        } else if self.is_complete {
            let old = [self.penalty; C];
            self.is_complete = self.resolvent.compute(delassus, contacts, &old).is_ok();
        }
        result
    }

    /// The penalty `rho` (kg) of the augmented Lagrangian.
    #[must_use]
    pub const fn penalty(&self) -> T {
        self.penalty
    }

    /// How many dofs contacts move.
    pub(crate) const fn moved(&self) -> usize {
        self.moved
    }

    /// Number of contacts of the scene this was computed for.
    #[must_use]
    pub const fn contacts(&self) -> usize {
        self.contacts
    }

    /// `trace(W_ii)`
    fn trace(&self, contact: usize) -> T {
        let rows = self.delassus.get(contact).into_iter().flatten();
        rows.enumerate().fold(T::ZERO, |trace, (row, entries)| {
            let block = entries.get(contact).into_iter().flatten();
            trace + block.copied().nth(row).unwrap_or(T::ZERO)
        })
    }

    /// Step `alpha_i = D / trace(W_ii)` (kg) of the natural map; 0 for a contact that nothing moves.
    #[must_use]
    pub fn step(&self, contact: usize) -> T {
        let trace = self.trace(contact);
        if trace > T::ZERO {
            T::count(D) / trace
        } else {
            T::ZERO
        }
    }

    #[cfg_attr(target_os = "none", inline(never))]
    fn compute_delassus(&mut self, scene: &Scene<T, N, D, C>) -> Result<(), Error> {
        self.contacts = 0;
        let mass = &scene.mass().data.0; // symmetric: columns are rows
        let floor = T::literal(32.0) * T::EPSILON;
        let mut reach = [usize::MAX; N]; // zeros would call memset
        factorise(mass, floor, &mut self.mass, &mut reach)
            .map_err(|dof| Error::MassNotPositiveDefinite { dof })?;
        self.measure_uncertainty(mass);
        self.contacts = scene.contacts().len();
        let mut scaled = Vec::new();
        for (i, contact) in opaque(scene.contacts()).iter().enumerate() {
            rolled();
            let Some(whitened) = self.whitened.get_mut(i) else {
                break;
            };
            let transpose = &contact.jacobian.data.0; // D rows in N columns
            scaled.clear();
            solve_upper_block(&self.mass, &reach, transpose, whitened, &mut scaled);
            for (j, y) in self.whitened.iter().enumerate().take(i + 1) {
                rolled();
                let block = products(&scaled, y);
                for (a, entries) in block.into_iter().enumerate() {
                    set(&mut self.delassus, [i, j], a, entries);
                }
            }
            if let Some(support) = self.supports.get_mut(i) {
                *support = Support::of::<N>(scaled.iter().map(|row| row.place));
            }
            let own = block(&self.delassus, i, i);
            if let (Some(mass), Some(own)) = (self.effective_mass.get_mut(i), own) {
                *mass = inverse(&own);
            }
        }
        Ok(())
    }

    /// `(I + rho W)⁻¹`, unless the factor was made without.
    pub(crate) fn resolvent(&self) -> Option<&Resolvent<T, D, C>> {
        self.is_complete.then_some(&self.resolvent)
    }

    /// `W`
    pub(crate) const fn delassus(&self) -> &ContactMatrix<T, D, C> {
        &self.delassus
    }

    /// `W_ii⁻¹`
    pub(crate) const fn effective_mass(&self) -> &[[[T; D]; D]; C] {
        &self.effective_mass
    }

    /// How far rounding may have moved `W`, relative to it.
    pub(crate) const fn uncertainty(&self) -> T {
        self.uncertainty
    }

    /// It grows with the largest `M_kk` over its pivot; 64 is enough for 500,000 random scenes in single
    /// precision.
    fn measure_uncertainty(&mut self, mass: &[[T; N]; N]) {
        let mut growth = T::ONE;
        for (k, (mass, factor)) in opaque(mass).iter().zip(&self.mass).enumerate() {
            rolled();
            if let (Some(&diagonal), Some(&reciprocal)) = (mass.get(k), factor.get(k)) {
                growth = larger(growth, &[diagonal], reciprocal);
            }
        }
        self.uncertainty = T::literal(64.0) * T::EPSILON * growth;
    }

    /// `y = W x`
    #[inline]
    pub(crate) fn delassus_times(&self, x: &[[T; D]], y: &mut [[T; D]]) {
        multiply_transposed(&self.delassus, x, y);
    }

    /// `X_i` and where it is not zero, of the contacts in use.
    #[inline]
    fn whitened(&self) -> impl Iterator<Item = (&[[T; D]; N], Support)> {
        let whitened = self.whitened.get(..self.contacts).unwrap_or_default();
        opaque(whitened).iter().zip(self.supports.iter().copied())
    }

    /// From `g` to the `x` of `Uᵀ D⁻¹ x = g`, from which [`Self::contact_velocity`] and
    /// [`Self::velocity`] start.
    pub(crate) fn whiten(&self, g: &mut [T; N]) {
        solve_upper(&self.mass, g);
    }

    /// `H M⁻¹ g` for a `g` that was whitened. Returns `gᵀ M⁻¹ g`.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn contact_velocity(&self, g: &[T; N], u: &mut ContactVector<T, D, C>) -> T {
        let mut scaled = *g;
        let mut energy = T::ZERO;
        for (i, (scaled, row)) in opaque_mut(&mut scaled)
            .iter_mut()
            .zip(&self.mass)
            .enumerate()
        {
            rolled();
            let g = *scaled;
            *scaled *= row.get(i).copied().unwrap_or(T::ZERO);
            energy += g * *scaled;
        }
        let (scaled, last) = scaled.as_chunks::<GROUP>();
        for (u, (whitened, support)) in opaque_mut(u).iter_mut().zip(self.whitened()) {
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            let mut sums = [T::ZERO; D];
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), scaled.get(group)) {
                    add_columns(columns, g, &mut sums);
                }
            }
            add_columns(rest, last, &mut sums);
            *u = sums;
        }
        energy
    }

    /// `W_NN d` for one `d_i` a contact, and `|H_Nᵀ d|` in the norm of `M⁻¹`; by way of `H_Nᵀ d`,
    /// so that both are small where that is.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(crate) fn normal_products(&self, d: &[T; C]) -> ([T; C], T) {
        let mut momentum = [T::ZERO; N];
        let mut impulse = [[T::ZERO; D]; C];
        for (impulse, &d) in impulse.iter_mut().zip(d) {
            if let Some(normal) = impulse.first_mut() {
                *normal = d;
            }
        }
        self.add_whitened(&impulse, &mut momentum);
        let energy = self.contact_velocity(&momentum, &mut impulse);
        let mut product = [T::ZERO; C];
        for (product, velocity) in product.iter_mut().zip(&impulse).take(self.contacts) {
            *product = velocity.first().copied().unwrap_or(T::ZERO);
        }
        (product, energy.max(T::ZERO).square_root())
    }

    /// Adds `Hᵀ r`, whitened, to `g`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn add_whitened(&self, r: &[[T; D]], g: &mut [T; N]) {
        let (g, last) = g.as_chunks_mut::<GROUP>();
        for (&r, (whitened, support)) in opaque(r).iter().zip(self.whitened()) {
            if r == [T::ZERO; D] {
                continue;
            }
            let (columns, rest) = whitened.as_chunks::<GROUP>();
            for group in support.groups::<N>() {
                rolled();
                if let (Some(columns), Some(g)) = (columns.get(group), g.get_mut(group)) {
                    add_products(columns, r, g);
                }
            }
            add_products(rest, r, last);
        }
    }

    /// `v = M⁻¹ (Hᵀ r + g)` for a `g` that was whitened.
    pub(crate) fn velocity(&self, g: &[T; N], r: &[[T; D]], v: &mut [T; N]) {
        *v = *g;
        self.add_whitened(r, v);
        solve_lower(&self.mass, v);
    }
}

/// Writes row `a` of the block of two contacts, and its mirror image: `W` stays symmetric to the bit, a
/// contact's own block too. (Where it was not, a tumbling box gained energy in single precision.)
fn set<T: Real, const D: usize, const C: usize>(
    matrix: &mut ContactMatrix<T, D, C>,
    [i, j]: [usize; 2],
    a: usize,
    entries: [T; D],
) {
    for (row, entry) in matrix.get_mut(j).into_iter().flatten().zip(entries) {
        if let Some(mirrored) = row.get_mut(i).and_then(|block| block.get_mut(a)) {
            *mirrored = entry;
        }
    }
    if let Some(row) = matrix.get_mut(i).and_then(|rows| rows.get_mut(a))
        && let Some(block) = row.get_mut(j)
    {
        *block = entries;
    }
}

/// `Σ_k x_k y_kᵀ`
#[inline]
fn products<T: Real, const N: usize, const D: usize>(
    x: &[Scaled<'_, T, N, D>],
    y: &[[T; D]; N],
) -> [[T; D]; D] {
    let mut sums = [[T::ZERO; D]; D];
    for Scaled { place, entry, .. } in x.iter().rev() {
        rolled();
        let Some(y) = y.get(*place) else { break };
        for (sums, &x) in sums.iter_mut().zip(entry) {
            for (sum, &y) in sums.iter_mut().zip(y) {
                *sum += x * y;
            }
        }
    }
    sums
}

/// `sums_j += |column_j|²`
#[inline]
fn add_squares<T: Real, const D: usize>(columns: &[[T; D]], sums: &mut [T]) {
    for (sum, column) in sums.iter_mut().zip(columns) {
        *sum = column.iter().fold(*sum, |sum, &entry| sum + entry * entry);
    }
}

/// The default `rho`, a power of two near 6 times the geometric mean of `M_jj / (HᵀH)_jj`, and how many
/// dofs contacts move.
///
/// The quotient is the mass felt by a contact that moves dof `j` alone, so `rho` has the unit of a
/// mass; the units of the dofs, and dofs that no contact moves, do not matter. The geometric mean
/// serves stacks of unlike bodies, where the trace of `W` sees only the lightest; taken over binary
/// exponents it needs no logarithm, and changing units by powers of two changes it exactly.
#[cfg_attr(target_os = "none", inline(never))]
fn default_penalty<T: Real, const N: usize, const D: usize, const C: usize>(
    scene: &Scene<T, N, D, C>,
) -> (T, usize) {
    // (HᵀH)_jj / M_jj
    let mut reach = [T::ZERO; N];
    let (groups, last) = reach.as_chunks_mut::<GROUP>();
    for (contact, support) in scene.supported() {
        let (columns, rest) = contact.jacobian.data.0.as_chunks::<GROUP>();
        for group in support.groups::<N>() {
            rolled();
            if let (Some(columns), Some(reach)) = (columns.get(group), groups.get_mut(group)) {
                add_squares(columns, reach);
            }
        }
        add_squares(rest, last);
    }
    let mut largest = T::ZERO;
    let masses = scene.mass().data.0.iter();
    for (j, (reach, masses)) in opaque_mut(&mut reach).iter_mut().zip(masses).enumerate() {
        rolled();
        *reach /= masses.get(j).copied().unwrap_or(T::ONE);
        if *reach > largest {
            largest = *reach;
        }
    }
    let rounding = largest * T::literal(1e-9);
    let (mut exponents, mut moved) = (0_i32, 0);
    for &reach in opaque(&reach) {
        rolled();
        if reach > rounding {
            exponents += reach.exponent();
            moved += 1;
        }
    }
    let count = i32::try_from(moved).unwrap_or(0);
    let mean = exponents.checked_div_euclid(count);
    (mean.map_or(T::ONE, |mean| T::power_of_two(2 - mean)), moved)
}
