//! A body model as an avatar: what stays of it in files that know no pose correctives.

use uvgraft::Mesh;

use super::{BodyError, Shaped};
use crate::Avatar;
use crate::rig::{Clip, Expression, ExpressionPreset, Morph, RigError};

/// How far the jaw opens, in radians: as far as in speech.
const JAW_OPEN: f32 = 0.25;

/// How far two bodies are from each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// The mean over vertices and frames, in millimetres.
    pub mean_mm: f64,
    /// The vertex and frame that is farthest away, in millimetres.
    pub max_mm: f64,
}

impl Shaped<'_> {
    /// Rigs a mesh of the same triangles: it takes this shape and keeps its layout.
    ///
    /// The first `expressions` components of expression become morphs `expression_00` and so on, each
    /// with a coefficient of 1 where its weight is 1. Bodies with a jaw get a morph `jaw_open`,
    /// correctives included, which is VRM's expression `aa`.
    ///
    /// # Errors
    /// [`BodyError::Count`] for another number of vertices, [`BodyError::Triangles`] for triangles that
    /// only one of the two has; where their corners begin and which way they wind does not matter.
    pub fn avatar(&self, mesh: Mesh, expressions: usize) -> Result<Avatar, BodyError> {
        let (found, wanted) = (mesh.positions().len(), self.positions.len());
        if found != wanted {
            return Err(BodyError::Count { what: "vertices in the mesh", found, wanted });
        }
        self.check_triangles(&mesh)?;
        let mut morphs: Vec<Morph> = (0..expressions.min(self.model.expressions()))
            .map(|component| {
                let name = format!("expression_{component:02}");
                Morph::from_dense(name, self.model.expression(component))
            })
            .collect();
        let mut named = Vec::new();
        if let Some(jaw) = self.model.kind.jaw() {
            named.push(Expression::preset(ExpressionPreset::Aa, vec![(morphs.len(), 1.0)]));
            morphs.push(self.jaw_open(jaw)?);
        }
        let mesh = mesh
            .with_positions(self.positions.clone())
            .map_err(|_| RigError::NotFinite { what: "a vertex of the shape".to_owned() })?;
        Ok(Avatar {
            mesh,
            materials: Vec::new(),
            skeleton: self.skeleton.clone(),
            skin: self.model.skin.clone(),
            morphs,
            expressions: named,
            clips: Vec::new(),
        })
    }

    fn jaw_open(&self, jaw: usize) -> Result<Morph, RigError> {
        let mut turns = vec![[0.0; 3]; self.skeleton.joints().len()];
        turns[jaw] = [JAW_OPEN, 0.0, 0.0];
        let open = self.posed(&crate::rig::Pose::from_axis_angles([0.0; 3], &turns))?;
        let offset = |(open, rest): (&[f32; 3], &[f32; 3])| {
            std::array::from_fn(|axis| open[axis] - rest[axis])
        };
        let offsets: Vec<[f32; 3]> = open.iter().zip(&self.positions).map(offset).collect();
        Ok(Morph::from_dense("jaw_open", &offsets))
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
            // One of them has a triangle twice, which nothing that is drawn shows.
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

    /// How far an avatar of this body is from the model over a clip: what files lose that know no
    /// pose correctives, and what is lost with pruned weights.
    ///
    /// # Errors
    /// [`BodyError::Count`] if the avatar has another number of vertices, [`BodyError::Rig`] for a clip
    /// of another skeleton.
    pub fn apart(&self, avatar: &Avatar, clip: &Clip) -> Result<Apart, BodyError> {
        let (found, wanted) = (avatar.mesh.positions().len(), self.positions.len());
        if found != wanted {
            return Err(BodyError::Count { what: "vertices in the avatar", found, wanted });
        }
        let (mut sum, mut max_mm) = (0.0_f64, 0.0_f64);
        for poses in clip.poses.chunks(super::correctives::BLOCK) {
            for (pose, exact) in poses.iter().zip(self.posed_frames(poses)?) {
                for (found, wanted) in avatar.posed(pose, &[])?.iter().zip(&exact) {
                    let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
                    let distance: f64 = found.iter().zip(wanted).map(square).sum();
                    let distance_mm = distance.sqrt() * 1000.0;
                    sum += distance_mm;
                    max_mm = max_mm.max(distance_mm);
                }
            }
        }
        let count = (clip.poses.len() * wanted).max(1);
        Ok(Apart { mean_mm: sum / count as f64, max_mm })
    }
}
