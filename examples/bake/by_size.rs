//! All scenes of some folders, by size: `examples/worst_case` solves them on an emulated board.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use testbed::mixed;
use testbed::mixed::{Friction, MixedFile};
use testbed::scene_file::{self, SceneFile};

/// Velocities, rows of a contact, contacts, joint rows and surfaces.
type Size = [usize; 5];

/// Numbers in the order in which `examples/worst_case/scene.rs` reads them.
type Numbers = Vec<f64>;

/// A macro call with sizes and their scenes for each size of the files.
pub(crate) fn write(files: &[PathBuf], steps: usize) -> Result<String, String> {
    let mut sizes = BTreeMap::<Size, Vec<Numbers>>::new();
    for path in files {
        if let Some(file) = mixed::read(path)? {
            let [contacts, rows] = [file.n_contacts, file.joints.len()].map(rounded);
            let size = [file.n_dof, file.dim, contacts, rows, contacts];
            sizes.entry(size).or_default().push(of_mixed(&file));
            continue;
        }
        for scene in scene_file::read(path)?.iter().take(steps) {
            let size = [scene.n_dof, scene.dim, rounded(scene.n_contacts), 0, 0];
            sizes.entry(size).or_default().push(of_contacts(scene));
        }
    }
    let mut source = String::from("sizes! {\n");
    for (size, scenes) in &sizes {
        let size = size.map(|n| n.to_string()).join(", ");
        let _ = writeln!(source, "    ({size}):");
        for scene in scenes {
            #[allow(clippy::cast_possible_truncation)] // the firmware's number type
            let numbers: Vec<String> = scene.iter().map(|&x| format!("{:?}", x as f32)).collect();
            let _ = writeln!(source, "        [{}],", numbers.join(", "));
        }
        source.push_str("        ;\n");
    }
    source.push_str("}\n");
    Ok(source)
}

/// The next larger number of contacts or joint rows, so that fewer sizes have to be compiled.
fn rounded(count: usize) -> usize {
    [0, 1, 4, 6, 12, 24].into_iter().find(|&size| size >= count).unwrap_or(count)
}

/// A scene of contacts alone.
fn of_contacts(scene: &SceneFile) -> Numbers {
    let mut numbers = counts(scene.n_contacts, 0);
    numbers.extend(scene.mass.transpose().iter());
    numbers.extend(scene.f.iter().map(|f| -f));
    for i in 0..scene.n_contacts {
        numbers.push(scene.mu[i]);
        let rows = i * scene.dim..(i + 1) * scene.dim;
        numbers.extend(rows.clone().map(|row| scene.w[row]));
        for row in rows {
            numbers.extend(scene.h.row(row).iter());
        }
    }
    numbers
}

/// A scene with surfaces and joint rows.
fn of_mixed(file: &MixedFile) -> Numbers {
    let mut numbers = counts(file.n_contacts, file.joints.len());
    numbers.extend(file.mass.concat());
    numbers.extend(file.f.iter().map(|f| -f));
    for (i, mu) in file.mu.iter().enumerate() {
        for row in 0..5 {
            numbers.push(match mu {
                Friction::Isotropic(mu) => *mu,
                Friction::Rows(mu) => mu.get(row).copied().unwrap_or(0.0),
            });
        }
        numbers.extend(file.compliance.get(i).copied().unwrap_or_default());
        let rows = i * file.dim..(i + 1) * file.dim;
        numbers.extend(&file.w[rows.clone()]);
        numbers.extend(file.h[rows].concat());
    }
    for joint in &file.joints {
        numbers.extend(&joint.row);
        numbers.extend([joint.offset, joint.compliance]);
        numbers.extend(match (joint.lower, joint.upper) {
            (Some(lower), Some(upper)) => [2.0, lower, upper],
            _ if joint.kind == "limit" => [0.0; 3],
            _ => [1.0, 0.0, 0.0],
        });
    }
    numbers
}

/// How many contacts and joint rows follow.
#[allow(clippy::cast_precision_loss)] // a few
fn counts(contacts: usize, rows: usize) -> Numbers {
    vec![contacts as f64, rows as f64]
}
