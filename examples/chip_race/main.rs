//! A contestant of the race on the chip, on an emulated Cortex-M4F: this crate, or a loop written by hand.
//!
//! `.ci/chip_race` builds it for each contestant and scene (`--cfg contestant="gauss_seidel"`, `--cfg scene="box"`) and runs it. A line is
//! a label, instructions and impulses as bits of `f32`, and stands for one call of `measured`: `examples/cycles` counts on that. What is
//! printed as `bytes` is no call.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("races on an emulated board: run .ci/chip_race");
}

#[cfg(all(target_os = "none", contestant = "admm_by_hand"))]
mod admm_by_hand;
#[cfg(target_os = "none")]
#[path = "../embedded/board.rs"]
mod board;
#[cfg(all(target_os = "none", contestant = "gauss_seidel"))]
mod by_hand;
#[cfg(target_os = "none")]
#[path = "../embedded/counter.rs"]
mod counter;
#[cfg(all(target_os = "none", contestant = "gauss_seidel"))]
#[path = "../embedded/gauss_seidel.rs"]
mod gauss_seidel;
#[cfg(target_os = "none")]
#[path = "../embedded/records.rs"]
mod records;
#[cfg(target_os = "none")]
#[path = "../embedded/stack.rs"]
mod stack;
#[cfg(all(target_os = "none", any(contestant = "stiction", contestant = "admm")))]
mod this_crate;

#[cfg(target_os = "none")]
mod race {
    use crate::board::exit;
    use crate::counter::Counter;
    use crate::records::{Records, Step};
    use core::hint::black_box;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::{hprint, hprintln};
    use nalgebra::SVector;

    #[cfg(contestant = "admm_by_hand")]
    use crate::admm_by_hand::race as contest;
    #[cfg(contestant = "gauss_seidel")]
    use crate::by_hand::race as contest;
    #[cfg(contestant = "empty")]
    use crate::stack::stack_bytes;
    #[cfg(any(contestant = "stiction", contestant = "admm"))]
    use crate::this_crate::race as contest;
    /// What the images of the others are compared with: reads the scene and prints.
    #[cfg(contestant = "empty")]
    fn contest(Course { step, push, before, counter }: Course<'_>) -> Option<()> {
        let stack = stack_bytes(|| _ = black_box((&step.scene, push, before)));
        cortex_m_semihosting::hprintln!("bytes stack {}", stack);
        run(counter, "nothing", stack, |_| ())?;
        run(counter, "nothing", "at all", |_| ())
    }

    /// Velocities of the scene.
    pub(crate) const N: usize = if cfg!(scene = "quadruped") { 18 } else { 6 };
    /// Contacts.
    pub(crate) const C: usize = if cfg!(scene = "hand_9") {
        9
    } else if cfg!(scene = "hand_6") {
        6
    } else {
        4
    };
    /// Compliance that makes forces unique, of the scenes that share them out; those have the convex model.
    pub(crate) const SHARING: Option<f32> = if cfg!(any(scene = "hand_6", scene = "hand_9")) {
        Some(1e-2)
    } else if cfg!(any(scene = "sharing", scene = "sharing_slip")) {
        Some(1e-3)
    } else {
        None
    };

    /// What a contestant is given.
    pub(crate) struct Course<'a> {
        pub(crate) step: &'a mut Step<f32, N, 3, C>,
        pub(crate) push: &'a Push,
        /// The push of the tick before.
        pub(crate) before: &'a Push,
        pub(crate) counter: &'a mut Counter,
    }

    /// A free impulse, N s.
    pub(crate) type Push = SVector<f32, N>;
    /// Impulses by contact, normal first, N s.
    pub(crate) type Impulses = [SVector<f32, 3>; C];

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        hprintln!("{}", info);
        exit(false)
    }

    /// Calls `f`: what is measured stands between entry and return, also in a trace.
    #[inline(never)]
    fn measured(f: &mut dyn FnMut()) {
        black_box(f)();
    }

    /// Prints what one call of `f` takes, and the impulses that it leaves.
    pub(crate) fn run(
        counter: &mut Counter,
        label: &str,
        setting: impl core::fmt::Display,
        mut f: impl FnMut(&mut Impulses),
    ) -> Option<()> {
        let mut impulses = [SVector::zeros(); C];
        let instructions = counter.count(|| measured(&mut || f(&mut impulses)))?;
        hprint!("{} {} {}", label, setting, instructions);
        for number in impulses.iter().flatten() {
            hprint!(" {:08x}", number.to_bits());
        }
        hprintln!();
        Some(())
    }

    #[cfg(scene = "quadruped")]
    const RECORDS: &[u8] = include_bytes!("../measure/quadruped.bin");
    #[cfg(scene = "hand_6")]
    const RECORDS: &[u8] = include_bytes!("hand_6.bin");
    #[cfg(scene = "hand_9")]
    const RECORDS: &[u8] = include_bytes!("hand_9.bin");
    #[cfg(scene = "sharing")]
    const RECORDS: &[u8] = include_bytes!("sharing.bin");
    #[cfg(scene = "sharing_slip")]
    const RECORDS: &[u8] = include_bytes!("sharing_slip.bin");
    #[cfg(scene = "box")]
    const RECORDS: &[u8] = include_bytes!("../measure/box.bin");

    #[entry]
    fn main() -> ! {
        static mut STEP: Step<f32, N, 3, C> = Step::new();
        let Some(peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        let mut counter = Counter::start(peripherals);
        let read = STEP.read(&mut Records::new(RECORDS));
        let push = STEP.push;
        // The tick before: a force turned by 0.01 rad, or all of it 1 % smaller.
        let mut before = push;
        if SHARING.is_some() {
            before[0] += 0.01 * push[1];
            before[1] -= 0.01 * push[0];
        } else {
            before *= 0.99;
        }
        let course = Course { step: STEP, push: &push, before: &before, counter: &mut counter };
        let done = read.and_then(|()| contest(course));
        exit(done.is_some())
    }
}
