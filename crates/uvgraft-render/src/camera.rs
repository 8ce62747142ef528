//! Cameras, and the homogeneous coordinates in which perspective projection is linear.

use glam::{Vec3, vec3};
use uvgraft::{Size, threads};

/// An orthographic view of a mesh. Angles are in degrees, lengths in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Azimuth of the camera: 0 in front (on +Z), 90 on +X.
    pub azimuth: f32,
    /// Elevation of the camera above the horizon, clamped to -89..=89.
    pub elevation: f32,
    /// The point at the centre of the picture.
    pub target: [f32; 3],
    /// Height of the region that fills the picture.
    pub height: f32,
    /// Whether the mesh stands on a floor that receives its shadow; visible only from above.
    pub floor: bool,
}

/// A perspective camera in the convention of three.js: a `PerspectiveCamera` with the same values
/// shows the same picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Perspective {
    /// Position of the camera.
    pub eye: [f32; 3],
    /// The point at the centre of the picture; must differ from `eye`.
    pub target: [f32; 3],
    /// Up direction in the picture; must not be parallel to the viewing direction.
    pub up: [f32; 3],
    /// Vertical field of view, in degrees.
    pub fov_y: f32,
    /// Distance of the near plane; above 0.
    pub near: f32,
    /// Distance of the far plane.
    pub far: f32,
}

/// The axis-aligned bounding box that a camera is to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub low: [f32; 3],
    /// The largest coordinates.
    pub high: [f32; 3],
}

impl Bounds {
    /// The bounding box of the finite points; `None` if there are none.
    pub fn of(points: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        points
            .into_iter()
            .filter(|p| p.iter().all(|value| value.is_finite()))
            .map(|p| Self { low: p, high: p })
            .reduce(Self::union)
    }

    /// The bounding box of both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            low: [0, 1, 2].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1, 2].map(|k| self.high[k].max(other.high[k])),
        }
    }

    /// The centre of the box.
    pub fn center(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| 0.5 * (self.low[k] + self.high[k]))
    }

    /// Half the diagonal.
    pub fn radius(&self) -> f32 {
        0.5 * (Vec3::from(self.high) - Vec3::from(self.low)).length()
    }

    fn corners(&self) -> impl Iterator<Item = Vec3> {
        let (low, high) = (self.low, self.high);
        (0..8).map(move |corner| {
            let side = |k: usize| if corner >> k & 1 == 0 { low[k] } else { high[k] };
            vec3(side(0), side(1), side(2))
        })
    }
}

impl Perspective {
    /// A camera outside a box that frames all of it, with a margin.
    ///
    /// - `azimuth`: degrees around the box: 0 in front (on +Z), 90 on +X.
    /// - `elevation`: degrees above the horizon, clamped to -89..=89.
    /// - `fov_y`: vertical field of view in degrees, clamped to 1..=120.
    /// - `aspect`: width of the picture divided by its height.
    /// - `zoom`: magnification relative to filling the picture; above 0.
    ///
    /// For a corner at `q` from the centre, the camera must be at least
    /// `q·towards + max(|q·up| / t, |q·right| / (t * aspect))` away, `t` being the tangent of
    /// half the field of view, reduced by the margin. The largest of these over the eight corners
    /// is the distance.
    pub fn framing(
        bounds: &Bounds,
        azimuth: f32,
        elevation: f32,
        fov_y: f32,
        aspect: f32,
        zoom: f32,
    ) -> Self {
        const MARGIN: f32 = 1.07;
        let fov_y = fov_y.clamp(1.0, 120.0);
        let towards = from_angles(azimuth, elevation);
        let right = vec3(0.0, 1.0, 0.0).cross(towards).normalize_or_zero();
        let up = towards.cross(right);
        let middle = Vec3::from(bounds.center());
        let tangent = (0.5 * fov_y).to_radians().tan() / MARGIN;
        // The nearest distance at which every corner is still in the picture.
        let mut distance = f32::MIN_POSITIVE;
        for corner in bounds.corners() {
            let q = corner - middle;
            let high = q.dot(up).abs() / tangent;
            let wide = q.dot(right).abs() / (tangent * aspect);
            distance = distance.max(q.dot(towards) + high.max(wide));
        }
        let radius = bounds.radius().max(1e-6);
        // Zooming in narrows the field of view and leaves the camera in place, or it would end up
        // inside the box. Zooming out moves the camera back, since the field of view is limited.
        let zoom = zoom.max(1e-3);
        let distance = (distance / zoom.min(1.0)).max(0.02 * radius);
        let half = (0.5 * fov_y).to_radians().tan() / zoom.max(1.0);
        let fov_y = 2.0 * half.atan().to_degrees();
        Self {
            eye: (middle + towards * distance).into(),
            target: middle.into(),
            up: [0.0, 1.0, 0.0],
            fov_y,
            near: (0.02 * distance).max(1e-6),
            far: distance + 20.0 * radius,
        }
    }

    /// Distance from the eye to the target.
    pub fn distance(&self) -> f32 {
        (Vec3::from(self.eye) - Vec3::from(self.target)).length()
    }

    /// The same camera, moved along its viewing direction to the distance of another camera.
    #[must_use]
    pub fn at_distance_of(&self, other: &Self) -> Self {
        let (eye, target) = (Vec3::from(self.eye), Vec3::from(self.target));
        let eye = target + (eye - target).normalize_or_zero() * other.distance();
        Self { eye: eye.into(), near: other.near, far: other.far, ..*self }
    }
}

fn from_angles(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin, cos) = azimuth.to_radians().sin_cos();
    let (rise, flat) = elevation.clamp(-89.0, 89.0).to_radians().sin_cos();
    vec3(sin * flat, rise, cos * flat)
}

/// A point before the perspective divide: `(x / w, y / w)` are sample coordinates.
pub(crate) type Homogeneous = [f64; 3];

/// Projects to sample coordinates, and to a depth that grows towards the camera and is affine on
/// the screen.
#[derive(Debug, Clone)]
pub(crate) struct Camera {
    pub right: Vec3,
    pub up: Vec3,
    /// Unit vector from the target to the camera.
    pub towards: Vec3,
    /// The eye with perspective, the target without.
    origin: Vec3,
    lens: Lens,
    centre: [f32; 2],
}

#[derive(Debug, Clone, Copy)]
enum Lens {
    Orthographic {
        unit_per_px: f32,
    },
    Perspective {
        /// Focal length, in samples.
        focal_px: f32,
        near: f32,
        far: f32,
    },
}

/// A viewing ray that starts at the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub origin: Vec3,
    /// Not normalised.
    pub direction: Vec3,
}

impl Camera {
    pub fn orthographic(view: &View, size: Size) -> Self {
        let towards = from_angles(view.azimuth, view.elevation);
        let unit_per_px = view.height / size.height as f32;
        Self::looking(towards, view.target.into(), unit_per_px, size)
    }

    /// Orthographic view from the direction `towards`, with `target` at the centre.
    pub fn looking(towards: Vec3, target: Vec3, unit_per_px: f32, size: Size) -> Self {
        let lens = Lens::Orthographic { unit_per_px };
        Self::new(towards, vec3(0.0, 1.0, 0.0), target, lens, size)
    }

    /// Orthographic view from below, with X to the left and Z downwards on the screen.
    pub fn from_below(target: Vec3, unit_per_px: f32, size: Size) -> Self {
        let lens = Lens::Orthographic { unit_per_px };
        Self::new(vec3(0.0, -1.0, 0.0), vec3(0.0, 0.0, -1.0), target, lens, size)
    }

    pub fn perspective(camera: &Perspective, size: Size) -> Self {
        let eye = Vec3::from(camera.eye);
        let towards = (eye - Vec3::from(camera.target)).normalize_or_zero();
        let tangent = (0.5 * camera.fov_y).to_radians().tan();
        let focal_px = 0.5 * size.height as f32 / tangent;
        let lens = Lens::Perspective { focal_px, near: camera.near, far: camera.far };
        Self::new(towards, camera.up.into(), eye, lens, size)
    }

    fn new(towards: Vec3, up: Vec3, origin: Vec3, lens: Lens, size: Size) -> Self {
        let right = up.cross(towards).normalize_or_zero();
        let centre = [size.width as f32 * 0.5, size.height as f32 * 0.5];
        Self { right, up: towards.cross(right), towards, origin, lens, centre }
    }

    pub fn homogeneous(&self, p: Vec3) -> Homogeneous {
        let q = p - self.origin;
        let (x, y) = (f64::from(q.dot(self.right)), f64::from(q.dot(self.up)));
        let [left, top] = self.centre.map(f64::from);
        match self.lens {
            Lens::Orthographic { unit_per_px } => {
                let unit = f64::from(unit_per_px);
                [left + x / unit, top - y / unit, 1.0]
            }
            Lens::Perspective { focal_px, .. } => {
                let (focal, w) = (f64::from(focal_px), -f64::from(q.dot(self.towards)));
                [left * w + focal * x, top * w - focal * y, w]
            }
        }
    }

    pub fn all_homogeneous(&self, points: &[Vec3]) -> Vec<Homogeneous> {
        threads::map_indices(points.len(), |index| self.homogeneous(points[index]))
    }

    /// Depth of a point whose homogeneous coordinate is `w`: 1 / w with perspective, which is
    /// affine on the screen.
    pub fn depth_of(&self, p: Vec3, w: f64) -> f64 {
        match self.lens {
            Lens::Orthographic { .. } => f64::from((p - self.origin).dot(self.towards)),
            Lens::Perspective { .. } => 1.0 / w,
        }
    }

    /// The near limit of `w`, and the smallest visible depth.
    pub fn limits(&self) -> (f64, f32) {
        match self.lens {
            Lens::Orthographic { .. } => (0.0, f32::NEG_INFINITY),
            Lens::Perspective { near, far, .. } => (f64::from(near), 1.0 / far),
        }
    }

    /// Position along the axis towards the camera at a depth, in mesh units.
    pub fn height_of(&self, depth: f32) -> f32 {
        match self.lens {
            Lens::Orthographic { .. } => depth,
            Lens::Perspective { .. } if depth > 0.0 => -1.0 / depth,
            Lens::Perspective { .. } => f32::NEG_INFINITY,
        }
    }

    /// Size of a sample at a depth, in mesh units.
    pub fn unit_per_px(&self, depth: f32) -> f32 {
        match self.lens {
            Lens::Orthographic { unit_per_px } => unit_per_px,
            Lens::Perspective { focal_px, .. } => 1.0 / (depth * focal_px),
        }
    }

    /// Size of a sample at a point, in mesh units.
    pub fn unit_per_px_at(&self, p: Vec3) -> f32 {
        match self.lens {
            Lens::Orthographic { unit_per_px } => unit_per_px,
            Lens::Perspective { focal_px, .. } => (self.origin - p).dot(self.towards) / focal_px,
        }
    }

    /// Unit vector from a point to the camera.
    pub fn towards_from(&self, p: Vec3) -> Vec3 {
        match self.lens {
            Lens::Orthographic { .. } => self.towards,
            Lens::Perspective { .. } => (self.origin - p).normalize_or_zero(),
        }
    }

    pub fn ray(&self, x: f32, y: f32) -> Ray {
        let (dx, dy) = (x - self.centre[0], self.centre[1] - y);
        let across = self.right * dx + self.up * dy;
        match self.lens {
            Lens::Orthographic { unit_per_px } => {
                Ray { origin: self.origin + across * unit_per_px, direction: -self.towards }
            }
            Lens::Perspective { focal_px, .. } => {
                Ray { origin: self.origin, direction: across - self.towards * focal_px }
            }
        }
    }

    /// Centre and radius of the visible region around a point, after projecting the point onto the
    /// optical axis.
    pub fn seen_around(&self, point: Vec3) -> (Vec3, f32) {
        let [half_width, half_height] = self.centre;
        let half = half_width.max(half_height);
        let away = (point - self.origin).dot(self.towards);
        let centre = match self.lens {
            Lens::Orthographic { .. } => self.origin + self.towards * away,
            Lens::Perspective { near, .. } => self.origin + self.towards * away.min(-near),
        };
        let depth = match self.lens {
            Lens::Orthographic { .. } => 0.0,
            Lens::Perspective { near, .. } => 1.0 / (-away).max(near),
        };
        (centre, half * self.unit_per_px(depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_land_where_a_pinhole_puts_them() {
        let camera = Perspective {
            eye: [0.0, 1.0, 4.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
            near: 0.1,
            far: 10.0,
        };
        let camera = Camera::perspective(&camera, Size::new(200, 100));
        // At distance 2 half the height of 100 is 2: 25 samples a unit.
        let [x, y, w] = camera.homogeneous(vec3(1.0, 2.0, 2.0));
        assert!((x / w - 125.0).abs() < 1e-4 && (y / w - 25.0).abs() < 1e-4, "{x} {y} {w}");
        assert_eq!(camera.height_of(camera.depth_of(vec3(1.0, 2.0, 2.0), w) as f32), -2.0);
        assert!((camera.unit_per_px(0.5) - 0.04).abs() < 1e-6);
        let ray = camera.ray(125.0, 25.0);
        let hit = ray.origin + ray.direction * (2.0 / 50.0);
        assert!((hit - vec3(1.0, 2.0, 2.0)).length() < 1e-5, "{hit:?}");
    }

    #[test]
    fn a_box_is_framed_from_every_side() {
        let bounds = Bounds { low: [-1.0, 0.0, -0.2], high: [1.0, 1.8, 0.3] };
        let size = Size::new(300, 400);
        for azimuth in [0.0, 45.0, 90.0, 200.0] {
            for elevation in [-30.0, 0.0, 60.0] {
                let view = Perspective::framing(&bounds, azimuth, elevation, 30.0, 0.75, 1.0);
                let camera = Camera::perspective(&view, size);
                let mut nearest = f64::MAX;
                for corner in bounds.corners() {
                    let [x, y, w] = camera.homogeneous(corner);
                    let (x, y) = (x / w, y / w);
                    assert!(w > f64::from(view.near) && w < f64::from(view.far));
                    nearest = nearest.min(x).min(y).min(300.0 - x).min(400.0 - y);
                }
                // The margin is 7 % of the half width or height.
                assert!((5.0..20.0).contains(&nearest), "{azimuth} {elevation}: {nearest}");
            }
        }
    }
}
