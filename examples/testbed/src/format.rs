//! The format of scene files: one JSON object a scene, or a sequence of time steps under `problems`. `src/guide/scenes.md` says what
//! the keys mean, `src/guide/scene.schema.json` which there are.

use crate::ContactKeys;
use crate::mixed::{Friction, Joint, MixedFile};
use nalgebra::DMatrix;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;
use std::sync::LazyLock;

static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    let schema = include_str!("../../../src/guide/scene.schema.json");
    serde_json::from_str(schema).expect("the schema is JSON")
});

/// What a file says, before it is checked. A time step of a sequence has what is missing from the sequence.
#[derive(Deserialize)]
struct Given {
    name: Option<String>,
    n_dof: Option<usize>,
    n_contacts: Option<usize>,
    dim: Option<usize>,
    #[serde(rename = "h")]
    time_step: Option<f64>,
    #[serde(rename = "M")]
    m: Option<Vec<Vec<f64>>>,
    #[serde(rename = "H")]
    h: Option<Vec<Vec<f64>>>,
    f: Option<Vec<f64>>,
    free_impulse: Option<Vec<f64>>,
    w: Option<Vec<f64>>,
    mu: Option<Vec<Friction>>,
    #[serde(default)]
    joints: Vec<Joint>,
    #[serde(default)]
    compliance: Vec<[f64; 2]>,
    /// What touches what; the same name twice for two points of one pair of bodies.
    #[serde(default)]
    contact_names: Vec<String>,
    problems: Option<Vec<Given>>,
}

/// All scenes of a file: one, or the time steps of a sequence named `name[k]`.
pub fn read(path: &Path) -> Result<Vec<MixedFile>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    read_text(&text, &stem)
}

/// All scenes of the text of a file of this name.
pub fn read_text(text: &str, stem: &str) -> Result<Vec<MixedFile>, String> {
    let mut file: Given = parse(text)?;
    check_keys(text)?;
    let mut keys = ContactKeys::default();
    let name = file.name.take().unwrap_or_else(|| stem.to_owned());
    let Some(steps) = file.problems.take() else {
        return Ok(vec![file.check(name, &mut keys)?]);
    };
    if file.m.is_some() || file.h.is_some() || file.f.is_some() || file.free_impulse.is_some() {
        return Err("problems: a sequence has no M, H or free impulse beside its time steps".into());
    }
    let steps = steps.into_iter().enumerate().map(|(k, mut step)| {
        step.n_dof = step.n_dof.or(file.n_dof);
        step.dim = step.dim.or(file.dim);
        step.time_step = step.time_step.or(file.time_step);
        let name = format!("{name}[{k}]");
        step.check(name.clone(), &mut keys).map_err(|error| format!("{name}: {error}"))
    });
    steps.collect()
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_str(text).map_err(|error| {
        let place = text.lines().nth(error.line().saturating_sub(1));
        let rest = place.and_then(|line| line.get(error.column().saturating_sub(1)..));
        let not_a_number = ["NaN", "Infinity", "-Infinity", "nan", "inf"];
        match rest {
            Some(rest) if not_a_number.iter().any(|word| rest.starts_with(word)) => {
                format!("not a finite number: {error}")
            }
            _ => error.to_string(),
        }
    })
}

/// Names a key that the schema does not know.
fn check_keys(text: &str) -> Result<(), String> {
    let file: Value = parse(text)?;
    let scene = &SCHEMA["properties"];
    let joint = &scene["joints"]["items"]["properties"];
    let check = |given: &Value, known: &Value| {
        let mut keys = given.as_object().into_iter().flat_map(|given| given.keys());
        let unknown = keys.find(|key| known.get(key).is_none());
        unknown.map_or(Ok(()), |key| Err(format!("{key}: a scene file has no such key")))
    };
    for step in list(&file, "problems").chain([&file]) {
        check(step, scene)?;
        for row in list(step, "joints") {
            check(row, joint).map_err(|error| format!("joints: {error}"))?;
        }
    }
    Ok(())
}

/// The entries of a list in an object, if there is one.
fn list<'a>(given: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    given[key].as_array().into_iter().flatten()
}

fn given<T>(name: &str, value: Option<T>) -> Result<T, String> {
    value.ok_or_else(|| format!("{name}: it is missing"))
}

fn check_matrix(what: &str, rows: &[Vec<f64>], n: usize, m: usize) -> Result<(), String> {
    if rows.len() != n || rows.iter().any(|row| row.len() != m) {
        let mut lengths = rows.iter().map(Vec::len);
        let wrong = lengths.clone().find(|&length| length != m);
        let columns = wrong.or(lengths.next_back()).unwrap_or(0);
        return Err(format!("{what}: it is {} x {columns}, not {n} x {m}", rows.len()));
    }
    Ok(())
}

fn check_length(what: &str, length: usize, wanted: usize) -> Result<(), String> {
    if length == wanted { Ok(()) } else { Err(format!("{what}: it has {length} entries, not {wanted}")) }
}

impl Given {
    fn check(self, name: String, known: &mut ContactKeys) -> Result<MixedFile, String> {
        let (n_dof, n_contacts) = (given("n_dof", self.n_dof)?, given("n_contacts", self.n_contacts)?);
        let dim = given("dim", self.dim)?;
        if !matches!(dim, 1..=4 | 6) {
            return Err(format!("dim: {dim} is not 1, 2, 3, 4 or 6"));
        }
        let (mass, h) = (given("M", self.m)?, given("H", self.h)?);
        let (w, mu) = (given("w", self.w)?, given("mu", self.mu)?);
        if let Some(h) = self.time_step.filter(|&h| !(h > 0.0 && h.is_finite())) {
            return Err(format!("h: {h} is no time step"));
        }
        let rows = dim.saturating_mul(n_contacts);
        check_matrix("M", &mass, n_dof, n_dof)?;
        check_matrix("H", &h, rows, n_dof)?; // dim rows a contact
        let f = match (self.f, self.free_impulse) {
            (Some(f), None) => f,
            (None, Some(free_impulse)) => free_impulse.iter().map(|x| -x).collect(),
            (None, None) => return Err("free_impulse: it is missing, and so is f, its negative".into()),
            (Some(_), Some(_)) => {
                return Err("free_impulse and f: one is the negative of the other, give one".into());
            }
        };
        check_length("free_impulse", f.len(), n_dof)?;
        check_length("w", w.len(), rows)?;
        check_length("mu", mu.len(), n_contacts)?;
        if !self.compliance.is_empty() {
            check_length("compliance", self.compliance.len(), n_contacts)?;
        }
        for mu in &mu {
            if let Friction::Rows(mu) = mu
                && mu.len() + 1 != dim
            {
                return Err(format!("mu: a list has {} entries, not {}", mu.len(), dim - 1));
            }
        }
        for joint in &self.joints {
            check_length("joints: row", joint.row.len(), n_dof)?;
            joint.law::<f64>()?;
        }
        let rows = DMatrix::from_fn(rows, n_dof, |i, j| h[i][j]);
        Ok(MixedFile {
            keys: known.of_step(&self.contact_names, &rows, n_contacts),
            name,
            n_dof,
            n_contacts,
            dim,
            time_step: self.time_step,
            mass,
            h,
            f,
            w,
            mu,
            joints: self.joints,
            compliance: self.compliance,
            limits_inside: false,
        })
    }
}
