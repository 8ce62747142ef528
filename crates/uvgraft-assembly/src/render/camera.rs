//! Camera placement: keeps the body or the head in the picture in every frame.

use uvgraft::{Size, choices};
use uvgraft_gltf::scene::{PoseRequest, PosedPrimitive, Scene};
use uvgraft_pipeline::{Blame, Context, Result};
use uvgraft_render::{Bounds, Perspective};

/// The framing of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shot {
    /// The whole model.
    Body,
    /// The head, found by its bone or the neck's, or as the top seventh of the body.
    Head,
}

choices!(Shot {
    Body => "body", "The whole model";
    Head => "head", "The head, found by its bone or the neck's, or as the top seventh of the body";
});

/// The target of the camera.
#[derive(Debug, Clone, PartialEq)]
pub enum Aim {
    /// All of the model, or its head.
    Shot(Shot),
    /// A bone, or a node.
    Named(String),
    /// A fixed box in world space.
    Box(Bounds),
}

impl Aim {
    /// A box given by two corners, in any order.
    pub fn between([x0, y0, z0, x1, y1, z1]: [f32; 6]) -> Self {
        let (a, b) = ([x0, y0, z0], [x1, y1, z1]);
        Self::Box(Bounds {
            low: [0, 1, 2].map(|k| a[k].min(b[k])),
            high: [0, 1, 2].map(|k| a[k].max(b[k])),
        })
    }

    /// Whether the picture shows the whole model, which stands on the floor.
    pub(super) fn shows_floor(&self) -> bool {
        *self != Self::Shot(Shot::Head)
    }
}

/// The camera for all frames.
pub(super) struct Cameras {
    aim: Aim,
    bounds: Option<Bounds>,
    lowest: f32,
}

impl Cameras {
    pub(super) const fn new(aim: Aim) -> Self {
        Self { aim, bounds: None, lowest: f32::MAX }
    }

    /// Extends the view to include a frame.
    pub(super) fn look_at(
        &mut self,
        scene: &Scene,
        posing: &PoseRequest,
        drawn: &[PosedPrimitive],
    ) -> Result<()> {
        let points = || drawn.iter().flat_map(corners);
        let Some(body) = Bounds::of(points()) else { return Ok(()) };
        self.lowest = self.lowest.min(body.low[1]);
        let shown = match &self.aim {
            Aim::Shot(Shot::Body) => body,
            Aim::Box(bounds) => *bounds,
            Aim::Named(name) => {
                let around = scene.extent(name, posing).or_input()?;
                let points = around.points.iter().copied();
                Bounds::of(points).unwrap_or_else(|| beside(around.joint, &body))
            }
            Aim::Shot(Shot::Head) => {
                let bone = |name| scene.bone(name, posing).or_input().context("the head");
                // FLAME's head rotates about its neck.
                let joint = bone("head")?.map_or_else(|| bone("neck"), |joint| Ok(Some(joint)))?;
                Bounds::of(points().filter(|p| is_head(*p, joint, &body))).unwrap_or(body)
            }
        };
        self.bounds = Some(self.bounds.map_or(shown, |bounds| bounds.union(shown)));
        Ok(())
    }

    /// The lowest height in all frames.
    pub(super) const fn lowest(&self) -> f32 {
        self.lowest
    }

    /// A camera for each angle, all at the same distance. `None` if there is nothing to see.
    pub(super) fn views(
        &self,
        azimuths: &[f32],
        elevation: f32,
        fov: f32,
        size: Size,
        zoom: f32,
    ) -> Option<Vec<Perspective>> {
        let bounds = self.bounds?;
        let aspect = size.width as f32 / size.height as f32;
        let zoom = zoom.clamp(0.1, 50.0);
        let view =
            |&azimuth: &f32| Perspective::framing(&bounds, azimuth, elevation, fov, aspect, zoom);
        let views: Vec<Perspective> = azimuths.iter().map(view).collect();
        let farthest =
            views.iter().copied().max_by(|a, b| a.distance().total_cmp(&b.distance()))?;
        Some(views.into_iter().map(|view| view.at_distance_of(&farthest)).collect())
    }
}

/// The positions of all vertices used by triangles.
fn corners(drawn: &PosedPrimitive) -> impl Iterator<Item = [f32; 3]> {
    drawn.triangles.iter().flatten().map(|&vertex| drawn.positions[vertex as usize])
}

/// A box around a joint that moves nothing: an eighth of the body.
fn beside(joint: [f32; 3], body: &Bounds) -> Bounds {
    let half = body.radius() / 8.0;
    Bounds { low: joint.map(|value| value - half), high: joint.map(|value| value + half) }
}

/// Whether a point belongs to the head: above its joint, but not a raised hand.
///
/// - `joint`: of the head or the neck.
fn is_head(p: [f32; 3], joint: Option<[f32; 3]>, body: &Bounds) -> bool {
    /// No body is that small, and no head that tall.
    const BUST_M: f32 = 0.6;
    /// Nor that deep, in shares of the height, in whatever unit: FLAME's head has 0.8, a bust with shoulders 0.5,
    /// SMPL-X and the figure 0.2.
    const BUST_DEPTH: f32 = 0.4;
    let height = body.high[1] - body.low[1];
    let Some(joint) = joint else {
        let is_bust = height < BUST_M || body.high[2] - body.low[2] > BUST_DEPTH * height;
        return is_bust || p[1] > body.high[1] - height / 7.0;
    };
    let beside = (p[0] - joint[0]).hypot(p[2] - joint[2]);
    // Heads are about a seventh of a body; a model of a head alone is all head.
    let reach = if joint[1] < body.low[1] + 0.6 * height { height } else { height / 8.0 };
    beside < reach && p[1] > joint[1] - 0.2 * reach
}
