//! The shadow map of a directional light.
//!
//! # Source
//! Reeves et al., "Rendering Antialiased Shadows with Depth Maps", 1987.

use glam::Vec3;
use uvgraft::{Size, threads};

use super::camera::Camera;
use super::cutouts::ShadowCasters;
use super::depth::{DepthMap, Drawing, Whole};
use super::projection::project;

/// Sides of the map, of which the smallest that is fine enough for the picture is chosen.
const SIDES: [u32; 3] = [512, 1024, 2048];

/// A texel is fine enough if it is at most this many pixels wide. The filter then is several texels
/// wide wherever its edges can be seen.
const FINE: f32 = 0.6;

/// Side of a tile whose range of depths is known.
const TILE: usize = 8;

/// Comparisons along each side of the filter.
const TAPS: i32 = 6;

/// Texels along each side that the comparisons touch: at most 10 between the outermost centres,
/// and the next one at either end.
const REACH: usize = 13;

/// Half the width of the filter is limited to this many texels, or it would skip some.
const SOFTEST: f32 = 6.0;

/// What a directional light sees.
#[derive(Debug)]
pub(crate) struct Shadow {
    camera: Camera,
    map: DepthMap,
    /// The farthest and the nearest depth in each tile.
    tiles: Vec<[f32; 2]>,
    side: u32,
    unit_per_texel: f32,
    /// Half the width of soft shadow edges, in texels: the same width everywhere.
    softness: f32,
    bias: f32,
}

impl Shadow {
    /// The shadows of a scene.
    ///
    /// - `towards`: unit vector to the light.
    /// - `seen`: centre and radius of the region that the map covers; nothing outside it is
    ///   shadowed.
    /// - `pixel`: size of a pixel of the picture there, in mesh units.
    /// - `metre`: length of one metre in mesh units.
    pub fn new(
        casters: &ShadowCasters<'_>,
        towards: Vec3,
        seen: (Vec3, f32),
        pixel: f32,
        metre: f32,
    ) -> Self {
        let is_fine = |side: &u32| 2.0 * seen.1 <= FINE * pixel * *side as f32;
        let side = SIDES.into_iter().find(is_fine).unwrap_or(SIDES[2]);
        let size = Size::square(side);
        let unit_per_texel = (2.0 * seen.1 / side as f32).max(f32::MIN_POSITIVE);
        let camera = Camera::looking(towards, seen.0, unit_per_texel, size);
        let homogeneous = camera.all_homogeneous(&casters.geometry.positions);
        let casts = |face: usize| casters.casts(face);
        let parts = project(&camera, casters.geometry, &homogeneous, size, casts);
        let drawing = Drawing::new(parts, size);
        let map = match casters.are_whole() {
            true => DepthMap::new(&drawing, 1, f32::NEG_INFINITY, &Whole),
            false => DepthMap::new(&drawing, 1, f32::NEG_INFINITY, &casters.holes(&homogeneous)),
        };
        let tiles = ranges(&map);
        let softness = (0.0022 * metre / unit_per_texel).clamp(1.0, SOFTEST);
        Self { camera, map, tiles, side, unit_per_texel, softness, bias: 0.0035 * metre }
    }

    /// The fraction of the light that reaches a point, with soft edges.
    ///
    /// Percentage-closer filtering: depth comparisons, not depths, are averaged, over a square of
    /// bilinear taps. The point is raised along its normal and the depth biased, or the surface
    /// would shadow itself.
    ///
    /// - `normal`: normal of the surface at the point.
    /// - `width`: size of the pixel that the point stands for, in mesh units.
    pub fn lit(&self, position: Vec3, normal: Vec3, width: f32) -> f32 {
        let raised = position + normal * self.bias;
        let [x, y, w] = self.camera.homogeneous(raised);
        let [x, y] = [x, y].map(|at| (at / w) as f32);
        let side = self.side as f32;
        if !(x >= 0.0 && y >= 0.0 && x < side && y < side) {
            return 1.0;
        }
        let height = self.camera.depth_of(raised, w) as f32 + self.bias;
        // Four points, a quarter of the pixel from its centre along both axes, would widen the box
        // to about this: their variance is that of the box plus a sixteenth.
        let width = width / self.unit_per_texel;
        // A box's variance is a third of its half width squared: 3 / 16 of the width squared is
        // added.
        let softness = (self.softness.powi(2) + (0.433 * width).powi(2)).sqrt().min(SOFTEST);
        let [farthest, nearest] = self.range([x, y], softness);
        if nearest <= height {
            1.0
        } else if farthest > height {
            0.0
        } else {
            self.filtered(&Line::new(x, softness), &Line::new(y, softness), height)
        }
    }

    /// The weighted mean of the comparisons. The weights of the taps form a product, so they are
    /// summed along each axis first.
    fn filtered(&self, left: &Line, top: &Line, height: f32) -> f32 {
        let mut sum = 0.0;
        for (row, by_row) in top.weights(self.side) {
            let depths = self.map.row(row as u32);
            let mut line = 0.0;
            for (column, weight) in left.weights(self.side) {
                line += if depths[column] <= height { weight } else { 0.0 };
            }
            sum += line * by_row;
        }
        sum / (TAPS * TAPS) as f32
    }

    /// Bounds of the depths that a point is compared with.
    fn range(&self, at: [f32; 2], softness: f32) -> [f32; 2] {
        let [(left, right), (top, bottom)] = at.map(|at| {
            // The next texel at either end takes part in interpolation.
            let tile = |texel: f32| (texel.clamp(0.0, (self.side - 1) as f32) as usize) / TILE;
            (tile(at - softness - 1.0), tile(at + softness + 1.0))
        });
        let tiles = self.side as usize / TILE;
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for row in top..=bottom {
            for &[low, high] in &self.tiles[row * tiles + left..=row * tiles + right] {
                range[0] = if low < range[0] { low } else { range[0] };
                range[1] = if high > range[1] { high } else { range[1] };
            }
        }
        range
    }
}

/// The farthest and the nearest depth in each tile of a map.
fn ranges(map: &DepthMap) -> Vec<[f32; 2]> {
    let count = map.size.width as usize / TILE;
    let mut tiles = vec![[f32::NEG_INFINITY; 2]; count * count];
    threads::for_each_chunk(&mut tiles, count, |row, tiles| {
        let (first, rest) = (row * TILE, row * TILE + 1..(row + 1) * TILE);
        let first = map.row(first as u32);
        // Down the columns first, so that several are done at once.
        let (mut low, mut high) = (first.to_vec(), first.to_vec());
        for y in rest {
            let depths = map.row(y as u32);
            for ((low, high), &depth) in low.iter_mut().zip(&mut high).zip(depths) {
                *low = if depth < *low { depth } else { *low };
                *high = if depth > *high { depth } else { *high };
            }
        }
        let (low, high) = (low.as_chunks::<TILE>().0, high.as_chunks::<TILE>().0);
        for ((tile, low), high) in tiles.iter_mut().zip(low).zip(high) {
            *tile = [
                low.iter().copied().fold(f32::INFINITY, f32::min),
                high.iter().copied().fold(f32::NEG_INFINITY, f32::max),
            ];
        }
    });
    tiles
}

/// The texels along one axis that a point is compared with.
struct Line {
    first: i32,
    weights: [f32; REACH],
    count: usize,
}

impl Line {
    /// - `at`: the point, in texels.
    /// - `softness`: half the width of the filter, in texels.
    fn new(at: f32, softness: f32) -> Self {
        let step = 2.0 * softness / TAPS as f32;
        let tap = |index: i32| at - 0.5 + (index as f32 - 0.5 * (TAPS - 1) as f32) * step;
        let first = tap(0).floor();
        let mut line = Self { first: first as i32, weights: [0.0; REACH], count: 0 };
        for index in 0..TAPS {
            // Not negative, so rounding towards zero is rounding down.
            let from_first = (tap(index) - first).max(0.0);
            let texel = (from_first as usize).min(REACH - 2);
            let part = from_first - texel as f32;
            line.weights[texel] += 1.0 - part;
            line.weights[texel + 1] += part;
            line.count = texel + 2;
        }
        line
    }

    /// Texels with the sums of their weights; coordinates are clamped to the map.
    ///
    /// - `side`: side of the map.
    fn weights(&self, side: u32) -> impl Iterator<Item = (usize, f32)> {
        let last = side as i32 - 1;
        let texel = move |index: usize| (self.first + index as i32).clamp(0, last) as usize;
        self.weights[..self.count].iter().enumerate().map(move |(k, &weight)| (texel(k), weight))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Face, Geometry};
    use crate::shading::Shading;
    use crate::surface::Surface;

    /// The definition: every tap for itself.
    fn reference(shadow: &Shadow, [x, y]: [f32; 2], height: f32, softness: f32) -> f32 {
        let step = 2.0 * softness / TAPS as f32;
        let mut sum = 0.0;
        for row in 0..TAPS {
            for column in 0..TAPS {
                let at = |tap: i32| (tap as f32 - 0.5 * (TAPS - 1) as f32) * step - 0.5;
                let (px, py) = (x + at(column), y + at(row));
                let (left, top) = (px.floor(), py.floor());
                let (fx, fy) = (px - left, py - top);
                let open = |dx: i32, dy: i32| {
                    let depth = shadow.map.depth(left as i32 + dx, top as i32 + dy);
                    f32::from(u8::from(depth <= height))
                };
                let upper = open(0, 0) * (1.0 - fx) + open(1, 0) * fx;
                let lower = open(0, 1) * (1.0 - fx) + open(1, 1) * fx;
                sum += upper * (1.0 - fy) + lower * fy;
            }
        }
        sum / (TAPS * TAPS) as f32
    }

    #[test]
    fn the_filter_is_the_mean_of_all_taps() {
        // Triangles at several heights, some across the edge of the map.
        let mut rng = fastrand::Rng::with_seed(3);
        let mut geometry = Geometry::default();
        for _ in 0..60 {
            let z = rng.f32();
            let first = geometry.positions.len() as u32;
            let at = [rng.f32() * 2.4 - 1.2, rng.f32() * 2.4 - 1.2];
            for _ in 0..3 {
                let [x, y] = at.map(|at| at + 0.3 * (rng.f32() - 0.5));
                geometry.positions.push(Vec3::new(x, y, z));
            }
            let vertices = [0, 1, 2].map(|k| first + k);
            geometry.faces.push(Face { vertices, uv: vertices, surface: 0 });
        }
        let surfaces = [Surface::of_part(Shading::Matt)];
        let casters = ShadowCasters { surfaces: &surfaces, mipmaps: &[], geometry: &geometry };
        let towards = Vec3::new(0.0, 0.0, 1.0);
        let mut seen = [0; 3];
        for (metre, pixel, side) in
            [(1.0, 0.001, 2048), (2.5, 0.002, 2048), (5.0, 0.004, 1024), (3.0, 0.01, 512)]
        {
            let seen_from = (Vec3::default(), 1.0);
            let shadow = Shadow::new(&casters, towards, seen_from, pixel, metre);
            assert_eq!(shadow.side, side);
            for _ in 0..20_000 {
                let p = Vec3::new(rng.f32() * 2.0 - 1.0, rng.f32() * 2.0 - 1.0, rng.f32() - 0.2);
                let up = Vec3::default();
                let width = 0.01 * rng.f32();
                let found = shadow.lit(p, up, width);
                let [x, y, _] = shadow.camera.homogeneous(p).map(|at| at as f32);
                let softness = shadow.softness.hypot(0.433 * width / shadow.unit_per_texel);
                let height = p.z + shadow.bias;
                let wanted = reference(&shadow, [x, y], height, softness.min(SOFTEST));
                assert!((found - wanted).abs() < 1e-4, "{p}: {found} {wanted}");
                seen[if found == 0.0 { 0 } else { 1 + usize::from(found == 1.0) }] += 1;
            }
        }
        assert!(seen.iter().all(|&count| count > 500), "{seen:?}");
    }
}
