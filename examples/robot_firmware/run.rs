//! What happens to the robot: it drops, stands, is pushed, and its sensors fail or tell garbage.

use crate::controller::{Clock, Controller, Sensors};
use crate::plant::Plant;
use core::fmt::{self, Write};
use nalgebra::Vector3;
use stiction::ContactMode;

/// Ticks of the run.
const TICKS: u32 = 750;
/// Ticks between two lines of the report.
const LINE: u32 = 50;

/// Lets sensors fail in some ticks.
fn disturb(tick: u32, sensors: &mut Sensors) {
    match tick {
        // The switch of the front left foot stays open: the controller misses a foot.
        350..400 => sensors.switches[0] = false,
        // The encoder of the calf behind at the left has a loose wire.
        500..510 => sensors.angles[2][2] = f32::NAN,
        // The estimator tells garbage: numbers, but no velocity.
        570..575 => sensors.velocity.z = -1e4,
        // The encoder of the front left thigh breaks.
        650.. => sensors.angles[0][1] = f32::NAN,
        _ => {}
    }
}

/// Returns the push on the torso in a tick (N), from the right.
fn push(tick: u32) -> Vector3<f32> {
    let force = if (200..260).contains(&tick) { 30.0 } else { 0.0 };
    Vector3::new(0.0, force, 0.0)
}

/// Fingerprint (FNV-1a) of all numbers so far.
struct Print(u32);

impl Print {
    fn add(&mut self, number: f32) {
        for byte in number.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
}

/// Numbers of ticks, by what the controller did.
#[derive(Default)]
struct Counts {
    solved: u32,
    held: u32,
    stopped: u32,
}

/// Runs all ticks.
pub(crate) fn run(
    (plant, controller): (&mut Plant, &mut Controller),
    out: &mut impl Write,
    clock: &mut impl Clock,
) -> fmt::Result {
    let (mut print, mut counts) = (Print(0x811c_9dc5), Counts::default());
    for tick in 0..TICKS {
        let mut sensors = plant.sense();
        disturb(tick, &mut sensors);
        let (age, had_stopped) = (controller.age, controller.has_stopped());
        clock.wait();
        let (torques, fault) = controller.tick(&sensors, clock);

        let has_stopped = controller.has_stopped();
        *match (has_stopped, controller.age) {
            (true, _) => &mut counts.stopped,
            (_, 0) => &mut counts.solved,
            _ => &mut counts.held,
        } += 1;
        if has_stopped && !had_stopped {
            writeln!(out, "{tick:4} stops: the impulses of {age} ticks ago are too old")?;
        } else if let (Some(fault), 0) = (fault, age) {
            writeln!(out, "{tick:4} holds impulses: {fault}")?;
        } else if age > 0 && controller.age == 0 {
            writeln!(out, "{tick:4} solves again, after {age} ticks")?;
        }
        if plant.step(&torques, &push(tick)).is_err() {
            return Err(fmt::Error);
        }
        for &torque in torques.as_flattened() {
            print.add(torque);
        }
        if (tick + 1).is_multiple_of(LINE) {
            write!(out, "{tick:4} ")?;
            report(plant, controller, out)?;
            writeln!(out, "  torques so far {:08x}", print.0)?;
        }
    }
    let Counts { solved, held, stopped } = counts;
    writeln!(out, "{TICKS} ticks: {solved} solved, {held} held, {stopped} stopped")
}

/// Writes what the feet do (= sticks, ~ slips, o open, . in the air), and where the torso is.
fn report(plant: &Plant, controller: &Controller, out: &mut impl Write) -> fmt::Result {
    for key in 0..4 {
        let push = controller.held.iter().find(|push| push.key == key);
        out.write_str(match push.map(|push| push.mode) {
            None => ".",
            Some(ContactMode::Open) => "o",
            Some(ContactMode::Stick) => "=",
            Some(ContactMode::Slip) => "~",
        })?;
    }
    #[allow(clippy::cast_possible_truncation)] // millimetres
    let [x, y, z] = [plant.place.x, plant.place.y, plant.place.z].map(|place| (place * 1e3) as i32);
    write!(out, "  torso at {x:4} {y:4} {z:4} mm")
}
