//! A coarse grid of texels over a mesh's layout, with the adjacency of texels on the surface.
//!
//! Segmenting a texture needs connectivity: which texels are connected, and across how large a
//! colour step. In image space island boundaries would break that up, so texels at a UV seam are
//! linked to those on its other side.

use uvgraft_surface::edges::Edges;
use uvgraft_surface::islands::Islands;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::threads::{for_each, for_each_chunk};

use crate::map::{MapOptions, SamplingMap};
use crate::texture::{Channels, Depth, Size, Texels, Texture, Value};

/// No texel, or no triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// A grid of texels over a layout, indexed row by row.
#[derive(Debug, Clone)]
pub(crate) struct LayoutGrid {
    size: Size,
    /// The triangle at each texel's centre, or [`NONE`].
    face: Vec<u32>,
    /// Barycentric weights of that triangle's first two corners.
    weights: Vec<[f32; 2]>,
    /// Per texel, as bits: whether its left, right, upper and lower neighbours are on the same
    /// island ([`ADJACENT`]), and whether it has neighbours across a UV seam ([`ACROSS_SEAM`]).
    links: Vec<u8>,
    /// Pairs of texels that are adjacent across a UV seam, in both directions, sorted.
    across: Vec<(u32, u32)>,
    /// `texels + 1` offsets into `across`.
    across_starts: Vec<u32>,
}

/// The bits of links to all four sides, and the bit of links across seams.
const ADJACENT: u8 = 15;
const ACROSS_SEAM: u8 = 16;

impl LayoutGrid {
    /// Rasterises a layout.
    pub fn new(mesh: &Mesh, size: Size) -> Self {
        Self::with_edges(mesh, &Edges::new(mesh), size)
    }

    /// As [`LayoutGrid::new`], with edges that are already computed.
    pub fn with_edges(mesh: &Mesh, edges: &Edges, size: Size) -> Self {
        let map = SamplingMap::of_layout(mesh, size, &MapOptions::with_gutter(0));
        let mut face = vec![NONE; size.texels()];
        for y in 0..size.height {
            for run in map.row(y) {
                let first = (y * size.width + run.x) as usize;
                face[first..first + run.len as usize].fill(map.patches()[run.patch as usize].face);
            }
        }
        let width = size.width as usize;
        let mut weights = vec![[0.0; 2]; size.texels()];
        for_each_chunk(&mut weights, width, |y, row| {
            for (x, (weights, &face)) in row.iter_mut().zip(&face[y * width..]).enumerate() {
                if face != NONE {
                    let at = [x as f64 + 0.5, y as f64 + 0.5];
                    *weights = barycentric(corners_px(mesh, face as usize, size), at);
                }
            }
        });
        let islands = Islands::new(mesh);
        let island = |texel: usize| match face[texel] {
            NONE => NONE,
            face => islands.of_faces()[face as usize],
        };
        let mut links = vec![0_u8; size.texels()];
        for_each_chunk(&mut links, width, |y, row| {
            let of_row = |y: usize| (0..width).map(|x| island(y * width + x)).collect::<Vec<u32>>();
            let here = of_row(y);
            let [above, below] = [y.checked_sub(1), Some(y + 1)].map(|y| {
                let y = y.filter(|&y| y < size.height as usize);
                y.map_or_else(Vec::new, of_row)
            });
            for (x, links) in row.iter_mut().enumerate().filter(|&(x, _)| here[x] != NONE) {
                let left = x.checked_sub(1).and_then(|x| here.get(x));
                let beside = [left, here.get(x + 1), above.get(x), below.get(x)];
                for (side, near) in beside.into_iter().enumerate() {
                    *links |= u8::from(near == Some(&here[x])) << side;
                }
            }
        });
        let mut grid =
            Self { size, face, weights, links, across: Vec::new(), across_starts: Vec::new() };
        grid.link_seams(mesh, edges);
        grid
    }

    /// The size of the grid.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The triangle at each texel, or [`NONE`].
    pub fn faces(&self) -> &[u32] {
        &self.face
    }

    /// The left, right, upper and lower neighbours of a texel on its island; [`NONE`]
    /// where there is none.
    #[inline]
    pub fn beside(&self, texel: u32) -> [u32; 4] {
        let links = self.links[texel as usize];
        let width = self.size.width;
        let near = |side: u8, near: u32| if links & 1 << side == 0 { NONE } else { near };
        [
            near(0, texel.wrapping_sub(1)),
            near(1, texel.wrapping_add(1)),
            near(2, texel.wrapping_sub(width)),
            near(3, texel.wrapping_add(width)),
        ]
    }

    /// The texels `STEPS / 2` and `STEPS` steps from a texel to one side, if its island extends
    /// that far.
    #[inline]
    pub fn along<const STEPS: usize>(&self, texel: u32, side: usize) -> Option<[u32; 2]> {
        let step = [-1, 1, -i64::from(self.size.width), i64::from(self.size.width)][side];
        let at = |steps: usize| i64::from(texel) + step * steps as i64;
        // Beyond an island's edge the index may leave the grid.
        let continues = |steps: usize| {
            self.links.get(at(steps) as usize).is_some_and(|links| links & 1 << side != 0)
        };
        (0..STEPS).all(continues).then(|| [at(STEPS / 2) as u32, at(STEPS) as u32])
    }

    /// The neighbours of a texel across UV seams.
    #[inline]
    pub fn across(&self, texel: u32) -> impl Iterator<Item = u32> + '_ {
        let texel = texel as usize;
        let range = if self.links[texel] & ACROSS_SEAM == 0 {
            0..0
        } else {
            self.across_starts[texel] as usize..self.across_starts[texel + 1] as usize
        };
        self.across[range].iter().map(|&(_, other)| other)
    }

    /// All neighbours of a texel on the surface.
    #[inline]
    pub fn neighbours(&self, texel: u32) -> impl Iterator<Item = u32> + '_ {
        self.beside(texel).into_iter().filter(|&near| near != NONE).chain(self.across(texel))
    }

    /// Visits [`LayoutGrid::neighbours`]. Several times as fast in loops over many texels, since
    /// nearly all of them are inside islands.
    #[inline(always)]
    pub fn each_neighbour(&self, texel: u32, mut visit: impl FnMut(u32)) {
        if self.is_inside(texel) {
            let width = self.size.width;
            for near in [texel - 1, texel + 1, texel - width, texel + width] {
                visit(near);
            }
        } else {
            self.neighbours(texel).for_each(visit);
        }
    }

    /// Interpolates vertex values linearly over triangles and samples them at the texels; 0 where
    /// there is no triangle.
    pub fn at_texels(&self, mesh: &Mesh, values: &[f32]) -> Vec<f32> {
        let width = self.size.width as usize;
        let mut at_texels = vec![0.0; self.size.texels()];
        for_each_chunk(&mut at_texels, width, |y, row| {
            for (x, out) in row.iter_mut().enumerate() {
                let value = self.at_texel(mesh, values, y * width + x);
                // Most areas are small, and memory is not committed until it is written.
                if value != 0.0 {
                    *out = value;
                }
            }
        });
        at_texels
    }

    /// As [`LayoutGrid::at_texels`], at one texel.
    pub fn at_texel(&self, mesh: &Mesh, values: &[f32], texel: usize) -> f32 {
        let face = self.face[texel];
        if face == NONE {
            return 0.0;
        }
        let [a, b] = self.weights[texel];
        let [x, y, z] = mesh.faces()[face as usize].map(|vertex| values[vertex as usize]);
        x * a + y * b + z * (1.0 - a - b)
    }

    /// Whether all four neighbours of a texel are on its island and no seam is adjacent.
    #[inline(always)]
    pub fn is_inside(&self, texel: u32) -> bool {
        self.links[texel as usize] == ADJACENT
    }

    /// Whether any of a texel's four neighbours is not on its island.
    pub fn is_at_edge(&self, texel: u32) -> bool {
        self.links[texel as usize] & ADJACENT != ADJACENT
    }

    /// Links the texels on both sides of every edge that two triangles share on the surface but not
    /// in the layout, stepping along the edge by at most one texel (up to 4096 steps).
    fn link_seams(&mut self, mesh: &Mesh, edges: &Edges) {
        let mut links = Vec::new();
        for edge in &edges.shared {
            let [mut a, b] = edge.halves.map(|half| ends_uv(mesh, half));
            if edge.opposed {
                a.swap(0, 1);
            }
            if a == b {
                continue;
            }
            let faces = edge.halves.map(|half| half / 3);
            for along in self.places_along(&[a, b]) {
                let [Some(from), Some(to)] = [(a, faces[0]), (b, faces[1])]
                    .map(|(ends, face)| self.near(mesh, ends, face, along))
                else {
                    continue;
                };
                if from != to {
                    links.extend([(from, to), (to, from)]);
                }
            }
        }
        links.sort_unstable();
        links.dedup();
        let mut starts = vec![0; self.size.texels() + 1];
        for &(from, _) in &links {
            self.links[from as usize] |= ACROSS_SEAM;
            starts[from as usize + 1] += 1;
        }
        for texel in 0..self.size.texels() {
            starts[texel + 1] += starts[texel];
        }
        (self.across, self.across_starts) = (links, starts);
    }

    /// Sample positions along edges, as fractions of their length: one per texel of the longest
    /// edge.
    pub fn places_along(&self, edges: &[[[f64; 2]; 2]]) -> impl Iterator<Item = f64> + use<> {
        let size = [self.size.width, self.size.height].map(f64::from);
        let length = |[from, to]: &[[f64; 2]; 2]| {
            (0..2).map(|k| ((to[k] - from[k]) * size[k]).powi(2)).sum::<f64>().sqrt()
        };
        let longest = edges.iter().map(length).fold(0.0, f64::max);
        let steps = (longest.ceil() as usize).clamp(1, 4096);
        (0..steps).map(move |step| (step as f64 + 0.5) / steps as f64)
    }

    /// The covered texel nearest to a point on a triangle's edge, among the texels that touch the
    /// edge. Found by stepping from the point towards the triangle's centroid.
    ///
    /// - `ends`: UV coordinates of the edge's ends.
    /// - `along`: position on the edge, `0.0..=1.0`.
    pub fn near(&self, mesh: &Mesh, ends: [[f64; 2]; 2], face: u32, along: f64) -> Option<u32> {
        let size = [self.size.width, self.size.height].map(f64::from);
        let centroid = {
            let uv = mesh.uv_triangle(face as usize).map(|uv| uv.map(f64::from));
            [0, 1].map(|k| uv.iter().map(|uv| uv[k]).sum::<f64>() / 3.0)
        };
        let on_edge = [0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) * along);
        let inward = [0, 1].map(|k| (centroid[k] - on_edge[k]) * size[k]);
        let length = inward[0].hypot(inward[1]).max(1e-12);
        // The centre of a texel that touches the edge lies up to 0.7 texels inside.
        [0.3, 0.8, 1.4].into_iter().find_map(|px: f64| {
            let at = [0, 1].map(|k| on_edge[k] * size[k] + inward[k] / length * px.min(length));
            let is_in = at.iter().zip(size).all(|(&at, size)| (0.0..size).contains(&at));
            let texel = is_in.then(|| at[1] as u32 * self.size.width + at[0] as u32)?;
            (self.face[texel as usize] != NONE).then_some(texel)
        })
    }
}

/// UV coordinates of both ends of a half-edge.
pub(crate) fn ends_uv(mesh: &Mesh, half: u32) -> [[f64; 2]; 2] {
    let (face, corner) = (half as usize / 3, half as usize % 3);
    let uv = mesh.uv_triangle(face);
    [uv[corner], uv[(corner + 1) % 3]].map(|uv| uv.map(f64::from))
}

/// Barycentric weights of the first two corners at a point; those of the centroid if the
/// triangle has no area.
fn barycentric([a, b, c]: [[f64; 2]; 3], at: [f64; 2]) -> [f32; 2] {
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let part = |p: [f64; 2], q: [f64; 2]| {
        (p[0] - at[0]) * (q[1] - at[1]) - (p[1] - at[1]) * (q[0] - at[0])
    };
    let weights = [part(b, c) / doubled, part(c, a) / doubled];
    if weights.iter().all(|weight| weight.is_finite()) {
        weights.map(|weight| weight.clamp(0.0, 1.0) as f32)
    } else {
        [1.0 / 3.0; 2]
    }
}

/// The colours of a texture at the texels of a grid: sRGB-encoded, 1.0 for full scale.
#[derive(Debug, Clone)]
pub(crate) struct GridColors {
    pub rgb: Vec<[f32; 3]>,
    /// How much of each texel the texture determines: its mean alpha, where texels with values that
    /// are not finite contribute 0.
    pub known: Vec<f32>,
}

/// Maximum number of source texels per axis that are averaged for one texel of the grid.
const MAX_SAMPLES: u32 = 4;

impl GridColors {
    /// Averages the source texels that each grid texel spans. Background bleeds into texels at the
    /// edges of islands, so these take the mean colour of their neighbours further inside.
    pub fn new(texture: &Texture, grid: &LayoutGrid) -> Self {
        let mut colors = match texture.texels() {
            Texels::U8(values) => averaged(texture, values, grid),
            Texels::U16(values) => averaged(texture, values, grid),
            Texels::F32(values) => averaged(texture, values, grid),
        };
        let Rings { order, ring } = Rings::new(grid);
        // From the inside out, so that each ring reads a finished inner ring.
        for texel in order.into_iter().rev() {
            let (mut sum, mut opacity, mut count) = ([0.0; 3], 0.0, 0.0);
            for near in grid.beside(texel).into_iter().filter(|&near| near != NONE) {
                let near = near as usize;
                if ring[near] > ring[texel as usize] {
                    for (sum, value) in sum.iter_mut().zip(colors.rgb[near]) {
                        *sum += value * colors.known[near];
                    }
                    opacity += colors.known[near];
                    count += 1.0;
                }
            }
            if count > 0.0 {
                colors.known[texel as usize] = opacity / count;
            }
            if opacity > 0.0 {
                colors.rgb[texel as usize] = sum.map(|sum| sum / opacity);
            }
        }
        colors
    }
}

/// The texels along the edges of islands, in rings from the edge inwards.
struct Rings {
    order: Vec<u32>,
    /// The ring of each texel; `u8::MAX` further inside.
    ring: Vec<u8>,
}

impl Rings {
    /// Number of rings. In the worst case background reaches this many texels into an island.
    const COUNT: u8 = 3;

    fn new(grid: &LayoutGrid) -> Self {
        const INNER: u8 = u8::MAX;
        let texels = 0..grid.size().texels() as u32;
        let mut ring = vec![INNER; texels.len()];
        let is_edge = |&texel: &u32| grid.is_at_edge(texel) && grid.faces()[texel as usize] != NONE;
        let mut order: Vec<u32> = texels.filter(is_edge).collect();
        order.iter().for_each(|&texel| ring[texel as usize] = 0);
        let mut next = 0;
        while let Some(&texel) = order.get(next) {
            next += 1;
            let further = ring[texel as usize] + 1;
            if further == Self::COUNT {
                continue;
            }
            for near in grid.beside(texel).into_iter().filter(|&near| near != NONE) {
                if ring[near as usize] == INNER {
                    ring[near as usize] = further;
                    order.push(near);
                }
            }
        }
        Self { order, ring }
    }
}

/// The mean of the source texels that each grid texel spans; 0 where there is no triangle.
fn averaged<T: Value>(texture: &Texture, values: &[T], grid: &LayoutGrid) -> GridColors {
    let channels = texture.channels();
    let is_plain = channels.has_color() && !channels.has_alpha() && texture.depth() != Depth::F32;
    let is_linear = texture.encoding() == crate::color::Encoding::Linear;
    let from = texture.size();
    let size = grid.size();
    let columns: Vec<Vec<u32>> =
        (0..size.width).map(|x| samples(x, from.width, size.width)).collect();
    let mut colors =
        GridColors { rgb: vec![[0.0; 3]; size.texels()], known: vec![0.0; size.texels()] };
    let side = size.width as usize;
    let rows = colors.rgb.chunks_mut(side).zip(colors.known.chunks_mut(side));
    for_each(rows, |y, (rgb, known)| {
        let row = from.width as usize * channels.count();
        let rows = samples(y as u32, from.height, size.height);
        let rows: Vec<&[T]> =
            rows.into_iter().map(|at| &values[at as usize * row..][..row]).collect();
        let sums = if is_plain { sums(&rows) } else { Vec::new() };
        for x in (0..side).filter(|&x| grid.face[y * side + x] != NONE) {
            (rgb[x], known[x]) = if is_plain {
                (plain_mean::<T>(&sums, rows.len(), &columns[x]), 1.0)
            } else {
                weighted_mean(&rows, &columns[x], channels)
            };
            if is_linear {
                rgb[x] = rgb[x].map(crate::color::srgb_from_linear);
            }
        }
    });
    colors
}

/// The element-wise sum of rows.
fn sums<T: Value>(rows: &[&[T]]) -> Vec<f32> {
    let mut sums = vec![0.0; rows.first().map_or(0, |row| row.len())];
    for row in rows {
        for (sum, value) in sums.iter_mut().zip(*row) {
            *sum += value.to_level();
        }
    }
    sums
}

/// The mean of opaque colours of an integer texture.
///
/// - `sums`: the element-wise sum of `rows` rows.
fn plain_mean<T: Value>(sums: &[f32], rows: usize, columns: &[u32]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for &column in columns {
        for (sum, value) in sum.iter_mut().zip(&sums[3 * column as usize..][..3]) {
            *sum += value;
        }
    }
    let scale = 1.0 / ((rows * columns.len()) as f32 * T::ONE.to_level());
    sum.map(|sum| sum * scale)
}

/// The alpha-weighted mean of colours, and their mean alpha. Texels with values that are not finite
/// count as transparent.
fn weighted_mean<T: Value>(rows: &[&[T]], columns: &[u32], channels: Channels) -> ([f32; 3], f32) {
    let count = channels.count();
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for row in rows {
        for &column in columns {
            let texel = &row[column as usize * count..][..count];
            let value = |k: usize| texel[k].to_unit();
            let rgb = if channels.has_color() { [0, 1, 2].map(value) } else { [value(0); 3] };
            let opacity = if channels.has_alpha() { value(count - 1) } else { 1.0 };
            if opacity > 0.0 && opacity.is_finite() && rgb.iter().all(|value| value.is_finite()) {
                for (sum, value) in sum.iter_mut().zip(rgb) {
                    *sum += value * opacity;
                }
                total += opacity;
            }
        }
    }
    if total <= 0.0 {
        return ([0.0; 3], 0.0);
    }
    (sum.map(|sum| sum / total), total / (rows.len() * columns.len()) as f32)
}

/// Up to [`MAX_SAMPLES`] evenly spaced rows or columns of the source (of which there are `from`)
/// that row or column `index` of the grid (of which there are `to`) spans.
fn samples(index: u32, from: u32, to: u32) -> Vec<u32> {
    let [first, end] =
        [index, index + 1].map(|index| (u64::from(index) * u64::from(from) / u64::from(to)) as u32);
    let end = end.max(first + 1);
    let count = (end - first).min(MAX_SAMPLES);
    (0..count).map(|k| first + (2 * k + 1) * (end - first) / (2 * count)).collect()
}
