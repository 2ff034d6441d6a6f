//! Tells RISC-V cores with floating-point registers by the name of their target: stable Rust has no `cfg` for them.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(fsqrt)");
    let target = std::env::var("TARGET").unwrap_or_default();
    // As in "riscv32imafc-unknown-none-elf"; g is short for imafd and two more.
    let core = target.split('-').next().unwrap_or_default();
    let letters = core.strip_prefix("riscv32").or_else(|| core.strip_prefix("riscv64"));
    if letters.is_some_and(|letters| letters.contains(['f', 'd', 'g'])) {
        println!("cargo::rustc-cfg=fsqrt");
    }
}
