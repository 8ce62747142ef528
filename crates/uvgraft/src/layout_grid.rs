//! The layout of a mesh as a coarse grid of texels that know what is beside them on the surface.
//!
//! Segmenting a texture needs connectivity: what hangs together, and across how large a step of colour. In the image
//! alone islands would cut that apart, so texels at UV seams are linked to those on the other side.

use crate::edges::Edges;
use crate::islands::Islands;
use crate::map::{MapOptions, SamplingMap, corners_px};
use crate::mesh::Mesh;
use crate::texture::{Size, Texels, Texture};
use crate::threads::{for_each, map_indices};

/// No texel, or no triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// The texels of a grid over a layout, numbered row by row.
#[derive(Debug, Clone)]
pub(crate) struct LayoutGrid {
    size: Size,
    /// The triangle at each texel's centre.
    face: Vec<u32>,
    /// The weights of that triangle's first two corners.
    weights: Vec<[f32; 2]>,
    /// The texels to the left, right, above and below, on the same island.
    beside: Vec<[u32; 4]>,
    /// Texels that are beside each other across a UV seam, both ways, sorted.
    across: Vec<(u32, u32)>,
    /// `texels + 1` offsets into `across`.
    across_starts: Vec<u32>,
}

impl LayoutGrid {
    /// Rasterises a layout.
    pub fn new(mesh: &Mesh, size: Size) -> Self {
        let map = SamplingMap::of_layout(mesh, size, &MapOptions::with_gutter(0));
        let mut face = vec![NONE; size.texels()];
        for y in 0..size.height {
            for run in map.row(y) {
                let first = (y * size.width + run.x) as usize;
                face[first..first + run.len as usize].fill(map.patches()[run.patch as usize].face);
            }
        }
        let width = size.width as usize;
        let weights = map_indices(size.height as usize, |y| {
            let row = &face[y * width..][..width];
            let weight = |(x, &face): (usize, &u32)| {
                if face == NONE {
                    return [0.0; 2];
                }
                barycentric(corners_px(mesh, face as usize, size), [x as f64 + 0.5, y as f64 + 0.5])
            };
            row.iter().enumerate().map(weight).collect::<Vec<_>>()
        })
        .concat();
        let islands = Islands::new(mesh);
        let island = |texel: usize| match face[texel] {
            NONE => NONE,
            face => islands.of_faces()[face as usize],
        };
        let height = size.height as usize;
        let beside = (0..size.texels())
            .map(|texel| {
                let (x, y) = (texel % width, texel / width);
                let near = [
                    (x > 0).then(|| texel - 1),
                    (x + 1 < width).then(|| texel + 1),
                    (y > 0).then(|| texel - width),
                    (y + 1 < height).then(|| texel + width),
                ];
                let here = island(texel);
                near.map(|near| match near {
                    Some(near) if here != NONE && island(near) == here => near as u32,
                    _ => NONE,
                })
            })
            .collect();
        let mut grid =
            Self { size, face, weights, beside, across: Vec::new(), across_starts: Vec::new() };
        grid.link_seams(mesh);
        grid
    }

    /// How large the grid is.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The triangle at each texel, or [`NONE`].
    pub fn faces(&self) -> &[u32] {
        &self.face
    }

    /// The texels to the left, right, above and below one on the same island, or [`NONE`].
    pub fn beside(&self, texel: u32) -> [u32; 4] {
        self.beside[texel as usize]
    }

    /// The texels beside one across a UV seam.
    pub fn across(&self, texel: u32) -> impl Iterator<Item = u32> + '_ {
        let range = self.across_starts[texel as usize] as usize
            ..self.across_starts[texel as usize + 1] as usize;
        self.across[range].iter().map(|&(_, other)| other)
    }

    /// The texels beside one on the surface.
    pub fn neighbours(&self, texel: u32) -> impl Iterator<Item = u32> + '_ {
        self.beside(texel).into_iter().filter(|&near| near != NONE).chain(self.across(texel))
    }

    /// Values at the vertices of the mesh, linear over its triangles, at the texels; 0 where there is no triangle.
    pub fn at_texels(&self, mesh: &Mesh, values: &[f32]) -> Vec<f32> {
        let width = self.size.width as usize;
        map_indices(self.size.height as usize, |y| {
            let row = y * width..(y + 1) * width;
            row.map(|texel| self.at_texel(mesh, values, texel)).collect::<Vec<_>>()
        })
        .concat()
    }

    /// As [`LayoutGrid::at_texels`], at one of them.
    pub fn at_texel(&self, mesh: &Mesh, values: &[f32], texel: usize) -> f32 {
        let face = self.face[texel];
        if face == NONE {
            return 0.0;
        }
        let [a, b] = self.weights[texel];
        let [x, y, z] = mesh.faces()[face as usize].map(|vertex| values[vertex as usize]);
        x * a + y * b + z * (1.0 - a - b)
    }

    /// Whether an island ends beside a texel.
    pub fn is_at_edge(&self, texel: u32) -> bool {
        self.beside[texel as usize].contains(&NONE)
    }

    fn link_seams(&mut self, mesh: &Mesh) {
        let edges = Edges::new(mesh);
        let mut links = Vec::new();
        for edge in &edges.shared {
            let [mut a, b] = edge.halves.map(|half| ends_uv(mesh, half));
            if edge.opposed {
                a.swap(0, 1);
            }
            if a == b {
                continue;
            }
            let steps = [a, b].map(|ends| self.length_px(ends)).into_iter().fold(0.0, f64::max);
            let steps = (steps.ceil() as usize).clamp(1, 4096);
            let faces = edge.halves.map(|half| half / 3);
            for step in 0..steps {
                let along = (step as f64 + 0.5) / steps as f64;
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
            starts[from as usize + 1] += 1;
        }
        for texel in 0..self.size.texels() {
            starts[texel + 1] += starts[texel];
        }
        (self.across, self.across_starts) = (links, starts);
    }

    fn length_px(&self, [from, to]: [[f64; 2]; 2]) -> f64 {
        let size = [self.size.width, self.size.height].map(f64::from);
        (0..2).map(|k| ((to[k] - from[k]) * size[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// The texel of a triangle's island that is nearest to a place on one of its edges, among those that touch it.
    fn near(&self, mesh: &Mesh, ends: [[f64; 2]; 2], face: u32, along: f64) -> Option<u32> {
        let size = [self.size.width, self.size.height].map(f64::from);
        let middle = {
            let uv = mesh.uv_triangle(face as usize).map(|uv| uv.map(f64::from));
            [0, 1].map(|k| uv.iter().map(|uv| uv[k]).sum::<f64>() / 3.0)
        };
        let on_edge = [0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) * along);
        let inward = [0, 1].map(|k| (middle[k] - on_edge[k]) * size[k]);
        let length = inward[0].hypot(inward[1]).max(1e-12);
        // Centres of texels lie up to 0.7 of a texel inside.
        [0.3, 0.8, 1.4].into_iter().find_map(|px: f64| {
            let at = [0, 1].map(|k| on_edge[k] * size[k] + inward[k] / length * px.min(length));
            let is_in = at.iter().zip(size).all(|(&at, size)| (0.0..size).contains(&at));
            let texel = is_in.then(|| at[1] as u32 * self.size.width + at[0] as u32)?;
            (self.face[texel as usize] != NONE).then_some(texel)
        })
    }
}

/// Where the ends of a triangle's edge are in the layout.
fn ends_uv(mesh: &Mesh, half: u32) -> [[f64; 2]; 2] {
    let (face, corner) = (half as usize / 3, half as usize % 3);
    let uv = mesh.uv_triangle(face);
    [uv[corner], uv[(corner + 1) % 3]].map(|uv| uv.map(f64::from))
}

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

/// The colours of a texture at the texels of a grid: sRGB values as stored, 1.0 for full.
#[derive(Debug, Clone)]
pub(crate) struct GridColors {
    pub rgb: Vec<[f32; 3]>,
    /// How much there is of the texture: opacity, 0 where values are not finite.
    pub known: Vec<f32>,
}

/// In each direction at most so many texels of the texture are averaged for one of the grid.
const MOST_SAMPLES: u32 = 4;

impl GridColors {
    /// Averages what the texels of a grid span. What lies beside islands bleeds into those at their edges, which take
    /// the colour of the others around.
    pub fn new(texture: &Texture, grid: &LayoutGrid) -> Self {
        let mut colors = match texture.texels() {
            Texels::U8(values) => averaged(texture, grid, |index| f32::from(values[index]) / 255.0),
            Texels::U16(values) => {
                averaged(texture, grid, |index| f32::from(values[index]) / 65535.0)
            }
            Texels::F32(values) => averaged(texture, grid, |index| values[index]),
        };
        // From the inside out, so that each ring finds its inner one done.
        for (texel, inner) in rings(grid).into_iter().rev() {
            let (mut sum, mut opacity) = ([0.0; 3], 0.0);
            for &near in &inner {
                for (sum, value) in sum.iter_mut().zip(colors.rgb[near as usize]) {
                    *sum += value * colors.known[near as usize];
                }
                opacity += colors.known[near as usize];
            }
            colors.known[texel as usize] = opacity / inner.len() as f32;
            if opacity > 0.0 {
                colors.rgb[texel as usize] = sum.map(|sum| sum / opacity);
            }
        }
        colors
    }
}

/// So many texels at the edges of islands are what lies beside them, at worst.
const BLEEDING: u8 = 3;

/// The texels at the edges of islands, ring by ring inwards, each with those beside it on the next ring.
fn rings(grid: &LayoutGrid) -> Vec<(u32, Vec<u32>)> {
    const INNER: u8 = u8::MAX;
    let texels = grid.size().texels() as u32;
    let mut ring = vec![INNER; texels as usize];
    let mut order: Vec<u32> = (0..texels)
        .filter(|&texel| grid.faces()[texel as usize] != NONE && grid.is_at_edge(texel))
        .collect();
    order.iter().for_each(|&texel| ring[texel as usize] = 0);
    let mut next = 0;
    while let Some(&texel) = order.get(next) {
        next += 1;
        let further = ring[texel as usize] + 1;
        if further == BLEEDING {
            continue;
        }
        for near in grid.beside(texel).into_iter().filter(|&near| near != NONE) {
            if ring[near as usize] == INNER {
                ring[near as usize] = further;
                order.push(near);
            }
        }
    }
    let with_inner = |texel: u32| {
        let inner = grid.beside(texel).into_iter().filter(|&near| near != NONE);
        let inner = inner.filter(|&near| ring[near as usize] > ring[texel as usize]);
        (texel, inner.collect::<Vec<u32>>())
    };
    order.into_iter().map(with_inner).filter(|(_, inner)| !inner.is_empty()).collect()
}

/// What a grid's texels span of a texture; nothing where there is no triangle.
fn averaged(
    texture: &Texture,
    grid: &LayoutGrid,
    value: impl Fn(usize) -> f32 + Sync,
) -> GridColors {
    let channels = texture.channels();
    let count = channels.count();
    let is_linear = texture.encoding() == crate::color::Encoding::Linear;
    let Size { width, height } = texture.size();
    let size = grid.size();
    let columns: Vec<Vec<u32>> = (0..size.width).map(|x| samples(x, width, size.width)).collect();
    let average = |columns: &[u32], rows: &[u32]| {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for &row in rows {
            for &column in columns {
                let at = (row as usize * width as usize + column as usize) * count;
                let rgb: [f32; 3] = if channels.has_color() {
                    std::array::from_fn(|k| value(at + k))
                } else {
                    [value(at); 3]
                };
                let opacity = if channels.has_alpha() { value(at + count - 1) } else { 1.0 };
                if opacity > 0.0 && opacity.is_finite() && rgb.iter().all(|value| value.is_finite())
                {
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
        let rgb = sum.map(|sum| sum / total);
        let rgb = if is_linear { rgb.map(crate::color::srgb_from_linear) } else { rgb };
        (rgb, total / (rows.len() * columns.len()) as f32)
    };
    let mut colors =
        GridColors { rgb: vec![[0.0; 3]; size.texels()], known: vec![0.0; size.texels()] };
    let side = size.width as usize;
    let rows = colors.rgb.chunks_mut(side).zip(colors.known.chunks_mut(side));
    for_each(rows, |y, (rgb, known)| {
        let rows = samples(y as u32, height, size.height);
        for x in 0..side {
            if grid.face[y * side + x] != NONE {
                (rgb[x], known[x]) = average(&columns[x], &rows);
            }
        }
    });
    colors
}

/// Which rows or columns of `from` the one at an index of `to` spans, some of them.
fn samples(index: u32, from: u32, to: u32) -> Vec<u32> {
    let [first, end] =
        [index, index + 1].map(|index| (u64::from(index) * u64::from(from) / u64::from(to)) as u32);
    let end = end.max(first + 1);
    let count = (end - first).min(MOST_SAMPLES);
    (0..count).map(|k| first + (2 * k + 1) * (end - first) / (2 * count)).collect()
}
