//! A body model as an avatar, and the deviation due to file formats without pose correctives.

use glam::Vec3;
use uvgraft::Mesh;

use super::{BodyError, Shaped};
use crate::Avatar;
use crate::rig::{Clip, MAX_INFLUENCES, RigError};

/// Distance between corresponding vertices of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Mean over vertices and frames, in millimetres.
    pub mean_mm: f64,
    /// Maximum over vertices and frames, in millimetres.
    pub max_mm: f64,
}

impl Shaped<'_> {
    /// Rigs a mesh with the same triangles: it takes on this shape and keeps its UV layout. It gets
    /// no morphs; see [`Shaped::expressions`] and [`Shaped::components`].
    ///
    /// # Errors
    /// [`BodyError::Count`] for another number of vertices, [`BodyError::Triangles`] for triangles
    /// that only one of the two has; their first corner and winding don't matter.
    pub fn avatar(&self, mesh: Mesh) -> Result<Avatar, BodyError> {
        let (found, wanted) = (mesh.positions().len(), self.positions.len());
        if found != wanted {
            return Err(BodyError::Count { what: "vertices in the mesh", found, wanted });
        }
        self.check_triangles(&mesh)?;
        let mesh = mesh
            .with_positions(self.positions.clone())
            .map_err(|_| RigError::NotFinite { what: "a vertex of the shape".to_owned() })?;
        Ok(Avatar {
            mesh,
            materials: Vec::new(),
            skeleton: self.skeleton.clone(),
            skin: self.model.skin.clone(),
            morphs: Vec::new(),
            expressions: Vec::new(),
            clips: Vec::new(),
        })
    }

    fn check_triangles(&self, mesh: &Mesh) -> Result<(), BodyError> {
        let sorted = |triangles: &[[u32; 3]]| {
            let mut triangles = triangles.to_vec();
            triangles.iter_mut().for_each(|corners| corners.sort_unstable());
            triangles.sort_unstable();
            triangles
        };
        let (of_mesh, of_model) = (sorted(mesh.faces()), sorted(&self.model.triangles));
        if of_mesh == of_model {
            return Ok(());
        }
        let missing = |some: &[[u32; 3]], others: &[[u32; 3]]| {
            some.iter().filter(|&triangle| others.binary_search(triangle).is_err()).count()
        };
        let only_mesh = missing(&of_mesh, &of_model);
        let only_model = missing(&of_model, &of_mesh);
        if only_mesh == 0 && only_model == 0 {
            // One of them contains a triangle twice, which has no visible effect.
            return Ok(());
        }
        Err(BodyError::Triangles {
            kind: self.model.kind.name(),
            only_mesh,
            mesh: of_mesh.len(),
            only_model,
            model: of_model.len(),
        })
    }

    /// Measures how far an avatar of this body deviates from the model over a clip, after aligning
    /// their roots at rest: the loss due to files without pose correctives and with four weights a
    /// vertex.
    ///
    /// # Errors
    /// [`BodyError::Count`] if the avatar has another number of vertices, [`BodyError::Rig`] if the
    /// clip belongs to another skeleton.
    pub fn deviation(&self, avatar: &Avatar, clip: &Clip) -> Result<Deviation, BodyError> {
        let (found, wanted) = (avatar.mesh.positions().len(), self.positions.len());
        if found != wanted {
            return Err(BodyError::Count { what: "vertices in the avatar", found, wanted });
        }
        // The weights as stored in a file, and the avatar's shift from the model.
        let skin = avatar.skin.pruned(MAX_INFLUENCES).0;
        let roots =
            [&avatar.skeleton, &self.skeleton].map(|rig| Vec3::from(rig.joints()[0].position));
        let moved = roots[0] - roots[1];
        let (mut sum, mut max_mm) = (0.0_f64, 0.0_f64);
        for poses in clip.poses.chunks(super::correctives::BLOCK) {
            for (pose, exact) in poses.iter().zip(self.posed_frames(poses)?) {
                let motions = avatar.skeleton.motions(pose)?;
                let posed = skin.pose(avatar.mesh.positions(), &motions);
                for (found, wanted) in posed.iter().zip(&exact) {
                    let distance = (Vec3::from(*found) - moved).distance(Vec3::from(*wanted));
                    let distance_mm = f64::from(distance) * 1000.0;
                    sum += distance_mm;
                    max_mm = max_mm.max(distance_mm);
                }
            }
        }
        let count = (clip.poses.len() * wanted).max(1);
        Ok(Deviation { mean_mm: sum / count as f64, max_mm })
    }
}
