//! Which laws the slots of a scene may obey: Coulomb's alone, or those of joint rows as well.
//!
//! What contacts alone do not need stands in a [`Room`], which has no size in a scene of [`Coulomb`], and of which a
//! compiler knows that there is nothing in it: neither memory nor an instruction is spent on joint rows there.

use core::fmt::Debug;
use core::marker::PhantomData;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Coulomb {}
    impl Sealed for super::Mixed {}
}

/// The laws of a scene: [`Coulomb`] or [`Mixed`]. Sealed: no other type implements it.
pub trait Laws: sealed::Sealed + Copy + Debug + 'static {
    /// May there be joint rows, compliance and shapes of friction?
    const MIXED: bool;

    /// Room for what a scene of contacts alone does not have.
    #[doc(hidden)]
    type Room<X: Copy + Debug>: Room<X>;
}

/// Contacts alone, rigid and of isotropic friction.
#[derive(Clone, Copy, Debug)]
pub enum Coulomb {}

/// Contacts and joint rows, rigid or compliant, with any shape of friction: see [`crate::guide::rows`].
#[derive(Clone, Copy, Debug)]
pub enum Mixed {}

impl Laws for Coulomb {
    const MIXED: bool = false;
    type Room<X: Copy + Debug> = NoRoom<X>;
}

impl Laws for Mixed {
    const MIXED: bool = true;
    type Room<X: Copy + Debug> = Option<X>;
}

/// A value, if there is room for one.
pub trait Room<X>: Copy + Debug {
    /// Nothing in it.
    const EMPTY: Self;

    /// With a value in it, if there is room.
    fn with(value: X) -> Self;

    /// What is in it.
    fn get(&self) -> Option<&X>;

    /// What is in it, to be changed.
    fn get_mut(&mut self) -> Option<&mut X>;
}

/// No room.
#[derive(Clone, Copy, Debug)]
pub struct NoRoom<X>(PhantomData<X>);

impl<X: Copy + Debug> Room<X> for NoRoom<X> {
    const EMPTY: Self = Self(PhantomData);

    #[inline(always)]
    #[allow(clippy::inline_always)] // nothing is to be left of it
    fn with(_: X) -> Self {
        Self::EMPTY
    }

    #[inline(always)]
    #[allow(clippy::inline_always)]
    fn get(&self) -> Option<&X> {
        None
    }

    #[inline(always)]
    #[allow(clippy::inline_always)]
    fn get_mut(&mut self) -> Option<&mut X> {
        None
    }
}

impl<X: Copy + Debug> Room<X> for Option<X> {
    const EMPTY: Self = None;

    fn with(value: X) -> Self {
        Some(value)
    }

    fn get(&self) -> Option<&X> {
        self.as_ref()
    }

    fn get_mut(&mut self) -> Option<&mut X> {
        self.as_mut()
    }
}
