//! A quadruped stands on a ramp, is pushed onto ice, slips, and is caught: `cargo run --release -p caught`.
//!
//! | file | what it does |
//! |---|---|
//! | `controller` | **what runs on a robot**: from sensors to torques, with what the kernel says of each foot |
//! | `plant` | the robot and the ramp in place of real ones, by the same kernel with half the time step |
//! | `story` | what happens, with the catch and without, and a test of it |
//! | `table`, `picture` | how it is shown |
//!
//! Kinematics and dynamics are those of `robot_firmware`, the same robot on a chip.

mod controller;
#[path = "../robot_firmware/dynamics.rs"]
mod dynamics;
#[path = "../robot_firmware/model.rs"]
mod model;
mod picture;
mod plant;
#[path = "../robot_firmware/spatial.rs"]
mod spatial;
mod story;
mod table;

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (caught, lost) = (story::tell(true)?, story::tell(false)?);
    table::print(&caught, &lost);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target");
    std::fs::create_dir_all(&folder)?;
    let path = folder.join("caught.svg");
    std::fs::write(&path, picture::draw(&caught, &lost))?;
    println!("\ndrawn in {}", path.display());
    Ok(())
}
