//! Build script: links the table of log texts into an image for a board, with all that is worth at least an `info`.

fn main() {
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-arg=-Tdefmt.x");
        println!("cargo:rustc-env=DEFMT_LOG=info");
    }
}
