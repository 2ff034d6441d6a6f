//! Reduced scenes, and the records `examples/embedded/records.rs` reads.

use crate::Selection;
use testbed::scene_file::SceneFile;

/// What is left of a scene.
pub(crate) struct Reduced {
    /// `M`
    pub(crate) mass: Vec<Vec<f64>>,
    pub(crate) f: Vec<f64>,
    pub(crate) contacts: Vec<Contact>,
}

pub(crate) struct Contact {
    pub(crate) key: u32,
    pub(crate) mu: f64,
    pub(crate) w: Vec<f64>,
    pub(crate) h: Vec<Vec<f64>>,
}

impl Selection {
    /// Keeps the chosen velocities, contacts and rows.
    pub(crate) fn reduce(&self, scene: &SceneFile) -> Reduced {
        let all = |chosen: &[usize], n: usize| match chosen {
            [] => (0..n).collect(),
            chosen => chosen.to_vec(),
        };
        let dofs = all(&self.dofs, scene.n_dof);
        let rows = all(&self.rows, scene.dim);
        let contact = |&i: &usize| {
            let row = |row: &usize| i * scene.dim + row;
            let entries = |row| dofs.iter().map(|&dof| scene.h[(row, dof)]).collect();
            Contact {
                key: scene.keys[i],
                mu: if rows.len() > 1 { scene.mu[i] } else { 0.0 },
                w: rows.iter().map(|r| scene.w[row(r)]).collect(),
                h: rows.iter().map(|r| entries(row(r))).collect(),
            }
        };
        let mass = |&i| dofs.iter().map(|&j| scene.mass[(i, j)]).collect();
        Reduced {
            mass: dofs.iter().map(mass).collect(),
            f: dofs.iter().map(|&dof| scene.f[dof]).collect(),
            contacts: all(&self.contacts, scene.n_contacts).iter().map(contact).collect(),
        }
    }
}

/// Writes a record.
pub(crate) fn write(scene: &Reduced, bytes: &mut Vec<u8>) {
    let count = u32::try_from(scene.contacts.len()).unwrap_or(u32::MAX);
    bytes.extend(count.to_le_bytes());
    for (i, row) in scene.mass.iter().enumerate() {
        write_numbers(&row[..=i], bytes);
    }
    write_numbers(&scene.f, bytes);
    for contact in &scene.contacts {
        bytes.extend(contact.key.to_le_bytes());
        write_numbers(&[contact.mu], bytes);
        write_numbers(&contact.w, bytes);
        for row in &contact.h {
            write_numbers(row, bytes);
        }
    }
}

#[allow(clippy::cast_possible_truncation)] // the firmware's number type
fn write_numbers(numbers: &[f64], bytes: &mut Vec<u8>) {
    for &number in numbers {
        bytes.extend((number as f32).to_le_bytes());
    }
}
