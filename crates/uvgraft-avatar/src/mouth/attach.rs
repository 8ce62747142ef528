//! Joins a mouth to its avatar: vertices, skinning weights and morphs.

use glam::{DVec3, Vec3};
use uvgraft::{Anatomy, Landmark, Mesh};

use super::motion::{Motion, near};
use super::piece::{Knot, Point};
use super::{Mouth, MouthError};
use crate::Avatar;
use crate::rig::{Morph, Skin};

/// Smaller weights of a joint come from the blending of skin weights, and are dropped.
const MIN: f32 = 0.03;

/// The joints that skull and jaw follow, with their weights.
#[derive(Debug, Clone)]
pub(super) struct MouthJoints {
    upper: Vec<(usize, f32)>,
    lower: Vec<(usize, f32)>,
}

impl MouthJoints {
    /// The skull follows the joints of the skin under the nose, the jaw those of the chin.
    pub fn find(avatar: &Avatar, anatomy: &Anatomy) -> Result<Self, MouthError> {
        let follows = |landmark, what, reach: f64| {
            let point = anatomy.point(landmark).ok_or(MouthError::Landmark(what))?;
            let near =
                near(avatar.mesh.positions(), DVec3::from(point), reach * anatomy.frame().unit);
            let mean = mean_weights(&avatar.skin, &near);
            if mean.is_empty() { Err(MouthError::Landmark(what)) } else { Ok(mean) }
        };
        Ok(Self {
            upper: follows(Landmark::NoseBase, "nose", 0.15)?,
            lower: follows(Landmark::Chin, "chin", 0.3)?,
        })
    }
}

fn mean_weights(skin: &Skin, vertices: &[u32]) -> Vec<(usize, f32)> {
    let mut sums: Vec<(usize, f32)> = Vec::new();
    for &vertex in vertices {
        add(&mut sums, skin.of(vertex as usize).iter().map(|&(j, w)| (usize::from(j), w)), 1.0);
    }
    let count = vertices.len().max(1) as f32;
    sums.iter_mut().for_each(|(_, weight)| *weight /= count);
    sums.retain(|&(_, weight)| weight >= MIN);
    sums
}

fn add(sums: &mut Vec<(usize, f32)>, weights: impl Iterator<Item = (usize, f32)>, share: f32) {
    for (joint, weight) in weights {
        match sums.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sum)) => *sum += share * weight,
            None => sums.push((joint, share * weight)),
        }
    }
}

pub(super) fn attach(mouth: &Mouth, avatar: Avatar) -> Result<Avatar, MouthError> {
    let points: Vec<Point> =
        mouth.pieces.iter().flat_map(|(piece, _)| piece.points.iter().copied()).collect();
    let world: Vec<Vec3> = points.iter().map(|point| mouth.frame.world(point.position)).collect();
    let mesh = mesh(mouth, &avatar.mesh, &world)?;
    let joints = avatar.skeleton.joints().len();
    let weights = points.iter().map(|point| weights(mouth, &avatar.skin, point));
    let skin = Skin::new(weights, joints).map_err(|_| MouthError::Weights)?;
    let skin = avatar.skin.followed_by(&skin);
    let first = avatar.mesh.positions().len() as u32;
    let morphs = avatar.morphs.iter().map(|morph| {
        let motion = mouth.jaw.motion(avatar.mesh.positions(), morph);
        with_mouth(morph, mouth, &motion, &points, &world, first)
    });
    let morphs = morphs.collect();
    Ok(Avatar { mesh, skin, morphs, ..avatar })
}

/// The avatar's mesh without its mouth sack, followed by the mouth's triangles.
fn mesh(mouth: &Mouth, own: &Mesh, world: &[Vec3]) -> Result<Mesh, MouthError> {
    let mut positions = own.positions().to_vec();
    let mut uv = own.uv().to_vec();
    let kept = |faces: &[[u32; 3]]| -> Vec<[u32; 3]> {
        let kept = faces.iter().zip(&mouth.rim.is_sack).filter(|(_, is_sack)| !**is_sack);
        kept.map(|(&face, _)| face).collect()
    };
    let (mut faces, mut uv_faces) = (kept(own.faces()), kept(own.uv_faces()));
    let mut first = positions.len() as u32;
    positions.extend(world.iter().map(Vec3::to_array));
    for (piece, place) in &mouth.pieces {
        let first_uv = uv.len() as u32;
        uv.extend(piece.corners.iter().map(|&(_, at)| place.uv(at)));
        let vertex = |corner: u32| match piece.corners[corner as usize].0 {
            Knot::Rim(at) => mouth.rim.vertices[at],
            Knot::Own(at) => first + at as u32,
        };
        faces.extend(piece.faces.iter().map(|face| face.map(vertex)));
        uv_faces.extend(piece.faces.iter().map(|face| face.map(|corner| first_uv + corner)));
        first += piece.points.len() as u32;
    }
    Ok(Mesh::from_triangles(positions, uv, &faces, &uv_faces)?)
}

fn weights(mouth: &Mouth, skin: &Skin, point: &Point) -> Vec<(usize, f32)> {
    let MouthJoints { upper, lower } = &mouth.followers;
    let (rim, share) = point.rim.unwrap_or((0, 0.0));
    let mut sums = Vec::new();
    add(&mut sums, upper.iter().copied(), (1.0 - share) * (1.0 - point.lower));
    add(&mut sums, lower.iter().copied(), (1.0 - share) * point.lower);
    let lips = skin.of(mouth.rim.vertices[rim] as usize);
    add(&mut sums, lips.iter().map(|&(joint, weight)| (usize::from(joint), weight)), share);
    sums
}

/// A morph with offsets for the mouth's points added: lips move with the rim, the jaw
/// rigidly, the skull not at all.
fn with_mouth(
    morph: &Morph,
    mouth: &Mouth,
    motion: &Motion,
    points: &[Point],
    world: &[Vec3],
    first: u32,
) -> Morph {
    /// A micrometre.
    const MIN_M: f32 = 1e-6;
    let mut of_rim = vec![Vec3::ZERO; mouth.rim.vertices.len()];
    for &(vertex, offset) in &morph.offsets {
        let at = mouth.rim.vertices.iter().position(|&rim| rim == vertex);
        if let Some(at) = at {
            of_rim[at] = offset.into();
        }
    }
    let offset = |(point, &position): (&Point, &Vec3)| {
        let bone = motion.offset(position) * point.lower;
        let (rim, share) = point.rim.unwrap_or((0, 0.0));
        bone * (1.0 - share) + of_rim[rim] * share
    };
    let new = (first..).zip(points.iter().zip(world).map(offset));
    let moved = new.filter(|(_, offset)| offset.length() > MIN_M);
    let mut offsets = morph.offsets.clone();
    offsets.extend(moved.map(|(vertex, offset)| (vertex, offset.to_array())));
    Morph { name: morph.name.clone(), offsets }
}
