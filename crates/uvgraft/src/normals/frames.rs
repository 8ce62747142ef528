//! The tangent frames of source and target over one piece.

use glam::Vec3;
use uvgraft_surface::tangents::TangentFrame;

/// The frames at one point: tangent and normal of the source, in the target's space, then
/// tangent and normal of the target. Bitangents follow from these.
pub(super) type Frames = [[f32; 3]; 4];

/// The frames over one piece of a target triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceFrames {
    /// UV coordinates of the piece's corners, in 64 bits for the sake of slivers.
    pub tgt_uv: [[f64; 2]; 3],
    /// The frames at the piece's corners.
    pub corners: [Frames; 3],
    /// The signs of the bitangents of source and target.
    pub signs: [f32; 2],
}

impl PieceFrames {
    /// - `tgt_uv`: UV coordinates of the piece's corners.
    /// - `source`: the source's frames at these corners, in the target's space.
    /// - `target`: the target's frames at these corners.
    pub fn new(
        tgt_uv: [[f64; 2]; 3],
        source: [TangentFrame; 3],
        target: &[TangentFrame; 3],
    ) -> Self {
        // If the meshes have opposite windings, the source's normals point to the target's back
        // side.
        let wide = |vector: [f32; 3]| Vec3::from(vector).as_dvec3();
        let agreement: f64 =
            (0..3).map(|k| wide(source[k].normal).dot(wide(target[k].normal))).sum();
        let side = if agreement < 0.0 { -1.0 } else { 1.0 };
        let corner = |k: usize| {
            let [tangent, normal] = [source[k].tangent, source[k].normal];
            let flipped = |vector: [f32; 3]| vector.map(|value| value * side);
            [flipped(tangent), flipped(normal), target[k].tangent, target[k].normal]
        };
        // Equal at all corners except on degenerate triangles; bakers clamp the mean.
        let sign = |frames: &[TangentFrame; 3]| {
            let sum: f32 = frames.iter().map(|frame| frame.sign).sum();
            if sum < 0.0 { -1.0 } else { 1.0 }
        };
        // Negating both vectors leaves their cross product unchanged, so the sign is flipped here.
        let signs = [sign(&source) * side, sign(target)];
        Self { tgt_uv, corners: [corner(0), corner(1), corner(2)], signs }
    }
}
