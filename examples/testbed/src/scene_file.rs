//! Scenes of contacts alone, and the bundled files.

use crate::format;
use crate::measure;
use crate::mixed::{Friction, MixedFile};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::path::{Path, PathBuf};
use stiction::{Contact, Error, Real, Scene};

/// A scene of contacts alone; rows of `h` go contact by contact, normal first.
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

/// All scenes of a file of contacts alone: one, or the time steps of a sequence named `name[k]`.
pub fn read(path: &Path) -> Result<Vec<SceneFile>, String> {
    format::read(path)?.iter().map(SceneFile::of_file).collect()
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

impl SceneFile {
    /// The scene of a file of contacts alone.
    pub fn of_file(file: &MixedFile) -> Result<Self, String> {
        let coefficient = |mu: &Friction| match mu {
            Friction::Isotropic(mu) => Ok(*mu),
            Friction::Rows(_) => Err(format!("{}: a list of mu is not read here", file.name)),
        };
        if !file.joints.is_empty() || !file.compliance.is_empty() {
            return Err(format!("{}: joint rows and compliance are not read here", file.name));
        }
        Ok(Self {
            name: file.name.clone(),
            n_dof: file.n_dof,
            n_contacts: file.n_contacts,
            dim: file.dim,
            mass: file.mass(),
            h: DMatrix::from_fn(file.h.len(), file.n_dof, |i, j| file.h[i][j]),
            f: DVector::from_column_slice(&file.f),
            w: DVector::from_column_slice(&file.w),
            mu: file.mu.iter().map(coefficient).collect::<Result<_, _>>()?,
            keys: file.keys.clone(),
        })
    }

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

    /// The scene in the kernel's types, over as many of `N` velocities as it has.
    pub fn scene<T: Real, const N: usize, const D: usize, const C: usize>(
        &self,
    ) -> Result<Scene<T, N, D, C>, Error> {
        let mut scene = Scene::new();
        scene.set_velocities(self.n_dof)?;
        scene.set_mass(&SMatrix::from_fn(|i, j| T::literal(*self.mass.get((i, j)).unwrap_or(&0.0))))?;
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
        let (n, rows) = (scene.velocities(), D * contacts.len());
        Self {
            name: String::new(),
            n_dof: n,
            n_contacts: contacts.len(),
            dim: D,
            mass: DMatrix::from_fn(n, n, |i, j| double(scene.mass()[(i, j)])),
            h: DMatrix::from_fn(rows, n, |i, j| double(contacts[i / D].jacobian[(i % D, j)])),
            f: DVector::from_fn(n, |i, _| -double(free_impulse[i])),
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

    /// The free impulse `-f` in the kernel's type, and zeros behind it.
    pub fn free_impulse<T: Real, const N: usize>(&self) -> SVector<T, N> {
        SVector::from_fn(|i, _| T::literal(-self.f.get(i).copied().unwrap_or(0.0)))
    }
}
