//! Errors of MuJoCo end a call, and not the process.
//!
//! MuJoCo calls a handler of the thread and ends the process behind it. Here the handler unwinds, up to who has set it.

use std::cell::Cell;
use std::ffi::{CStr, c_char, c_int};

/// The first fields of an `mjLogMessage`.
#[repr(C)]
pub(super) struct LogMessage {
    level: c_int,
    _topic: c_int,
    subject: [c_char; 1024],
}

type LogHandler = unsafe extern "C-unwind" fn(*const LogMessage);
type ErrorHandler = unsafe extern "C-unwind" fn(*const c_char);

/// What sets the handlers of a thread.
pub(super) enum Handlers {
    /// From 3.10 on: one for all messages. It gets those that are no errors as well, so it needs the one of all threads.
    Log {
        set: unsafe extern "C-unwind" fn(Option<LogHandler>) -> Option<LogHandler>,
        of_all: unsafe extern "C-unwind" fn() -> Option<LogHandler>,
    },
    /// Before: one for errors.
    Error {
        get: unsafe extern "C-unwind" fn() -> Option<ErrorHandler>,
        set: unsafe extern "C-unwind" fn(Option<ErrorHandler>),
    },
}

/// What MuJoCo said as it gave up.
struct Failure(String);

thread_local! {
    /// What takes messages that are no errors.
    static OTHERS: Cell<Option<LogHandler>> = const { Cell::new(None) };
}

/// `mjLOG_ERROR`.
const ERROR: c_int = 3;

unsafe extern "C-unwind" fn raise(text: *const c_char) {
    // SAFETY: MuJoCo ends it by 0.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
    std::panic::resume_unwind(Box::new(Failure(text)));
}

unsafe extern "C-unwind" fn hear(message: *const LogMessage) {
    // SAFETY: MuJoCo's header says so.
    let LogMessage { level, subject, .. } = unsafe { &*message };
    if *level >= ERROR {
        // SAFETY: as above.
        unsafe { raise(subject.as_ptr()) };
    }
    if let Some(handler) = OTHERS.get() {
        // SAFETY: it is MuJoCo's own.
        unsafe { handler(message) };
    }
}

impl Handlers {
    /// # Safety
    /// The library is MuJoCo.
    pub(super) unsafe fn load(library: &libloading::Library) -> Result<Self, libloading::Error> {
        // SAFETY: the types are those of MuJoCo's sources; no header has these functions.
        unsafe {
            if let Ok(set) = library.get(b"_mjPRIVATE_setTlsLogHandler") {
                return Ok(Self::Log { set: *set, of_all: *library.get(b"_mjPRIVATE_getGlobalLogHandler")? });
            }
            Ok(Self::Error {
                get: *library.get(b"_mjPRIVATE__get_tls_error_fn")?,
                set: *library.get(b"_mjPRIVATE__set_tls_error_fn")?,
            })
        }
    }

    /// Runs a call. Other threads, and what this one does afterwards, have the handlers that they had.
    ///
    /// # Errors
    /// What MuJoCo said as it gave up.
    pub(super) fn watched<R>(&self, call: impl FnOnce() -> R) -> Result<R, String> {
        let call = std::panic::AssertUnwindSafe(call);
        // SAFETY: these functions have these types.
        let done = unsafe {
            match self {
                Self::Log { set, of_all } => {
                    OTHERS.set(of_all());
                    let before = set(Some(hear));
                    let done = std::panic::catch_unwind(call);
                    set(before);
                    done
                }
                Self::Error { get, set } => {
                    let before = get();
                    set(Some(raise));
                    let done = std::panic::catch_unwind(call);
                    set(before);
                    done
                }
            }
        };
        done.map_err(|panic| match panic.downcast::<Failure>() {
            Ok(failure) => failure.0,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    }
}
