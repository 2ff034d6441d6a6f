//! Instructions on a Cortex-M4F, from the table that the firmware run records
//! (`examples/measure/baseline.txt`): lines `target scene quantity number`.

use std::collections::BTreeMap;
use testbed::scene_file::repository;

const TARGET: &str = "m4f32";
/// Name in the table, and what the picture calls it.
pub(crate) const SCENES: [(&str, &str); 4] = [
    ("box", "box, 6 dofs, 4 contacts"),
    ("quadruped", "quadruped, 18 dofs, 4 contacts"),
    ("walker", "planar walker, 9 dofs, 4 contacts"),
    ("stack", "three boxes, 18 dofs, 12 contacts"),
];

/// `(instructions, error)` of one method on one scene.
pub(crate) struct Counts {
    pub(crate) prepare: f64,
    pub(crate) points: Vec<(f64, f64)>,
}

/// The default method and Gauss-Seidel on one scene.
pub(crate) struct Firmware {
    pub(crate) title: &'static str,
    pub(crate) default: Counts,
    pub(crate) gauss_seidel: Counts,
}

/// The counts of [`SCENES`] in the recorded table.
///
/// # Errors
/// The table cannot be read, or does not hold one of them.
pub(crate) fn read() -> Result<Vec<Firmware>, String> {
    let path = repository().join("examples/measure/baseline.txt");
    let text = std::fs::read_to_string(&path).map_err(|error| error.to_string())?;
    let counts = SCENES.iter().map(|&(name, title)| {
        firmware(&text, name, title).ok_or_else(|| format!("{} does not count {name}", path.display()))
    });
    counts.collect()
}

fn firmware(text: &str, name: &str, title: &'static str) -> Option<Firmware> {
    let mut quantities = BTreeMap::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let [TARGET, scene, quantity, number] = words[..]
            && scene == name
        {
            quantities.insert(quantity, number.parse::<f64>().ok()?);
        }
    }
    // "prefix1e-3" gives the tolerance that was asked for.
    let ladder = |prefix: &str| -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = quantities
            .iter()
            .filter_map(|(quantity, count)| {
                let tolerance = quantity.strip_prefix(prefix)?.parse().ok()?;
                Some((*count, tolerance))
            })
            .collect();
        points.sort_by(|a, b| b.1.total_cmp(&a.1));
        points
    };
    Some(Firmware {
        title,
        default: Counts { prepare: *quantities.get("prepare")?, points: ladder("cold_") },
        gauss_seidel: Counts { prepare: *quantities.get("race_gs_prepare")?, points: ladder("race_gs_") },
    })
}
