//! The steps of the trot, as `examples/firmware` prints them.

use crate::core_itself::Out;
use crate::trot::Trot;
use core::fmt::Write;
use stiction::Real;

static mut SINGLE: Trot<f32> = Trot::new();
#[cfg(not(single))]
static mut DOUBLE: Trot<f64> = Trot::new();

fn run<T: Real>(name: &str, trot: &mut Trot<T>) -> bool {
    let mut ok = writeln!(Out, "{name}").is_ok();
    while trot.sense() {
        ok &= trot.solve();
        ok &= trot.report(&mut Out).is_ok() && writeln!(Out).is_ok();
    }
    ok
}

#[allow(unsafe_code)]
pub(crate) fn all() -> bool {
    // SAFETY: it is called once.
    let ok = run("f32", unsafe { &mut *&raw mut SINGLE });
    #[cfg(not(single))]
    let ok = ok & run("f64", unsafe { &mut *&raw mut DOUBLE });
    ok
}
