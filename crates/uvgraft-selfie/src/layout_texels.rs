//! Where each texel of a layout lies on the mesh.

use uvgraft::raster::ScanTriangle;
use uvgraft::surface_index::SurfacePoint;
use uvgraft::{Mesh, Size};

const NONE: u32 = u32::MAX;

/// The triangle of each texel of a layout. Where islands overlap, the first triangle owns a texel.
#[derive(Debug, Clone)]
pub struct LayoutTexels {
    size: Size,
    faces: Vec<u32>,
    /// For each triangle, the weights of its second and third corner as functions of the texel.
    weights: Vec<[f64; 6]>,
}

impl LayoutTexels {
    /// Rasterises a mesh's layout.
    pub fn new(mesh: &Mesh, size: Size) -> Self {
        let mut faces = vec![NONE; size.texels()];
        let [width, height] = [f64::from(size.width), f64::from(size.height)];
        let mut weights = Vec::with_capacity(mesh.faces().len());
        for face in 0..mesh.faces().len() {
            let px =
                mesh.uv_triangle(face).map(|[u, v]| [f64::from(u) * width, f64::from(v) * height]);
            weights.push(inverse(px));
            let Some(scan) = ScanTriangle::new(px, size) else { continue };
            for row in scan.rows() {
                let span = scan.span(row);
                let start = row as usize * size.width as usize;
                for owner in &mut faces[start + span.start as usize..start + span.end as usize] {
                    if *owner == NONE {
                        *owner = face as u32;
                    }
                }
            }
        }
        Self { size, faces, weights }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The triangle that owns a texel, if any.
    pub fn face(&self, texel: usize) -> Option<u32> {
        let face = self.faces[texel];
        (face != NONE).then_some(face)
    }

    /// The place of a texel's centre on the mesh.
    pub fn place(&self, texel: usize) -> Option<SurfacePoint> {
        let face = self.face(texel)?;
        let width = self.size.width as usize;
        let (x, y) = ((texel % width) as f64 + 0.5, (texel / width) as f64 + 0.5);
        let [ax, ay, a, bx, by, b] = self.weights[face as usize];
        let (second, third) = (ax * x + ay * y + a, bx * x + by * y + b);
        Some(SurfacePoint { face, weights: [1.0 - second - third, second, third] })
    }
}

/// The barycentric weights of the second and third corner as affine functions of a position.
fn inverse([a, b, c]: [[f64; 2]; 3]) -> [f64; 6] {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return [0.0; 6];
    }
    let second = [(c[1] - a[1]) / area, -(c[0] - a[0]) / area];
    let third = [-(b[1] - a[1]) / area, (b[0] - a[0]) / area];
    let offset = |[x, y]: [f64; 2]| -x * a[0] - y * a[1];
    [second[0], second[1], offset(second), third[0], third[1], offset(third)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_know_their_place() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]];
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let texels = LayoutTexels::new(&mesh, Size::square(8));
        let place = texels.place(8 + 2).unwrap();
        // The centre of texel (2, 1): u = 2.5 / 8, v = 1.5 / 8.
        for (found, wanted) in place.weights.into_iter().zip([0.3125, 0.3125, 0.375]) {
            assert!((found - wanted).abs() < 1e-12);
        }
        assert_eq!(texels.place(63), None);
    }
}
