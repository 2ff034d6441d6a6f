//! The memory of the board that belongs to the target, where the linker finds it.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let target = env::var("TARGET").expect("cargo sets it");
    let board = if target.starts_with("thumbv8m.main") {
        "rp2350.x"
    } else {
        "stm32f4.x"
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::copy(board, out.join("memory.x")).expect("the folder can be written");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed={board}");
}
