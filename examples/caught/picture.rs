//! The picture: the robot at four moments, feet that stick and slip over time, and the speed of the torso.

use crate::plant::{EDGE, SLOPE, TICK, friction};
use crate::story::{FORCE, PUSH, TICKS, Tick};
use nalgebra::{Rotation2, Vector2, Vector3};
use std::fmt::Write;
use stiction::ContactMode;

const STICK: &str = "#1f77b4";
const SLIP: &str = "#e66e0a";
const PUSHED: &str = "#b41e28";
const ICE: &str = "#8fd0e8";
const GROUND: &str = "#8a7f72";
const BODY: &str = "#3a3f48";
const PALE: &str = "#e4e4e0";

/// Moments that are drawn (ticks), and what happens in them.
const MOMENTS: [(usize, &str); 4] =
    [(200, "stands"), (380, "is pushed, slips"), (700, "slips on ice, leans back"), (1700, "stands again")];
/// Width and height of the picture, and width of a moment (px).
const WIDTH: f32 = 830.0;
const ALL: f32 = 396.0;
const MOMENT: f32 = WIDTH / 4.0;
/// Scale of places (px/m) and of forces (px/N).
const METRE: f32 = 245.0;
const NEWTON: f32 = 1.2;
/// Height of friction cones (px).
const CONE: f32 = 56.0;
/// Left and right end of the time axis (px).
const AXIS: [f32; 2] = [100.0, 810.0];
/// Upper edge of the rows of the feet, and height of a row (px).
const FEET: f32 = 216.0;
const ROW: f32 = 20.0;
/// Lower edge and height of the chart of speeds (px), and the speed at its upper edge (m/s).
const BOTTOM: f32 = 376.0;
const HEIGHT: f32 = 56.0;
const FAST: f32 = 0.8;

/// Picture as SVG.
struct Svg(String);

impl Svg {
    fn add(&mut self, element: &str) {
        self.0.push_str(element);
        self.0.push('\n');
    }

    fn text(&mut self, [x, y]: [f32; 2], anchor: &str, text: &str) {
        self.add(&format!("<text x='{x:.1}' y='{y:.1}' text-anchor='{anchor}'>{text}</text>"));
    }

    fn area(&mut self, [x, y]: [f32; 2], [width, height]: [f32; 2], colour: &str) {
        self.add(&format!(
            "<rect x='{x:.1}' y='{y:.1}' width='{width:.1}' height='{height:.1}' fill='{colour}'/>"
        ));
    }

    /// Draws a line through points; `style` are attributes.
    fn line(&mut self, points: impl IntoIterator<Item = Vector2<f32>>, style: &str) {
        let mut list = String::new();
        for point in points {
            let _ = write!(list, "{:.1},{:.1} ", point.x, point.y); // a string takes all
        }
        self.add(&format!("<polyline points='{}' fill='none' {style}/>", list.trim_end()));
    }
}

/// Draws both stories.
pub(crate) fn draw(caught: &[Tick], lost: &[Tick]) -> String {
    let mut svg = Svg(String::new());
    let size = format!("width='{WIDTH}' height='{ALL}' viewBox='0 0 {WIDTH} {ALL}'");
    let font = "font-family='sans-serif' font-size='14'";
    svg.add(&format!("<svg xmlns='http://www.w3.org/2000/svg' {size} {font}>"));
    svg.area([0.0, 0.0], [WIDTH, ALL], "white");
    for (index, (tick, words)) in (0_u16..).zip(MOMENTS) {
        moment(&mut svg, f32::from(index) * MOMENT, &caught[tick], words);
    }
    legend(&mut svg);
    let push = [PUSH.start, PUSH.end].map(|tick| across(f32::from(tick) * TICK));
    svg.area([push[0], FEET - 18.0], [push[1] - push[0], BOTTOM - FEET + 18.0], "#f7dede");
    svg.text([f32::midpoint(push[0], push[1]), FEET - 4.0], "middle", &format!("push, {FORCE} N"));
    let names = ["front left", "front right", "rear left", "rear right"];
    for (foot, name) in (0..).zip(names) {
        row(&mut svg, foot, name, caught);
    }
    speeds(&mut svg, caught, lost);
    svg.add("</svg>");
    svg.0
}

/// Draws what the colours mean.
fn legend(svg: &mut Svg) {
    let (mut x, y) = (16.0, FEET - 30.0);
    let entries = [
        (STICK, "foot sticks", 104.0),
        (SLIP, "slips", 70.0),
        (GROUND, "rough floor", 110.0),
        (ICE, "ice", 56.0),
        (PALE, "friction cone: a foot with its force on the edge slips", 0.0),
    ];
    for (colour, words, width) in entries {
        svg.area([x, y - 11.0], [12.0, 12.0], colour);
        svg.text([x + 18.0, y], "start", words);
        x += width;
    }
}

/// Draws the robot in a tick as it is seen from the right, and the forces on its feet in their friction cones.
fn moment(svg: &mut Svg, left: f32, tick: &Tick, words: &str) {
    let ramp = Rotation2::new(SLOPE);
    let on_page = |x: f32, z: f32| Vector2::new(left + 68.0, 116.0) + ramp * Vector2::new(x, -z) * METRE;
    let place = |place: &Vector3<f32>| on_page(place.x, place.z);
    svg.text([left + MOMENT / 2.0, 16.0], "middle", &format!("{:.1} s: {words}", tick.time));
    let floor = |svg: &mut Svg, from, to, colour| {
        svg.line(
            [on_page(from, -0.012), on_page(to, -0.012)],
            &format!("stroke='{colour}' stroke-width='5'"),
        );
    };
    floor(svg, -0.27, EDGE, GROUND);
    floor(svg, EDGE, 0.57, ICE);
    for pair in [0, 2] {
        let foot = &tick.legs[pair][2];
        let tip = |mu: f32| place(foot) + ramp * Vector2::new(mu, -1.0) * CONE;
        let mu = friction(foot);
        let cone = [tip(-mu), place(foot), tip(mu)];
        svg.line(cone, &format!("stroke='{PALE}' stroke-width='1' style='fill:{PALE}'"));
    }
    let hinges = [0, 2].map(|leg| place(&tick.legs[leg][0]));
    svg.line(hinges, &format!("stroke='{BODY}' stroke-width='16' stroke-linecap='round'"));
    for (leg, touch) in tick.legs.iter().zip(&tick.touches) {
        svg.line(leg.iter().map(place), &format!("stroke='{BODY}' stroke-width='4' stroke-linejoin='round'"));
        let (foot, colour) = (place(&leg[2]), colour(touch.mode));
        svg.add(&format!("<circle cx='{:.1}' cy='{:.1}' r='5' fill='{colour}'/>", foot.x, foot.y));
    }
    for pair in [0, 2] {
        let [[up, ahead, _]] = (tick.touches[pair].force + tick.touches[pair + 1].force).data.0;
        let force = ramp * Vector2::new(ahead, -up) * NEWTON;
        arrow(svg, place(&tick.legs[pair][2]), force, colour(tick.touches[pair].mode));
    }
    let push = ramp * Vector2::new(tick.push, 0.0) * NEWTON;
    arrow(svg, hinges[1] - push - ramp * Vector2::new(12.0, 0.0), push, PUSHED);
}

/// Draws an arrow, unless it is shorter than 3 px.
fn arrow(svg: &mut Svg, from: Vector2<f32>, arrow: Vector2<f32>, colour: &str) {
    if arrow.norm() < 3.0 {
        return;
    }
    let (to, back) = (from + arrow, arrow.normalize() * 8.0);
    let side = Vector2::new(-back.y, back.x) * 0.5;
    svg.line([from, to - back], &format!("stroke='{colour}' stroke-width='3'"));
    svg.line([to - back + side, to, to - back - side], &format!("style='fill:{colour}'"));
}

fn ground(mu: f32) -> &'static str {
    if mu < 0.3 { ICE } else { GROUND }
}

fn colour(mode: ContactMode) -> &'static str {
    match mode {
        ContactMode::Open => PALE,
        ContactMode::Stick => STICK,
        ContactMode::Slip => SLIP,
    }
}

/// Returns the place of a time (s) on the axis.
fn across(time: f32) -> f32 {
    AXIS[0] + (AXIS[1] - AXIS[0]) * time / (f32::from(TICKS) * TICK)
}

/// Draws what a foot does over time, and below it where it is on the ice.
fn row(svg: &mut Svg, foot: u16, name: &str, ticks: &[Tick]) {
    let top = FEET + f32::from(foot) * ROW;
    let foot = usize::from(foot);
    svg.text([AXIS[0] - 8.0, top + 12.0], "end", name);
    let mut bars = |top, height, colour: &dyn Fn(&Tick) -> &'static str| {
        for run in ticks.chunk_by(|a, b| colour(a) == colour(b)) {
            let [from, to] = [run[0].time, run[run.len() - 1].time + TICK].map(across);
            svg.area([from, top], [to - from, height], colour(&run[0]));
        }
    };
    bars(top, 12.0, &|tick| colour(tick.touches[foot].mode));
    bars(top + 12.0, 3.0, &|tick| ground(friction(&tick.legs[foot][2])));
}

/// Draws the speed of the torso over time.
fn speeds(svg: &mut Svg, caught: &[Tick], lost: &[Tick]) {
    let at = |time, speed| Vector2::new(across(time), BOTTOM - HEIGHT * speed / FAST);
    for step in 0_u16..=2 {
        let speed = f32::from(step) * 0.4;
        let line = AXIS.map(|x| Vector2::new(x, at(0.0, speed).y));
        svg.line(line, &format!("stroke='{PALE}' stroke-width='1'"));
        svg.text([AXIS[0] - 8.0, line[0].y + 5.0], "end", &format!("{speed:.1}"));
    }
    for step in 0_u16..=6 {
        let time = f32::from(step) * 0.3;
        svg.text([across(time), BOTTOM + 16.0], "middle", &format!("{time:.1} s"));
    }
    svg.text([AXIS[0], BOTTOM - HEIGHT - 6.0], "start", "speed of the torso (m/s)");
    svg.text([at(0.95, 0.0).x, at(0.0, 0.5).y], "end", "without the catch");
    svg.text([at(1.15, 0.0).x, at(0.0, 0.15).y], "start", "caught");
    let points = |ticks: &[Tick]| -> Vec<_> {
        let shown = ticks.iter().step_by(5).take_while(|tick| tick.speed < FAST);
        shown.map(|tick| at(tick.time, tick.speed)).collect()
    };
    svg.line(points(lost), &format!("stroke='{BODY}' stroke-width='2' stroke-dasharray='6 4'"));
    svg.line(points(caught), &format!("stroke='{BODY}' stroke-width='2.5'"));
}
