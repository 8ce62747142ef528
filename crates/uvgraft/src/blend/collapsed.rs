//! Mouth interiors that collapse almost to a line in the layout that textures are read from.
//!
//! A closed mouth is a slit in one layout and an open circle in the other: each texel of the slit
//! would be smeared across the whole circle as a shard. The texture says nothing about such a part
//! beyond the colours around it, so the part is filled smoothly from those.

use std::sync::Arc;

use uvgraft_surface::anatomy::Area;
use uvgraft_surface::mesh::doubled_area;
use uvgraft_surface::piece::wide;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::surface::Surface;
use uvgraft_surface::threads::for_each_chunk;

use super::controls::VALUES;
use super::field::LinearValue;
use super::selection::BlendDomain;
use crate::map::SamplingMap;
use crate::sampler::Sampler;
use crate::texture::{Channels, Size, Texture, Value};

/// Least anisotropy, as of [`anisotropy`], of the triangles that a part starts from. Origin not
/// recorded.
const SEED_RATIO: f64 = 64.0;
/// Least anisotropy of the triangles that it grows over. Origin not recorded.
const GROWTH_RATIO: f64 = 8.0;
/// Parts below this fraction of all texels are left alone: shards of a few texels are invisible.
const MIN_SHARE: f64 = 5e-4;
/// Sweeps over the points inside a part: enough for rings of ten points.
const SWEEPS: usize = 400;

/// Mouth interiors that collapse in the source's layout, on a map's target.
#[derive(Debug)]
pub(crate) struct Collapsed {
    map: Arc<SamplingMap>,
    /// For each triangle of the target, whether it belongs to such a part.
    faces: Vec<bool>,
    /// The points of the parts.
    points: Vec<Point>,
    /// The points of each triangle that belongs to a part, as indices into `points`.
    corners: Vec<[u32; 3]>,
}

/// A point of a part.
#[derive(Debug, Clone, Default)]
struct Point {
    /// Where textures are sampled next to the part, as UV coordinates; empty for points inside it.
    around: Vec<[f64; 2]>,
    /// The points that it shares an edge with; once for each triangle at the edge.
    adjacent: Vec<u32>,
}

/// The smooth colours of the parts, from one texture.
#[derive(Debug)]
pub(crate) struct Smooth {
    of: Arc<Collapsed>,
    /// For each patch of the map that belongs to a part, red, green and blue; 1.0 is full
    /// intensity.
    values: Vec<Option<[LinearValue; 3]>>,
}

impl Collapsed {
    /// Finds the parts; `None` if there are none.
    ///
    /// A part grows by hysteresis: from triangles of the mouth with an anisotropy of at least
    /// [`SEED_RATIO`], over adjacent ones with at least [`GROWTH_RATIO`], and takes in what it
    /// encloses. Its points then form a graph, with colour samples at the points where it
    /// meets the rest of the surface.
    pub fn new(domain: &BlendDomain, map: &Arc<SamplingMap>, source: Size) -> Option<Self> {
        let mut faces = shards(domain, map.size(), source)?;
        if !faces.contains(&true) {
            return None;
        }
        enclose(domain.surface(), &mut faces);
        let (points, corners) = graph(domain, &faces);
        Some(Self { map: Arc::clone(map), faces, points, corners })
    }

    /// Computes the smooth colours of the parts from a texture.
    ///
    /// Points at the edge of a part take the mean of the samples around it. Each point inside
    /// relaxes to the mean of its neighbours (Laplace's equation on the graph, by Gauss-Seidel
    /// sweeps), so colours blend across the part without an edge.
    ///
    /// - `texture`: in the working format.
    pub fn smooth(self: &Arc<Self>, domain: &BlendDomain, texture: &Texture) -> Smooth {
        let sampler = Sampler::new(texture);
        let mean = |point: &Point| {
            let mut sum = [0.0; 3];
            for &uv in &point.around {
                let [r, g, b, _] = sampler.rgba(uv);
                for (sum, value) in sum.iter_mut().zip([r, g, b]) {
                    *sum += value / point.around.len() as f32;
                }
            }
            sum
        };
        let mut colors: Vec<[f32; 3]> = self.points.iter().map(mean).collect();
        let known: Vec<[f32; 3]> = (0..colors.len())
            .filter(|&point| !self.points[point].around.is_empty())
            .map(|point| colors[point])
            .collect();
        let overall = [0, 1, 2]
            .map(|k| known.iter().map(|rgb| rgb[k]).sum::<f32>() / known.len().max(1) as f32);
        let within: Vec<usize> =
            (0..colors.len()).filter(|&point| self.points[point].around.is_empty()).collect();
        within.iter().for_each(|&point| colors[point] = overall);
        for _ in 0..SWEEPS {
            for &point in &within {
                let adjacent = &self.points[point].adjacent;
                let sum = |k: usize| adjacent.iter().map(|&at| colors[at as usize][k]).sum::<f32>();
                colors[point] = [0, 1, 2].map(|k| sum(k) / adjacent.len() as f32);
            }
        }
        let values = self.map.patches().iter().map(|patch| {
            let face = patch.face as usize;
            self.faces[face].then(|| {
                let corners_px = corners_px(domain.mesh(), face, self.map.size());
                let of_corners = self.corners[face].map(|point| colors[point as usize]);
                [0, 1, 2].map(|k| LinearValue::new(corners_px, of_corners.map(|rgb| rgb[k])))
            })
        });
        Smooth { of: Arc::clone(self), values: values.collect() }
    }
}

/// For each triangle, whether it belongs to a part that grew from a seed and is large enough; `None`
/// without an anatomy.
fn shards(domain: &BlendDomain, size: Size, source: Size) -> Option<Vec<bool>> {
    let anatomy = domain.anatomy()?;
    let surface = domain.surface();
    let triangles = surface.triangles();
    let areas = [Area::MouthInterior, Area::Lips].map(|area| anatomy.area(area));
    // Behind the ears there are such triangles too, with real detail between them.
    let of_mouth = |face: usize| {
        let corners = domain.mesh().faces()[face].map(|vertex| vertex as usize);
        corners.iter().map(|&vertex| areas[0][vertex].max(areas[1][vertex])).sum::<f32>() / 3.0
    };
    let anisotropy_of = |face: usize| {
        if of_mouth(face) > 0.0 { anisotropy(domain, face, size, source) } else { 1.0 }
    };
    let anisotropy: Vec<f64> = (0..triangles.len()).map(anisotropy_of).collect();
    let mut faces = vec![false; triangles.len()];
    let mut is_known = faces.clone();
    for first in 0..triangles.len() {
        let begins = anisotropy[first] >= SEED_RATIO && of_mouth(first) >= 0.5;
        if !begins || std::mem::replace(&mut is_known[first], true) {
            continue;
        }
        let (mut part, mut next) = (vec![first as u32], 0);
        while let Some(&face) = part.get(next) {
            next += 1;
            for &other in triangles[face as usize].iter().flat_map(|&at| surface.around(at)) {
                if anisotropy[other as usize] >= GROWTH_RATIO
                    && !std::mem::replace(&mut is_known[other as usize], true)
                {
                    part.push(other);
                }
            }
        }
        let area = |face: u32| doubled_area(corners_px(domain.mesh(), face as usize, size));
        let texels = 0.5 * part.iter().map(|&face| area(face).abs()).sum::<f64>();
        if texels >= MIN_SHARE * size.texels() as f64 {
            part.into_iter().for_each(|face| faces[face as usize] = true);
        }
    }
    Some(faces)
}

/// Adds enclosed triangles to the parts: one whose points are collinear by chance still lies between
/// shards.
fn enclose(surface: &Surface, faces: &mut [bool]) {
    let triangles = surface.triangles();
    let mut is_of_part = vec![false; surface.positions().len()];
    for face in (0..triangles.len()).filter(|&face| faces[face]) {
        triangles[face].iter().for_each(|&point| is_of_part[point as usize] = true);
    }
    for (face, corners) in faces.iter_mut().zip(triangles) {
        *face |= corners.iter().all(|&point| is_of_part[point as usize]);
    }
}

/// The points of the parts, and those of each triangle that belongs to one.
fn graph(domain: &BlendDomain, faces: &[bool]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let surface = domain.surface();
    let triangles = surface.triangles();
    let mut indices = vec![u32::MAX; surface.positions().len()];
    let mut points: Vec<Point> = Vec::new();
    let mut corners = vec![[0; 3]; triangles.len()];
    let read = domain.pair().from(domain.direction());
    for face in (0..triangles.len()).filter(|&face| faces[face]) {
        corners[face] = triangles[face].map(|point| {
            let index = &mut indices[point as usize];
            if *index == u32::MAX {
                *index = points.len() as u32;
                let beyond = surface.around(point).iter().filter(|&&face| !faces[face as usize]);
                let pieces = beyond.flat_map(|&face| domain.pieces().of_face(face as usize));
                let around = pieces.map(|&piece| domain.centroid(piece, read)).collect();
                points.push(Point { around, adjacent: Vec::new() });
            }
            *index
        });
        let [a, b, c] = corners[face];
        for (from, to) in [(a, b), (b, c), (c, a)] {
            points[from as usize].adjacent.push(to);
            points[to as usize].adjacent.push(from);
        }
    }
    (points, corners)
}

impl Smooth {
    /// Writes the colours of the parts into some rows; alpha and all other texels stay.
    pub fn lay<T: Value>(&self, channels: Channels, first_row: u32, rows: &mut [T]) {
        let count = channels.count();
        let colors = if channels.has_color() { 3 } else { 1 };
        let map = &self.of.map;
        let one = T::ONE.to_level();
        for_each_chunk(rows, map.size().width as usize * count, |index, texels| {
            let row = first_row + index as u32;
            for run in map.row(row) {
                let Some(values) = &self.values[run.patch as usize] else { continue };
                let part = run.x as usize * count..(run.x + run.len) as usize * count;
                for (channel, value) in values.iter().take(colors).enumerate() {
                    let line = value.line(run.x, row);
                    let texels = texels[part.clone()].chunks_exact_mut(count);
                    for (k, texel) in (0..).zip(texels) {
                        texel[channel] = T::from_level(line.at(k) * one);
                    }
                }
            }
        });
    }

    /// Sets the controls of the parts' texels in some rows to those of the surroundings of a mouth:
    /// half of the tone, as lips have, and full transfer.
    pub fn settle(&self, first_row: u32, controls: &mut [u8]) {
        let map = &self.of.map;
        for_each_chunk(controls, map.size().width as usize * VALUES, |index, texels| {
            for run in map.row(first_row + index as u32) {
                if self.values[run.patch as usize].is_some() {
                    let part = run.x as usize * VALUES..(run.x + run.len) as usize * VALUES;
                    texels[part].as_chunks_mut::<VALUES>().0.fill([128, 255]);
                }
            }
        });
    }
}

/// The anisotropy of the mapping from a target triangle to the source, in texels: how much longer
/// than wide the image of a circle is, the ratio of the singular values of the Jacobian. 1 for a
/// triangle that is not transferred whole.
fn anisotropy(domain: &BlendDomain, face: usize, target: Size, source: Size) -> f64 {
    let &[piece] = domain.pieces().of_face(face) else { return 1.0 };
    if domain.pieces().part(piece).is_some() {
        return 1.0;
    }
    let read = domain.pair().from(domain.direction());
    let to = corners_px(domain.mesh(), face, target);
    let scale = [f64::from(source.width), f64::from(source.height)];
    let from = domain.pieces().at_corners(piece, wide(read.uv_triangle(piece.from as usize)));
    let from = from.map(|uv| [0, 1].map(|k| uv[k] * scale[k]));
    let edges = |corners: [[f64; 2]; 3]| {
        [1, 2].map(|k| [0, 1].map(|axis| corners[k][axis] - corners[0][axis]))
    };
    let ([p, q], [u, v]) = (edges(to), edges(from));
    let area = p[0] * q[1] - p[1] * q[0];
    if area == 0.0 {
        return 1.0;
    }
    // The Jacobian; `greatest` is its larger singular value squared, `product` the product of both.
    let column = |a: f64, b: f64| [0, 1].map(|axis| (u[axis] * a + v[axis] * b) / area);
    let (x, y) = (column(q[1], -p[1]), column(-q[0], p[0]));
    let squares = x[0] * x[0] + x[1] * x[1] + y[0] * y[0] + y[1] * y[1];
    let product = (x[0] * y[1] - x[1] * y[0]).abs();
    let greatest = 0.5 * (squares + (squares * squares - 4.0 * product * product).max(0.0).sqrt());
    if greatest > 0.0 { greatest / product.max(1e-9 * greatest) } else { 1.0 }
}
