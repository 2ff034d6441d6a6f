//! The square root of an `f32`, by the instruction of an Arm or RISC-V core that has one.
//!
//! Stable Rust has no such root without `std`, and `libm` computes it in 51 instructions. The result is the correctly rounded one
//! (IEEE 754) either way: the same bits.
#![no_std]

/// The square root of `x`, correctly rounded: `vsqrt.f32` on Arm targets with floating-point registers (`eabihf`), `fsqrt.s` on RISC-V
/// targets with them (an `f`, `d` or `g` in the name, as in `riscv32imafc`), `libm` elsewhere.
#[inline]
#[must_use]
#[allow(unsafe_code)]
pub fn sqrtf(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    return vsqrt(x);
    #[cfg(fsqrt)]
    return fsqrt(x);
    #[cfg(not(any(fsqrt, all(target_arch = "arm", target_abi = "eabihf"))))]
    libm::sqrtf(x)
}

/// The instruction. The C interface of `eabihf` passes the number, and the root, in the register `s0`.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[unsafe(naked)]
#[allow(unsafe_code)]
extern "C" fn vsqrt(x: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}

/// The instruction, rounded to the nearest whatever the mode of the core.
#[cfg(fsqrt)]
#[inline]
#[allow(unsafe_code)]
fn fsqrt(x: f32) -> f32 {
    let root;
    // SAFETY: it reads a register, writes one, and raises flags of exceptions, which an `asm!` may do.
    unsafe {
        core::arch::asm!("fsqrt.s {root}, {x}, rne", root = lateout(freg) root, x = in(freg) x, options(pure, nomem, nostack));
    }
    root
}
