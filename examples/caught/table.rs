//! The table in the terminal: what the robot does, with the catch and without.

use crate::story::Tick;
use stiction::ContactMode;

/// Ticks of a line.
const LINE: usize = 100;

/// Prints a line for each tenth of a second of both stories.
pub(crate) fn print(caught: &[Tick], lost: &[Tick]) {
    println!("{:50}|{:38}| without the catch", "", "");
    println!(" time  what happens                            feet | friction used   at    speed   tick");
    for (caught, lost) in caught.chunks(LINE).zip(lost.chunks(LINE)) {
        let (Some(tick), Some(other)) = (caught.last(), lost.last()) else { continue };
        let mut times: Vec<f32> = caught.iter().map(|tick| tick.took).collect();
        times.sort_by(f32::total_cmp);
        println!(
            "{:4.1} s  {:32} {}  {:6.0} % {:9.1} cm {:6.1} cm/s {:5.1} µs  |  {}  {:6.1} cm {:6.1} cm/s",
            tick.time + 1e-3,
            words(tick),
            feet(tick),
            tick.used() * 100.0,
            tick.place * 100.0,
            tick.speed * 100.0,
            times[times.len() / 2],
            feet(other),
            other.place * 100.0,
            other.speed * 100.0,
        );
    }
}

/// Says what happens in a tick.
fn words(tick: &Tick) -> &'static str {
    match (tick.push > 0.0, tick.sticks(), tick.leans) {
        (true, true, _) => "is pushed downhill, stands",
        (true, false, false) => "is pushed downhill, slips",
        (true, false, true) => "is pushed onto the ice, leans back",
        (false, false, true) => "slips on ice, leans back",
        (false, false, false) => "slips on ice, slows down",
        (false, true, _) => "stands",
    }
}

/// Draws what the feet do.
fn feet(tick: &Tick) -> String {
    let mode = |mode| match mode {
        ContactMode::Open => 'o',
        ContactMode::Stick => '=',
        ContactMode::Slip => '~',
    };
    tick.touches.iter().map(|touch| mode(touch.mode)).collect()
}
