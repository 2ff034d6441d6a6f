//! Room on the stack for kernels whose locals do not fit on every stack: a thread that a caller keeps.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::{Cell, RefCell};

/// The stack of a thread with room, in bytes.
pub const STACK: usize = 64 << 20;

/// Kernels of more bytes than this are made and run where there is room for any.
const LARGE: usize = 1 << 19;
/// What making, solving and differentiating take of a stack: so many times the kernel, and this.
const TIMES: usize = 6;
const BESIDE: usize = 96 << 10;

thread_local! {
    static HAS_ROOM: Cell<bool> = const { Cell::new(false) };
    /// Where this thread's stack ends; 0 if that is not known.
    static END: usize = end().unwrap_or(0);
    /// This thread's helper, and the process that has made it: a fork leaves its threads behind.
    static HELPER: RefCell<Option<(u32, ThreadPool)>> = const { RefCell::new(None) };
}

/// Says that this thread has a stack of [`STACK`] bytes.
pub fn note() {
    HAS_ROOM.set(true);
}

/// Runs work with a kernel of so many bytes where there is room: here, or on this thread's helper. (A new thread each time would take
/// longer than most solves: its stack is touched for the first time.)
pub(crate) fn with_room<R: Send>(kernel: usize, work: impl FnOnce() -> R + Send) -> R {
    if HAS_ROOM.get() || kernel <= LARGE && left() >= TIMES * kernel + BESIDE {
        return apart(work);
    }
    HELPER.with_borrow_mut(|helper| {
        let process = std::process::id();
        if let Some((_, left)) = helper.take_if(|(owner, _)| *owner != process) {
            std::mem::forget(left);
        }
        let (_, pool) = helper.get_or_insert_with(|| (process, made()));
        pool.install(|| apart(work))
    })
}

/// What is left of this thread's stack, in bytes; 0 if that is not known.
fn left() -> usize {
    let here = 0_u8;
    END.with(|&end| if end == 0 { 0 } else { (&raw const here as usize).saturating_sub(end) })
}

/// Where the stack of this thread ends, at its lowest address.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn end() -> Option<usize> {
    // SAFETY: the attributes are read once they are filled in, and given back.
    unsafe {
        let mut attributes = std::mem::zeroed::<libc::pthread_attr_t>();
        if libc::pthread_getattr_np(libc::pthread_self(), &raw mut attributes) != 0 {
            return None;
        }
        let (mut lowest, mut size, mut guard) = (std::ptr::null_mut(), 0, 0);
        let is_known =
            libc::pthread_attr_getstack(&raw const attributes, &raw mut lowest, &raw mut size) == 0;
        libc::pthread_attr_getguardsize(&raw const attributes, &raw mut guard);
        libc::pthread_attr_destroy(&raw mut attributes);
        is_known.then_some(lowest as usize + guard)
    }
}

/// Where the stack of this thread ends, at its lowest address.
#[cfg(target_os = "macos")]
#[allow(unsafe_code)]
fn end() -> Option<usize> {
    // SAFETY: both ask about the thread that calls.
    unsafe {
        let own = libc::pthread_self();
        (libc::pthread_get_stackaddr_np(own) as usize).checked_sub(libc::pthread_get_stacksize_np(own))
    }
}

/// Elsewhere nobody knows.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn end() -> Option<usize> {
    None
}

/// Runs work in a frame of its own, so that its locals are not those of who sends it elsewhere.
#[inline(never)]
fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// A thread with room.
fn made() -> ThreadPool {
    let builder = ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).start_handler(|_| note());
    match builder.build() {
        Ok(pool) => pool,
        Err(error) => panic!("no thread for a large kernel: {error}"),
    }
}
