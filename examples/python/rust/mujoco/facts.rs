//! What of a model stays the same as it is stepped, and its own units of speed and length.

use super::end::Moved;
use super::ffi::{BALL, BODY, BOX, FREE, HFIELD, MESH, Model, PLANE, SLIDE};
use nalgebra::{Matrix3, Vector3};

/// Kinds of geoms that have corners, or are flat.
const CORNERED: [i32; 4] = [PLANE, HFIELD, BOX, MESH];

/// Where things are fixed to, and how thick they are.
pub(super) struct Facts {
    /// The body of motion capture that a body is fixed to.
    mocap: Vec<Option<usize>>,
    /// Half of the thickness of a geom that can be passed through (m); infinite of a plane, a height field and what touches nothing.
    thickness: Vec<f64>,
    thinnest: f64,
    /// May a geom move?
    moves: Vec<bool>,
    has_corners: Vec<bool>,
    /// Is a velocity one of turning?
    pub(super) turns: Vec<bool>,
    pub(super) height_fields: bool,
    /// Are there actuators that pull at what their body touches?
    pub(super) has_suction: bool,
}

impl Facts {
    pub(super) fn new(model: &Model) -> Self {
        let bodies = 0..model.sizes.bodies;
        let mocap = bodies.map(|body| {
            let mut body = body;
            while body > 0 && model.body_mocapid()[body] < 0 {
                body = model.body_parentid()[body].unsigned_abs() as usize;
            }
            usize::try_from(model.body_mocapid()[body]).ok().filter(|_| body > 0)
        });
        let is = |geom: usize, kind: i32| model.geom_type()[geom] == kind;
        let thickness = |geom: usize| {
            let half = &model.geom_aabb()[6 * geom + 3..][..3];
            let touches = model.geom_contype()[geom] != 0 || model.geom_conaffinity()[geom] != 0;
            let is_solid = touches && !is(geom, PLANE) && !is(geom, HFIELD);
            if is_solid { half.iter().copied().fold(f64::INFINITY, f64::min) } else { f64::INFINITY }
        };
        let geoms = 0..model.sizes.geoms;
        let thickness: Vec<_> = geoms.clone().map(thickness).collect();
        let body = |geom: usize| model.geom_bodyid()[geom].unsigned_abs() as usize;
        Self {
            mocap: mocap.collect(),
            thinnest: thickness.iter().copied().fold(f64::INFINITY, f64::min),
            moves: geoms
                .clone()
                .map(|geom| model.body_weldid()[body(geom)] > 0 && thickness[geom].is_finite())
                .collect(),
            thickness,
            has_corners: model.geom_type().iter().map(|kind| CORNERED.contains(kind)).collect(),
            turns: turns(model),
            height_fields: geoms.clone().any(|geom| is(geom, HFIELD)),
            has_suction: model.actuator_trntype().contains(&BODY),
        }
    }

    /// Does a geom touch with its corners and edges, or is it flat?
    pub(super) fn has_corners(&self, geom: usize) -> bool {
        self.has_corners[geom]
    }

    /// May it move?
    pub(super) fn moves(&self, geom: usize) -> bool {
        self.moves[geom]
    }

    pub(super) fn mocap(&self, body: usize) -> Option<usize> {
        self.mocap[body]
    }

    /// At how many poses of a step contacts are looked for, if geoms move by so much: one at the end, more if something moves by
    /// more than its thickness and that of the thinnest geom, or two move so against each other, and more still if what has corners turns
    /// on that way. And whether these are not enough.
    pub(super) fn poses(&self, moved: &[Moved]) -> (u32, bool) {
        let all = || moved.iter().zip(&self.thickness).zip(&self.has_corners).zip(&self.moves);
        let geoms = || all().filter(|&(_, &moves)| moves).map(|(geom, _)| geom);
        let of = |by: f64, thickness: f64| by / (thickness + self.thinnest);
        let own = |((moved, &thickness), &has_corners): ((&Moved, &f64), &bool)| {
            let far = of(moved.most, thickness);
            if far > 1.0 && has_corners { far.max(moved.turned / TURN) } else { far }
        };
        let alone = geoms().map(own).fold(1.0, f64::max);
        let pairs = geoms().enumerate().flat_map(|(i, ((one, &thin), _))| {
            let others = geoms().take(i);
            others.map(move |((other, &thick), _)| (one.most + other.most) / (thin + thick))
        });
        let farthest = geoms().fold(0.0, |most, ((moved, _), _)| f64::max(most, moved.most));
        let most = if of(2.0 * farthest, self.thinnest) > 1.0 { pairs.fold(alone, f64::max) } else { alone };
        let enough = (1..=MOST_FAR).find(|&poses| f64::from(poses) >= most);
        (enough.unwrap_or(MOST_FAR), enough.is_none())
    }
}

/// What has corners and moves far turns by no more than this between two poses; what is round and turns by more in a step rolls (1).
pub(super) const TURN: f64 = 0.07;
/// The most poses of a step that contacts are looked for at as far as things move; what needs more is counted.
const MOST_FAR: u32 = 256;
/// And as deep as things have entered.
pub(super) const MOST_POSES: u32 = 16;

/// Which velocities are those of turning.
fn turns(model: &Model) -> Vec<bool> {
    let mut turns = Vec::new();
    for &kind in model.jnt_type() {
        match kind {
            FREE => turns.extend([false, false, false, true, true, true]),
            BALL => turns.extend([true; 3]),
            _ => turns.push(kind != SLIDE),
        }
    }
    turns
}

/// A contact is closed up to this gap, and overlaps from this depth on, over the model's own length: more than residuals of solves add up to
/// in a minute.
pub(super) const CLOSED: f64 = 1e-7;

/// How fast a length of the model falls from itself (m/s): `sqrt(g L)`.
pub(super) fn speed_scale(model: &Model) -> f64 {
    let gravity = Vector3::from(model.gravity()).norm();
    let gravity = if gravity > 0.0 { gravity } else { 9.81 };
    (gravity * model.size()).sqrt()
}

/// How much a free point of a body is moved by an impulse (1/kg).
pub(super) fn mobility(model: &Model, body: usize) -> f64 {
    model.body_invweight0()[2 * body]
}

/// Does an impulse along a row of this response move it, beside a free point of this mobility? If not, what it has of entries is
/// rounding, as out of the plane of a planar linkage, or nothing moves that way, as of an arm that is stretched.
pub(super) fn has_lever(response: f64, mobility: f64) -> bool {
    response >= NO_LEVER * mobility
}

/// Square of the least lever, over that of a free point.
const NO_LEVER: f64 = 1e-6;

/// The body of a geom.
pub(super) fn body_of(model: &Model, geom: usize) -> usize {
    model.geom_bodyid()[geom].unsigned_abs() as usize
}

/// Is a contact the side of a prism below a height field? Its normal is flatter than the surface around it.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // numbers of cells
pub(super) fn is_side_of_prism(
    model: &Model,
    geom: usize,
    [position, place]: [[f64; 3]; 2],
    rotation: [f64; 9],
    outward: Vector3<f64>,
) -> bool {
    if model.geom_type()[geom] != HFIELD {
        return false;
    }
    let frame = Matrix3::from_row_slice(&rotation).transpose();
    let place = frame * (Vector3::from(place) - Vector3::from(position));
    let field = model.geom_dataid()[geom].unsigned_abs() as usize;
    let ([x, y, top, _], heights, [rows, columns]) = model.height_field(field);
    // Cells around, along one axis: first and behind the last.
    let around = |place: f64, half: f64, count: usize| {
        let cell = f64::midpoint(place / half, 1.0) * (count - 1) as f64;
        let cell = cell.clamp(0.0, (count - 1) as f64) as usize;
        (cell.saturating_sub(1), (cell + 3).min(count))
    };
    let (left, right) = around(place.x, x, columns);
    let (front, back) = around(place.y, y, rows);
    let height = |row: usize, column: usize| f64::from(heights[row * columns + column]) * top;
    let [mut along, mut across] = [0.0_f64; 2];
    for row in front..back {
        for column in left..right {
            if column + 1 < right {
                along = along.max((height(row, column + 1) - height(row, column)).abs());
            }
            if row + 1 < back {
                across = across.max((height(row + 1, column) - height(row, column)).abs());
            }
        }
    }
    let slope = [along * (columns - 1) as f64 / (2.0 * x), across * (rows - 1) as f64 / (2.0 * y)];
    (frame * outward).z < 0.98 / (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt()
}
