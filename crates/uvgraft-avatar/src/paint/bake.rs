//! Paints a texture by evaluating a colour function at the surface point of every texel. Colours
//! are functions of the point in space at rest, so charts have no visible seams.

use glam::Vec3;
use uvgraft::raster::ScanTriangle;
use uvgraft::{Channels, Encoding, Mesh, Size, Texels, Texture, Value, threads};

use super::texel::Color;
use crate::normals::vertex_normals;

/// A surface point to be coloured.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// Index of its triangle.
    pub face: usize,
    /// In world space, in centimetres.
    pub position: Vec3,
    /// Of length 1, interpolated between the vertices.
    pub normal: Vec3,
}

const BAND: usize = 16;

/// Colours every texel that a chart covers, and fills a gutter around the charts.
///
/// - `faces`: the triangles to paint.
/// - `color`: sRGB values of a point.
///
/// The triangles are binned into bands of rows, which are painted in parallel. A texel that two
/// triangles share is painted by the later one, whatever the number of threads.
///
/// # Panics
/// If a triangle does not exist.
pub fn bake(
    mesh: &Mesh,
    faces: impl IntoIterator<Item = usize>,
    size: Size,
    background: Color,
    color: impl Fn(&Spot) -> Color + Sync,
) -> Texture {
    let normals = vertex_normals(mesh.positions(), mesh.faces());
    let triangles: Vec<Triangle> =
        faces.into_iter().filter_map(|face| Triangle::new(mesh, &normals, face, size)).collect();
    let width = size.width as usize;
    let mut bands = vec![Vec::new(); (size.height as usize).div_ceil(BAND)];
    for (index, triangle) in triangles.iter().enumerate() {
        let rows = triangle.scan.rows();
        let touched = rows.start as usize / BAND..=(rows.end as usize - 1) / BAND;
        for band in &mut bands[touched] {
            band.push(index);
        }
    }
    let fill = background.map(u8::from_unit);
    let mut texels = fill.repeat(size.texels());
    let mut painted = vec![0_u8; size.texels()];
    let pieces = texels.chunks_mut(width * BAND * 3).zip(painted.chunks_mut(width * BAND));
    threads::for_each(pieces.zip(&bands), |band, ((texels, painted), indices)| {
        let first = (band * BAND) as u32;
        let end = (first + BAND as u32).min(size.height);
        for &index in indices {
            let triangle = &triangles[index];
            let rows = triangle.scan.rows();
            for row in rows.start.max(first)..rows.end.min(end) {
                for column in triangle.scan.span(row) {
                    let texel = (row - first) as usize * width + column as usize;
                    let spot = triangle.spot(column as f32 + 0.5, row as f32 + 0.5);
                    let value = color(&spot).map(u8::from_unit);
                    texels[texel * 3..texel * 3 + 3].copy_from_slice(&value);
                    painted[texel] = 1;
                }
            }
        }
    });
    let gutter = (size.width.max(size.height) / 256).max(2) as usize;
    spread(&mut texels, &mut painted, width, gutter);
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
        .expect("the buffer was made for this size")
}

struct Triangle {
    scan: ScanTriangle,
    face: usize,
    /// Texel coordinates of the first corner, then the rows of the matrix that gives the
    /// barycentric weights of the other two corners.
    origin: [f32; 2],
    weights: [[f32; 2]; 2],
    positions: [Vec3; 3],
    normals: [Vec3; 3],
}

impl Triangle {
    fn new(mesh: &Mesh, normals: &[Vec3], face: usize, size: Size) -> Option<Self> {
        const CENTIMETRES: f32 = 100.0;
        let [a, b, c] = mesh.uv_triangle(face).map(|[u, v]| {
            [f64::from(u) * f64::from(size.width), f64::from(v) * f64::from(size.height)]
        });
        let scan = ScanTriangle::new([a, b, c], size)?;
        let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let area = ab[0] * ac[1] - ab[1] * ac[0];
        let weights = [[ac[1] / area, -ac[0] / area], [-ab[1] / area, ab[0] / area]];
        let vertices = mesh.faces()[face].map(|vertex| vertex as usize);
        Some(Self {
            scan,
            face,
            origin: a.map(|value| value as f32),
            weights: weights.map(|row| row.map(|value| value as f32)),
            positions: vertices.map(|v| Vec3::from(mesh.positions()[v]) * CENTIMETRES),
            normals: vertices.map(|v| normals[v]),
        })
    }

    fn spot(&self, x: f32, y: f32) -> Spot {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let [b, c] = self.weights.map(|row| row[0] * dx + row[1] * dy);
        let blend = |[p, q, r]: [Vec3; 3]| p * (1.0 - b - c) + q * b + r * c;
        Spot {
            face: self.face,
            position: blend(self.positions),
            normal: blend(self.normals).normalize_or_zero(),
        }
    }
}

/// Fills the gutter: copies painted texels outwards along rows, then along columns, so that
/// filtering near chart edges does not pick up the background.
fn spread(texels: &mut [u8], painted: &mut [u8], width: usize, gutter: usize) {
    let rows = texels.chunks_mut(width * 3).zip(painted.chunks_mut(width));
    threads::for_each(rows, |_, (texels, painted)| {
        let source = painted.to_vec();
        for step in [1_isize, -1] {
            let mut distance = gutter;
            let mut value = [0; 3];
            for k in 0..width {
                let x = if step > 0 { k } else { width - 1 - k };
                if source[x] == 1 {
                    distance = 0;
                    value.copy_from_slice(&texels[x * 3..x * 3 + 3]);
                    continue;
                }
                distance += 1;
                // Painted texels are marked 1, copies with their distance plus 1.
                let mark = (distance + 1).min(255) as u8;
                if distance <= gutter && (painted[x] == 0 || mark < painted[x]) {
                    texels[x * 3..x * 3 + 3].copy_from_slice(&value);
                    painted[x] = mark;
                }
            }
        }
    });
    let height = painted.len() / width;
    let source: Vec<bool> = painted.iter().map(|&mark| mark > 0).collect();
    for down in [true, false] {
        let mut distance = vec![gutter; width];
        for k in 0..height {
            let y = if down { k } else { height - 1 - k };
            for (x, distance) in distance.iter_mut().enumerate() {
                let texel = y * width + x;
                if source[texel] {
                    *distance = 0;
                    continue;
                }
                *distance += 1;
                let mark = (*distance + 1).min(255) as u8;
                if *distance <= gutter && (painted[texel] == 0 || mark < painted[texel]) {
                    let from = if down { texel - width } else { texel + width } * 3;
                    texels.copy_within(from..from + 3, texel * 3);
                    painted[texel] = mark;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gutter_takes_the_nearest_colour() {
        let mut texels = vec![0; 15];
        texels[6] = 9;
        let mut painted = vec![0, 0, 1, 0, 0];
        spread(&mut texels, &mut painted, 5, 1);
        assert_eq!(painted, [0, 2, 1, 2, 0]);
        assert_eq!((texels[3], texels[9], texels[12]), (9, 9, 0));
    }
}
