//! The frames of source and target over one piece.

use glam::Vec3;

use crate::tangents::TangentFrame;

/// The frames at one place: tangent and normal of the source, in the target's space, then tangent and
/// normal of the target. Bitangents follow from these.
pub(super) type Frames = [[f32; 3]; 4];

/// The frames over a piece of a target triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceFrames {
    /// Not rounded, for parts that are slivers.
    pub tgt_uv: [[f64; 2]; 3],
    /// At the piece's corners: those of the source, in the target's space, and the target's.
    pub corners: [Frames; 3],
    /// Which way the bitangents of source and target point.
    pub signs: [f32; 2],
}

impl PieceFrames {
    /// - `tgt_uv`: the piece's corners.
    /// - `source`: there, in the target's space.
    /// - `target`: there.
    pub fn new(
        tgt_uv: [[f64; 2]; 3],
        source: [TangentFrame; 3],
        target: &[TangentFrame; 3],
    ) -> Self {
        // Where the meshes wind opposite ways, the source's normals point to the target's back.
        let wide = |vector: [f32; 3]| Vec3::from(vector).as_dvec3();
        let agreement: f64 =
            (0..3).map(|k| wide(source[k].normal).dot(wide(target[k].normal))).sum();
        let side = if agreement < 0.0 { -1.0 } else { 1.0 };
        let corner = |k: usize| {
            let [tangent, normal] = [source[k].tangent, source[k].normal];
            let turned = |vector: [f32; 3]| vector.map(|value| value * side);
            [turned(tangent), turned(normal), target[k].tangent, target[k].normal]
        };
        // The same at all corners, but for triangles without area; bakers clamp the mean.
        let sign = |frames: &[TangentFrame; 3]| {
            let sum: f32 = frames.iter().map(|frame| frame.sign).sum();
            if sum < 0.0 { -1.0 } else { 1.0 }
        };
        // Vectors that are both turned around have the same product, so bitangents are turned here.
        let signs = [sign(&source) * side, sign(target)];
        Self { tgt_uv, corners: [corner(0), corner(1), corner(2)], signs }
    }
}
