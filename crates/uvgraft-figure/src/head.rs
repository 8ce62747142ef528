//! The head's skin: a grid around the head, with edge loops set into it around eyes and mouth.
//!
//! Columns go around the neck and rows from the crown to the base of the neck, both denser on the
//! face. Around each eye and the mouth a block of cells is replaced by rings that end on the lids
//! and lips, so that these are clean edges that can open.
//!
//! A corner's chart parameters are `[s, t]`: `s` in `-1.0..=1.0` around the head, with 0 in front
//! and the seam at the back; `t` in `0.0..=1.0` from crown to neck.

use std::f32::consts::PI;

use glam::{Vec3, vec3};
use uvgraft::easing::{mix, smoothstep};

use super::head_shape::{
    EYE, EYE_RADIUS, LID_RADIUS, LID_WIDTH, LIP_WIDTH, lip_bottom, lip_line, lip_top, lower_lid,
    neck_axis, skin as solid, upper_lid,
};
use super::sdf::{leave, meet};
use super::surface::{BodyPart, Knot, PartKind, Side, Surface};

pub(crate) const COLUMNS: usize = 72;
/// Rows down to below the chin; the remaining ones are on the neck.
const JAW_ROWS: usize = 50;
const ROWS: usize = 56;
/// High enough that rays leave through the underside of the nose.
const CENTRE: Vec3 = vec3(0.0, 3.5, -1.0);
const REACH: f32 = 24.0;
const FACE: BodyPart = BodyPart { kind: PartKind::Face, side: Side::Both };

/// Cells `columns.0..columns.1` and `rows.0..rows.1` of the grid, which rings replace.
#[derive(Clone, Copy)]
struct Block {
    columns: (usize, usize),
    rows: (usize, usize),
}

const LEFT_EYE: Block = Block { columns: (39, 50), rows: (15, 27) };
const RIGHT_EYE: Block = Block { columns: (22, 33), rows: (15, 27) };
const MOUTH: Block = Block { columns: (26, 46), rows: (32, 40) };

impl Block {
    fn has_cell(&self, column: usize, row: usize) -> bool {
        (self.columns.0..self.columns.1).contains(&column)
            && (self.rows.0..self.rows.1).contains(&row)
    }

    /// Grid points on the boundary, counterclockwise seen from outside.
    fn rim(&self) -> Vec<(usize, usize)> {
        let ((left, right), (top, bottom)) = (self.columns, self.rows);
        (top..bottom)
            .map(|row| (left, row))
            .chain((left..right).map(|column| (column, bottom)))
            .chain((top + 1..=bottom).rev().map(|row| (right, row)))
            .chain((left + 1..=right).rev().map(|column| (column, top)))
            .collect()
    }
}

/// The skin of the head, in head space.
pub(crate) struct HeadSkin {
    pub surface: Surface,
    /// The vertices of the boundary at the base of the neck, by column.
    pub rim: Vec<u32>,
    /// Vertices inside the outline of the lips and in the mouth, with their coordinate along the
    /// lips: 0 in the corners, 1 at the centre of the lower lip and -1 at that of the upper one.
    /// Closed lips coincide, so positions do not tell them apart.
    pub lips: Vec<(u32, f32)>,
}

pub(crate) fn skin() -> HeadSkin {
    let grid = Grid::new();
    let mut surface = Surface::default();
    let mut vertices = vec![[u32::MAX; COLUMNS]; ROWS + 1];
    let mut knot = |surface: &mut Surface, column: usize, row: usize| {
        let slot = &mut vertices[row][if row == 0 { 0 } else { column % COLUMNS }];
        if *slot == u32::MAX {
            *slot = surface.vertex(grid.positions[row][column % COLUMNS]);
        }
        Knot { vertex: *slot, at: Grid::at(column, row) }
    };
    let blocks = [LEFT_EYE, RIGHT_EYE, MOUTH];
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            if blocks.iter().any(|block| block.has_cell(column, row)) {
                continue;
            }
            let (left, right) = (column, column + 1);
            let bottom = [knot(&mut surface, left, row + 1), knot(&mut surface, right, row + 1)];
            if row == 0 {
                let crown = knot(&mut surface, column, 0);
                surface.cap_above(FACE, crown, &bottom);
            } else {
                let top = [knot(&mut surface, left, row), knot(&mut surface, right, row)];
                surface.strip(FACE, &top, &bottom);
            }
        }
    }
    let mut set = |surface: &mut Surface, block: Block, rings: Rings| {
        let rim: Vec<Knot> =
            block.rim().into_iter().map(|(column, row)| knot(surface, column, row)).collect();
        set_rings(surface, &rim, rings)
    };
    set(&mut surface, LEFT_EYE, eye_rings);
    set(&mut surface, RIGHT_EYE, eye_rings);
    let mouth = set(&mut surface, MOUTH, mouth_rings);
    let lips = close_mouth(&mut surface, &mouth);
    let rim = (0..COLUMNS).map(|column| knot(&mut surface, column, ROWS).vertex).collect();
    HeadSkin { surface, rim, lips }
}

/// Closes the mouth at the back with quads from its roof to its floor; returns [`HeadSkin::lips`].
fn close_mouth(surface: &mut Surface, rings: &[Vec<Knot>]) -> Vec<(u32, f32)> {
    let around = rings[0].len();
    // Rings begin at the upper left corner of the block and run down; the corners of the mouth are
    // at the centres of its sides.
    let corner = (MOUTH.rows.1 - MOUTH.rows.0) / 2;
    let floor = |step: usize| corner + step;
    let roof = |step: usize| (corner + around - step) % around;
    if let Some(last) = rings.last() {
        for step in 0..around / 2 {
            let quad = [floor(step), floor(step + 1), roof(step + 1), roof(step)];
            let mut knots: Vec<Knot> = quad.into_iter().map(|k| last[k]).collect();
            knots.dedup_by_key(|knot| knot.vertex);
            if knots[0].vertex == knots[knots.len() - 1].vertex {
                knots.pop();
            }
            surface.polygon(FACE, &knots);
        }
    }
    let border = &rings[LIP_RINGS - 1];
    let middle = |k: usize| {
        let t = surface.positions[border[k].vertex as usize].x / LIP_WIDTH;
        (1.0 - t * t).max(0.0)
    };
    let along: Vec<f32> = (0..around)
        .map(|k| match k.checked_sub(corner) {
            Some(step) if step <= around / 2 => middle(k),
            _ => -middle(k),
        })
        .collect();
    let inside = rings[LIP_RINGS..].iter();
    inside.flat_map(|ring| ring.iter().map(|knot| knot.vertex).zip(along.iter().copied())).collect()
}

struct Grid {
    positions: Vec<Vec<Vec3>>,
}

impl Grid {
    fn new() -> Self {
        let positions = (0..=ROWS)
            .map(|row| (0..COLUMNS).map(|column| grid_position(column, row)).collect())
            .collect();
        Self { positions }
    }

    fn at(column: usize, row: usize) -> [f32; 2] {
        [column as f32 / COLUMNS as f32 * 2.0 - 1.0, row as f32 / ROWS as f32]
    }
}

/// Azimuth of a column, 0 in front; columns are denser in front.
pub(crate) fn azimuth(column: usize) -> f32 {
    let s = Grid::at(column, 0)[0];
    PI * (0.38 * s + 0.62 * s * s * s)
}

/// Elevation of a row's rays in front of the head, in degrees.
fn elevation(row: usize) -> f32 {
    // Crown, forehead, brow to nose, nose to chin, below the chin.
    const TURNS: [(usize, f32); 6] =
        [(0, 90.0), (6, 25.0), (14, -5.0), (30, -38.0), (46, -66.0), (JAW_ROWS, -78.0)];
    let after = TURNS.iter().position(|turn| row <= turn.0).unwrap_or(TURNS.len() - 1).max(1);
    let (from, to) = (TURNS[after - 1], TURNS[after]);
    mix(from.1, to.1, (row - from.0) as f32 / (to.0 - from.0) as f32)
}

fn grid_position(column: usize, row: usize) -> Vec3 {
    let around = azimuth(column);
    let towards = vec3(around.sin(), 0.0, around.cos());
    if row <= JAW_ROWS {
        let mut degrees = elevation(row);
        if degrees < 0.0 {
            // Behind the ears the same rows end on the nape, which is higher than the chin.
            degrees *= mix(1.0, 0.72, smoothstep(0.38 * PI, 0.85 * PI, around.abs()));
        }
        let (up, out) = degrees.to_radians().sin_cos();
        return leave(solid, CENTRE, towards * out + vec3(0.0, up, 0.0), REACH);
    }
    let jaw = grid_position(column, JAW_ROWS);
    let rim_axis = neck_axis(mix(-13.8, -16.3, 0.5 + 0.5 * around.cos()));
    let rim = leave(solid, rim_axis, towards, REACH);
    let down = (row - JAW_ROWS) as f32 / (ROWS - JAW_ROWS) as f32;
    let guide = jaw.lerp_monotonic(rim, down);
    // Ray origins move down to the neck's axis only gradually: next to the jaw, rays
    // come from above.
    let origin = CENTRE.lerp_monotonic(neck_axis(guide.y), down);
    leave(solid, origin, (guide - origin).normalize_or_zero(), REACH)
}

/// A point of a ring: its position, and the point in the frontal plane that gives its
/// chart parameters.
struct RingPoint {
    position: Vec3,
    chart_xy: [f32; 2],
}

/// Rings from the boundary inwards, from the boundary points and their angles around the block.
type Rings = fn(&[Vec3], &[f32]) -> Vec<Vec<RingPoint>>;

/// A block's chart parameters as a flat view from the front.
struct FrontView {
    /// Lowest and highest coordinates of the boundary.
    x: (f32, f32),
    y: (f32, f32),
    /// Lowest and highest parameters of the boundary.
    s: (f32, f32),
    t: (f32, f32),
}

impl FrontView {
    fn of(rim: &[Knot], points: &[Vec3]) -> Self {
        let extent = |values: &mut dyn Iterator<Item = f32>| {
            values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        Self {
            x: extent(&mut points.iter().map(|p| p.x)),
            y: extent(&mut points.iter().map(|p| p.y)),
            s: extent(&mut rim.iter().map(|k| k.at[0])),
            t: extent(&mut rim.iter().map(|k| k.at[1])),
        }
    }

    /// The direction of parameters from the centre.
    fn angle(&self, at: [f32; 2]) -> f32 {
        let right = (at[0] - self.s.0) / (self.s.1 - self.s.0) * 2.0 - 1.0;
        let down = (at[1] - self.t.0) / (self.t.1 - self.t.0) * 2.0 - 1.0;
        (-down).atan2(right)
    }

    /// The parameters of a point in the frontal plane.
    fn at(&self, [px, py]: [f32; 2]) -> [f32; 2] {
        let Self { x, y, s, t } = self;
        [mix(s.0, s.1, (px - x.0) / (x.1 - x.0)), mix(t.0, t.1, (y.1 - py) / (y.1 - y.0))]
    }

    /// How far from the centre a point is, as a share of the boundary's distance.
    fn outwards(&self, point: [f32; 2], at_rim: Vec3) -> f32 {
        let Self { x, y, .. } = self;
        let centre = [0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)];
        let (dx, dy) = (at_rim.x - centre[0], at_rim.y - centre[1]);
        let (px, py) = (point[0] - centre[0], point[1] - centre[1]);
        ((px * px + py * py) / (dx * dx + dy * dy)).sqrt().min(1.0)
    }
}

/// Fills a block with rings of quads and returns their knots.
///
/// Chart parameters blend from the grid's, at the boundary, to a flat front view in the centre. The
/// boundary's offset from the front view fades out with the distance from the centre; without that,
/// parameters would jump there.
fn set_rings(surface: &mut Surface, rim: &[Knot], rings: Rings) -> Vec<Vec<Knot>> {
    let points: Vec<Vec3> = rim.iter().map(|k| surface.positions[k.vertex as usize]).collect();
    let front = FrontView::of(rim, &points);
    let angles: Vec<f32> = rim.iter().map(|knot| front.angle(knot.at)).collect();
    let rings = rings(&points, &angles);
    // The inside of the mouth is flat in any case.
    let count = rings.len().min(10) as f32;
    let mut outer: Vec<Knot> = rim.to_vec();
    let mut set = Vec::new();
    for (step, ring) in rings.into_iter().enumerate() {
        // Near the boundary the chart is the grid's own, further in it is the flat front view.
        let flat = smoothstep(0.0, 0.45, (step as f32 + 1.0) / count);
        let mut inner: Vec<Knot> = ring
            .iter()
            .zip(rim.iter().zip(&points))
            .map(|(point, (from, at_rim))| {
                let here = front.at(point.chart_xy);
                let rim_plane = front.at([at_rim.x, at_rim.y]);
                // Offset of the boundary's parameters from the front view, fading inwards.
                let keep = (1.0 - flat) * front.outwards(point.chart_xy, *at_rim);
                let at = [
                    here[0] + (from.at[0] - rim_plane[0]) * keep,
                    here[1] + (from.at[1] - rim_plane[1]) * keep,
                ];
                surface.knot(point.position, at)
            })
            .collect();
        outer.push(outer[0]);
        inner.push(inner[0]);
        for m in 0..outer.len() - 1 {
            surface.polygon(FACE, &[outer[m], outer[m + 1], inner[m + 1], inner[m]]);
        }
        inner.pop();
        set.push(inner.clone());
        outer = inner;
    }
    set
}

/// The point where a ray along -Z at `(x, y)`, from the front, hits the skin.
pub(crate) fn front_hit(x: f32, y: f32) -> Vec3 {
    meet(solid, vec3(x, y, 13.0), vec3(0.0, 0.0, -1.0), 12.0)
}

/// Rings around an eye: five on the skin, from the block's boundary towards the lid opening, then
/// the lid's edge and two rings inside, behind the edge.
fn eye_rings(rim: &[Vec3], angles: &[f32]) -> Vec<Vec<RingPoint>> {
    let side = rim[0].x.signum();
    let centre = vec3(side * EYE.x, EYE.y, EYE.z);
    let opening: Vec<[f32; 2]> = angles
        .iter()
        .map(|angle| {
            let x = angle.cos() * LID_WIDTH;
            let outwards = x * side;
            let lid = if angle.sin() > 0.0 { upper_lid } else { lower_lid };
            [centre.x + x, lid(outwards)]
        })
        .collect();
    let on_lid = |[x, y]: [f32; 2], radius: f32| {
        let (dx, dy) = (x - centre.x, y - centre.y);
        let depth = (LID_RADIUS * LID_RADIUS - dx * dx - dy * dy).max(0.0).sqrt();
        centre + vec3(dx, dy, depth) * (radius / LID_RADIUS)
    };
    let mut rings: Vec<Vec<RingPoint>> = [0.3, 0.55, 0.74, 0.87, 0.95]
        .into_iter()
        .map(|t| {
            rim.iter()
                .zip(&opening)
                .zip(angles)
                .map(|((at_rim, goal), angle)| {
                    let (x, y) = (mix(at_rim.x, goal[0], t), mix(at_rim.y, goal[1], t));
                    // The fold of the upper lid.
                    let fold = if t == 0.74 { 0.14 * angle.sin().max(0.0) } else { 0.0 };
                    let position = front_hit(x, y) - vec3(0.0, 0.0, fold);
                    RingPoint { position, chart_xy: [x, y] }
                })
                .collect()
        })
        .collect();
    for (radius, scale) in [(LID_RADIUS, 1.0), (EYE_RADIUS + 0.02, 0.86), (1.2, 0.6)] {
        rings.push(
            opening
                .iter()
                .map(|&goal| RingPoint {
                    position: on_lid(goal, radius),
                    chart_xy: [mix(centre.x, goal[0], scale), mix(centre.y + 0.1, goal[1], scale)],
                })
                .collect(),
        );
    }
    rings
}

/// Rings on the outside of the mouth, up to the outline of the lips.
const LIP_RINGS: usize = 5;

/// Rings around the mouth: [`LIP_RINGS`] on the skin, up to the outline of the lips, then seven
/// over the lips and into the mouth.
fn mouth_rings(rim: &[Vec3], angles: &[f32]) -> Vec<Vec<RingPoint>> {
    let columns: Vec<(f32, bool)> =
        angles.iter().map(|angle| (angle.cos() * LIP_WIDTH, angle.sin() > 0.0)).collect();
    let border = |&(x, upper): &(f32, bool)| if upper { lip_top(x) } else { lip_bottom(x) };
    let mut rings: Vec<Vec<RingPoint>> = ([0.3, 0.55, 0.76, 0.91, 1.0] as [f32; LIP_RINGS])
        .into_iter()
        .map(|t| {
            rim.iter()
                .zip(&columns)
                .map(|(at_rim, column)| {
                    let (x, y) = (mix(at_rim.x, column.0, t), mix(at_rim.y, border(column), t));
                    RingPoint { position: front_hit(x, y), chart_xy: [x, y] }
                })
                .collect()
        })
        .collect();
    // Over the lips to where they touch, then into the mouth, which has room between roof and
    // floor. On the chart the slit stays open, or the lips would have no area in the texture.
    for (t, narrow, depth, room, open) in [
        (0.4, 0.99, 0.0, 0.0, 0.7),
        (0.75, 0.975, 0.0, 0.0, 0.45),
        (0.97, 0.96, 0.1, 0.0, 0.25),
        (1.0, 0.93, 0.7, 0.0, 0.17),
        (1.0, 0.90, 1.3, 0.45, 0.12),
        (1.0, 0.86, 2.3, 0.85, 0.08),
        (1.0, 0.72, 3.6, 0.75, 0.04),
    ] {
        rings.push(
            columns
                .iter()
                .map(|column| {
                    let x = column.0 * narrow;
                    let line = lip_line(x);
                    // The walls of the mouth are curved like the outline of the lips.
                    let room = room * (border(column) - lip_line(column.0));
                    let y = mix(border(column), line, t) + room;
                    let chart_y = line + (border(column) - lip_line(column.0)) * open;
                    let position = vec3(x, y, front_hit(x, y - room).z - depth);
                    RingPoint { position, chart_xy: [x, chart_y] }
                })
                .collect(),
        );
    }
    rings
}
