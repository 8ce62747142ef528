//! Eyes that share an island: one of them is moved to free space of the layout.

use std::collections::HashMap;

use glam::Vec3;
use uvgraft::sampler::{Beyond, bilinear};
use uvgraft::{Corner, Mesh, MeshError, Size, TexelsMut, Texture, Value};

use super::eyeball::{is_round, pieces, sphere};
use crate::atlas::{ChartRect, FreeSpace};

/// Maximum relative difference of the two eyes' radii.
const ALIKE: f32 = 0.1;

/// Two islands are the same if their bounding boxes overlap by this fraction of the smaller one.
const SHARED: f32 = 0.5;

/// Minimum scale of the moved island.
const MIN: f32 = 0.4;

/// Why eyes keep sharing their island.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SeparationError {
    /// The layout is full.
    #[error(
        "no free space in the UV layout for a second eye, which needs {wanted:.3} of its width"
    )]
    NoRoom {
        /// The minimum width that it needs, in UV units.
        wanted: f32,
    },
    /// The mesh with the added coordinates is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// A layout in which one of two eyes was moved to a separate island.
#[derive(Debug, Clone)]
pub struct SeparatedEyes {
    /// The mesh: the same vertices and triangles, in the same order.
    pub mesh: Mesh,
    /// Bounding box of the moved eye's old island: left, top, right and bottom, in UV units.
    from: [f32; 4],
    /// Its new rectangle.
    place: ChartRect,
}

impl SeparatedEyes {
    /// Finds two eyes that share an island, adjacent spheres of one size, and moves one of them.
    /// `None` if there are none, usually because each eye has its own island.
    ///
    /// # Errors
    /// [`SeparationError::NoRoom`] if the layout is full.
    pub fn find(mesh: &Mesh) -> Result<Option<Self>, SeparationError> {
        let eyes = round_pieces(mesh);
        let pair = eyes.iter().enumerate().find_map(|(k, first)| {
            let second = eyes[k + 1..].iter().find(|second| first.shares_with(second))?;
            Some((first, second))
        });
        let Some((_, moved)) = pair else { return Ok(None) };
        let [left, top, right, bottom] = moved.uv_box;
        let (width, height) = (right - left, bottom - top);
        let wanted = MIN * width;
        let place = FreeSpace::of(mesh).place(width / height, width, wanted);
        let place = place.ok_or(SeparationError::NoRoom { wanted })?;
        let mesh = moved_mesh(mesh, moved, &place)?;
        Ok(Some(Self { mesh, from: moved.uv_box, place }))
    }

    /// Copies the old island's texels to the new one, for a base texture that was made
    /// for the old layout.
    pub fn copy(&self, texture: &mut Texture) {
        let source = texture.clone();
        let Size { width, height } = texture.size();
        let channels = texture.channels().count();
        let [left, top, right, bottom] = self.from;
        let range = |from: f32, extent: f32, side: u32| {
            let first = ((from - ChartRect::GUTTER) * side as f32).floor().max(0.0) as u32;
            first..(((from + extent + ChartRect::GUTTER) * side as f32).ceil() as u32).min(side)
        };
        let columns = range(self.place.left, self.place.width, width);
        for y in range(self.place.top, self.place.height, height) {
            for x in columns.clone() {
                let uv = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
                let [s, t] = self.place.at(uv);
                let uv = [left + s * (right - left), top + t * (bottom - top)];
                let first = (y as usize * width as usize + x as usize) * channels;
                let (texel, values) = (first..first + channels, sample(&source, uv));
                match texture.texels_mut() {
                    TexelsMut::U8(texels) => put(&mut texels[texel], values),
                    TexelsMut::U16(texels) => put(&mut texels[texel], values),
                    TexelsMut::F32(texels) => put(&mut texels[texel], values),
                }
            }
        }
    }
}

fn put<T: Value>(texel: &mut [T], values: [f32; 4]) {
    texel.iter_mut().zip(values).for_each(|(texel, value)| *texel = T::from_unit(value));
}

/// All channels of a texture, followed by zeros.
fn sample(texture: &Texture, uv: [f32; 2]) -> [f32; 4] {
    let (size, channels) = (texture.size(), texture.channels().count());
    let sides = [size.width, size.height].map(f64::from);
    let at_px = [0, 1].map(|k| f64::from(uv[k]) * sides[k]);
    bilinear(size, at_px, Beyond::Edge, |x, y| {
        std::array::from_fn(|k| if k < channels { texture.get(x, y, k) } else { 0.0 })
    })
}

/// A nearly spherical connected component of a mesh.
#[derive(Debug)]
struct RoundPiece {
    center: Vec3,
    radius: f32,
    faces: Vec<usize>,
    uv_box: [f32; 4],
}

impl RoundPiece {
    fn shares_with(&self, other: &Self) -> bool {
        let [a, b] = [self.uv_box, other.uv_box];
        let sides = |k: usize| (a[k + 2].min(b[k + 2]) - a[k].max(b[k])).max(0.0);
        let area = |[left, top, right, bottom]: [f32; 4]| (right - left) * (bottom - top);
        let is_alike = (self.radius - other.radius).abs() < ALIKE * self.radius;
        let apart = self.center.distance(other.center) / self.radius;
        is_alike
            && (1.5..12.0).contains(&apart)
            && sides(0) * sides(1) > SHARED * area(a).min(area(b))
    }
}

/// The spherical components of a mesh, in the order of their first triangles.
fn round_pieces(mesh: &Mesh) -> Vec<RoundPiece> {
    const FEWEST: usize = 24;
    let pieces = pieces(mesh);
    let mut order = Vec::new();
    let mut faces: HashMap<u32, Vec<usize>> = HashMap::new();
    for (face, corners) in mesh.faces().iter().enumerate() {
        let piece = pieces[corners[0] as usize];
        let of_piece = faces.entry(piece).or_insert_with(|| {
            order.push(piece);
            Vec::new()
        });
        of_piece.push(face);
    }
    let mut found = Vec::new();
    for piece in order {
        let Some(faces) = faces.remove(&piece) else { continue };
        let mut vertices: Vec<u32> = faces.iter().flat_map(|&face| mesh.faces()[face]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.len() < FEWEST {
            continue;
        }
        let points: Vec<Vec3> =
            vertices.iter().map(|&vertex| mesh.positions()[vertex as usize].into()).collect();
        let Some((center, radius)) = sphere(&points).filter(|ball| is_round(&points, *ball)) else {
            continue;
        };
        let mut uv_box = [f32::MAX, f32::MAX, f32::MIN, f32::MIN];
        for [u, v] in faces.iter().flat_map(|&face| mesh.uv_triangle(face)) {
            let [left, top, right, bottom] = uv_box;
            uv_box = [left.min(u), top.min(v), right.max(u), bottom.max(v)];
        }
        found.push(RoundPiece { center, radius, faces, uv_box });
    }
    found
}

/// The mesh with the UV coordinates of one component moved.
fn moved_mesh(mesh: &Mesh, moved: &RoundPiece, place: &ChartRect) -> Result<Mesh, MeshError> {
    let mut is_moved = vec![false; mesh.faces().len()];
    moved.faces.iter().for_each(|&face| is_moved[face] = true);
    let [left, top, right, bottom] = moved.uv_box;
    let mut uv = mesh.uv().to_vec();
    let mut moved_uv: HashMap<u32, u32> = HashMap::new();
    let (mut corners, mut sizes) = (Vec::new(), Vec::new());
    for polygon in 0..mesh.polygon_count() {
        let own = mesh.polygon_corners(polygon);
        let is_moved = mesh.polygon(polygon).any(|face| is_moved[face]);
        sizes.push(own.len() as u32);
        corners.extend(own.into_iter().map(|corner| {
            if !is_moved {
                return corner;
            }
            let index = *moved_uv.entry(corner.uv).or_insert_with(|| {
                let [u, v] = mesh.uv()[corner.uv as usize];
                uv.push(place.uv([(u - left) / (right - left), (v - top) / (bottom - top)]));
                uv.len() as u32 - 1
            });
            Corner { uv: index, ..corner }
        }));
    }
    let moved = Mesh::from_polygons(mesh.positions().to_vec(), uv, &corners, &sizes)?;
    Ok(moved.with_parts(mesh.parts().to_vec()))
}

#[cfg(test)]
mod tests {
    use uvgraft::islands::Islands;
    use uvgraft_figure::{Figure, paint_body};

    use super::*;

    #[test]
    fn the_figures_eyes_get_separate_islands_and_look_the_same() {
        let figure = Figure::new();
        let parted = SeparatedEyes::find(&figure.body).unwrap().unwrap();
        let (before, after) = (&figure.body, &parted.mesh);
        assert_eq!((before.positions(), before.faces()), (after.positions(), after.faces()));
        assert_eq!(before.parts(), after.parts());
        assert_eq!(Islands::new(before).count(), Islands::new(after).count());
        assert_eq!(SeparatedEyes::find(after).unwrap().map(|parted| parted.place), None);
        let texture = paint_body(&figure, Size::square(1024));
        let mut copied = texture.clone();
        parted.copy(&mut copied);
        let mut moved = 0;
        for face in 0..before.faces().len() {
            let center = |mesh: &Mesh| {
                let corners = mesh.uv_triangle(face);
                std::array::from_fn(|k| corners.iter().map(|uv| uv[k]).sum::<f32>() / 3.0)
            };
            let (old, new): ([f32; 2], [f32; 2]) = (center(before), center(after));
            moved += usize::from(old != new);
            for channel in 0..3 {
                let (was, is) = (sample(&texture, old)[channel], sample(&copied, new)[channel]);
                assert!((was - is).abs() < 0.12, "face {face}: {was} {is}");
            }
        }
        // One of the two eyes.
        assert!((200..400).contains(&moved), "{moved}");
    }

    #[test]
    fn eyes_with_separate_islands_keep_them() {
        assert!(SeparatedEyes::find(&Figure::new().head).unwrap().is_none());
    }
}
