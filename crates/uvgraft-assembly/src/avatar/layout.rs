//! The UV layouts of an avatar: the body's alone, or the head's own next to it.

use std::sync::Arc;

use uvgraft::{Blend, BlendDomain, Direction, Mesh, Pair, SourceLayout, ToneCorrection};
use uvgraft_avatar::Avatar;
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{Blame, Failure, Result};

use super::request::AvatarRequest;

/// Index of the head's material.
const HEAD: u8 = 1;

/// Least share of the region that must consist of whole triangles of the head's mesh.
const MIN_SHARE: f64 = 0.5;

/// The head's own layout on the body, and the blend of its texture there.
pub(super) struct HeadLayout {
    own: SourceLayout,
    blend: Arc<Blend>,
    toning: Option<ToneCorrection>,
}

impl HeadLayout {
    /// - `blend`: that of the body's layout.
    /// - `shown`: its region without cloth.
    pub(super) fn new(
        request: &AvatarRequest,
        file: &PairFile,
        blend: &Blend,
        shown: &Blend,
        toning: Option<&ToneCorrection>,
    ) -> Result<Self> {
        let own = SourceLayout::new(&file.pair, shown.touched()).or_input()?;
        let Some(own) = own.filter(|own| own.share >= MIN_SHARE) else {
            return Err(Failure::option(format!(
                "{}: `texture_layout` head+body needs a body whose head has the same triangles as \
                 the head mesh; use `texture_layout` atlas",
                request.pair_name()
            )));
        };
        let domain = BlendDomain::new(Arc::clone(&own.pair), Direction::Forward);
        let toning = toning.map(|toning| toning.with_layout(&domain)).transpose().or_work()?;
        Ok(Self { blend: Arc::new(blend.with_layout(&domain).or_input()?), own, toning })
    }

    /// From the head to its own layout on the body's surface.
    pub(super) fn pair(&self) -> &Arc<Pair> {
        &self.own.pair
    }

    pub(super) fn blend(&self) -> &Arc<Blend> {
        &self.blend
    }

    pub(super) fn toning(&self) -> Option<&ToneCorrection> {
        self.toning.as_ref()
    }

    /// Assigns the head's UV coordinates and material to the triangles of an avatar that belong to
    /// the head.
    ///
    /// - `avatar`: its triangles are those of the pair's target in order, minus removed ones,
    ///   followed by additional ones.
    pub(super) fn apply(&self, avatar: &mut Avatar) -> Result<()> {
        let (mesh, own) = (&avatar.mesh, self.own.pair.target());
        let mut uv = mesh.uv().to_vec();
        let first = uv.len() as u32;
        uv.extend_from_slice(own.uv());
        let mut uv_faces = mesh.uv_faces().to_vec();
        avatar.materials.resize(mesh.faces().len(), 0);
        let mut face = 0;
        let of_head = self.own.faces.iter().zip(own.faces().iter().zip(own.uv_faces()));
        for (&is_head, (vertices, corners)) in of_head {
            if mesh.faces().get(face) != Some(vertices) {
                continue;
            }
            if is_head {
                uv_faces[face] = corners.map(|corner| first + corner);
                avatar.materials[face] = HEAD;
            }
            face += 1;
        }
        let positions = mesh.positions().to_vec();
        avatar.mesh = Mesh::from_triangles(positions, uv, mesh.faces(), &uv_faces).or_work()?;
        Ok(())
    }
}
