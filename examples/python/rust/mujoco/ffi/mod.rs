//! MuJoCo's library, models and data: the one place that reads memory of C.
//!
//! Python hands over addresses of `mjModel` and `mjData`, which it keeps alive; a table says where each version has its fields.
#![allow(unsafe_code)]

mod data;
mod layout;
mod model;

pub(super) use data::{ContactRef, Data, OwnedContact};
use layout::{LAYOUTS, Layout};
pub(super) use model::Model;
use std::cell::Cell;
use std::ffi::{CStr, c_char, c_int};
use std::path::Path;
use std::sync::Arc;

/// `mjtIntegrator`, `mjtDisableBit`, `mjtGeom`, `mjtEq`, `mjtObj`: what is asked for.
pub(super) const EULER: i32 = 0;
pub(super) const IMPLICITFAST: i32 = 3;
pub(super) const DAMPER: i32 = 1 << 6;
pub(super) const EULERDAMP: i32 = 1 << 15;
const ISLAND: i32 = 1 << 18;
/// `mjCONE_ELLIPTIC`, `mjJAC_DENSE`.
const ELLIPTIC: i32 = 1;
const DENSE: i32 = 0;
pub(super) const PLANE: i32 = 0;
pub(super) const HFIELD: i32 = 1;
pub(super) const BOX: i32 = 6;
pub(super) const MESH: i32 = 7;
/// `mjtJoint`.
pub(super) const FREE: i32 = 0;
pub(super) const BALL: i32 = 1;
pub(super) const SLIDE: i32 = 2;
pub(super) const CONNECT: i32 = 0;
pub(super) const WELD: i32 = 1;
pub(super) const SITE: i32 = 7;

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
    euler as b"mj_Euler": fn(Address, Address);
    smooth_velocity as b"mjd_smooth_vel": fn(Address, Address, c_int);
    full_mass as b"mj_fullM": fn(Address, Address, *mut f64);
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
    set_log_handler as b"_mjPRIVATE_setTlsLogHandler": fn(Option<LogHandler>) -> Option<LogHandler>;
    global_log_handler as b"_mjPRIVATE_getGlobalLogHandler": fn() -> Option<LogHandler>;
}

/// The first fields of an `mjLogMessage`.
#[repr(C)]
struct LogMessage {
    level: c_int,
    _topic: c_int,
    subject: [c_char; 1024],
}

type LogHandler = unsafe extern "C-unwind" fn(*const LogMessage);

/// What MuJoCo said as it gave up.
struct Failure(String);

thread_local! {
    /// What takes messages that are no errors.
    static WARNINGS: Cell<Option<LogHandler>> = const { Cell::new(None) };
}

/// `mjLOG_ERROR`: MuJoCo ends the process behind it.
const ERROR: c_int = 3;

unsafe extern "C-unwind" fn raise(message: *const LogMessage) {
    // SAFETY: MuJoCo's header says so.
    let LogMessage { level, subject, .. } = unsafe { &*message };
    if *level >= ERROR {
        // SAFETY: MuJoCo ends it by 0.
        let text = unsafe { CStr::from_ptr(subject.as_ptr()) }.to_string_lossy().into_owned();
        std::panic::resume_unwind(Box::new(Failure(text)));
    }
    if let Some(handler) = WARNINGS.get() {
        // SAFETY: it is MuJoCo's own.
        unsafe { handler(message) };
    }
}

/// The loaded library.
pub(super) struct Library {
    functions: Functions,
    layout: &'static Layout,
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
        let layout = LAYOUTS.iter().find(|layout| layout.version == version);
        let layout = layout.ok_or_else(|| {
            let known = LAYOUTS.iter().map(|layout| {
                let of = |unit: i32| layout.version / unit % 1_000;
                format!("{}.{}.{}", of(1_000_000), of(1_000), of(1))
            });
            let known = known.collect::<Vec<_>>().join(", ");
            format!("MuJoCo {name}: the Stepper knows {known}")
        })?;
        // SAFETY: as its path says, and of a version that has all of them.
        let functions = unsafe { Functions::load(&library) }.map_err(|error| error.to_string())?;
        Ok(Arc::new(Self { functions, layout, _open: library }))
    }

    /// Runs what calls the library, so that an error there ends the call and not the process.
    ///
    /// # Errors
    /// What MuJoCo said.
    pub(super) fn watched<R>(&self, call: impl FnOnce() -> R) -> Result<R, String> {
        // SAFETY: these functions have these types.
        let before = unsafe {
            WARNINGS.set((self.functions.global_log_handler)());
            (self.functions.set_log_handler)(Some(raise))
        };
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(call));
        // SAFETY: as above.
        unsafe { (self.functions.set_log_handler)(before) };
        done.map_err(|panic| match panic.downcast::<Failure>() {
            Ok(failure) => failure.0,
            Err(panic) => std::panic::resume_unwind(panic),
        })
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
