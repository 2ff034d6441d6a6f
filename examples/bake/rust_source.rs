//! A scene and its factor as Rust constants, every number by its bits.

use crate::records::Reduced;
use nalgebra::{SMatrix, SVector};
use stiction::{AdmmFactor, AdmmFactorParts, Contact, Error, Scene};

/// The sizes of the firmware, `examples/baked`.
const N: usize = 18;
const D: usize = 3;
const C: usize = 4;

/// Something that can be written as a Rust expression.
trait Source {
    fn source(&self) -> String;
}

impl Source for f32 {
    fn source(&self) -> String {
        format!("bits({:#010x})", self.to_bits())
    }
}

impl<S: Source, const K: usize> Source for [S; K] {
    fn source(&self) -> String {
        let entries: Vec<String> = self.iter().map(Source::source).collect();
        format!("[{}]", entries.join(", "))
    }
}

impl<const R: usize, const K: usize> Source for SMatrix<f32, R, K> {
    fn source(&self) -> String {
        let columns = self.data.0.source();
        format!("SMatrix::from_array_storage(ArrayStorage({columns}))")
    }
}

/// The source file: `SCENE`, `FACTOR` and `FREE_IMPULSE`.
pub(crate) fn write(scene: &Reduced) -> Result<String, String> {
    if (scene.f.len(), scene.contacts.len()) != (N, C) {
        return Err(format!("not a scene of {N} velocities and {C} contacts"));
    }
    factorised(scene).map_err(|error| error.to_string())
}

#[allow(clippy::cast_possible_truncation)] // the firmware's number type
fn factorised(source: &Reduced) -> Result<String, Error> {
    let mut scene = Scene::<f32, N, D, C>::new();
    scene.set_mass(&SMatrix::from_fn(|i, j| source.mass[i][j] as f32))?;
    for contact in &source.contacts {
        scene.push(&Contact {
            jacobian: SMatrix::from_fn(|row, dof| contact.h[row][dof] as f32),
            offset: SVector::from_fn(|row, _| contact.w[row] as f32),
            mu: contact.mu as f32,
            key: contact.key,
        })?;
    }
    let parts = AdmmFactor::new(&scene)?.parts();
    let parts: AdmmFactorParts<f32, N, D, C> = parts.ok_or(Error::StaleFactor)?;
    let free_impulse = SVector::<f32, N>::from_fn(|i, _| -source.f[i] as f32);

    let contacts = scene.contacts().iter().map(|contact| {
        let (jacobian, offset) = (contact.jacobian.source(), contact.offset.source());
        let (mu, key) = (contact.mu.source(), contact.key);
        format!("Contact {{ jacobian: {jacobian}, offset: {offset}, mu: {mu}, key: {key} }},\n")
    });
    let contacts: String = contacts.collect();
    let sizes = format!("f32, {N}, {D}, {C}");
    let (mass, free_impulse) = (scene.mass().source(), free_impulse.source());
    let fields: String = [
        ("moved", parts.factor.moved.to_string()),
        ("uncertainty", parts.factor.uncertainty.source()),
        ("mass", parts.factor.mass.source()),
        ("whitened", parts.factor.whitened.source()),
        ("whitened_rows", parts.factor.whitened_rows.source()),
        ("delassus", parts.factor.delassus.source()),
        ("coupling", parts.factor.coupling.source()),
        ("row_delassus", parts.factor.row_delassus.source()),
        ("effective_mass", parts.factor.effective_mass.source()),
    ]
    .map(|(name, value)| format!("{name}: {value},\n"))
    .concat();
    let (penalty, resolvent) = (parts.penalty.source(), parts.resolvent.source());
    Ok(format!(
        "// Written by `cargo run -p bake -- rust FILE`: each number is the bits of an f32.\n\
         const fn bits(bits: u32) -> f32 {{ f32::from_bits(bits) }}\n\
         pub(super) static SCENE: Scene<{sizes}> = Scene::from_parts({mass}, [\n{contacts}], []);\n\
         pub(super) static FREE_IMPULSE: SVector<f32, {N}> = {free_impulse};\n\
         pub(super) static FACTOR: AdmmFactor<{sizes}> = AdmmFactor::from_parts(&AdmmFactorParts {{\n\
         factor: FactorParts {{\n{fields}}},\npenalty: {penalty},\nresolvent: {resolvent},\n}});\n"
    ))
}
