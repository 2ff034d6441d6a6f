//! Bodies as a file: those that are rigid or on wheels, as numbers that `tests/rest_kept.rs` makes a scene of.

use crate::body::{Body, Brake};
use serde_json::{Value, json};

pub(crate) fn text(bodies: &[Body]) -> String {
    let bodies = bodies.iter().filter(|body| !body.feet.is_empty());
    let lines: Vec<String> = bodies.map(|body| line(body).to_string()).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

/// A locked wheel has no torque.
fn line(body: &Body) -> Value {
    let feet = body.feet.iter().zip(&body.mu);
    let feet = feet.map(|(foot, mu)| json!([foot.point, foot.normal, mu]));
    let torque = |brake: &Brake| brake.torque.is_finite().then_some(brake.torque);
    let brakes: Vec<Option<f64>> = body.brakes.iter().map(torque).collect();
    json!({
        "kind": body.kind.name(),
        "masses": body.mass.diagonal().as_slice(),
        "feet": feet.collect::<Vec<_>>(),
        "radius": body.radius,
        "brakes": brakes,
        "weight": &body.weight.as_slice()[..3],
        "load": &body.load.as_slice()[..6],
    })
}
