//! Triangles that nobody sees: the backs of eyeballs.

use glam::{DMat3, DVec3, Vec3};
use uvgraft::disjoint::DisjointSets;

use crate::Avatar;
use crate::rig::HumanBone;

/// How far eyes turn from straight ahead, in degrees; with it the part of an eyeball that may show grows.
const TURN: f32 = 35.0;

/// What lids open further in a surprised face, and the width of a triangle, in degrees.
const MARGIN: f32 = 10.0;

/// How far an eyeball's vertices may be from a sphere, in parts of its radius: corneas bulge.
const ROUNDNESS: f32 = 0.2;

/// Which triangles nobody sees.
///
/// An eyeball is a piece of the mesh that follows an eye's joint alone and is about a sphere. How wide
/// the lids are open is measured from its centre: a direction in the front half that meets nothing but
/// the eyeball is open. Triangles farther from straight ahead (+Z) than the widest open direction, the
/// 35° that eyes turn and 10° to be safe stay behind the lids.
pub fn hidden(avatar: &Avatar) -> Vec<bool> {
    let mut is_hidden = vec![false; avatar.mesh.faces().len()];
    let pieces = pieces(avatar);
    for bone in [HumanBone::LeftEye, HumanBone::RightEye] {
        let Some(joint) = avatar.skeleton.human(bone) else { continue };
        for eyeball in eyeballs(avatar, joint, &pieces) {
            mark(avatar, &eyeball, &pieces, &mut is_hidden);
        }
    }
    is_hidden
}

/// For each vertex the piece that it is in: vertices that triangles join, or that are at one place.
fn pieces(avatar: &Avatar) -> Vec<u32> {
    let mesh = &avatar.mesh;
    let count = mesh.positions().len() as u32;
    let mut sets = DisjointSets::new(count);
    let mut known = std::collections::HashMap::new();
    for (vertex, position) in (0..).zip(mesh.positions()) {
        let key = position.map(|value| (value + 0.0).to_bits());
        sets.join(vertex, *known.entry(key).or_insert(vertex));
    }
    for &[a, b, c] in mesh.faces() {
        sets.join(a, b);
        sets.join(b, c);
    }
    (0..count).map(|vertex| sets.root(vertex)).collect()
}

/// A piece of the mesh that is about a sphere.
struct Eyeball {
    piece: u32,
    center: Vec3,
}

/// The pieces all of whose vertices follow a joint alone and that are round.
fn eyeballs(avatar: &Avatar, joint: usize, pieces: &[u32]) -> Vec<Eyeball> {
    let follows = |vertex: usize| {
        matches!(avatar.skin.of(vertex), [(first, weight), ..]
            if usize::from(*first) == joint && *weight > 0.99)
    };
    let mut found: Vec<u32> =
        (0..pieces.len()).filter(|&v| follows(v)).map(|v| pieces[v]).collect();
    found.sort_unstable();
    found.dedup();
    let mut eyeballs = Vec::new();
    for piece in found {
        let own: Vec<usize> = (0..pieces.len()).filter(|&v| pieces[v] == piece).collect();
        if !own.iter().all(|&vertex| follows(vertex)) {
            continue;
        }
        let places: Vec<Vec3> =
            own.iter().map(|&vertex| avatar.mesh.positions()[vertex].into()).collect();
        let Some((center, radius)) = sphere(&places) else { continue };
        let off = |place: &Vec3| (place.distance(center) - radius).abs();
        if places.iter().all(|place| off(place) < ROUNDNESS * radius) {
            eyeballs.push(Eyeball { piece, center });
        }
    }
    eyeballs
}

/// The sphere that is nearest to points by least squares: its centre and radius. Eyeballs may be open at
/// their backs, so the middle of a box would not do.
///
/// With points measured from their mean, |p|² = 2 c·p + constant is linear in the centre c.
fn sphere(places: &[Vec3]) -> Option<(Vec3, f32)> {
    let count = places.len() as f64;
    let mean = places.iter().map(|place| place.as_dvec3()).sum::<DVec3>() / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for place in places {
        let p = place.as_dvec3() - mean;
        matrix += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * p.length_squared() / 2.0;
    }
    // What is flat has no sphere; the scale makes the determinant one of shape.
    let scale = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) / 3.0;
    if matrix.determinant() <= 1e-6 * scale.powi(3) {
        return None;
    }
    let center = (mean + matrix.inverse() * right).as_vec3();
    let radius = places.iter().map(|place| place.distance(center)).sum::<f32>() / count as f32;
    Some((center, radius))
}

fn mark(avatar: &Avatar, eyeball: &Eyeball, pieces: &[u32], is_hidden: &mut [bool]) {
    let &Eyeball { piece, center } = eyeball;
    let mesh = &avatar.mesh;
    let corners = |face: usize| {
        mesh.faces()[face].map(|vertex| Vec3::from(mesh.positions()[vertex as usize]) - center)
    };
    let is_own = |face: &usize| pieces[mesh.faces()[*face][0] as usize] == piece;
    let (own, others): (Vec<usize>, Vec<usize>) = (0..mesh.faces().len()).partition(is_own);
    // Whatever is behind the eye covers nothing in front.
    let before = |triangle: &[Vec3; 3]| triangle.iter().any(|corner| corner.z > 0.0);
    let covers: Vec<[Vec3; 3]> = others.into_iter().map(corners).filter(before).collect();
    let open = |direction: &Vec3| !covers.iter().any(|cover| is_hit(*direction, cover));
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

/// Whether a ray from the origin meets a triangle.
///
/// Based on Möller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997.
fn is_hit(direction: Vec3, &[a, b, c]: &[Vec3; 3]) -> bool {
    let (p, q) = (b - a, c - a);
    let across = direction.cross(q);
    let determinant = p.dot(across);
    if determinant == 0.0 {
        return false;
    }
    let u = -a.dot(across) / determinant;
    let turned = (-a).cross(p);
    let v = direction.dot(turned) / determinant;
    let distance = q.dot(turned) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;

    use super::*;
    use crate::rig::{Joint, Skeleton, Skin};

    const RINGS: usize = 18;
    const SIDES: usize = 12;

    /// A ball around the Z axis with a vertex every 10° and 30°, and before it a square frame whose opening
    /// reaches `opening` degrees to either side.
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
    fn what_lids_never_show_is_hidden() {
        let hidden = hidden(&eye(42.0));
        // Along the opening's diagonal vertices at 45° and more might show: tan 42° · √2 is tan 51.9°,
        // but vertices stand at 30° around and their corners are covered. Straight up the last open
        // ring is at 40°; at 30° and 60° around, the opening reaches 42° / cos 30° or 46.1°.
        // So 40° + 45° = 85°, and rings from 90° on may go: nine bands of 24 triangles.
        let count = hidden.iter().filter(|&&is_hidden| is_hidden).count();
        assert_eq!(count, 9 * 2 * SIDES);
        assert!(hidden[9 * 2 * SIDES..RINGS * 2 * SIDES].iter().all(|&is_hidden| is_hidden));
    }

    #[test]
    fn part_of_a_sphere_is_enough_to_know_it() {
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
    fn more_stays_where_lids_are_wide_and_what_is_no_eyeball_stays() {
        let count = |avatar: &Avatar| hidden(avatar).into_iter().filter(|&h| h).count();
        // 60° and 45°: from 110° on.
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
