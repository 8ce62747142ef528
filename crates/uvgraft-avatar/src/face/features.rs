//! Locates eyelids, lips, corners of the mouth and brows.

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::{Anatomy, Area, HeadFrame, Landmark};

use super::FaceError;
use super::surface::{Hit, Spot, Surface};

/// Upper limit of an eyeball's radius, in distances between the eyes: real ones have 0.19.
const WIDEST_EYE: f32 = 0.4;

/// The two sides of an opening at one position along it: margins of the lids, or lips.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    pub upper: Spot,
    pub lower: Spot,
}

/// One eye and its lids.
#[derive(Debug, Clone)]
pub(super) struct Eye {
    /// The eyeball's centre in head coordinates.
    pub center: Vec3,
    /// From the inner corner to the outer one.
    pub lids: Vec<Opening>,
}

/// A face's features as points fixed to its mesh, which follow expressions, shapes and poses. Left
/// and right are the person's own, in this order.
#[derive(Debug, Clone)]
pub struct Face {
    pub(super) frame: HeadFrame,
    pub(super) vertices: usize,
    pub(super) eyes: [Eye; 2],
    pub(super) lips: Vec<Opening>,
    pub(super) corners: [Spot; 2],
    pub(super) inner_brows: [Spot; 2],
    pub(super) outer_brows: [Spot; 2],
    /// From corner to corner, in distances between the eyes.
    pub(super) mouth_width: f32,
}

impl Face {
    /// Locates a face by its geometry, in any unit and orientation.
    ///
    /// The margin of a lid is where rays from the eyeball's centre begin to hit skin. A lip is the
    /// upper one if it is nearer to the base of the nose than to the chin along the surface, which
    /// also holds for lips that touch and for any geometry of the mouth behind them.
    ///
    /// # Errors
    /// [`FaceError`] if there is no head, or if eyeballs, open lids or lips are missing.
    pub fn find(mesh: &Mesh) -> Result<Self, FaceError> {
        let anatomy = Anatomy::find(mesh)?;
        let frame = *anatomy.frame();
        let surface = Surface::new(mesh, &frame);
        let local = |landmark| {
            let place = anatomy.point(landmark)?;
            Some(Vec3::from(frame.local(place).map(|value| value as f32)))
        };
        let missing = |part| FaceError::Part { part };
        let eye = |landmark, side| {
            let eye = local(landmark).and_then(|center| eye(&surface, center, side));
            eye.ok_or_else(|| missing("eyeballs between open eyelids"))
        };
        let eyes = [eye(Landmark::LeftEye, 1.0)?, eye(Landmark::RightEye, -1.0)?];
        let mouth = Mouth::find(&surface, &local).ok_or_else(|| missing("lips"))?;
        let corner = |side: f32| {
            let place = Vec3::new(side * mouth.corner.x, mouth.corner.y, mouth.corner.z);
            spot(&surface, mouth.skin, place, 0.06).ok_or_else(|| missing("corners of the mouth"))
        };
        let brow = |side: f32, inner| {
            brow(&surface, anatomy.area(Area::Brows), side, inner).ok_or_else(|| missing("brows"))
        };
        Ok(Self {
            frame,
            vertices: mesh.positions().len(),
            lips: mouth.lips(&surface).ok_or_else(|| missing("lips that can open"))?,
            corners: [corner(1.0)?, corner(-1.0)?],
            inner_brows: [brow(1.0, true)?, brow(-1.0, true)?],
            outer_brows: [brow(1.0, false)?, brow(-1.0, false)?],
            mouth_width: 2.0 * mouth.corner.x,
            eyes,
        })
    }
}

/// The lids around an eye, on fixed columns of rays from the centre of the eyeball.
fn eye(surface: &Surface, center: Vec3, side: f32) -> Option<Eye> {
    let ball = eyeball(surface, center)?;
    let mut skin = surface.within(ball.center, 2.0 * ball.radius);
    skin.retain(|triangle| surface.piece[triangle[0] as usize] != ball.piece);
    let columns = [-30.0_f32, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0];
    let column = |across: f32| {
        let (sin, cos) = (side * across).to_radians().sin_cos();
        let hit = |elevation: f32| {
            let (up, ahead) = elevation.to_radians().sin_cos();
            let direction = Vec3::new(sin, up * cos, ahead * cos);
            let hits = surface.hits(ball.center, direction, &skin);
            // Lids continue behind their margins, along the eyeball or into the socket.
            hits.into_iter().find(|hit| hit.distance > 0.97 * ball.radius)
        };
        lids_of_column(hit)
    };
    let lids: Vec<Opening> = columns.into_iter().filter_map(column).collect();
    (lids.len() >= 3).then_some(Eye { center: ball.center, lids })
}

/// The margins below and above the widest opening in a column of rays, by elevation in degrees.
fn lids_of_column(hit: impl Fn(f32) -> Option<Hit>) -> Option<Opening> {
    const STEEPEST: i32 = 60;
    const MIN_DEG: i32 = 6;
    let is_open: Vec<bool> =
        (-STEEPEST..=STEEPEST).map(|elevation| hit(elevation as f32).is_none()).collect();
    let mut best: Option<(i32, i32)> = None;
    let mut start = None;
    for (at, open) in (0..).zip(is_open.iter().copied().chain([false])) {
        match (open, start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                if best.is_none_or(|(low, high)| at - from > high - low) {
                    best = Some((from, at));
                }
                start = None;
            }
            _ => {}
        }
    }
    // Bounded by skin on both sides, and wider than a slit between triangles.
    let (low, high) = best.filter(|&(low, high)| {
        high - low >= MIN_DEG && low > 0 && (high as usize) < is_open.len()
    })?;
    let (lower, upper) = (hit((low - 1 - STEEPEST) as f32)?, hit((high - STEEPEST) as f32)?);
    Some(Opening { upper: upper.spot(), lower: lower.spot() })
}

struct Ball {
    piece: u32,
    center: Vec3,
    radius: f32,
}

/// The connected component around an eye's centre that is small enough for an eyeball; the
/// outermost, if the cornea is a separate component.
fn eyeball(surface: &Surface, center: Vec3) -> Option<Ball> {
    let mut near: Vec<(u32, f32)> = surface
        .triangles
        .iter()
        .map(|triangle| triangle[0])
        .map(|vertex| (surface.piece[vertex as usize], surface.positions[vertex as usize]))
        .map(|(piece, place)| (piece, place.distance(center)))
        .collect();
    near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let balls = near.chunk_by(|a, b| a.0 == b.0).filter(|piece| {
        piece.len() > 20 && piece.last().is_some_and(|&(_, farthest)| farthest < WIDEST_EYE)
    });
    let ball =
        balls.map(|piece| Ball { piece: piece[0].0, center, radius: piece[piece.len() / 2].1 });
    ball.max_by(|a, b| a.radius.total_cmp(&b.radius))
}

/// The Gaussian-weighted mean of a component's vertices around a point, with standard
/// deviation `width`.
fn spot(surface: &Surface, piece: u32, place: Vec3, width: f32) -> Option<Spot> {
    let weight = |(vertex, &at): (usize, &Vec3)| {
        let square = at.distance_squared(place) / (width * width);
        (vertex as u32, if square < 9.0 { (-0.5 * square).exp() } else { 0.0 })
    };
    let own = surface.positions.iter().enumerate().filter(|&(v, _)| surface.piece[v] == piece);
    Spot::mean(own.map(weight))
}

/// The inner or the outer part of a brow.
fn brow(surface: &Surface, area: &[f32], side: f32, inner: bool) -> Option<Spot> {
    // Range of distances from the midline; an eye's centre is at 0.5.
    let [from, to] = if inner { [0.12, 0.42] } else { [0.55, 0.95] };
    let weights = (0..).zip(area).map(|(vertex, &weight)| {
        let across = surface.positions[vertex as usize].x * side;
        (vertex, if (from..to).contains(&across) { weight } else { 0.0 })
    });
    Spot::mean(weights)
}

struct Mouth {
    center: Vec3,
    corner: Vec3,
    skin: u32,
    /// For each vertex, the surface distance from the chin minus that from the base of
    /// the nose: positive on the upper lip.
    upper: Vec<f32>,
}

impl Mouth {
    /// Search range for the line between the lips, above and below its landmark.
    const REACH: f32 = 0.25;

    fn find(surface: &Surface, local: &impl Fn(Landmark) -> Option<Vec3>) -> Option<Self> {
        let (nose, chin) = (local(Landmark::NoseBase)?, local(Landmark::Chin)?);
        // The first hit of a ray towards the chin from the front is the face's skin.
        let ahead = Vec3::new(chin.x, chin.y, chin.z + 1.0);
        let hits = surface.hits(ahead, Vec3::NEG_Z, &surface.triangles);
        let skin = surface.piece[hits.first()?.vertex() as usize];
        let from_nose = surface.distances(surface.nearest(nose, skin)?);
        let from_chin = surface.distances(surface.nearest(chin, skin)?);
        let upper = from_chin.iter().zip(&from_nose).map(|(chin, nose)| chin - nose);
        Some(Self {
            center: local(Landmark::Mouth)?,
            corner: local(Landmark::LeftMouthCorner)?,
            skin,
            upper: upper.collect(),
        })
    }

    /// The lips at several positions across the mouth.
    fn lips(&self, surface: &Surface) -> Option<Vec<Opening>> {
        const MIN: usize = 3;
        let across = [-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45];
        let mut skin = surface.within(self.center, 1.5 * self.corner.x.max(Self::REACH));
        skin.retain(|triangle| surface.piece[triangle[0] as usize] == self.skin);
        let lips: Vec<Opening> =
            across.into_iter().filter_map(|share| self.lips_at(surface, &skin, share)).collect();
        (lips.len() >= MIN).then_some(lips)
    }

    /// Where the surface visible from the front changes from the lower lip to the upper one.
    fn lips_at(&self, surface: &Surface, skin: &[[u32; 3]], share: f32) -> Option<Opening> {
        const STEP: f32 = 0.01;
        let x = share * self.corner.x;
        let y = self.center.y + share * share * (self.corner.y - self.center.y);
        let seen = |y: f32| {
            let origin = Vec3::new(x, y, self.center.z + 1.0);
            let hit = surface.hits(origin, Vec3::NEG_Z, skin).into_iter().next()?;
            // Anything visible through parted lips lies behind them.
            (hit.distance < 1.0 + 0.3).then_some(hit)
        };
        let steps = (2.0 * Self::REACH / STEP) as i32;
        let column: Vec<Hit> =
            (0..=steps).filter_map(|step| seen(y - Self::REACH + STEP * step as f32)).collect();
        let is_upper = |hit: &Hit| self.upper[hit.vertex() as usize] > 0.0;
        let last_lower = column.iter().rposition(|hit| !is_upper(hit))?;
        let (lower, upper) = (column.get(last_lower)?, column.get(last_lower + 1)?);
        Some(Opening { upper: upper.spot(), lower: lower.spot() })
    }
}
