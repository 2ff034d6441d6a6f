//! The square root of an `f32`, by the instruction of an Arm core that has one.
//!
//! Stable Rust has no such root without `std`, and `libm` computes it in 51 instructions. The result is the correctly rounded one
//! (IEEE 754) either way: the same bits.
#![no_std]

/// The square root of `x`, correctly rounded: `vsqrt.f32` on Arm targets with floating-point registers (`eabihf`), `libm` elsewhere.
#[inline]
#[must_use]
#[allow(unsafe_code)]
pub fn sqrtf(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    return vsqrt(x);
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(x)
}

/// The instruction. The C interface of `eabihf` passes the number, and the root, in the register `s0`.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[unsafe(naked)]
#[allow(unsafe_code)]
extern "C" fn vsqrt(x: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
