//! Which contact is which, from one time step of a sequence to the next.

use nalgebra::DMatrix;

/// Numbers contacts in the order in which they first come.
#[derive(Default)]
pub struct ContactKeys {
    /// Contact `k` has the key `k`.
    known: Vec<Known>,
    /// Time steps so far.
    steps: usize,
}

/// A contact as it was last seen.
struct Known {
    name: String,
    /// Its rows of `H`.
    rows: DMatrix<f64>,
    step: usize,
}

impl ContactKeys {
    /// The keys of a step's contacts. Of the contacts of its name each is the one that was seen last,
    /// of several the one whose rows of `H` are the most alike, the closest pairs first. Without
    /// names the first is 0, the second 1.
    pub fn of_step(&mut self, names: &[String], h: &DMatrix<f64>, contacts: usize) -> Vec<u32> {
        if names.len() != contacts {
            return (0..).take(contacts).collect();
        }
        self.steps += 1;
        let dim = h.nrows().checked_div(contacts).unwrap_or(0);
        let rows: Vec<_> = (0..contacts).map(|i| h.rows(i * dim, dim).into_owned()).collect();
        let mut pairs = Vec::new();
        for (i, name) in names.iter().enumerate() {
            for (k, known) in self.known.iter().enumerate() {
                if known.name == *name {
                    let distance = (&rows[i] - &known.rows).norm_squared();
                    pairs.push((self.steps - known.step, distance, i, k));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut keys = vec![None; contacts];
        for (_, _, i, k) in pairs {
            if keys[i].is_none() && !keys.contains(&Some(k)) {
                keys[i] = Some(k);
            }
        }
        let mut step = Vec::new();
        for ((key, rows), name) in keys.into_iter().zip(rows).zip(names) {
            let seen = Known { name: name.clone(), rows, step: self.steps };
            let key = key.unwrap_or(self.known.len());
            if let Some(known) = self.known.get_mut(key) {
                *known = seen;
            } else {
                self.known.push(seen);
            }
            step.push(u32::try_from(key).expect("fewer contacts"));
        }
        step
    }
}
