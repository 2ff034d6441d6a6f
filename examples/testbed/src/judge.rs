//! The error of a solution as a stranger computes it who does not round: in double-double arithmetic, 106 bits.

use twofloat::TwoFloat;

/// A number of 106 bits.
pub(crate) type Wide = TwoFloat;

/// A vector.
pub(crate) type Vector = Vec<Wide>;

pub(crate) fn wide(x: &[f64]) -> Vector {
    x.iter().map(|&x| Wide::from(x)).collect()
}

pub(crate) fn zero() -> Wide {
    Wide::from(0.0)
}

pub(crate) fn dot(x: &[Wide], y: &[Wide]) -> Wide {
    x.iter().zip(y).fold(zero(), |sum, (&x, &y)| sum + x * y)
}

pub(crate) fn square(x: &[Wide]) -> Wide {
    dot(x, x)
}

pub(crate) fn larger(x: Wide, y: Wide) -> Wide {
    if y > x { y } else { x }
}

/// Its root; 0 of what is not positive.
pub(crate) fn root(x: Wide) -> Wide {
    if x > zero() { x.sqrt() } else { zero() }
}

/// In f64; infinite where there is no number.
pub(crate) fn narrow(x: Wide) -> f64 {
    let x = f64::from(x);
    if x.is_nan() { f64::INFINITY } else { x }
}

/// A quotient in which 0/0 is 0.
pub(crate) fn ratio(x: Wide, y: Wide) -> Wide {
    if x == zero() { zero() } else { x / y }
}

/// `M = L Lᵀ`, and solves with it.
pub(crate) struct Cholesky {
    lower: Vec<Vector>,
}

impl Cholesky {
    /// `None` if a pivot is not positive.
    pub(crate) fn new(mass: &[Vector]) -> Option<Self> {
        let mut lower: Vec<Vector> = Vec::new();
        for (i, source) in mass.iter().enumerate() {
            let mut row = Vector::new();
            for above in &lower {
                let j = row.len();
                row.push((source[j] - dot(&row, &above[..j])) / above[j]);
            }
            let pivot = source[i] - square(&row);
            let usable = pivot > zero();
            row.push(root(pivot));
            lower.push(usable.then_some(row)?);
        }
        Some(Self { lower })
    }

    /// `L⁻¹ x`
    pub(crate) fn whiten(&self, x: &[Wide]) -> Vector {
        let mut y = Vector::new();
        for (row, &x) in self.lower.iter().zip(x) {
            let known = dot(row, &y);
            y.push((x - known) / row[y.len()]);
        }
        y
    }

    /// `L⁻ᵀ y`
    pub(crate) fn unwhiten(&self, mut y: Vector) -> Vector {
        for i in (0..y.len()).rev() {
            y[i] /= self.lower[i][i];
            for j in 0..i {
                let known = self.lower[i][j] * y[i];
                y[j] -= known;
            }
        }
        y
    }
}

/// What a contact is judged by, in rows that are scaled so that its cone is round.
pub(crate) struct Contact {
    /// Rows of `H`, as given, and their scales.
    pub(crate) rows: Vec<Vector>,
    pub(crate) scales: Vector,
    /// Scaled.
    pub(crate) offset: Vector,
    pub(crate) compliance: Vector,
    /// Of the cone, and of the De Saxcé shift.
    pub(crate) mu: Wide,
    pub(crate) shift: Wide,
}

/// What a joint row is judged by.
pub(crate) struct Row {
    pub(crate) entries: Vector,
    pub(crate) offset: Wide,
    pub(crate) compliance: Wide,
    /// The least and the largest impulse, if there are any.
    pub(crate) bounds: [Option<f64>; 2],
}

/// A scene, and what it is relative to.
pub(crate) struct Scene {
    pub(crate) mass: Vec<Vector>,
    /// `M v_free`
    pub(crate) push: Vector,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) rows: Vec<Row>,
    /// Is there anything but rigid contacts of one friction coefficient?
    pub(crate) is_mixed: bool,
}

/// `Π_K(r - alpha û)`, from `r` and `u`, all scaled.
fn projected(contact: &Contact, alpha: Wide, r: &[Wide], u: &[Wide]) -> Vector {
    let mut z: Vector = r.iter().zip(u).map(|(&r, &u)| r - alpha * u).collect();
    z[0] -= alpha * contact.shift * root(square(&u[1..]));
    let (mu, length) = (contact.mu, root(square(&z[1..])));
    if z[0] >= zero() && length <= mu * z[0] {
        return z;
    }
    let along = (z[0] + mu * length) / (Wide::from(1.0) + mu * mu);
    if along <= zero() {
        return vec![zero(); z.len()];
    }
    let turn = ratio(along * mu, length);
    let mut projection: Vector = z.iter().map(|&z| z * turn).collect();
    projection[0] = along;
    projection
}

/// The square of what normal and tangent leave apart: Alart and Curnier's function, of a contact that has no compliance of its own.
fn apart(contact: &Contact, alpha: Wide, r: &[Wide], u: &[Wide]) -> Wide {
    let tangent = || r[1..].iter().zip(&u[1..]);
    let grip = contact.mu * r[0];
    let length = root(square(&tangent().map(|(&r, &u)| r - alpha * u).collect::<Vector>()));
    let share = if length > grip { ratio(grip, length) } else { Wide::from(1.0) };
    let mut left: Vector = tangent().map(|(&r, &u)| r - (r - alpha * u) * share).collect();
    let push = alpha * u[0];
    left.push(if push < r[0] { push } else { r[0] });
    square(&left)
}

/// Contacts without a mass matrix: squares of the natural map and of the sizes, from velocities.
#[derive(Clone, Copy)]
pub(crate) struct NaturalMap {
    off: Wide,
    impulse: Wide,
    alone: Wide,
    stop: Wide,
    /// `Σ |r0_i|² / alpha_i`
    pub(crate) energy: Wide,
}

impl NaturalMap {
    pub(crate) fn new() -> Self {
        let [off, impulse, alone, stop, energy] = [zero(); 5];
        Self { off, impulse, alone, stop, energy }
    }

    /// Adds a contact with `trace(W_ii)`, impulse and velocity, the free one, and `abs(H_i) abs(v_free)`, all scaled. `None` if
    /// nothing moves it, though it asks for another velocity.
    pub(crate) fn add(
        &mut self,
        contact: &Contact,
        trace: Wide,
        (r, u): (&[Wide], &[Wide]),
        (q, speeds): (&[Wide], &[Wide]),
    ) -> Option<()> {
        let rows = Wide::from(u32::try_from(r.len()).ok()?);
        let alpha = ratio(rows, trace);
        let alpha = if trace > zero() { alpha } else { zero() };
        let slip = root(square(&u[1..]));
        if alpha == zero() && u[0] + (contact.shift - contact.mu) * slip < zero() {
            return None;
        }
        let nearest = projected(contact, alpha, r, u);
        let left: Vector = r.iter().zip(nearest).map(|(&r, x)| r - x).collect();
        let alone = square(&projected(contact, alpha, &vec![zero(); r.len()], q));
        let mut off = square(&left);
        if contact.shift > Wide::from(10.0) {
            let apart = apart(contact, alpha, r, u);
            off = if apart < off { apart } else { off };
        }
        self.off += off;
        self.impulse += square(r);
        self.alone += alone;
        self.energy += ratio(alone, alpha);
        for (k, (&w, &speed)) in contact.offset.iter().zip(speeds).enumerate() {
            let gap = k == 0 && w > zero();
            let w = if gap { zero() } else { w.abs() };
            let stop = alpha * (speed + w) / Wide::from(100.0);
            self.stop += stop * stop;
        }
        Some(())
    }

    /// The larger of `|r0|` and `|stop|`.
    pub(crate) fn size(&self) -> Wide {
        root(larger(self.alone, self.stop))
    }

    /// Relative to the impulses. What the violation is more than half of the expected impulses counts, too, up to 1; `carried` is
    /// what momenta let expect.
    pub(crate) fn error(&self, carried: Wide) -> Wide {
        let expected = larger(self.alone, self.stop);
        let error = root(ratio(self.off, larger(self.impulse, expected)));
        if expected <= zero() {
            return error;
        }
        let share = root(self.off) / larger(root(expected), carried);
        let beyond = share * Wide::from(2.0) - Wide::from(1.0);
        let one = Wide::from(1.0);
        larger(error, if beyond < one { beyond } else { one })
    }
}

impl Row {
    /// The nearest impulse within the bounds.
    fn clamped(&self, x: Wide) -> Wide {
        match self.bounds {
            [Some(lower), _] if x < lower => Wide::from(lower),
            [_, Some(upper)] if x > upper => Wide::from(upper),
            _ => x,
        }
    }
}

/// The rows of a contact times a vector.
fn times(rows: &[Vector], scales: &[Wide], v: &[Wide]) -> Vector {
    let pairs = rows.iter().zip(scales);
    pairs.map(|(row, &scale)| scale * dot(row, v)).collect()
}

impl Scene {
    /// The natural map of contacts, `L⁻¹ Hᵀ r` scaled, `L⁻¹ M v_free` and the factor; `None` where there is none, or what
    /// nothing moves is not met.
    pub(crate) fn contacts(
        &self,
        v: &[Wide],
        r: &[Vector],
    ) -> Option<(NaturalMap, Vector, Vector, Cholesky)> {
        let cholesky = Cholesky::new(&self.mass)?;
        let free = cholesky.whiten(&self.push);
        let v_free = cholesky.unwhiten(free.clone());
        let mut map = NaturalMap::new();
        let mut pushed = vec![zero(); free.len()];
        for (contact, r) in self.contacts.iter().zip(r) {
            let scaled = r.iter().zip(&contact.scales);
            let scaled: Vector = scaled.map(|(&r, &scale)| ratio(r, scale)).collect();
            let whitened: Vec<Vector> = contact.rows.iter().map(|h| cholesky.whiten(h)).collect();
            let rows = whitened.iter().zip(&contact.scales);
            let inverse_masses = rows.zip(&contact.compliance);
            let trace = inverse_masses
                .fold(zero(), |sum, ((x, &scale), &soft)| sum + scale * scale * square(x) + soft);
            let mut u = times(&contact.rows, &contact.scales, v);
            let mut q = times(&whitened, &contact.scales, &free);
            let pairs = u.iter_mut().zip(&mut q);
            for (k, (u, q)) in pairs.enumerate() {
                *u += contact.offset[k] + contact.compliance[k] * scaled[k];
                *q += contact.offset[k];
            }
            let speeds: Vector = contact
                .rows
                .iter()
                .zip(&contact.scales)
                .map(|(row, &scale)| {
                    let terms = row.iter().zip(&v_free);
                    scale * terms.fold(zero(), |sum, (&h, &v)| sum + (h * v).abs())
                })
                .collect();
            map.add(contact, trace, (&scaled, &u), (&q, &speeds))?;
            for (x, (&scale, &r)) in whitened.iter().zip(contact.scales.iter().zip(&scaled)) {
                for (sum, &x) in pushed.iter_mut().zip(x) {
                    *sum += scale * x * r;
                }
            }
        }
        Some((map, pushed, free, cholesky))
    }

    /// The impulse that the momentum of a dof, with what joint rows bring, asks of the contact with the longest lever on it, and that which gives it the fastest
    /// offset.
    fn carried(&self) -> Wide {
        let size = |x: Wide| larger(x, -x);
        let Some(cholesky) = Cholesky::new(&self.mass) else {
            return zero();
        };
        let (mut levers, mut fastest, mut mobility) = (vec![zero(); self.push.len()], zero(), zero());
        for contact in &self.contacts {
            let mut moved = zero();
            for (k, row) in contact.rows.iter().enumerate() {
                let scale = contact.scales[k];
                moved += scale * scale * square(&cholesky.whiten(row)) + contact.compliance[k];
                if k >= 3 {
                    continue; // spin and roll
                }
                let offset = ratio(contact.offset[k], scale);
                if k > 0 || offset < zero() {
                    fastest = larger(fastest, size(offset));
                }
                for (lever, &h) in levers.iter_mut().zip(row) {
                    *lever = larger(*lever, size(h));
                }
            }
            mobility = larger(mobility, moved);
        }
        let mut asked: Vector = self.push.iter().map(|&p| size(p)).collect();
        let free = cholesky.whiten(&self.push);
        for row in &self.rows {
            let x = cholesky.whiten(&row.entries);
            let inverse_mass = square(&x) + row.compliance;
            let s_free = dot(&x, &free) + row.offset;
            let alone =
                if inverse_mass > zero() { row.clamped(-s_free / inverse_mass) } else { row.clamped(zero()) };
            for (asked, &entry) in asked.iter_mut().zip(&row.entries) {
                *asked += size(entry * alone);
            }
        }
        let mut largest = zero();
        for (j, &lever) in levers.iter().enumerate() {
            let mass = self.mass[j][j];
            if lever * lever > Wide::from(1e-14) * mass * mobility {
                largest = larger(largest, (asked[j] + mass * fastest / lever) / lever);
            }
        }
        largest
    }

    /// The largest of the errors of contacts, joint rows and dynamics; infinite where double-double arithmetic cannot tell.
    pub(crate) fn error(&self, v: &[f64], r: &[Vec<f64>], lambda: &[f64]) -> f64 {
        let v = wide(v);
        let r: Vec<Vector> = r.iter().map(|r| wide(r)).collect();
        let Some((map, mut net, free, cholesky)) = self.contacts(&v, &r) else {
            return f64::INFINITY;
        };
        // A row that is scaled by 0 has no friction.
        let stray = self.contacts.iter().zip(&r).any(|(contact, r)| {
            let mut rows = r.iter().zip(&contact.scales);
            rows.any(|(&r, &scale)| scale == zero() && r != zero())
        });
        let Some(rows) = self.rows(&v, lambda, &map, (&free, &mut net, &cholesky), &r) else {
            return f64::INFINITY;
        };
        let (joints, least) = rows;
        let mut errors = vec![map.error(self.carried()), joints];
        errors.extend(self.dynamics(&v, &r, lambda, least));
        let errors: Vec<f64> = errors.into_iter().map(narrow).collect();
        let largest = errors.into_iter().fold(0.0, f64::max);
        if stray { f64::INFINITY } else { largest }
    }

    /// The error of joint rows, and what energies are compared with at least. `None` if an impulse lies outside of its bounds, or
    /// what nothing moves is not met.
    fn rows(
        &self,
        v: &[Wide],
        lambda: &[f64],
        map: &NaturalMap,
        (free, net, cholesky): (&[Wide], &mut Vector, &Cholesky),
        r: &[Vector],
    ) -> Option<(Wide, Wide)> {
        let (mut off, mut energy, mut stored) = (zero(), map.energy, zero());
        for (row, &given) in self.rows.iter().zip(lambda) {
            let [lower, upper] = row.bounds;
            if lower.is_some_and(|lower| given < lower) || upper.is_some_and(|upper| given > upper) {
                return None;
            }
            let (x, lambda) = (cholesky.whiten(&row.entries), Wide::from(given));
            let inverse_mass = square(&x) + row.compliance;
            let s = dot(&row.entries, v) + row.offset + row.compliance * lambda;
            let s_free = dot(&x, free) + row.offset;
            if inverse_mass > zero() {
                let left = lambda - row.clamped(lambda - s / inverse_mass);
                let alone = row.clamped(-s_free / inverse_mass);
                off += inverse_mass * left * left;
                energy += inverse_mass * alone * alone;
            } else if s > zero() && lower.is_none() || s < zero() && upper.is_none() {
                return None;
            }
            for (sum, &x) in net.iter_mut().zip(&x) {
                *sum += x * lambda;
            }
            stored += row.compliance * lambda * lambda;
        }
        for (contact, r) in self.contacts.iter().zip(r) {
            for (k, &r) in r.iter().enumerate() {
                let scaled = ratio(r, contact.scales[k]);
                stored += contact.compliance[k] * scaled * scaled;
            }
        }
        let least = larger(energy, square(free) / Wide::from(1e4));
        let size = larger(square(net) + stored, least);
        Some((root(ratio(off, size)), least))
    }

    /// The error of the dynamics, and of a mixed scene that in the norm `Σ e_k² / M_kk`.
    fn dynamics(&self, v: &[Wide], r: &[Vector], lambda: &[f64], least: Wide) -> Vec<Wide> {
        let inertia: Vector = self.mass.iter().map(|row| dot(row, v)).collect();
        let mut pushed = vec![zero(); v.len()];
        let contacts = self.contacts.iter().zip(r);
        let rows = contacts.flat_map(|(contact, r)| contact.rows.iter().zip(r.iter().copied()));
        let joints = self.rows.iter().map(|row| &row.entries);
        for (row, r) in rows.chain(joints.zip(wide(lambda))) {
            for (sum, &h) in pushed.iter_mut().zip(row) {
                *sum += h * r;
            }
        }
        let own = |k: usize| self.mass[k][k];
        let heaviest = (0..v.len()).map(own).fold(zero(), larger);
        let gaps = inertia.iter().zip(&self.push).zip(&pushed);
        let gaps: Vector = gaps.map(|((&a, &b), &c)| a - b - c).collect();
        let error = |weight: &dyn Fn(usize) -> Wide, least: Wide| {
            let size = |x: &Vector| {
                let terms = x.iter().enumerate();
                terms.fold(zero(), |sum, (k, &x)| sum + x * x * weight(k))
            };
            let sizes = [&self.push, &inertia, &pushed].map(size);
            let largest = sizes.into_iter().fold(least, larger);
            root(ratio(size(&gaps), largest))
        };
        let share = least / Wide::from(1e4);
        if self.is_mixed {
            let one = Wide::from(1.0);
            vec![error(&|_| one, share * heaviest), error(&|k| one / own(k), share)]
        } else {
            vec![error(&|_| Wide::from(1.0), zero())]
        }
    }
}
