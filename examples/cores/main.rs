//! A recorded trot on a bare core of any family under QEMU, with the bits of the host; or what a quadruped's solver takes of flash.
//!
//! `.ci/cores` builds and runs it. `--cfg whole` and `--cfg sweeps` are images with a solver of all phases and of sweeps alone, `--cfg empty` is
//! one without.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("runs on an emulated core: .ci/cores");
}

#[cfg(target_os = "none")]
#[cfg_attr(any(whole, sweeps, empty), allow(dead_code))] // those write nothing
mod core_itself;
#[cfg(all(target_os = "none", any(whole, sweeps)))]
mod quadruped;
#[cfg(all(target_os = "none", not(any(whole, sweeps, empty))))]
#[path = "../embedded/records.rs"]
mod records;
#[cfg(all(target_os = "none", not(any(whole, sweeps, empty))))]
mod steps;
#[cfg(all(target_os = "none", not(any(whole, sweeps, empty))))]
#[path = "../firmware/trot.rs"]
mod trot;

/// What a start-up calls.
#[cfg(target_os = "none")]
fn run() -> bool {
    #[cfg(any(whole, sweeps))]
    return quadruped::solve();
    #[cfg(empty)]
    return true;
    #[cfg(not(any(whole, sweeps, empty)))]
    steps::all()
}
