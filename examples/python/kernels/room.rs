//! Room on the stack for kernels whose locals do not fit on every stack: a thread that a caller keeps.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::{Cell, RefCell};

/// The stack of a thread with room, in bytes.
pub const STACK: usize = 64 << 20;

thread_local! {
    static HAS_ROOM: Cell<bool> = const { Cell::new(false) };
    /// This thread's helper, and the process that has made it: a fork leaves its threads behind.
    static HELPER: RefCell<Option<(u32, ThreadPool)>> = const { RefCell::new(None) };
}

/// Says that this thread has a stack of [`STACK`] bytes.
pub fn note() {
    HAS_ROOM.set(true);
}

/// Runs work where there is room: here, or on this thread's helper. (A new thread each time would take longer than most solves: its
/// stack is touched for the first time.)
pub(crate) fn with_room<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    if HAS_ROOM.get() {
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
