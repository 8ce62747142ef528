//! Paints the figure's textures: colours of its parts at the surface point of every texel.

use glam::Vec3;
use uvgraft::{Mesh, Size, Texture};
use uvgraft_avatar::paint::bake;
pub(crate) use uvgraft_avatar::paint::texel::Color;

use super::PartFaces;
use super::surface::BodyPart;

/// A surface point to be coloured.
pub(crate) struct Spot {
    pub part: BodyPart,
    /// In world space, in centimetres.
    pub position: Vec3,
    pub normal: Vec3,
}

/// Colours every texel that a chart covers; see [`bake::bake`].
pub(crate) fn bake(
    mesh: &Mesh,
    parts: &[PartFaces],
    size: Size,
    background: Color,
    color: impl Fn(&Spot) -> Color + Sync,
) -> Texture {
    let mut part_of: Vec<Option<BodyPart>> = vec![None; mesh.faces().len()];
    parts.iter().for_each(|part| part_of[part.faces.clone()].fill(Some(part.part)));
    let faces = parts.iter().flat_map(|part| part.faces.clone());
    bake::bake(mesh, faces, size, background, |spot| {
        let bake::Spot { face, position, normal } = *spot;
        part_of[face].map_or(background, |part| color(&Spot { part, position, normal }))
    })
}

/// Interpolates between two colours.
pub(crate) fn blend(a: Color, b: Color, t: f32) -> Color {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}

/// Scales the brightness.
pub(crate) fn scaled(color: Color, factor: f32) -> Color {
    color.map(|value| value * factor)
}

#[cfg(test)]
mod tests {
    use uvgraft::raster::ScanTriangle;

    use super::*;
    use crate::Figure;

    #[test]
    fn every_texel_of_a_chart_is_painted() {
        const SIDE: u32 = 256;
        let figure = Figure::new();
        let size = Size::square(SIDE);
        for (mesh, parts) in
            [(&figure.head, &figure.head_parts), (&figure.body, &figure.body_parts)]
        {
            let texture = bake(mesh, parts, size, [0.0; 3], |spot| {
                assert!(spot.position.length().is_finite() && spot.normal.length().is_finite());
                [1.0; 3]
            });
            for face in 0..mesh.faces().len() {
                let corners =
                    mesh.uv_triangle(face).map(|uv| uv.map(|value| f64::from(value) * 256.0));
                let Some(scan) = ScanTriangle::new(corners, size) else { continue };
                for row in scan.rows() {
                    for column in scan.span(row) {
                        assert_eq!(texture.get(column, row, 0), 1.0, "{column}, {row}");
                    }
                }
            }
        }
    }
}
