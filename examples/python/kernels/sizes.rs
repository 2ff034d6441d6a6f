//! The sizes that are compiled.

use crate::engine::{Compiled, Engine, Number};
use crate::problem::Needs;
use stiction::{Contact, Error, Scene, Surface};

/// A compiled size: velocities, rows of a contact, contacts, joint rows, contacts with a surface.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    n: usize,
    dim: usize,
    contacts: usize,
    rows: usize,
    surfaces: usize,
}

impl Size {
    pub fn tuple(&self) -> (usize, usize, usize, usize, usize) {
        let Self { n, dim, contacts, rows, surfaces } = *self;
        (n, dim, contacts, rows, surfaces)
    }

    pub fn holds(&self, needs: &Needs) -> bool {
        needs.n <= self.n
            && needs.dim == self.dim
            && needs.contacts <= self.contacts
            && needs.rows <= self.rows
            && (!needs.surfaces || self.surfaces > 0)
    }
}

impl Needs {
    /// The argument that asks for more than this size has.
    fn culprit(&self, most: &Size) -> &'static str {
        if self.n > most.n {
            "M"
        } else if self.contacts > most.contacts {
            "H"
        } else {
            "rows"
        }
    }
}

/// A size, and what makes a kernel of it. Tables are statics: who names a constant compiles all kernels again.
pub type Entry<T> = (Size, fn() -> Box<dyn Engine<T>>);

/// The index of the first size of a number type that holds a scene.
///
/// # Errors
/// No size does: what to do.
pub fn index<T: Number>(needs: &Needs) -> Result<usize, String> {
    T::sizes().iter().position(|(size, _)| size.holds(needs)).ok_or_else(|| {
        let Needs { n, dim, contacts, rows, .. } = *needs;
        match of_dim::<T>(dim).max_by_key(|size| (size.n, size.contacts, size.rows)) {
            Some(most) => format!(
                "{}: a scene of {n} velocities, {contacts} contacts of {dim} rows and {rows} joint rows: at most {}, {} and {} \
                 are compiled; leave out velocities that no contact moves, merge contacts, leave out limits that are far, \
                 or add a line to kernels/sizes.rs",
                needs.culprit(most), most.n, most.contacts, most.rows
            ),
            None => format!("H: contacts of {dim} rows; 1, 2, 3, 4 or 6 have a meaning"),
        }
    })
}

/// A kernel of a size, by its index.
pub fn engine<T: Number>(index: usize) -> Box<dyn Engine<T>> {
    T::sizes()[index].1()
}

fn of_dim<T: Number>(dim: usize) -> impl Iterator<Item = &'static Size> {
    T::sizes().iter().map(|(size, _)| size).filter(move |size| size.dim == dim)
}

/// The table of a number type, in the order in which sizes are tried. `push` fills in contacts with one coefficient, which spin and roll
/// have not.
macro_rules! sizes {
    ($t:ty; $($push:ident: $(($n:literal, $d:literal, $c:literal, $r:literal, $s:literal))*;)*) => {
        &[$($((
            Size { n: $n, dim: $d, contacts: $c, rows: $r, surfaces: $s },
            || Compiled::<$t, $n, $d, $c, $r, $s>::boxed($push!()),
        ),)*)*]
    };
}

macro_rules! plain {
    () => {
        Scene::push
    };
}

macro_rules! on_surface {
    () => {
        push_on_surface
    };
}

/// Adds a contact with one coefficient, which spin and roll have not.
pub(crate) fn push_on_surface<
    T: stiction::Real,
    const N: usize,
    const D: usize,
    const C: usize,
    const R: usize,
    const S: usize,
>(
    scene: &mut Scene<T, N, D, C, R, S>,
    contact: &Contact<T, N, D>,
) -> Result<usize, Error> {
    scene.push_on(contact, &Surface::isotropic(contact.mu))
}

// Room that a scene does not use costs little: of velocities up to a fifth of the time. A size takes four seconds of a build. (At
// level 3 one with 16 contacts and 24 rows takes a minute: LLVM 22 unrolls a loop of the central path and simplifies it for that long.)
pub static DOUBLE: &[Entry<f64>] = sizes! {
    f64;
    plain:
        (6, 3, 8, 6, 8) (18, 3, 16, 30, 16) (36, 3, 24, 48, 24) (60, 3, 64, 96, 64) (144, 3, 64, 96, 64)
        (288, 3, 96, 96, 96)
        (36, 2, 16, 48, 16)
        (36, 1, 16, 48, 16);
    on_surface:
        (36, 4, 16, 48, 16)
        (36, 6, 24, 48, 24) (96, 6, 64, 96, 64);
};

// For the bits of microcontrollers. A scene has them in any size.
pub static SINGLE: &[Entry<f32>] = sizes! {
    f32;
    plain:
        (6, 3, 8, 6, 8) (18, 3, 16, 30, 16) (36, 3, 24, 48, 24) (288, 3, 96, 96, 96)
        (36, 2, 16, 48, 16)
        (36, 1, 16, 48, 16);
    on_surface:
        (36, 4, 16, 48, 16)
        (36, 6, 24, 48, 24) (96, 6, 64, 96, 64);
};

/// The most contacts of so many rows that any of `f64` has.
pub fn most_contacts(dim: usize) -> usize {
    of_dim::<f64>(dim).map(|size| size.contacts).max().unwrap_or(0)
}

/// Has a kernel of `f64` of so many rows a contact room for so many velocities?
pub fn has_room(velocities: usize, dim: usize) -> bool {
    of_dim::<f64>(dim).any(|size| size.n >= velocities)
}
