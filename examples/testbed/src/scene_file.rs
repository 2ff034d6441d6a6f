//! Scene files: one JSON object a file, or a sequence of time steps under `problems`.

use crate::contact_keys::ContactKeys;
use crate::measure;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use std::path::{Path, PathBuf};
use stiction::{Contact, Error, Real, Scene};

/// A scene as it stands in a file; rows of `h` go contact by contact, normal first.
#[derive(Clone, Debug)]
pub struct SceneFile {
    pub name: String,
    pub n_dof: usize,
    pub n_contacts: usize,
    pub dim: usize,
    pub mass: DMatrix<f64>,
    pub h: DMatrix<f64>,
    pub f: DVector<f64>,
    pub w: DVector<f64>,
    pub mu: Vec<f64>,
    /// Which contact is which, from one time step to the next.
    pub keys: Vec<u32>,
}

/// What tells a sequence from a scene, and what they have in common.
#[derive(Deserialize)]
struct Header {
    name: Option<String>,
    n_dof: usize,
    dim: usize,
    problems: Option<IgnoredAny>,
}

#[derive(Deserialize)]
struct Sequence {
    problems: Vec<Problem>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Problem {
    #[serde(rename = "n_contacts")]
    n_contacts: usize,
    m: Vec<Vec<f64>>,
    h: Vec<Vec<f64>>,
    #[serde(rename = "f")]
    f: Vec<f64>,
    #[serde(rename = "w")]
    w: Vec<f64>,
    #[serde(rename = "mu")]
    mu: Vec<f64>,
    /// What touches what; the same name twice for two points of one pair of bodies.
    #[serde(rename = "contact_names", default)]
    contact_names: Vec<String>,
}

/// All scenes of a file: one, or the time steps of a sequence named `name[k]`.
pub fn read(path: &Path) -> Result<Vec<SceneFile>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    read_text(&text, &stem)
}

/// All scenes of the text of a file of this name.
pub fn read_text(text: &str, stem: &str) -> Result<Vec<SceneFile>, String> {
    let header: Header = parse(text)?;
    let name = header.name.unwrap_or_else(|| stem.to_owned());
    let mut keys = ContactKeys::default();
    let mut check = |problem: Problem, name| problem.check(name, header.n_dof, header.dim, &mut keys);
    if header.problems.is_none() {
        return Ok(vec![check(parse(text)?, name)?]);
    }
    let sequence: Sequence = parse(text)?;
    let steps = sequence.problems.into_iter().enumerate();
    steps
        .map(|(k, problem)| {
            let name = format!("{name}[{k}]");
            check(problem, name.clone()).map_err(|error| format!("{name}: {error}"))
        })
        .collect()
}

pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
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

/// The folder of the whole repository.
pub fn repository() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.nth(2).expect("this package is two folders down")
}

/// The bundled scenes, by name.
pub fn bundled() -> Vec<PathBuf> {
    json_files(&repository().join("tests/scenes"))
}

/// All scenes of the bundled files.
pub fn bundled_scenes() -> Vec<SceneFile> {
    let read = |path: PathBuf| read(&path).expect("bundled scenes can be read");
    bundled().into_iter().flat_map(read).collect()
}

/// The bundled sequences of time steps, by name.
pub fn bundled_sequences() -> Vec<PathBuf> {
    json_files(&repository().join("tests/sequences"))
}

/// The `.json` files of a folder, by name.
pub fn json_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .collect();
    files.sort();
    files
}

pub(crate) fn matrix(what: &str, rows: &[Vec<f64>], n: usize, m: usize) -> Result<DMatrix<f64>, String> {
    if rows.len() != n || rows.iter().any(|row| row.len() != m) {
        let mut lengths = rows.iter().map(Vec::len);
        let wrong = lengths.clone().find(|&length| length != m);
        let columns = wrong.or(lengths.next_back()).unwrap_or(0);
        return Err(format!("{what} is {} x {columns}, not {n} x {m}", rows.len()));
    }
    Ok(DMatrix::from_fn(n, m, |i, j| rows[i][j]))
}

pub(crate) fn vector(what: &str, entries: Vec<f64>, n: usize) -> Result<DVector<f64>, String> {
    if entries.len() != n {
        return Err(format!("{what} has {} entries, not {n}", entries.len()));
    }
    Ok(DVector::from_vec(entries))
}

impl Problem {
    fn check(
        self,
        name: String,
        n_dof: usize,
        dim: usize,
        keys: &mut ContactKeys,
    ) -> Result<SceneFile, String> {
        if !(1..=4).contains(&dim) {
            return Err(format!("dim {dim} is not 1, 2, 3 or 4"));
        }
        let rows = dim.saturating_mul(self.n_contacts);
        let h = matrix("H (dim rows a contact)", &self.h, rows, n_dof)?;
        Ok(SceneFile {
            name,
            n_dof,
            n_contacts: self.n_contacts,
            dim,
            mass: matrix("M", &self.m, n_dof, n_dof)?,
            f: vector("f", self.f, n_dof)?,
            w: vector("w", self.w, rows)?,
            mu: vector("mu", self.mu, self.n_contacts)?.as_slice().to_vec(),
            keys: keys.of_step(&self.contact_names, &h, self.n_contacts),
            h,
        })
    }
}

impl SceneFile {
    /// The scene as a number type holds it.
    #[must_use]
    pub fn rounded<T: Real>(&self) -> Self {
        let round = |x: f64| measure::double(&T::literal(x));
        Self {
            mass: self.mass.map(round),
            h: self.h.map(round),
            f: self.f.map(round),
            w: self.w.map(round),
            mu: self.mu.iter().map(|&mu| round(mu)).collect(),
            ..self.clone()
        }
    }

    /// The scene in the kernel's types, padded with decoupled velocities of unit mass up to `N`.
    pub fn scene<T: Real, const N: usize, const D: usize, const C: usize>(
        &self,
    ) -> Result<Scene<T, N, D, C>, Error> {
        let mut scene = Scene::new();
        scene.set_mass(&SMatrix::from_fn(|i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            T::literal(*self.mass.get((i, j)).unwrap_or(&unit))
        }))?;
        for i in 0..self.n_contacts {
            scene.push(&Contact {
                jacobian: SMatrix::from_fn(|row, j| {
                    T::literal(*self.h.get((i * D + row, j)).unwrap_or(&0.0))
                }),
                offset: SVector::from_fn(|row, _| T::literal(self.w[i * D + row])),
                mu: T::literal(self.mu[i]),
                key: self.keys[i],
            })?;
        }
        Ok(scene)
    }

    /// The data of a scene of the kernel, in f64.
    pub fn of<T: Real, const N: usize, const D: usize, const C: usize, const R: usize, const S: usize>(
        scene: &Scene<T, N, D, C, R, S>,
        free_impulse: &SVector<T, N>,
    ) -> Self {
        assert!(scene.rows().is_empty(), "a scene of contacts alone");
        let double = |x: T| x.to_subset().unwrap_or(f64::NAN);
        let contacts = scene.contacts();
        let rows = D * contacts.len();
        Self {
            name: String::new(),
            n_dof: N,
            n_contacts: contacts.len(),
            dim: D,
            mass: DMatrix::from_fn(N, N, |i, j| double(scene.mass()[(i, j)])),
            h: DMatrix::from_fn(rows, N, |i, j| double(contacts[i / D].jacobian[(i % D, j)])),
            f: DVector::from_fn(N, |i, _| -double(free_impulse[i])),
            w: DVector::from_fn(rows, |i, _| double(contacts[i / D].offset[i % D])),
            mu: contacts.iter().map(|contact| double(contact.mu)).collect(),
            keys: contacts.iter().map(|contact| contact.key).collect(),
        }
    }

    /// The text of a scene file.
    pub fn json(&self) -> String {
        let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
            let rows = matrix.row_iter();
            rows.map(|row| row.iter().copied().collect()).collect()
        };
        serde_json::json!({
            "name": self.name,
            "n_dof": self.n_dof,
            "n_contacts": self.n_contacts,
            "dim": self.dim,
            "M": rows(&self.mass),
            "H": rows(&self.h),
            "f": self.f.as_slice(),
            "w": self.w.as_slice(),
            "mu": self.mu,
        })
        .to_string()
    }

    /// The free impulse `-f` in the kernel's type, padded with zeros.
    pub fn free_impulse<T: Real, const N: usize>(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| T::literal(-self.f.get(i).copied().unwrap_or(0.0)))
    }
}
