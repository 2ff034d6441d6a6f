//! Scene files: one format, whose schema names all keys; what is missing, unknown or said twice is refused by name.

use serde_json::{Value, json};
use testbed::format;
use testbed::scene_file::{bundled, bundled_sequences, json_files, repository};

fn schema() -> Value {
    let text = std::fs::read_to_string(repository().join("src/guide/scene.schema.json"));
    serde_json::from_str(&text.expect("it can be read")).expect("JSON")
}

/// 2 kg that slide on a floor, with a stop.
fn scene() -> Value {
    json!({
        "n_dof": 2, "n_contacts": 1, "dim": 2, "M": [[2.0, 0.0], [0.0, 2.0]], "H": [[0.0, 1.0], [1.0, 0.0]],
        "free_impulse": [0.03, -0.02], "w": [0.0, 0.0], "mu": [0.5],
        "joints": [{ "kind": "box", "row": [1.0, 0.0], "offset": 0.0, "lower": -0.1, "upper": 0.2 }],
    })
}

/// The complaint of a scene of which one thing is changed; `None` if it is read.
fn refused(change: impl FnOnce(&mut Value)) -> Option<String> {
    let mut scene = scene();
    change(&mut scene);
    format::read_text(&scene.to_string(), "changed").err()
}

fn without(scene: &mut Value, key: &str) {
    scene.as_object_mut().expect("an object").remove(key);
}

#[test]
fn a_missing_key_is_named() {
    assert_eq!(refused(|_| ()), None);
    for key in schema()["else"]["required"].as_array().expect("a list") {
        let key = key.as_str().expect("a word");
        assert_eq!(refused(|scene| without(scene, key)), Some(format!("{key}: it is missing")));
    }
    let said = refused(|scene| without(scene, "free_impulse")).expect("it is refused");
    assert!(said.starts_with("free_impulse: it is missing"), "{said}");
}

#[test]
fn an_unknown_key_is_named() {
    let unknown = |key: &str| Some(format!("{key}: a scene file has no such key"));
    assert_eq!(refused(|scene| scene["rows"] = json!([])), unknown("rows"));
    assert_eq!(refused(|scene| scene["joints"][0]["mu"] = json!(1.0)), unknown("joints: mu"));
    let said = format::read_text(&json!({ "problems": [{ "m": [] }] }).to_string(), "sequence").err();
    assert_eq!(said, unknown("m"));
}

#[test]
fn the_free_impulse_has_one_sign() {
    let said = refused(|scene| scene["f"] = json!([-0.03, 0.02])).expect("it is refused");
    assert!(said.starts_with("free_impulse and f:"), "{said}");
    let read = |scene: &Value| format::read_text(&scene.to_string(), "scene").expect("it is read").remove(0);
    let mut negative = scene();
    without(&mut negative, "free_impulse");
    negative["f"] = json!([-0.03, 0.02]);
    assert_eq!(read(&scene()).free_impulse::<f64, 2>().as_slice(), [0.03, -0.02]);
    assert_eq!(read(&negative).free_impulse::<f64, 2>(), read(&scene()).free_impulse::<f64, 2>());
}

#[test]
fn what_has_no_meaning_is_named() {
    let said = |key: &str, value: Value| refused(|scene| scene[key] = value).expect("it is refused");
    assert_eq!(said("h", json!(-1.0)), "h: -1 is no time step");
    assert_eq!(said("h", json!(0.0)), "h: 0 is no time step");
    assert_eq!(said("dim", json!(5)), "dim: 5 is not 1, 2, 3, 4 or 6");
    assert_eq!(said("free_impulse", json!([0.0])), "free_impulse: it has 1 entries, not 2");
    assert_eq!(said("H", json!([[0.0, 1.0]])), "H: it is 1 x 2, not 2 x 2");
    let motor = refused(|scene| scene["joints"][0]["kind"] = json!("motor")).expect("it is refused");
    assert_eq!(motor, "joints: kind \"motor\" is not limit, equality or box");
}

#[test]
fn a_sequence_gives_its_steps_what_they_lack() {
    let mut step = scene();
    for key in ["n_dof", "dim"] {
        without(&mut step, key);
    }
    let sequence = json!({ "n_dof": 2, "dim": 2, "h": 0.01, "problems": [step.clone(), step] });
    let steps = format::read_text(&sequence.to_string(), "slide").expect("it is read");
    assert_eq!(steps.len(), 2);
    assert!(steps.iter().all(|step| step.time_step == Some(0.01) && step.joints.len() == 1));
    assert_eq!(steps[1].name, "slide[1]");
}

#[test]
fn bundled_files_are_read() {
    let mixed = json_files(&repository().join("tests/mixed"));
    for path in bundled().iter().chain(&mixed).chain(&bundled_sequences()) {
        if let Err(error) = format::read(path) {
            panic!("{}: {error}", path.display());
        }
    }
}
