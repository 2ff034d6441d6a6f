//! Arrays as they come from Python: their shapes checked, each complaint with the name of its argument.

use crate::solve::Loaded;
use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use stiction_kernels::problem::{Friction, Problem, Rows};

/// A number of kernels and of numpy.
pub(crate) trait Number: stiction_kernels::engine::Number + Element {}

impl<T: stiction_kernels::engine::Number + Element> Number for T {}

/// One array, with the length of its leading axis if it is one of a batch.
struct Array<'py, T: Element> {
    name: &'static str,
    values: PyReadonlyArrayDyn<'py, T>,
    lead: usize,
    is_batch: bool,
}

impl<'py, T: Element + Copy> Array<'py, T> {
    fn new(name: &'static str, array: &Bound<'py, PyAny>, is_batch: bool) -> PyResult<Self> {
        let values = match array.extract::<PyReadonlyArrayDyn<'py, T>>() {
            Ok(values) if values.is_c_contiguous() && values.as_slice().is_ok() => values, // and aligned
            _ => Self::converted(name, array)?,
        };
        let lead = match (is_batch, values.shape().first()) {
            (false, _) => 1,
            (true, Some(&lead)) => lead,
            (true, None) => {
                return Err(PyValueError::new_err(format!("{name}: a batch has a leading axis")));
            }
        };
        Ok(Self { name, values, lead, is_batch })
    }

    /// What is not an array of this type, or not row by row, made one.
    fn converted(name: &str, array: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
        let py = array.py();
        let convert = py.import("stiction._arrays")?.getattr("array")?;
        let made = convert.call1((name, array, T::get_dtype(py)))?;
        made.extract()
            .map_err(|_| PyValueError::new_err(format!("{name}: an array that is being written to")))
    }

    fn optional(name: &'static str, array: &Bound<'py, PyAny>, is_batch: bool) -> PyResult<Option<Self>> {
        if array.is_none() {
            return Ok(None);
        }
        Self::new(name, array, is_batch).map(Some)
    }

    /// Its shape, without the leading axis.
    fn shape(&self) -> &[usize] {
        &self.values.shape()[usize::from(self.is_batch)..]
    }

    fn wrong(&self, wanted: &str) -> PyErr {
        let leading = if self.is_batch { " behind the leading axis" } else { "" };
        PyValueError::new_err(format!("{}: shape {:?} is not {wanted}{leading}", self.name, self.shape()))
    }

    /// Its shape is one of these.
    fn expect(&self, shapes: &[&[usize]]) -> PyResult<()> {
        if shapes.contains(&self.shape()) {
            return Ok(());
        }
        let names: Vec<_> = shapes.iter().map(|shape| format!("{shape:?}")).collect();
        Err(self.wrong(&names.join(" or ")))
    }

    /// Continues a fingerprint with the bits of all its numbers, in four hashes that need not wait for each other.
    fn print(&self, hash: u64, bits: impl Fn(T) -> u64) -> u64 {
        let next = |hash: u64, bits: u64| (hash.rotate_left(32) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut hashes = [hash, 1, 2, 3];
        for numbers in self.values.as_slice().unwrap_or_default().chunks(4) {
            for (hash, &number) in hashes.iter_mut().zip(numbers) {
                *hash = next(*hash, bits(number));
            }
        }
        hashes.into_iter().fold(0, next)
    }

    /// That of a scene; of all, if the leading axis has length 1.
    fn of(&self, scene: usize) -> &[T] {
        let all = self.values.as_slice().unwrap_or_default();
        let length: usize = self.shape().iter().product();
        let place = if self.lead == 1 { 0 } else { scene };
        &all[place * length..][..length]
    }
}

/// The joint rows of a call.
struct RowArrays<'py, T: Element> {
    jacobian: Array<'py, T>,
    /// Offset, lower and upper bound, compliance.
    numbers: [Array<'py, T>; 4],
    keys: Array<'py, u32>,
}

/// The arrays of a call.
pub(crate) struct Arrays<'py, T: Element> {
    pub(crate) n: usize,
    pub(crate) dim: usize,
    pub(crate) contacts: usize,
    pub(crate) rows: usize,
    /// Number of scenes.
    pub(crate) lead: usize,
    /// `M`, `H` and the free impulse.
    dynamics: [Array<'py, T>; 3],
    offsets: Array<'py, T>,
    friction: Array<'py, T>,
    compliance: Option<Array<'py, T>>,
    keys: Option<Array<'py, u32>>,
    joint: Option<RowArrays<'py, T>>,
}

impl<'py, T: Number> Arrays<'py, T> {
    /// From `(M, H, free impulse, w, mu, compliance or None, keys or None, rows or None)`; rows are
    /// `(jacobian, offset, lower, upper, compliance, keys)`.
    pub(crate) fn new(arguments: &Bound<'py, PyTuple>, is_batch: bool) -> PyResult<Self> {
        let at = |place: usize| arguments.get_item(place);
        let number = |name, place: usize| Array::<T>::new(name, &at(place)?, is_batch);
        let friction = number("mu", 4)?;
        let offsets = number("w", 3)?;
        let contacts =
            *friction.shape().first().ok_or_else(|| friction.wrong("one coefficient a contact"))?;
        let dynamics = [number("M", 0)?, number("H", 1)?, number("free_impulse", 2)?];
        let [n, behind, pushed] = dynamics.each_ref().map(|array| array.shape().last().copied().unwrap_or(0));
        // Whom two others contradict is wrong.
        let n = if behind == pushed && n != behind { behind } else { n };
        let [mass, shaped, free_impulse] = &dynamics;
        mass.expect(&[&[n, n]])?;
        // The rows of a contact, as `H` has them.
        let behind = &[n][..];
        let dim = match (shaped.shape(), contacts) {
            ([of, dim, rest @ ..], _) if *of == contacts && rest == behind => *dim,
            ([_, ..], 0) => 3,
            ([all, rest @ ..], _) if rest == behind && all % contacts == 0 => all / contacts,
            _ => {
                return Err(shaped.wrong(&format!("that of {contacts} contacts over the velocities")));
            }
        };
        if !matches!(dim, 1..=4 | 6) {
            return Err(shaped.wrong("that of contacts with 1, 2, 3, 4 or 6 rows"));
        }
        offsets.expect(&[&[contacts, dim], &[contacts * dim]])?;
        let by_row = [contacts, dim - 1];
        let round: &[&[usize]] = if dim > 3 { &[&by_row] } else { &[&[contacts], &by_row] };
        friction.expect(round)?;
        let compliance = Array::optional("compliance", &at(5)?, is_batch)?;
        let keys = Array::optional("keys", &at(6)?, is_batch)?;
        let joint = Self::rows(&at(7)?, n, is_batch)?;
        let rows = joint.as_ref().map_or(0, |rows| rows.numbers[0].shape()[0]);
        shaped.expect(&[&[contacts, dim, n], &[contacts * dim, n]])?;
        free_impulse.expect(&[&[n]])?;
        compliance.as_ref().map_or(Ok(()), |array| array.expect(&[&[contacts, 2]]))?;
        keys.as_ref().map_or(Ok(()), |array| array.expect(&[&[contacts]]))?;
        let mut arrays =
            Self { n, dim, contacts, rows, lead: 1, dynamics, offsets, friction, compliance, keys, joint };
        arrays.lead = arrays.common_lead()?;
        Ok(arrays)
    }

    fn rows(rows: &Bound<'py, PyAny>, n: usize, is_batch: bool) -> PyResult<Option<RowArrays<'py, T>>> {
        if rows.is_none() {
            return Ok(None);
        }
        let rows = rows.cast::<PyTuple>()?;
        let number = |name, place: usize| Array::<T>::new(name, &rows.get_item(place)?, is_batch);
        let jacobian = number("rows.jacobian", 0)?;
        let numbers = [
            number("rows.offset", 1)?,
            number("rows.lower", 2)?,
            number("rows.upper", 3)?,
            number("rows.compliance", 4)?,
        ];
        let keys = Array::new("rows.keys", &rows.get_item(5)?, is_batch)?;
        let count = jacobian.shape().first().copied().unwrap_or(0);
        jacobian.expect(&[&[count, n]])?;
        numbers.iter().try_for_each(|array| array.expect(&[&[count]]))?;
        keys.expect(&[&[count]])?;
        Ok(Some(RowArrays { jacobian, numbers, keys }))
    }

    /// The length of the leading axis that all have which have not 1.
    fn common_lead(&self) -> PyResult<usize> {
        let own = self.dynamics.iter().chain([&self.offsets, &self.friction]).chain(&self.compliance);
        let rows = self.joint.iter().flat_map(|rows| rows.numbers.iter().chain([&rows.jacobian]));
        let keys = self.keys.iter().chain(self.joint.iter().map(|rows| &rows.keys));
        let leads: Vec<_> = own
            .chain(rows)
            .map(|array| (array.name, array.lead))
            .chain(keys.map(|array| (array.name, array.lead)))
            .collect();
        let lead = leads.iter().map(|&(_, lead)| lead).find(|&lead| lead != 1).unwrap_or(1);
        match leads.iter().find(|&&(_, own)| own != 1 && own != lead) {
            None => Ok(lead),
            Some((name, own)) => Err(PyValueError::new_err(format!(
                "{name}: a leading axis of length {own} beside one of {lead}; 1 is broadcast"
            ))),
        }
    }

    /// A fingerprint of all of them, in single precision if they were solved in that.
    pub(crate) fn fingerprint(&self, single: bool) -> u64 {
        #[allow(clippy::cast_possible_truncation)]
        let bits = |number: T| {
            let number: f64 = number.into();
            if single { u64::from((number as f32).to_bits()) } else { number.to_bits() }
        };
        let own = self.dynamics.iter().chain([&self.offsets, &self.friction]).chain(&self.compliance);
        let rows = self.joint.iter().flat_map(|rows| rows.numbers.iter().chain([&rows.jacobian]));
        let numbers = own.chain(rows).fold(0, |hash, array| array.print(hash, bits));
        let keys = self.keys.iter().chain(self.joint.iter().map(|rows| &rows.keys));
        keys.fold(numbers, |hash, array| array.print(hash, u64::from))
    }

    /// What a solution remembers of them.
    pub(crate) fn loaded(&self) -> Loaded {
        let sizes = [self.n, self.contacts, self.dim, self.rows];
        Loaded { sizes, fingerprint: self.fingerprint(size_of::<T>() == 4) }
    }

    /// A scene of them.
    pub(crate) fn problem(&self, scene: usize) -> Problem<'_, T> {
        let [mass, jacobian, free_impulse] = self.dynamics.each_ref().map(|array| array.of(scene));
        let mu = self.friction.of(scene);
        let friction =
            if self.friction.shape().len() == 1 { Friction::Round(mu) } else { Friction::Shaped(mu) };
        let rows = self.joint.as_ref().map_or(Rows::NONE, |rows| {
            let [offset, lower, upper, compliance] = rows.numbers.each_ref().map(|array| array.of(scene));
            Rows {
                jacobian: rows.jacobian.of(scene),
                offset,
                lower,
                upper,
                compliance,
                keys: rows.keys.of(scene),
            }
        });
        Problem {
            n: self.n,
            dim: self.dim,
            mass,
            jacobian,
            free_impulse,
            offsets: self.offsets.of(scene),
            friction,
            compliance: self.compliance.as_ref().map_or(&[], |array| array.of(scene)),
            keys: self.keys.as_ref().map_or(&[], |array| array.of(scene)),
            rows,
        }
    }
}
