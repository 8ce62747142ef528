//! The floor under a mesh: the fraction of light that its shadow leaves, as a small texture seen
//! from above.
//!
//! It combines three shadows: the key light's, softened; a wide, faint one under the whole
//! mesh, for the part of the sky that the mesh hides; and a narrow contact shadow where it
//! touches the floor.

use glam::{Vec3, vec3};
use uvgraft::Size;
use uvgraft::easing::smoothstep;

use super::camera::{Camera, Ray};
use super::depth::{DepthMap, Drawing, Whole};
use super::geometry::Geometry;
use super::projection::project;

/// Side of the shadow texture, in cells.
const SIDE: u32 = 320;

#[derive(Debug)]
pub(crate) struct Floor {
    height: f32,
    centre: Vec3,
    radius: f32,
    /// Remaining light of each cell, row-major: rows along Z, columns along X.
    light: Vec<f32>,
}

impl Floor {
    /// Each shadow darkens the floor by a factor `1 - strength * s`. For the key light `s` is its
    /// blocked fraction; for the contact and the sky shadow `s = exp(-gap / length)`, where `gap`
    /// is the height of the mesh above the cell (from a depth buffer seen from below) and `length`
    /// 3 cm and 90 cm. All three are blurred before they are multiplied.
    ///
    /// - `lit`: the fraction of the key light that reaches a point.
    /// - `metre`: length of one metre in mesh units.
    pub fn new(geometry: &Geometry, height: f32, metre: f32, lit: impl Fn(Vec3) -> f32) -> Self {
        let (low, high) = geometry.bounds();
        let centre = low.lerp_monotonic(high, 0.5);
        let centre = vec3(centre.x, height, centre.z);
        let cell = Self::cell((low, high));
        let radius = 0.5 * cell * SIDE as f32;
        let size = Size::square(SIDE);

        // Seen from below, Z runs down the screen and X to the left: rows match, columns are
        // mirrored.
        let camera = Camera::from_below(centre, cell, size);
        let homogeneous = camera.all_homogeneous(&geometry.positions);
        let parts = project(&camera, geometry, &homogeneous, size, |_| true);
        let below = DepthMap::new(&Drawing::new(parts, size), 1, f32::NEG_INFINITY, &Whole);
        let point = |column: i32, row: i32| {
            let at = |index: i32| (index as f32 + 0.5) * cell - radius;
            centre + vec3(at(column), 0.0, at(row))
        };
        let mut key = Vec::with_capacity(size.texels());
        let (mut touching, mut hanging) = (key.clone(), key.clone());
        for row in 0..SIDE as i32 {
            for column in 0..SIDE as i32 {
                key.push(1.0 - lit(point(column, row)));
                let gap = (-below.depth(SIDE as i32 - 1 - column, row)).max(0.0) / metre;
                touching.push((-gap / 0.03).exp());
                hanging.push((-gap / 0.9).exp());
            }
        }
        let spread = |values: Vec<f32>, metres: f32| blurred(values, metres * metre / cell);
        let key = spread(key, 0.03);
        let (touching, hanging) = (spread(touching, 0.022), spread(hanging, 0.16));
        let light = (0..size.texels())
            .map(|k| (1.0 - 0.5 * key[k]) * (1.0 - 0.55 * touching[k]) * (1.0 - 0.42 * hanging[k]))
            .collect();
        Self { height, centre, radius, light }
    }

    /// Side of a cell of the shadow texture.
    ///
    /// - `low`, `high`: the bounds of all that stands on the floor.
    pub fn cell((low, high): (Vec3, Vec3)) -> f32 {
        let (dx, dz) = (high.x - low.x, high.z - low.z);
        let radius = 0.5 * (high - low).length().max(1e-6) + 0.3 * dx.hypot(dz);
        2.0 * radius / SIDE as f32
    }

    /// Brightness of the floor where a viewing ray meets it: 1 outside the shadow, and where the
    /// ray does not meet the floor. The shadow fades out towards the edge of the texture and at
    /// grazing angles.
    pub fn brightness(&self, ray: &Ray) -> f32 {
        let along = (ray.origin.y - self.height) / -ray.direction.y;
        // Most rays of a picture do not meet the texture: they are found without a root.
        let is_met = ray.direction.y < 0.0 && along > 0.0;
        if !is_met {
            return 1.0;
        }
        let p = ray.origin + ray.direction * along;
        let from_centre = p - self.centre;
        let is_near = from_centre.dot(from_centre) < self.radius * self.radius;
        if !is_near {
            return 1.0;
        }
        let away = from_centre.length() / self.radius;
        let fall = -ray.direction.normalize_or_zero().y;
        let near = smoothstep(0.98, 0.5, away) * smoothstep(0.01, 0.05, fall);
        if near == 0.0 {
            return 1.0;
        }
        let cells = 0.5 * SIDE as f32 / self.radius;
        let at = |value: f32, centre: f32| (value - centre + self.radius) * cells - 0.5;
        let (x, y) = (at(p.x, self.centre.x), at(p.z, self.centre.z));
        // Not negative where the shadow has not faded out, so rounding towards zero is rounding down.
        // `uvgraft::sampler::bilinear` sums in another order, which moves pixels of a palette by two
        // levels.
        let (left, top) = (x as i32, y as i32);
        let (fx, fy) = (x - left as f32, y - top as f32);
        let cell = |dx: i32, dy: i32| {
            let inside = |index: i32, d: i32| (index + d).clamp(0, SIDE as i32 - 1) as usize;
            self.light[inside(top, dy) * SIDE as usize + inside(left, dx)]
        };
        let upper = cell(0, 0) * (1.0 - fx) + cell(1, 0) * fx;
        let lower = cell(0, 1) * (1.0 - fx) + cell(1, 1) * fx;
        1.0 - near * (1.0 - (upper * (1.0 - fy) + lower * fy))
    }
}

/// Three box blurs, which approximate a Gaussian with standard deviation `sigma`, in cells.
fn blurred(mut values: Vec<f32>, sigma: f32) -> Vec<f32> {
    let side = SIDE as usize;
    // A box of 2r + 1 cells has variance r(r + 1)/3; three passes have three times that.
    let radius =
        ((sigma * sigma + 0.25).sqrt() - 0.5).round().clamp(0.0, SIDE as f32 / 4.0) as usize;
    if radius == 0 {
        return values;
    }
    let share = 1.0 / (2 * radius + 1) as f64;
    // The box moves on by one cell at a time: one value enters, one leaves. In double precision the
    // sum stays exact to within what single precision shows.
    let mut sums = vec![0.0_f64; side];
    let mut columns = vec![0.0_f32; side * side];
    for _ in 0..3 {
        for (line, blurred) in values.chunks_exact(side).zip(columns.chunks_exact_mut(side)) {
            let mut sum: f64 = line[..radius].iter().map(|&value| f64::from(value)).sum();
            for k in 0..side {
                sum += line.get(k + radius).map_or(0.0, |&value| f64::from(value));
                blurred[k] = (sum * share) as f32;
                sum -= k.checked_sub(radius).map_or(0.0, |left| f64::from(line[left]));
            }
        }
        let row = |y: usize| &columns[y * side..][..side];
        let add = |sums: &mut [f64], y: usize, sign: f64| {
            for (sum, &value) in sums.iter_mut().zip(row(y)) {
                *sum += sign * f64::from(value);
            }
        };
        sums.fill(0.0);
        (0..radius).for_each(|y| add(&mut sums, y, 1.0));
        for (y, line) in values.chunks_exact_mut(side).enumerate() {
            if y + radius < side {
                add(&mut sums, y + radius, 1.0);
            }
            for (value, sum) in line.iter_mut().zip(&sums) {
                *value = (sum * share) as f32;
            }
            if let Some(left) = y.checked_sub(radius) {
                add(&mut sums, left, -1.0);
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;

    use super::*;

    #[test]
    fn what_touches_the_floor_darkens_it_where_it_stands() {
        // A sole on the floor, and a raised arm that makes the bounds extend to one
        // side and forward.
        let sole = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.0, 0.3], [0.0, 0.0, 0.3]];
        let arm = [[0.8, 1.0, 0.9], [0.9, 1.0, 0.9], [0.9, 1.0, 1.0], [0.8, 1.0, 1.0]];
        let positions = [sole, arm].concat();
        let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let mesh = Mesh::from_triangles(positions, vec![[0.0; 2]; 8], &faces, &faces).unwrap();
        let floor = Floor::new(&Geometry::of_mesh(&mesh, &[0; 4]), 0.0, 1.0, |_| 1.0);
        let brightness = |x: f32, z: f32| {
            let ray = Ray { origin: vec3(x, 1.0, z), direction: vec3(0.0, -1.0, 0.0) };
            floor.brightness(&ray)
        };
        assert!(brightness(0.05, 0.15) < 0.5, "{}", brightness(0.05, 0.15));
        for [x, z] in [[0.85, 0.15], [0.05, 0.85], [-0.2, 0.15], [0.3, 0.15], [0.05, -0.2]] {
            assert!(brightness(x, z) > 0.8, "{x} {z}: {}", brightness(x, z));
        }
    }

    #[test]
    fn a_point_spreads_into_a_bell_that_keeps_its_sum() {
        let side = SIDE as usize;
        let mut values = vec![0.0; side * side];
        values[100 * side + 150] = 1.0;
        let spread = blurred(values, 5.0);
        let sum: f32 = spread.iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        let variance: f32 =
            (0..side * side).map(|k| spread[k] * ((k % side) as f32 - 150.0).powi(2)).sum();
        // Radii are integers: 4 or 5 give a variance of 20 or 30 instead of 25.
        assert!((19.0..31.0).contains(&variance), "{variance}");
    }
}
