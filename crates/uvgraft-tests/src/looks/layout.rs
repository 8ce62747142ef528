//! The surface point of each texel in a mesh's layout.

use uvgraft::raster::ScanTriangle;
use uvgraft::{Channels, Encoding, Mesh, Size, Texels, Texture, threads};

use super::{Color, Label, Labels, Painted};

/// A surface point to be painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Position, in the mesh's unit.
    pub position: [f32; 3],
    /// Unit normal, pointing outwards.
    pub normal: [f32; 3],
    /// Index of the triangle.
    pub face: u32,
}

/// The surface points of all texels in a mesh's layout.
#[derive(Debug, Clone)]
pub struct LayoutSpots {
    size: Size,
    /// `[texels]`, row-major; `None` outside the islands.
    spots: Vec<Option<Spot>>,
}

/// Width of the gutter in texels: beyond any filter's footprint.
const GUTTER_PX: usize = 6;

impl LayoutSpots {
    /// Rasterises a layout. Where triangles overlap, the last one wins.
    pub fn new(mesh: &Mesh, size: Size) -> Self {
        let normals = vertex_normals(mesh);
        let mut spots = vec![None; size.texels()];
        for (face, vertices) in (0..).zip(mesh.faces()) {
            let corners = mesh.uv_triangle(face as usize).map(|[u, v]| {
                [f64::from(u) * f64::from(size.width), f64::from(v) * f64::from(size.height)]
            });
            let Some(scan) = ScanTriangle::new(corners, size) else { continue };
            let [a, b, c] = corners;
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let positions = vertices.map(|vertex| mesh.positions()[vertex as usize]);
            let normals = vertices.map(|vertex| normals[vertex as usize]);
            for row in scan.rows() {
                for column in scan.span(row) {
                    let (x, y) = (f64::from(column) + 0.5 - a[0], f64::from(row) + 0.5 - a[1]);
                    let s = ((x * (c[1] - a[1]) - y * (c[0] - a[0])) / area) as f32;
                    let t = ((y * (b[0] - a[0]) - x * (b[1] - a[1])) / area) as f32;
                    let blend = |p: [[f32; 3]; 3]| {
                        [0, 1, 2].map(|k| p[0][k] * (1.0 - s - t) + p[1][k] * s + p[2][k] * t)
                    };
                    let position = blend(positions);
                    let normal = normalized(blend(normals));
                    spots[(row * size.width + column) as usize] =
                        Some(Spot { position, normal, face });
                }
            }
        }
        Self { size, spots }
    }

    /// The size of the textures to be painted.
    pub fn size(&self) -> Size {
        self.size
    }

    /// `[texels]`, row-major; `None` outside the islands.
    pub fn spots(&self) -> &[Option<Spot>] {
        &self.spots
    }

    /// Paints every surface point, and a gutter around the islands.
    ///
    /// - `paint`: returns the linear light and the label of a point.
    pub(super) fn paint(&self, paint: impl Fn(&Spot) -> (Color, Label) + Send + Sync) -> Painted {
        let painted =
            threads::map_indices(self.spots.len(), |at| self.spots[at].as_ref().map(&paint));
        let of_texels =
            painted.iter().map(|texel| texel.map_or(Label::Other, |(_, label)| label)).collect();
        let mut colors: Vec<Option<[u8; 3]>> = painted
            .into_iter()
            .map(|texel| texel.map(|(color, _)| color.map(level_from_linear)))
            .collect();
        spread(&mut colors, self.size.width as usize);
        let values = colors.into_iter().flat_map(|color| color.unwrap_or([24; 3])).collect();
        let texture = Texture::new(self.size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
            .expect("as many values as texels");
        Painted { texture, truth: Labels { size: self.size, of_texels } }
    }
}

fn level_from_linear(value: f32) -> u8 {
    (uvgraft::color::srgb_from_linear(value).clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Fills empty texels with the mean of their filled neighbours, ring by ring.
fn spread(colors: &mut [Option<[u8; 3]>], width: usize) {
    for _ in 0..GUTTER_PX {
        let before = colors.to_vec();
        for at in 0..before.len() {
            if before[at].is_some() {
                continue;
            }
            let (x, y) = (at % width, at / width);
            let neighbours = [
                (x > 0).then(|| at - 1),
                (x + 1 < width).then_some(at + 1),
                (y > 0).then(|| at - width),
                (at + width < before.len()).then_some(at + width),
            ];
            let mut sum = [0_u32; 4];
            for color in neighbours.into_iter().flatten().filter_map(|other| before[other]) {
                (0..3).for_each(|k| sum[k] += u32::from(color[k]));
                sum[3] += 1;
            }
            if sum[3] > 0 {
                colors[at] = Some([0, 1, 2].map(|k| (sum[k] / sum[3]) as u8));
            }
        }
    }
}

fn vertex_normals(mesh: &Mesh) -> Vec<[f32; 3]> {
    let mut normals = vec![[0.0_f32; 3]; mesh.positions().len()];
    for face in mesh.faces() {
        let [a, b, c] = face.map(|vertex| mesh.positions()[vertex as usize]);
        let (p, q) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let cross =
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
        for &vertex in face {
            (0..3).for_each(|k| normals[vertex as usize][k] += cross[k]);
        }
    }
    normals.into_iter().map(normalized).collect()
}

fn normalized(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-20);
    v.map(|value| value / length)
}
