//! x
#[path = "../robot_firmware/dynamics.rs"]
mod dynamics;
#[path = "../robot_firmware/model.rs"]
mod model;
#[path = "../robot_firmware/spatial.rs"]
mod spatial;
mod controller;
mod plant;
mod story;

fn main() -> Result<(), stiction::Error> {
    for catches in [true, false] {
    let t = story::tell(catches)?;
    for (i, t) in t.iter().enumerate().filter(|(i, _)| i % 50 == 49) {
        let m: String = t.touches.iter().map(|t| match t.mode { stiction::ContactMode::Open => 'o', stiction::ContactMode::Stick => '=', _ => '~' }).collect();
        println!("{i} {m} {:.2} x {:.3} z {:.3} feet {:.3} {:.3} v {:.3} {} {:.1} N {:.1} {:.1}", t.used(), t.torso.x, t.torso.z, t.feet[0].x, t.feet[2].x, t.speed, t.leans, t.time, t.touches[0].force[0], t.touches[2].force[0]);
    }
    }
    Ok(())
}
