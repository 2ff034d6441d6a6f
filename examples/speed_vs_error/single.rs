//! One solver on one scene, again and again: for a profiler (`profile.py`).

use crate::contestant::Id;
use crate::sizes;
use testbed::scene_file::SceneFile;

/// `SCENE:SOLVER:TOLERANCE:CALLS`, the solver as the tables name it.
pub(crate) fn run(scenes: &[SceneFile], what: &str) -> Result<(), String> {
    let parts: Vec<&str> = what.split(':').collect();
    let [scene, solver, tolerance, calls] = parts[..] else {
        return Err(format!("{what} is not SCENE:SOLVER:TOLERANCE:CALLS"));
    };
    let scene = scenes.iter().find(|file| file.name == scene);
    let scene = scene.ok_or("no such scene")?;
    let id = Id::ALL.into_iter().find(|id| id.name() == solver);
    let id = id.ok_or("no such solver")?;
    let tolerance: f64 = tolerance.parse().map_err(|_| "no such tolerance")?;
    let calls: usize = calls.parse().map_err(|_| "no such number of calls")?;
    let mut contestant = sizes::contestant(scene, id).ok_or("not in this number type")?;
    contestant.prepare();
    for call in 1..=calls {
        let effort = contestant.solve(tolerance);
        if call == calls {
            println!("{} {}", effort.iterations, effort.newton_steps);
        }
    }
    Ok(())
}
