//! A figure of fifteen boxes in as many colours, whose pictures are predictable: each box follows a
//! single joint and shows a single colour.

use uvgraft::{Channels, Encoding, Mesh, Size, Texels, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{
    Clip, Expression, ExpressionPreset, HumanBone, Joint, Morph, Pose, Skeleton, Skin,
};
use uvgraft_gltf::glb::{
    AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, Permissions, VrmMeta, write,
};

/// Bone, joint name, index of its parent, start and end of its box, half the box's width; in
/// metres. The names are SMPL's, the bones those that VRM requires.
type Part = (HumanBone, &'static str, Option<usize>, [f32; 3], [f32; 3], f32);

const PARTS: [Part; 15] = {
    use HumanBone as B;
    [
        (B::Hips, "pelvis", None, [0.0, 0.95, 0.0], [0.0, 1.1, 0.0], 0.14),
        (B::Spine, "spine1", Some(0), [0.0, 1.12, 0.0], [0.0, 1.45, 0.0], 0.13),
        (B::Head, "head", Some(1), [0.0, 1.5, 0.0], [0.0, 1.75, 0.0], 0.1),
        (B::LeftUpperArm, "left_shoulder", Some(1), [0.2, 1.4, 0.0], [0.44, 1.4, 0.0], 0.05),
        (B::LeftLowerArm, "left_elbow", Some(3), [0.45, 1.4, 0.0], [0.66, 1.4, 0.0], 0.04),
        (B::LeftHand, "left_wrist", Some(4), [0.68, 1.4, 0.0], [0.8, 1.4, 0.0], 0.05),
        (B::RightUpperArm, "right_shoulder", Some(1), [-0.2, 1.4, 0.0], [-0.44, 1.4, 0.0], 0.05),
        (B::RightLowerArm, "right_elbow", Some(6), [-0.45, 1.4, 0.0], [-0.66, 1.4, 0.0], 0.04),
        (B::RightHand, "right_wrist", Some(7), [-0.68, 1.4, 0.0], [-0.8, 1.4, 0.0], 0.05),
        (B::LeftUpperLeg, "left_hip", Some(0), [0.1, 0.9, 0.0], [0.1, 0.52, 0.0], 0.07),
        (B::LeftLowerLeg, "left_knee", Some(9), [0.1, 0.5, 0.0], [0.1, 0.12, 0.0], 0.06),
        (B::LeftFoot, "left_ankle", Some(10), [0.1, 0.06, 0.0], [0.1, 0.06, 0.16], 0.05),
        (B::RightUpperLeg, "right_hip", Some(0), [-0.1, 0.9, 0.0], [-0.1, 0.52, 0.0], 0.07),
        (B::RightLowerLeg, "right_knee", Some(12), [-0.1, 0.5, 0.0], [-0.1, 0.12, 0.0], 0.06),
        (B::RightFoot, "right_ankle", Some(13), [-0.1, 0.06, 0.0], [-0.1, 0.06, 0.16], 0.05),
    ]
};

/// Cells along a side of the texture, one for each box, and texels along a side of a cell.
const CELLS: usize = 4;
const CELL: usize = 16;

/// Offset of the head by the expression "happy", in metres.
const ASIDE: [f32; 3] = [0.25, 0.0, 0.0];

/// The figure, in T-pose: an expression "happy" that moves its head to its left, and a clip "bow"
/// of one second with frames at 0, 0.5 and 1 s.
pub fn avatar() -> Avatar {
    let (mut positions, mut uv, mut faces, mut uv_faces) = (vec![], vec![], vec![], vec![]);
    for (number, &(_, _, _, start, end, half)) in PARTS.iter().enumerate() {
        let along = (0..3).find(|&axis| (end[axis] - start[axis]).abs() > 0.01).unwrap_or(1);
        for corner in 0..8 {
            positions.push([0, 1, 2].map(|axis: usize| {
                let (low, high) = (start[axis].min(end[axis]), start[axis].max(end[axis]));
                let margin = if axis == along { 0.0 } else { half };
                if corner >> axis & 1 == 0 { low - margin } else { high + margin }
            }));
        }
        // The centre of the cell, where filtering reaches no other colour.
        let cell = [number % CELLS, number / CELLS].map(|k| k as f32);
        uv.extend(
            [[0.3, 0.3], [0.7, 0.3], [0.7, 0.7], [0.3, 0.7]].map(|[u, v]: [f32; 2]| {
                [(cell[0] + u) / CELLS as f32, (cell[1] + v) / CELLS as f32]
            }),
        );
        // Bits of a corner: 0 for x, 1 for y, 2 for z. Counterclockwise seen from outside.
        let sides =
            [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]];
        for side in sides.map(|side: [u32; 4]| side.map(|corner| number as u32 * 8 + corner)) {
            faces.extend([[side[0], side[1], side[2]], [side[0], side[2], side[3]]]);
            let first = number as u32 * 4;
            uv_faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    let joints = PARTS.iter().map(|&(bone, name, parent, position, ..)| Joint {
        name: name.to_owned(),
        parent,
        position,
        human: Some(bone),
    });
    let weights = (0..PARTS.len()).flat_map(|joint| vec![[(joint, 1.0f32)]; 8]);
    let head = number(HumanBone::Head);
    let aside = (0..8).map(|corner| ((head * 8 + corner) as u32, ASIDE)).collect();
    Avatar {
        mesh: Mesh::from_triangles(positions, uv, &faces, &uv_faces).expect("a sound mesh"),
        materials: Vec::new(),
        skeleton: Skeleton::new(joints.collect()).expect("a sound skeleton"),
        skin: Skin::new(weights, PARTS.len()).expect("sound weights"),
        morphs: vec![Morph { name: "aside".to_owned(), offsets: aside }],
        expressions: vec![Expression::preset(ExpressionPreset::Happy, vec![(0, 1.0)])],
        clips: vec![Clip {
            name: "bow".to_owned(),
            times: vec![0.0, 0.5, 1.0],
            poses: vec![Pose::rest(PARTS.len()), pose(0.5), pose(1.0)],
        }],
    }
}

/// A pose in which every box is visible from the front: limbs bent about all axes, more for a
/// larger `amount` up to 1, and the whole figure translated.
pub fn pose(amount: f32) -> Pose {
    let mut turns = [[0.0f32; 3]; PARTS.len()];
    for (bone, turn) in [
        (HumanBone::Hips, [0.0, 0.15, 0.05]),
        (HumanBone::Spine, [0.1, -0.1, -0.1]),
        (HumanBone::Head, [0.1, 0.2, 0.15]),
        (HumanBone::LeftUpperArm, [0.2, -0.2, -0.7]),
        (HumanBone::LeftLowerArm, [0.3, -0.3, 0.5]),
        (HumanBone::LeftHand, [0.4, 0.0, 0.4]),
        (HumanBone::RightUpperArm, [0.0, 0.3, -0.5]),
        (HumanBone::RightLowerArm, [-0.2, 0.2, -0.8]),
        (HumanBone::LeftUpperLeg, [-0.4, 0.1, 0.1]),
        (HumanBone::LeftLowerLeg, [0.5, 0.0, 0.0]),
        (HumanBone::RightUpperLeg, [0.2, 0.0, -0.15]),
        (HumanBone::RightLowerLeg, [0.3, 0.0, 0.1]),
        (HumanBone::RightFoot, [-0.5, 0.1, 0.0]),
    ] {
        turns[number(bone)] = turn.map(|value| value * amount);
    }
    Pose::from_axis_angles([0.05 * amount, 0.02 * amount, -0.1 * amount], &turns)
}

/// The index of a bone's joint, box and cell.
fn number(bone: HumanBone) -> usize {
    PARTS.iter().position(|part| part.0 == bone).expect("a bone of the mannequin")
}

/// The colour of a box by its index; no two are alike.
pub fn color(number: usize) -> [u8; 3] {
    let number = number as u8;
    [40 + number % 4 * 60, 40 + number / 4 * 60, 230 - number * 12]
}

/// The texture with all colours, as PNG.
pub fn texture() -> EmbeddedImage {
    let side = CELLS * CELL;
    let texels = (0..side * side).flat_map(|at| {
        let (x, y) = (at % side, at / side);
        color(y / CELL * CELLS + x / CELL)
    });
    encoded(side as u32, texels.collect())
}

/// A texture of a single colour, as PNG.
pub fn plain(color: [u8; 3]) -> EmbeddedImage {
    encoded(8, color.repeat(64))
}

fn encoded(side: u32, values: Vec<u8>) -> EmbeddedImage {
    let size = Size { width: side, height: side };
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values));
    let texture = texture.expect("as many values as the size says");
    EmbeddedImage::encode(texture, EmbeddedFormat::Png, 90).expect("a small PNG")
}

/// The figure as a GLB or VRM file.
pub fn file(is_vrm: bool) -> Vec<u8> {
    let meta = || {
        VrmMeta::new("mannequin", vec!["uvgraft's tests".to_owned()], Permissions::NON_COMMERCIAL)
    };
    let export =
        Export { name: "mannequin".to_owned(), vrm: is_vrm.then(meta), ..Export::default() };
    write(&avatar(), &AvatarMaterial::new(texture()), &export).expect("a sound avatar").bytes
}

/// Centres of the boxes' front faces in a pose, with a weight for the expression "happy".
pub fn fronts(avatar: &Avatar, pose: &Pose, happy: f32) -> Vec<[f32; 3]> {
    let positions = avatar.posed(pose, &[happy]).expect("a sound pose");
    let front =
        |corners: &[[f32; 3]]| [0, 1, 2].map(|k| (4..8).map(|c| corners[c][k]).sum::<f32>() / 4.0);
    positions.chunks_exact(8).map(front).collect()
}
