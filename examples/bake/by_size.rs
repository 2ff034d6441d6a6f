//! All scenes of some folders, by size: `examples/worst_case` solves them on an emulated board.

use std::fmt::Write as _;
use std::path::PathBuf;
use testbed::format;
use testbed::mixed::{Friction, MixedFile};
use testbed::scene_file::SceneFile;

/// Velocities, rows of a contact, contacts, joint rows and surfaces.
type Size = [usize; 5];

/// Numbers in the order in which `examples/worst_case/scene.rs` reads them.
type Numbers = Vec<f64>;

/// The sizes that are compiled, for a solver of all phases and, where that is said, for those of fewer. A scene goes into the first that has
/// room. Each number of rows a contact has a size that a scene fills; the dense variants of `examples/worst_case` fill them all.
const ROOMS: [(Size, &str); 14] = [
    // Contacts alone.
    ([3, 2, 1, 0, 0], ALL),
    ([6, 2, 4, 0, 0], ALL),
    ([6, 3, 4, 0, 0], LEAN),
    ([18, 3, 4, 0, 0], LEAN),
    ([18, 3, 12, 0, 0], LEAN),
    ([24, 3, 12, 0, 0], ALL),
    // Joint rows, compliance, contacts that slip differently in each direction, spin or roll.
    ([2, 3, 0, 6, 0], ALL),
    ([6, 2, 2, 5, 2], LEAN),
    ([6, 3, 5, 0, 5], ALL),
    ([10, 3, 3, 6, 3], LEAN),
    ([8, 3, 8, 5, 8], LEAN),
    ([6, 4, 1, 0, 1], LEAN),
    ([6, 6, 1, 0, 1], ALL),
    ([8, 6, 3, 4, 3], LEAN),
];
const ALL: &str = "AllPhases";
const LEAN: &str = "AllPhases SweepsAndNewton SweepsOnly";

/// A macro call with the sizes, each with its phases and scenes.
pub(crate) fn write(files: &[PathBuf], steps: usize) -> Result<String, String> {
    let mut rooms = ROOMS.map(|(size, phases)| (size, phases, Vec::<Numbers>::new()));
    let mut place = |name: &str, size: Size, numbers: Numbers| {
        let room = rooms.iter_mut().find(|(room, ..)| has_room(room, &size));
        let (.., scenes) = room.ok_or_else(|| format!("{name}: no size has room for {size:?}"))?;
        scenes.push(numbers);
        Ok::<(), String>(())
    };
    for path in files {
        let name = path.display().to_string();
        for file in format::read(path)?.iter().take(steps) {
            let (n, contacts, rows) = (file.n_dof, file.n_contacts, file.joints.len());
            if file.has_contacts_alone() {
                place(&name, [n, file.dim, contacts, 0, 0], of_contacts(&SceneFile::of_file(file)?))?;
            } else {
                place(&name, [n, file.dim, contacts, rows, contacts], of_mixed(file))?;
            }
        }
    }
    let mut source = String::from("sizes! {\n");
    for (size, phases, scenes) in &rooms {
        let size = size.map(|n| n.to_string()).join(", ");
        let _ = writeln!(source, "    ({size}) [{phases}]:");
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

/// As many rows a contact, enough of everything else, and room for joint rows and surfaces only where there are some.
fn has_room(room: &Size, size: &Size) -> bool {
    let is_mixed = |size: &Size| size[3] + size[4] > 0;
    room[1] == size[1]
        && is_mixed(room) == is_mixed(size)
        && room.iter().zip(size).all(|(room, size)| room >= size)
}

/// A scene of contacts alone.
fn of_contacts(scene: &SceneFile) -> Numbers {
    let mut numbers = counts([scene.n_dof, scene.n_contacts, 0]);
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
    let mut numbers = counts([file.n_dof, file.n_contacts, file.joints.len()]);
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

/// How many velocities, contacts and joint rows follow.
#[allow(clippy::cast_precision_loss)] // a few
fn counts(counts: [usize; 3]) -> Numbers {
    counts.map(|count| count as f64).to_vec()
}
