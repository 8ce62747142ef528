//! The body with the face on it: shape, textures, eyes and mouth.

use uvgraft::{Texture, threads};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::Deviation;
use uvgraft_avatar::mouth::{Mouth, MouthError};
use uvgraft_gltf::glb::VrmError;
use uvgraft_pipeline::{Failure, Observer, Result};

use super::body::RiggedBody;
use super::face::Face;
use super::face_transfer::{self, AvatarTextures};
use super::ingredients::Ingredients;
use super::maps::TransferredMaps;
use super::plan::Plan;
use super::request::AvatarRequest;
use super::{expressions, features};
use crate::report::Report;

/// An avatar that only has to be fitted to its limits and written.
pub(super) struct Assembled {
    pub(super) avatar: Avatar,
    /// What to call the body.
    pub(super) name: String,
    /// The deviation of each clip from the body model.
    pub(super) apart: Vec<(String, Deviation)>,
    /// The grounding of each clip.
    pub(super) grounds: Vec<String>,
    /// The terms of the body model.
    pub(super) license: Option<String>,
    /// The body's colours with the face.
    pub(super) color: Texture,
    /// The head's own, if it keeps its layout.
    pub(super) head: Option<Texture>,
    pub(super) maps: TransferredMaps,
    /// Number of triangles of the fitted mouth.
    pub(super) mouth: Option<usize>,
    pub(super) preview: Option<Texture>,
    pub(super) labels: Option<Texture>,
    /// The report on the photographs.
    pub(super) of_photos: Report,
}

type FittedMouth = Option<std::result::Result<Mouth, MouthError>>;

impl Assembled {
    pub(super) fn new(
        request: &AvatarRequest,
        plan: &Plan,
        ingredients: Ingredients,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let Ingredients { file, given, parted, mut body, selfie } = ingredients;
        let (shaped, textures) = threads::join(
            || {
                if let Some(selfie) = &selfie {
                    body.avatar = request.shaped(selfie, &given, body.avatar, &body.name)?;
                }
                if let Some(parted) = &parted {
                    body.avatar = features::with_layout(body.avatar, &parted.mesh)?;
                }
                let mouth: FittedMouth = match body.has_mouth {
                    true => None,
                    false => request.fit_mouth(&body.avatar),
                };
                Ok::<_, Failure>((body, mouth))
            },
            || {
                let preset = plan.preset.as_ref();
                let (face, base) = threads::join(
                    || match (&selfie, &request.face) {
                        (Some(selfie), _) => Ok(Face::of_selfie(selfie)),
                        (None, Some(face)) => Face::read(face, observer),
                        (None, None) => Err(Failure::input("a face texture is required")),
                    },
                    || face_transfer::base_texture(request, preset),
                );
                let mut base = base?;
                if let Some(parted) = &parted {
                    parted.copy(&mut base);
                }
                face_transfer::transfer_face(request, &file, face?, base, preset, observer)
            },
        );
        let ((body, mouth), textures) = (shaped?, textures?);
        observer.check()?;
        check_bones(request, plan, &body)?;
        if let (Some((kind, solved)), Some(model)) = (&body.solved, request.model()) {
            expressions::report(model, *kind, solved, &body.avatar, observer);
        }
        let of_photos = selfie.map(|selfie| selfie.report(&file.source_name)).unwrap_or_default();
        with_features(request, body, mouth, textures, of_photos, observer)
    }
}

/// Rejects bodies that a VRM file cannot hold, before messages about a face that will never be in one.
fn check_bones(request: &AvatarRequest, plan: &Plan, body: &RiggedBody) -> Result<()> {
    let missing = body.avatar.skeleton.missing_bones();
    if plan.vrm.is_none() || missing.is_empty() {
        return Ok(());
    }
    let (name, why) = (&body.name, VrmError::MissingBones { bones: missing });
    Err(Failure::input(format!("{name} as {}: {why}", request.file_name.display())))
}

/// Draws the eyes, attaches the mouth and transfers the other maps.
fn with_features(
    request: &AvatarRequest,
    body: RiggedBody,
    mouth: FittedMouth,
    textures: AvatarTextures<'_>,
    of_photos: Report,
    observer: &dyn Observer,
) -> Result<Assembled> {
    let RiggedBody { avatar, name, apart, grounds, license, .. } = body;
    let AvatarTextures { body: mut color, head, map_transfer, preview, labels } = textures;
    request.draw_eyes(&avatar, &mut color, &name, observer);
    let (mut avatar, mouth) = match mouth {
        Some(mouth) => features::with_mouth(avatar, mouth, &mut color, &name, observer)?,
        None => (avatar, None),
    };
    if let Some(layout) = &map_transfer.head {
        layout.apply(&mut avatar)?;
    }
    observer.check()?;
    let maps = request.materials.transfer(&map_transfer, color.size())?;
    Ok(Assembled {
        avatar,
        name,
        apart,
        grounds,
        license,
        color,
        head,
        maps,
        mouth,
        preview,
        labels,
        of_photos,
    })
}
