//! Triangles that are never visible: the backs of eyeballs.

use glam::Vec3;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::eyes::eyeball::{Eyeball, eyeballs, pieces};
use uvgraft_avatar::ray::intersect;
use uvgraft_avatar::rig::HumanBone;

/// Largest rotation of the eyes from straight ahead, in degrees; it widens the part of the
/// eyeball that can become visible.
const TURN: f32 = 35.0;

/// Safety margin, in degrees: for lids that open wider in a surprised face, and for the width of a
/// triangle.
const MARGIN: f32 = 10.0;

/// For each triangle, whether it is never visible.
///
/// An eyeball is a connected component of the mesh that follows only an eye's joint and is nearly a
/// sphere. The opening of the lids is measured from its centre: a direction in the front half is
/// open if its ray hits nothing but the eyeball. Triangles whose angle from straight ahead (+Z) is
/// larger than that of the widest open direction, plus the 35° that eyes rotate and a margin of
/// 10°, always stay behind the lids.
pub fn hidden(avatar: &Avatar) -> Vec<bool> {
    let mut is_hidden = vec![false; avatar.mesh.faces().len()];
    let pieces = pieces(&avatar.mesh);
    for bone in [HumanBone::LeftEye, HumanBone::RightEye] {
        for eyeball in eyeballs(avatar, bone, &pieces) {
            mark(avatar, &eyeball, &pieces, &mut is_hidden);
        }
    }
    is_hidden
}

fn mark(avatar: &Avatar, eyeball: &Eyeball, pieces: &[u32], is_hidden: &mut [bool]) {
    let &Eyeball { piece, center, .. } = eyeball;
    let mesh = &avatar.mesh;
    let corners = |face: usize| {
        mesh.faces()[face].map(|vertex| Vec3::from(mesh.positions()[vertex as usize]) - center)
    };
    let is_own = |face: &usize| pieces[mesh.faces()[*face][0] as usize] == piece;
    let (own, others): (Vec<usize>, Vec<usize>) = (0..mesh.faces().len()).partition(is_own);
    // Triangles behind the eye's centre cannot cover its front.
    let before = |triangle: &[Vec3; 3]| triangle.iter().any(|corner| corner.z > 0.0);
    let covers: Vec<[Vec3; 3]> = others.into_iter().map(corners).filter(before).collect();
    let open = |direction: &Vec3| {
        !covers.iter().any(|cover| intersect(Vec3::ZERO, *direction, cover).is_some())
    };
    let ahead: Vec<Vec3> = (0..pieces.len())
        .filter(|&vertex| pieces[vertex] == piece)
        .map(|vertex| Vec3::from(mesh.positions()[vertex]) - center)
        .filter(|direction| direction.z > 0.0)
        .collect();
    let widest =
        ahead.into_iter().filter(open).map(|d| d.angle_between(Vec3::Z)).fold(0.0, f32::max);
    let limit = widest + (TURN + MARGIN).to_radians();
    for face in own {
        is_hidden[face] = corners(face).iter().all(|corner| corner.angle_between(Vec3::Z) > limit);
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;
    use uvgraft_avatar::eyes::eyeball::sphere;
    use uvgraft_avatar::rig::{Joint, Skeleton, Skin};

    use super::*;

    const RINGS: usize = 18;
    const SIDES: usize = 12;

    /// A sphere around the Z axis with a vertex every 10° and 30°, and in front of it a square
    /// frame whose opening reaches `opening` degrees to either side.
    fn eye(opening: f32) -> Avatar {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for ring in 0..=RINGS {
            let (sin, cos) = (10.0 * ring as f32).to_radians().sin_cos();
            for side in 0..SIDES {
                let (y, x) = (30.0 * side as f32).to_radians().sin_cos();
                positions.push([0.012 * sin * x, 1.6 + 0.012 * sin * y, 0.012 * cos]);
            }
        }
        let quad = |a, b, c, d| [[a, b, c], [a, c, d]];
        for ring in 0..RINGS {
            for side in 0..SIDES {
                let v = |up, on| ((ring + up) * SIDES + (side + on) % SIDES) as u32;
                faces.extend(quad(v(0, 0), v(1, 0), v(1, 1), v(0, 1)));
            }
        }
        let balls = positions.len();
        let inner = 0.02 * opening.to_radians().tan();
        for half in [inner, 100.0] {
            let corner = |[x, y]: [f32; 2]| [half * x, 1.6 + half * y, 0.02];
            positions.extend([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner));
        }
        for side in 0..4 {
            let v = |up: usize, on: usize| (balls + 4 * up + (side + on) % 4) as u32;
            faces.extend(quad(v(0, 0), v(0, 1), v(1, 1), v(1, 0)));
        }
        let joint = |name: &str, parent, human| Joint {
            name: name.to_owned(),
            parent,
            position: [0.0, 1.6, 0.0],
            human,
        };
        let joints =
            vec![joint("head", None, None), joint("eye", Some(0), Some(HumanBone::LeftEye))];
        let weights = (0..positions.len()).map(|vertex| [(usize::from(vertex < balls), 1.0)]);
        let skin = Skin::new(weights, 2).unwrap();
        let uv = vec![[0.0; 2]; positions.len()];
        Avatar {
            mesh: Mesh::from_triangles(positions, uv, &faces, &faces).unwrap(),
            materials: Vec::new(),
            skeleton: Skeleton::new(joints).unwrap(),
            skin,
            morphs: Vec::new(),
            expressions: Vec::new(),
            clips: Vec::new(),
        }
    }

    #[test]
    fn triangles_always_behind_lids_are_hidden() {
        let hidden = hidden(&eye(42.0));
        // Along the opening's diagonal, vertices at 45° and more might be visible: tan 42° · √2
        // is tan 51.9°, but vertices are at 30° steps around the axis, and the diagonal has
        // none. Straight up, the last open ring is at 40°; at 30° and 60° around, the opening
        // reaches 42° / cos 30° or 46.1°. So the limit is 40° + 45° = 85°, and rings from 90° on
        // may go: nine bands of 24 triangles.
        let count = hidden.iter().filter(|&&is_hidden| is_hidden).count();
        assert_eq!(count, 9 * 2 * SIDES);
        assert!(hidden[9 * 2 * SIDES..RINGS * 2 * SIDES].iter().all(|&is_hidden| is_hidden));
    }

    #[test]
    fn a_cap_determines_its_sphere() {
        let center = Vec3::new(0.03, 1.6, 0.06);
        let cap: Vec<Vec3> = eye(42.0).mesh.positions()[..8 * SIDES]
            .iter()
            .map(|&position| Vec3::from(position) + center - Vec3::new(0.0, 1.6, 0.0))
            .collect();
        let (found, radius) = sphere(&cap).unwrap();
        assert!(found.distance(center) < 1e-6 && (radius - 0.012).abs() < 1e-6, "{found} {radius}");
        assert_eq!(sphere(&cap[SIDES..2 * SIDES]), None);
    }

    #[test]
    fn wide_lids_hide_less_and_other_shapes_stay() {
        let count = |avatar: &Avatar| hidden(avatar).into_iter().filter(|&h| h).count();
        // 60° + 45°: hidden from 110° on.
        assert_eq!(count(&eye(62.0)), 7 * 2 * SIDES);
        let mut other = eye(42.0);
        let joints = other.skeleton.joints().to_vec();
        let joints = joints.into_iter().map(|joint| Joint { human: None, ..joint });
        other.skeleton = Skeleton::new(joints.collect()).unwrap();
        assert_eq!(count(&other), 0);
        // An ellipsoid.
        let mut flat = eye(42.0);
        let positions = flat.mesh.positions().iter().map(|&[x, y, z]| [2.0 * x, y, z]).collect();
        flat.mesh = flat.mesh.with_positions(positions).unwrap();
        assert_eq!(count(&flat), 0);
    }
}
