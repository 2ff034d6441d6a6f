//! The JSON of the program has the library's words.

use serde_json::{Value, json};
use std::process::Command;

/// Status and mode of the first contact of a bundled scene.
fn solved(scene: &str, budget: &str) -> Value {
    let path = format!("{}/../../tests/scenes/{scene}.json", env!("CARGO_MANIFEST_DIR"));
    let mut solve = Command::new(env!("CARGO_BIN_EXE_solve"));
    let output = solve.args(["--json", "--budget", budget, &path]).output().expect("it runs");
    let line: Value = serde_json::from_slice(&output.stdout).expect("it is a line of JSON");
    json!([line["status"], line["modes"][0]])
}

#[test]
fn statuses_and_modes_have_the_names_of_the_library() {
    assert_eq!(solved("slope_box_slip", "1000"), json!(["Solved", "Slip"]));
    assert_eq!(solved("slope_box_stick", "1000"), json!(["Solved", "Stick"]));
    assert_eq!(solved("slope_box_stick", "0"), json!(["OutOfBudget", "Open"]));
    assert_eq!(solved("infeasible_squeeze", "1000")[0], "Infeasible");
}
