//! Fills the rims of eyeballs in a texture.
//!
//! The rims lie behind the lids, where captures see nothing: their texels hold whatever is next to
//! the island, such as background or the edge of the image. Where both eyes share one disc of the
//! other layout, or that disc is slightly larger, this shows as a crescent. So rims are filled with
//! the colours inside them.

use std::ops::Range;

use uvgraft_surface::anatomy::Area;
use uvgraft_surface::islands::Islands;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::{ScanTriangle, corners_px};

use super::selection::BlendDomain;
use crate::texture::{Size, TexelsMut, Texture, Value};

/// The rim texels, from the inside out, for textures of one size.
#[derive(Debug, Clone)]
pub(crate) struct EyeRims {
    /// Each texel with its neighbours farther inside; [`NONE`] in place of missing ones.
    texels: Vec<(u32, [u32; 4])>,
}

const NONE: u32 = u32::MAX;

/// Width of a rim as a fraction of the texture's longer side: four texels of a capture of 512.
const MAX_WIDTH: f64 = 1.0 / 128.0;

/// Upper limit of that width, as a fraction of the island's radius. Origin not recorded.
const MAX_SHARE: f64 = 0.35;

impl EyeRims {
    /// Finds the rims in the layout that textures are read from; `None` if no island
    /// belongs to eyeballs alone.
    pub fn new(domain: &BlendDomain, size: Size) -> Option<Self> {
        let head = domain.head()?;
        let mesh = domain.pair().from(domain.direction());
        let eyes = head.anatomy.area(Area::Eyes);
        let is_eye = |face: usize| {
            mesh.faces()[face].iter().all(|&vertex| eyes[vertex as usize] >= 0.5)
                && !mesh.is_outside(face)
        };
        let islands = Islands::new(mesh);
        let mut faces: Vec<Option<Vec<usize>>> = vec![Some(Vec::new()); islands.count()];
        for (face, &island) in islands.of_faces().iter().enumerate() {
            let of_island = &mut faces[island as usize];
            if is_eye(face) {
                of_island.iter_mut().for_each(|faces| faces.push(face));
            } else {
                *of_island = None;
            }
        }
        let found = faces.into_iter().flatten().filter(|faces| !faces.is_empty());
        let texels: Vec<_> = found.flat_map(|faces| rim(mesh, &faces, size)).collect();
        (!texels.is_empty()).then_some(Self { texels })
    }

    /// Fills the rims of a texture from the inside.
    ///
    /// # Panics
    /// If the texture has fewer texels than the size that the rims were made for.
    pub fn fill(&self, texture: &mut Texture) {
        let channels = texture.channels().count();
        match texture.texels_mut() {
            TexelsMut::U8(values) => self.fill_values(channels, values),
            TexelsMut::U16(values) => self.fill_values(channels, values),
            TexelsMut::F32(values) => self.fill_values(channels, values),
        }
    }

    fn fill_values<T: Value>(&self, channels: usize, values: &mut [T]) {
        for (texel, inner) in &self.texels {
            let inner = inner.iter().filter(|&&inner| inner != NONE);
            let count = inner.clone().count() as f32;
            for channel in 0..channels {
                let level = |texel: u32| values[texel as usize * channels + channel].to_level();
                let sum: f32 = inner.clone().map(|&inner| level(inner)).sum();
                values[*texel as usize * channels + channel] = T::from_level(sum / count);
            }
        }
    }
}

/// The rim of one island: the texels of its outermost rings, by erosion, each with its
/// neighbours on inner rings. Inner rings come first, so that filling in this order extends the
/// colours inside the rim outwards.
fn rim(mesh: &Mesh, faces: &[usize], size: Size) -> Vec<(u32, [u32; 4])> {
    const INSIDE: u32 = u32::MAX;
    const OUTSIDE: u32 = 0;
    let triangles =
        faces.iter().filter_map(|&face| ScanTriangle::new(corners_px(mesh, face, size), size));
    let spans: Vec<(u32, Range<u32>)> = triangles
        .flat_map(|triangle| triangle.spans(&(0..size.height)).collect::<Vec<_>>())
        .filter(|(_, span)| !span.is_empty())
        .collect();
    let Some(left) = spans.iter().map(|(_, span)| span.start).min() else { return Vec::new() };
    let right = spans.iter().map(|(_, span)| span.end).max().unwrap_or(left);
    let top = spans.iter().map(|(row, _)| *row).min().unwrap_or(0);
    let bottom = spans.iter().map(|(row, _)| row + 1).max().unwrap_or(top);
    // A frame of one texel, so that every texel has four neighbours.
    let width = (right - left) as usize + 2;
    let mut ring = vec![OUTSIDE; width * ((bottom - top) as usize + 2)];
    for (row, span) in spans {
        let first = (row - top + 1) as usize * width + 1;
        let columns = (span.start - left) as usize..(span.end - left) as usize;
        ring[first + columns.start..first + columns.end].fill(INSIDE);
    }
    let adjacent = |texel: usize| [texel - 1, texel + 1, texel - width, texel + width];
    let inside: Vec<usize> = (0..ring.len()).filter(|&texel| ring[texel] == INSIDE).collect();
    let radius = (inside.len() as f64 / std::f64::consts::PI).sqrt();
    let side = f64::from(size.width.max(size.height));
    let rings = (MAX_WIDTH * side).min(MAX_SHARE * radius).round() as u32;
    let mut order: Vec<usize> = Vec::new();
    let mut edge = inside;
    edge.retain(|&texel| adjacent(texel).into_iter().any(|near| ring[near] == OUTSIDE));
    for number in 1..=rings {
        edge.iter().for_each(|&texel| ring[texel] = number);
        let mut next: Vec<usize> = edge.iter().flat_map(|&texel| adjacent(texel)).collect();
        next.retain(|&texel| ring[texel] == INSIDE);
        next.sort_unstable();
        next.dedup();
        order.append(&mut edge);
        edge = next;
    }
    let index = |texel: usize| {
        let (x, y) = ((texel % width - 1) as u32 + left, (texel / width - 1) as u32 + top);
        y * size.width + x
    };
    let with_inner = |texel: usize| {
        let inner =
            adjacent(texel).map(|near| if ring[near] > ring[texel] { index(near) } else { NONE });
        (index(texel), inner)
    };
    let rim = order.into_iter().rev().map(with_inner);
    rim.filter(|(_, inner)| inner.iter().any(|&inner| inner != NONE)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::texture::{Channels, Texels};

    /// A disc of a hundred texels across in a texture of 512.
    fn disc() -> Mesh {
        let corner = |k: usize| {
            let (sin, cos) = (k as f32 / 64.0 * std::f32::consts::TAU).sin_cos();
            [0.3 + 0.1 * cos, 0.4 + 0.1 * sin]
        };
        let mut uv: Vec<[f32; 2]> = (0..64).map(corner).collect();
        uv.push([0.3, 0.4]);
        let faces: Vec<[u32; 3]> = (0..64).map(|k| [k, (k + 1) % 64, 64]).collect();
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    }

    #[test]
    fn rims_are_filled_from_inside() {
        let (mesh, size) = (disc(), Size::square(512));
        let faces: Vec<usize> = (0..mesh.faces().len()).collect();
        let rims = EyeRims { texels: rim(&mesh, &faces, size) };
        let from_centre = |x: u32, y: u32| {
            let at = [f64::from(x) + 0.5 - 0.3 * 512.0, f64::from(y) + 0.5 - 0.4 * 512.0];
            at[0].hypot(at[1])
        };
        // Red on the rim and outside.
        let mut levels = Vec::new();
        for y in 0..512 {
            for x in 0..512 {
                let is_red = from_centre(x, y) > 51.2 - 2.0;
                levels.extend(if is_red { [255_u8, 0, 0] } else { [90, 100, 110] });
            }
        }
        let texels = Texels::U8(levels);
        let before = Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap();
        let mut after = before.clone();
        rims.fill(&mut after);
        for y in 0..512 {
            for x in 0..512 {
                let [found, was] = [&after, &before].map(|texture| texture.get(x, y, 0));
                if from_centre(x, y) < 50.5 {
                    assert_eq!(found, 90.0 / 255.0, "{x}, {y}");
                } else if from_centre(x, y) > 52.0 {
                    assert_eq!(found, was, "{x}, {y}");
                }
            }
        }
    }

    #[test]
    fn small_islands_keep_their_interior() {
        let mesh = disc();
        let faces: Vec<usize> = (0..mesh.faces().len()).collect();
        for side in [1, 2, 8, 16, 64] {
            let size = Size::square(side);
            let inside = std::f64::consts::PI * (0.1 * f64::from(side)).powi(2);
            assert!((rim(&mesh, &faces, size).len() as f64) < 0.7 * inside.max(1.0), "{side}");
        }
    }
}
