//! Landmarks of the meshes to paint on.

use uvgraft::Mesh;
use uvgraft_figure::Figure;

use super::noise::Point;

/// Landmarks of a head. Except for `unit` and [`HeadFrame::origin`], lengths are in centimetres
/// from the midpoint of the eyes' centres: Y up, Z out of the face, X to its left. The left eye
/// stands for both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadFrame {
    /// Centimetres per unit of the mesh.
    pub unit: f32,
    /// The midpoint of the eyes' centres, in the mesh's unit.
    pub origin: [f32; 3],
    /// Centre of the left eyeball.
    pub eye: [f32; 3],
    /// Radius of the eyeball.
    pub eye_radius: f32,
    /// Heights of the upper and lower lid over the pupil.
    pub lids: [f32; 2],
    /// Height of the brow over the pupil.
    pub brow: f32,
    /// Height and depth of the tip of the nose.
    pub nose: [f32; 2],
    /// Heights of the upper lip's upper edge, the line between the lips, and the lower lip's lower
    /// edge.
    pub lips: [f32; 3],
    /// Half the width of the mouth.
    pub mouth_width: f32,
    /// Points between the lips that are less far out than this are inside the mouth.
    pub mouth_depth: f32,
    /// Height of the chin's lower edge.
    pub chin: f32,
    /// Height of the hairline over the forehead.
    pub hairline: f32,
    /// A collar covers points whose `y + slope · z` is below a level: the slope, then the levels of
    /// crew and polo necks.
    pub collar: [f32; 3],
}

impl HeadFrame {
    /// FLAME's template.
    pub const FLAME: Self = Self {
        unit: 100.0,
        origin: [0.0, 1.5251, 0.0377],
        eye: [3.15, 0.0, 0.0],
        eye_radius: 1.3,
        lids: [0.37, -0.45],
        brow: 1.75,
        nose: [-2.9, 5.2],
        lips: [-5.35, -6.3, -7.45],
        mouth_width: 2.75,
        mouth_depth: 3.25,
        chin: -11.0,
        hairline: 6.0,
        collar: [0.35, -21.6, -15.6],
    };

    /// The head of SMPL-X's template.
    pub const SMPLX: Self = Self {
        origin: [0.0, 0.324_55, 0.063_75],
        eye: [3.245, 0.0, 0.0],
        nose: [-3.0, 5.45],
        lips: [-5.7, -6.8, -8.05],
        mouth_width: 2.85,
        mouth_depth: 3.4,
        chin: -11.8,
        hairline: 6.3,
        ..Self::FLAME
    };

    /// The synthetic figure, for its head and its body alike.
    pub const FIGURE: Self = Self {
        unit: 100.0,
        origin: [0.0, 1.63, 0.065],
        eye: [3.25, 0.0, 0.0],
        eye_radius: 1.75,
        lids: [0.72, -0.58],
        brow: 2.2,
        nose: [-3.7, 4.2],
        lips: [-6.55, -7.2, -8.05],
        mouth_width: 2.5,
        mouth_depth: 0.9,
        chin: -11.2,
        hairline: 6.2,
        collar: [0.26, -16.3, -13.6],
    };

    /// A position on the mesh, in centimetres from the midpoint of the eyes.
    pub fn local(&self, position: [f32; 3]) -> Point {
        [0, 1, 2].map(|k| (position[k] - self.origin[k]) * self.unit)
    }

    pub(super) fn is_in_eye(&self, p: Point, share: f32) -> bool {
        let d = [p[0].abs() - self.eye[0], p[1] - self.eye[1], p[2] - self.eye[2]];
        d.iter().map(|value| value * value).sum::<f32>() < (self.eye_radius * share).powi(2)
    }

    /// The component that each triangle is part of: eyeballs are the connected components of the
    /// mesh that lie within the eyes; the hair shell and shoes are parts with known object and
    /// material names.
    pub(super) fn pieces(&self, mesh: &Mesh) -> Vec<Piece> {
        let mut root: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        fn find(root: &mut [u32], mut at: u32) -> u32 {
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            at
        }
        for face in mesh.faces() {
            let first = find(&mut root, face[0]);
            for &vertex in &face[1..] {
                let other = find(&mut root, vertex);
                root[other as usize] = first;
            }
        }
        let mut is_eye = vec![true; root.len()];
        for (vertex, &position) in (0..).zip(mesh.positions()) {
            let inside = self.is_in_eye(self.local(position), 1.25);
            let piece = find(&mut root, vertex);
            is_eye[piece as usize] &= inside;
        }
        let mut pieces: Vec<Piece> = mesh
            .faces()
            .iter()
            .map(|face| {
                if is_eye[find(&mut root, face[0]) as usize] { Piece::Eyeball } else { Piece::Body }
            })
            .collect();
        for part in mesh.parts() {
            let piece = match (part.object.as_str(), part.material.as_str()) {
                ("head", "hair") => Piece::HairShell,
                ("body", "leather") => Piece::Shoe,
                _ => continue,
            };
            for polygon in part.polygons.clone() {
                pieces[mesh.polygon(polygon as usize)].fill(piece);
            }
        }
        pieces
    }
}

/// The component that a triangle is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Piece {
    Body,
    Eyeball,
    HairShell,
    Shoe,
}

/// Landmarks of a body, in centimetres from the origin of the head's frame; the left side stands
/// for both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFrame {
    /// Landmarks of the head on this body.
    pub head: HeadFrame,
    /// Height of the neck's boundary in front, and the rise of its plane per centimetre towards the
    /// back.
    pub rim: [f32; 2],
    /// Positions of the shoulder and the wrist.
    pub arm: [[f32; 3]; 2],
    /// Heights of the waist, the crotch, the knees and the ankles.
    pub heights: [f32; 4],
    /// The front of the chest that shirts leave free: half its width, then its lower and upper
    /// height.
    pub chest: [f32; 3],
}

impl BodyFrame {
    /// SMPL-X's template, in T-pose.
    pub const SMPLX: Self = Self {
        head: HeadFrame::SMPLX,
        rim: [-22.2, 0.3],
        arm: [[17.0, -26.0, -11.0], [68.0, -28.0, -12.5]],
        heights: [-57.0, -113.0, -120.0, -159.0],
        chest: [5.5, -31.0, -24.0],
    };

    /// The synthetic figure, in A-pose.
    pub const FIGURE: Self = Self {
        head: HeadFrame::FIGURE,
        rim: [-16.3, 0.26],
        arm: [[16.6, -22.0, -8.3], [56.4, -55.4, -8.3]],
        heights: [-60.0, -88.0, -113.0, -154.0],
        chest: [5.0, -23.0, -17.5],
    };

    /// Position along the arm: 0 at the shoulder, 1 at the wrist, `None` on the trunk.
    pub(super) fn along_arm(&self, p: Point) -> Option<f32> {
        let [shoulder, wrist] = self.arm;
        let q = [p[0].abs() - shoulder[0], p[1] - shoulder[1], p[2] - shoulder[2]];
        let d = [0, 1, 2].map(|k| wrist[k] - shoulder[k]);
        let length = d.iter().map(|value| value * value).sum::<f32>();
        let along = (0..3).map(|k| q[k] * d[k]).sum::<f32>() / length;
        let beside: f32 = (0..3).map(|k| (q[k] - along * d[k]).powi(2)).sum::<f32>().sqrt();
        (along > 0.0 && beside < 16.0 && p[0].abs() > shoulder[0] - 2.0).then_some(along)
    }
}

/// The figure's pair: its head as the source, its body as the target.
///
/// # Panics
/// Never: the figure's meshes fit each other.
pub fn figure_pair(figure: &Figure) -> std::sync::Arc<uvgraft::Pair> {
    let map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
    let pair = uvgraft::Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &map);
    std::sync::Arc::new(pair.expect("the figure's head is part of its body"))
}
