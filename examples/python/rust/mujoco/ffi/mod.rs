//! MuJoCo's library, models and data: the one place that reads memory of C.
//!
//! Python hands over addresses of `mjModel` and `mjData`, which it keeps alive; a table says where each version has its fields.
#![allow(unsafe_code)]

mod data;
mod failure;
mod layout;
mod model;

pub(super) use data::{ContactRef, Data, OwnedContact};
use failure::Handlers;
pub(super) use layout::{BALL, BODY, BOX, CONNECT, EULER, FREE, HFIELD, MESH, PLANE, SITE, SLIDE, WELD};
use layout::{DENSE, ELLIPTIC, IMPLICITFAST, LAYOUTS, Layout};
pub(super) use model::Model;
use std::ffi::{CStr, c_char, c_int};
use std::path::Path;
use std::sync::Arc;

type Address = *mut u8;

macro_rules! functions {
    ($($name:ident as $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library.
        struct Functions {
            $($name: unsafe extern "C-unwind" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// The library is MuJoCo.
            unsafe fn load(library: &libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of MuJoCo's header.
                unsafe { Ok(Self { $($name: *library.get($symbol)?,)* }) }
            }
        }
    };
}

functions! {
    step1 as b"mj_step1": fn(Address, Address);
    actuation as b"mj_fwdActuation": fn(Address, Address);
    acceleration as b"mj_fwdAcceleration": fn(Address, Address);
    kinematics as b"mj_kinematics": fn(Address, Address);
    com_pos as b"mj_comPos": fn(Address, Address);
    collision as b"mj_collision": fn(Address, Address);
    make_constraint as b"mj_makeConstraint": fn(Address, Address);
    check_acceleration as b"mj_checkAcc": fn(Address, Address);
    sensor_acc as b"mj_sensorAcc": fn(Address, Address);
    transmission as b"mj_transmission": fn(Address, Address);
    euler as b"mj_Euler": fn(Address, Address);
    smooth_velocity as b"mjd_smooth_vel": fn(Address, Address, c_int);
    full_mass as b"mj_fullM": fn(Address, Address, Address);
    jacobian as b"mj_jac": fn(Address, Address, *mut f64, *mut f64, *const f64, c_int);
    add_contact as b"mj_addContact": fn(Address, Address, Address) -> c_int;
    differentiate as b"mj_differentiatePos": fn(Address, *mut f64, f64, *const f64, *const f64);
    integrate as b"mj_integratePos": fn(Address, *mut f64, *const f64, f64);
    make_data as b"mj_makeData": fn(Address) -> Address;
    copy_data as b"mj_copyData": fn(Address, Address, Address) -> Address;
    delete_data as b"mj_deleteData": fn(Address);
    reset_data as b"mj_resetData": fn(Address, Address);
    set_state as b"mj_setState": fn(Address, Address, *const f64, c_int);
    get_state as b"mj_getState": fn(Address, Address, *mut f64, c_int);
}

/// The loaded library.
pub(super) struct Library {
    functions: Functions,
    handlers: Handlers,
    layout: &'static Layout,
    version: c_int,
    /// Keeps the functions where they are.
    _open: libloading::Library,
}

impl Library {
    /// Opens the library that Python has loaded.
    ///
    /// # Errors
    /// It is not there, or of a version that has no layout here.
    pub(super) fn open(path: &Path) -> Result<Arc<Self>, String> {
        // SAFETY: its initialisers have run, since Python has loaded it.
        let library = unsafe { libloading::Library::new(path) }.map_err(|error| error.to_string())?;
        // SAFETY: MuJoCo's header gives the types; the name ends by 0.
        let (version, name) = unsafe {
            let said = |error: libloading::Error| error.to_string();
            let version = library.get::<unsafe extern "C" fn() -> c_int>(b"mj_version");
            let name = library.get::<unsafe extern "C" fn() -> *const c_char>(b"mj_versionString");
            let (version, name) = (version.map_err(said)?(), name.map_err(said)?());
            (version, CStr::from_ptr(name).to_string_lossy().into_owned())
        };
        let layout = LAYOUTS.iter().find(|layout| layout.versions.contains(&version));
        let layout = layout.ok_or_else(|| {
            let versions = LAYOUTS.iter().flat_map(|layout| layout.versions);
            let known = versions.map(|&version| {
                // Up to 3.4 a number has a digit for each part.
                let unit = if version < 1_000 { 10 } else { 1_000 };
                format!("{}.{}.{}", version / unit / unit, version / unit % unit, version % unit)
            });
            let known = known.collect::<Vec<_>>().join(", ");
            format!("MuJoCo {name}: the Stepper knows {known}")
        })?;
        // SAFETY: as its path says, and of a version that has all of them.
        let functions = unsafe { Functions::load(&library) }.map_err(|error| error.to_string())?;
        // SAFETY: as above.
        let handlers = unsafe { Handlers::load(&library) }.map_err(|error| error.to_string())?;
        Ok(Arc::new(Self { functions, handlers, layout, version, _open: library }))
    }

    /// Runs what calls the library, so that an error there ends the call and not the process.
    ///
    /// # Errors
    /// What MuJoCo said.
    pub(super) fn watched<R>(&self, call: impl FnOnce() -> R) -> Result<R, String> {
        self.handlers.watched(call)
    }
}

/// A number of a struct.
///
/// # Safety
/// There is a `T` at `offset` behind `base`.
unsafe fn read<T: Copy>(base: *const u8, offset: usize) -> T {
    // SAFETY: the caller's.
    unsafe { base.add(offset).cast::<T>().read_unaligned() }
}

/// An array that a pointer of a struct leads to.
///
/// # Safety
/// The pointer at `offset` behind `base` leads to `count` of `T`, which nobody writes as long as the slice lives.
unsafe fn array<'a, T>(base: *const u8, offset: usize, count: usize) -> &'a [T] {
    if count == 0 {
        return &[];
    }
    // SAFETY: the caller's.
    unsafe { std::slice::from_raw_parts(read::<*const T>(base, offset), count) }
}
