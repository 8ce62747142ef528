//! A rigged mesh, as it is exported to a GLB or VRM file.

use glam::Vec3;
use uvgraft::Mesh;

use crate::motion::Soles;
use crate::rig::{Clip, Expression, HumanBone, Morph, Pose, RigError, Skeleton, Skin};

/// A rigged body. Its mesh is in the rest pose, in metres, Y up, facing +Z.
#[derive(Debug, Clone)]
pub struct Avatar {
    /// The mesh at rest, with its UV layout.
    pub mesh: Mesh,
    /// `[triangles]`, the index of each triangle's material, which its UV coordinates refer to;
    /// empty if all triangles use material 0.
    pub materials: Vec<u8>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Skinning weights of the vertices.
    pub skin: Skin,
    /// Morph targets.
    pub morphs: Vec<Morph>,
    /// Named combinations of morph targets.
    pub expressions: Vec<Expression>,
    /// Animations.
    pub clips: Vec<Clip>,
}

impl Avatar {
    /// Checks that the parts are consistent.
    ///
    /// # Errors
    /// [`RigError`] if counts disagree, indices are out of range or values are not finite.
    pub fn check(&self) -> Result<(), RigError> {
        let count = |what, found, wanted| {
            if found == wanted { Ok(()) } else { Err(RigError::Count { what, found, wanted }) }
        };
        let vertices = self.mesh.positions().len();
        count("vertices with weights", self.skin.vertices(), vertices)?;
        if !self.materials.is_empty() {
            count("triangles with materials", self.materials.len(), self.mesh.faces().len())?;
        }
        let joints = self.skeleton.joints().len();
        for vertex in 0..vertices {
            if self.skin.of(vertex).iter().any(|&(joint, _)| usize::from(joint) >= joints) {
                let problem = "has a weight for a joint that does not exist";
                return Err(RigError::Weights { vertex, problem });
            }
        }
        for morph in &self.morphs {
            for (vertex, offset) in &morph.offsets {
                if *vertex as usize >= vertices || !offset.iter().all(|value| value.is_finite()) {
                    let what = format!("morph `{}` at vertex {vertex}", morph.name);
                    return Err(RigError::NotFinite { what });
                }
            }
        }
        for expression in &self.expressions {
            let known = |&(morph, _): &(usize, f32)| morph < self.morphs.len();
            let found = expression.morphs.iter().filter(|entry| known(entry)).count();
            count("morphs of an expression", found, expression.morphs.len())?;
        }
        self.clips.iter().try_for_each(|clip| clip.check(joints))
    }

    /// The material index of a triangle.
    pub fn material(&self, face: usize) -> u8 {
        self.materials.get(face).copied().unwrap_or(0)
    }

    /// Vertex positions in a pose, with morph targets applied with the weights `morphs`.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn posed(&self, pose: &Pose, morphs: &[f32]) -> Result<Vec<[f32; 3]>, RigError> {
        let motions = self.skeleton.motions(pose)?;
        let mut positions = self.mesh.positions().to_vec();
        for (morph, &weight) in self.morphs.iter().zip(morphs) {
            morph.add(weight, &mut positions);
        }
        Ok(self.skin.pose(&positions, &motions))
    }

    /// Moves the avatar onto the floor: its lowest vertex at rest goes to y = 0 and the origin lies
    /// between its feet. Clips need no change, because poses are relative to rest. An avatar
    /// without two feet, such as a head, stays where it is.
    ///
    /// # Errors
    /// [`RigError::NotFinite`] if the shift makes a position overflow.
    pub fn standing(mut self) -> Result<Self, RigError> {
        let Some(shift) = self.floor_shift() else { return Ok(self) };
        let moved = |place: [f32; 3]| (Vec3::from(place) + shift).into();
        let positions = self.mesh.positions().iter().map(|&place| moved(place)).collect();
        let mut joints = self.skeleton.joints().to_vec();
        for joint in &mut joints {
            joint.position = moved(joint.position);
        }
        self.skeleton = Skeleton::new(joints)?;
        self.mesh = self
            .mesh
            .with_positions(positions)
            .map_err(|_| RigError::NotFinite { what: "a vertex on the floor".to_owned() })?;
        Ok(self)
    }

    /// The translation onto the floor; `None` without two feet.
    fn floor_shift(&self) -> Option<Vec3> {
        let foot = |bone| {
            let joint = self.skeleton.human(bone)?;
            Some(Vec3::from(self.skeleton.joints()[joint].position))
        };
        let between = (foot(HumanBone::LeftFoot)? + foot(HumanBone::RightFoot)?) / 2.0;
        let lowest = self.lowest(self.mesh.positions())?;
        Some(-Vec3::new(between.x, lowest, between.z))
    }

    /// The soles of the feet: see [`Soles`].
    pub fn soles(&self) -> Option<Soles> {
        Soles::new(self.mesh.positions(), &self.skin, &self.skeleton)
    }

    /// Height of the lowest vertex that belongs to a triangle; `None` without triangles.
    ///
    /// - `positions`: of the mesh's vertices, as returned by [`Avatar::posed`].
    pub fn lowest(&self, positions: &[[f32; 3]]) -> Option<f32> {
        let vertices = self.mesh.faces().iter().flatten();
        vertices.map(|&vertex| positions[vertex as usize][1]).reduce(f32::min)
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;

    use super::*;
    use crate::rig::Joint;

    /// A triangle on two joints, with a morph and a clip.
    fn avatar() -> Avatar {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.5, 0.0]];
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let joint = |name: &str, parent, position| Joint {
            name: name.to_owned(),
            parent,
            position,
            human: None,
        };
        let joints = vec![joint("a", None, [0.0; 3]), joint("b", Some(0), [1.0, 0.0, 0.0])];
        let skin = [vec![(0, 1.0)], vec![(0, 0.5), (1, 0.5)], vec![(1, 1.0)]];
        let turns = [[0.1, 0.2, 0.3], [-0.5, 0.4, 0.2]];
        Avatar {
            mesh,
            materials: Vec::new(),
            skeleton: Skeleton::new(joints).unwrap(),
            skin: Skin::new(skin, 2).unwrap(),
            morphs: vec![Morph { name: "m".to_owned(), offsets: vec![(2, [0.0, 1.0, 0.0])] }],
            expressions: Vec::new(),
            clips: vec![Clip {
                name: "c".to_owned(),
                times: vec![0.0],
                poses: vec![Pose::from_axis_angles([0.3, 0.0, 0.0], &turns)],
            }],
        }
    }

    #[test]
    fn an_avatar_with_feet_stands_with_its_origin_between_them() {
        let before = avatar();
        assert_eq!(before.clone().standing().unwrap().skeleton, before.skeleton, "no feet");
        let mut hanging = avatar();
        let joints = [HumanBone::LeftFoot, HumanBone::RightFoot].map(Some);
        let places = [[0.3, -1.0, 0.1], [0.1, -0.8, 0.2]];
        let joint = |(number, (human, position))| Joint {
            name: format!("foot {number}"),
            parent: (number > 0).then_some(0),
            position,
            human,
        };
        let joints = joints.into_iter().zip(places).enumerate().map(joint).collect();
        hanging.skeleton = Skeleton::new(joints).unwrap();
        let positions = vec![[0.0, -1.4, 0.0], [1.0, 0.3, 0.0], [2.0, 0.5, 0.0]];
        hanging.mesh = hanging.mesh.with_positions(positions).unwrap();
        let pose = hanging.clips[0].poses[0].clone();
        let shown = hanging.posed(&pose, &[1.0]).unwrap();
        let standing = hanging.standing().unwrap();
        assert_eq!(standing.mesh.positions()[0][1], 0.0);
        let feet = standing.skeleton.joints();
        assert!((feet[0].position[0] + feet[1].position[0]).abs() < 1e-6);
        assert!((feet[0].position[2] + feet[1].position[2]).abs() < 1e-6);
        // Clips look the same apart from the shift.
        let move_ = Vec3::new(-0.2, 1.4, -0.15);
        for (before, after) in shown.iter().zip(standing.posed(&pose, &[1.0]).unwrap()) {
            assert!((Vec3::from(*before) + move_).abs_diff_eq(after.into(), 1e-5));
        }
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        avatar().check().unwrap();
        let mut wrong = avatar();
        wrong.morphs[0].offsets[0].0 = 3;
        wrong.check().unwrap_err();
        let mut wrong = avatar();
        wrong.clips[0].poses[0].rotations.pop();
        wrong.check().unwrap_err();
        let mut wrong = avatar();
        wrong.materials = vec![0, 1];
        wrong.check().unwrap_err();
        let mut wrong = avatar();
        wrong.expressions.push(Expression {
            name: "e".to_owned(),
            preset: None,
            morphs: vec![(1, 1.0)],
        });
        wrong.check().unwrap_err();
    }
}
