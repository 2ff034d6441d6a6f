//! Reduced scenes, and the records `examples/embedded/records.rs` reads.

use crate::Selection;
use crate::support::scene_file::SceneFile;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// What is left of a scene.
pub(crate) struct Reduced {
    /// `M`
    pub(crate) mass: Vec<Vec<f64>>,
    pub(crate) f: Vec<f64>,
    pub(crate) contacts: Vec<Contact>,
}

pub(crate) struct Contact {
    pub(crate) name: u32,
    pub(crate) mu: f64,
    pub(crate) w: Vec<f64>,
    pub(crate) h: Vec<Vec<f64>>,
}

impl Selection {
    /// Keeps the chosen velocities, contacts and rows.
    pub(crate) fn reduce(&self, scene: &SceneFile, names: &[u32]) -> Reduced {
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
                name: names[i],
                mu: if rows.len() > 1 { scene.mu[i] } else { 0.0 },
                w: rows.iter().map(|r| scene.w[row(r)]).collect(),
                h: rows.iter().map(|r| entries(row(r))).collect(),
            }
        };
        let mass = |&i| dofs.iter().map(|&j| scene.mass[(i, j)]).collect();
        Reduced {
            mass: dofs.iter().map(mass).collect(),
            f: dofs.iter().map(|&dof| scene.f[dof]).collect(),
            contacts: all(&self.contacts, scene.n_contacts)
                .iter()
                .map(contact)
                .collect(),
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
        bytes.extend(contact.name.to_le_bytes());
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

/// Numbers for the contact names of each step; the second contact of a name gets its own.
pub(crate) fn names(path: &Path) -> Result<Vec<Vec<u32>>, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let file: Value = serde_json::from_reader(BufReader::new(file)).map_err(|e| e.to_string())?;
    let steps = match file.get("problems").and_then(Value::as_array) {
        Some(steps) => steps.as_slice(),
        None => std::slice::from_ref(&file),
    };
    let mut known = BTreeMap::new();
    let of_step = |step: &Value| {
        let mut seen = BTreeMap::new();
        let names = step.get("contact_names").and_then(Value::as_array);
        let names = names.into_iter().flatten().map(|name| {
            let name = name.as_str().unwrap_or_default().to_owned();
            let occurrence = seen.entry(name.clone()).or_insert(0);
            *occurrence += 1;
            let next = known.len();
            let number = *known.entry((name, *occurrence)).or_insert(next);
            u32::try_from(number).unwrap_or(u32::MAX)
        });
        names.collect()
    };
    Ok(steps.iter().map(of_step).collect())
}
