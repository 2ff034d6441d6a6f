//! The table in the terminal: what the robot does, with the catch and without.

use crate::plant::TICK;
use crate::story::Tick;
use stiction::ContactMode;

/// Ticks of a line.
const LINE: usize = 100;

/// Prints a line for each tenth of a second of both stories.
pub(crate) fn print(caught: &[Tick], lost: &[Tick]) {
    println!("feet (front left and right, rear left and right): = sticks, ~ slips, o open");
    println!("friction: share of what the floor can give; tick: time of the controller\n");
    println!("{:92}| without the catch", "");
    println!(
        " time  {:36}feet  friction    moved       speed    tick  | feet     moved       speed",
        "what happens"
    );
    for (caught, lost) in caught.chunks(LINE).zip(lost.chunks(LINE)) {
        let (Some(tick), Some(other)) = (caught.last(), lost.last()) else { continue };
        let mut times: Vec<f32> = caught.iter().map(|tick| tick.took).collect();
        times.sort_by(f32::total_cmp);
        println!(
            "{:3.1} s  {:36}{}  {:6.0} %  {:4.1} cm  {:5.1} cm/s  {:3.1} µs  | {}  {:5.1} cm  {:5.1} cm/s",
            tick.time + TICK,
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
