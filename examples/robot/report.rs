//! What the steps cost and how they were solved; where files go.

use crate::{Failure, Tick};
use std::path::PathBuf;
use stiction::{ContactMode, RowMode};

/// Prints what the steps cost, split into their parts, and how they were solved.
pub fn report(ticks: &[Tick]) {
    println!("a step costs (µs)     median    99 %   worst");
    for (part, name) in ["dynamics", "collision", "contact"].into_iter().enumerate() {
        let mut cost: Vec<_> = ticks.iter().map(|tick| tick.cost[part]).collect();
        cost.sort_by(f64::total_cmp);
        let at = |share: usize| cost[(cost.len() - 1) * share / 100];
        println!("{name:18} {:9.1} {:7.1} {:7.1}", at(50), at(99), at(100));
    }
    let count = |kind: &dyn Fn(&Tick) -> bool| ticks.iter().filter(|tick| kind(tick)).count();
    let solved = count(&|tick| tick.error <= 1e-8);
    let worst = ticks.iter().map(|tick| tick.error).fold(0.0, f64::max);
    println!("{solved} of {} steps are solved to 1e-8; the largest error is {worst:.1e}", ticks.len());
    let motor = [RowMode::AtLower, RowMode::AtUpper];
    let saturated = count(&|tick| tick.rows.iter().any(|mode| motor.contains(mode)));
    let stopped = count(&|tick| tick.rows.contains(&RowMode::AtLimit));
    println!("a motor gave all it has in {saturated} steps, a joint was at its stop in {stopped}");
    let slips = |tick: &Tick| tick.touches.iter().any(|touch| touch.mode == ContactMode::Slip);
    println!("a contact slipped in {}", count(&slips));
    if ticks.iter().all(|tick| tick.touches.is_empty()) {
        println!("nothing has touched anything: has the foot a <collision>?");
    }
}

/// The file of a name in the folder that is the program's first argument, or else in `target`; says that it is drawn there.
pub(crate) fn save(name: &str) -> Result<PathBuf, Failure> {
    let repository = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let target = || PathBuf::from(repository).canonicalize().map(|folder| folder.join("target"));
    let folder = std::env::args_os().nth(1).map_or_else(target, |folder| Ok(folder.into()))?;
    std::fs::create_dir_all(&folder)?;
    let file = folder.join(name);
    let here = std::env::current_dir()?;
    println!("drawn in {}", file.strip_prefix(here).unwrap_or(&file).display());
    Ok(file)
}
