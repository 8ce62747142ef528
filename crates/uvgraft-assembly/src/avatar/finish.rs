//! Fewer triangles, levels of detail, and the files.

use std::fmt::Display;

use uvgraft_avatar::Avatar;
use uvgraft_gltf::glb::{self, Export};
use uvgraft_gltf::preset::{self, FittedAvatar};
use uvgraft_pipeline::{Blame, Failure, Observer, Result};

use super::assembled::Assembled;
use super::levels::Levels;
use super::maps::Encoder;
use super::plan::Plan;
use super::request::AvatarRequest;
use super::summary::{AvatarSummary, Simplified};
use super::{AvatarFiles, metadata, thumbnail};

/// JPEG quality: textures are looked at closely, and base colours have no blur to hide blocks.
const JPEG_QUALITY: u8 = 92;

impl Assembled {
    /// Fits the avatar to its limits and writes its files.
    pub(super) fn finish(
        self,
        request: &AvatarRequest,
        plan: Plan,
        observer: &dyn Observer,
    ) -> Result<AvatarFiles> {
        let Fitted { avatar, normals, simplified } = Fitted::new(self.avatar, plan.triangles)?;
        observer.check()?;
        let levels = Levels::new(request.levels, &avatar, normals.as_deref())?;
        observer.check()?;
        let is_vrm = plan.vrm.is_some();
        let colors = [Some(&self.color), self.head.as_ref()].into_iter().flatten();
        let shown = is_vrm.then(|| thumbnail::Colors::new(colors));
        // Textures already have the preset's size.
        let quality = request.textures.quality.unwrap_or(JPEG_QUALITY);
        let encoder = Encoder { format: plan.format, quality, style: request.materials.look };
        let looks = self.maps.looks((self.color, self.head), &encoder).or_input()?;
        let (meta, license) = (&request.metadata, self.license.as_deref());
        let export = Export {
            name: meta.title(&request.file_name),
            copyright: meta.copyright(license),
            extras: if is_vrm { Default::default() } else { meta.extras(license) },
            thumbnail: shown.and_then(|shown| shown.thumbnail(&avatar, &looks, observer)),
            normals,
            vrm: plan.vrm.map(|vrm| metadata::with_body_terms(vrm, license)),
            levels: levels.inside(),
        };
        observer.check()?;
        let refused = |error: &dyn Display| {
            Failure::input(format!("{} as {}: {error}", self.name, request.file_name.display()))
        };
        let exported = glb::write(&avatar, &looks, &export).map_err(|error| refused(&error))?;
        let coarser = levels.files(&looks, &export).map_err(|error| refused(&error))?;
        let coarser: Vec<Vec<u8>> = coarser.into_iter().map(|file| file.bytes).collect();
        let summary = AvatarSummary {
            file_name: &request.file_name,
            is_vrm,
            body: &self.name,
            avatar: &avatar,
            looks: &looks,
            figures: &exported.report,
            apart: &self.apart,
            grounds: &self.grounds,
            mouth: self.mouth,
            simplified,
            levels: levels.rows(&coarser, &request.file_name),
            limits: plan.preset.as_ref().map(|preset| preset.limits),
        };
        let report = summary.report().after(self.of_photos);
        let (preview, labels) = (self.preview, self.labels);
        Ok(AvatarFiles { file: exported.bytes, levels: coarser, preview, labels, report })
    }
}

/// An avatar within a number of triangles.
struct Fitted {
    avatar: Avatar,
    /// The normals that its vertices had before.
    normals: Option<Vec<[f32; 3]>>,
    simplified: Option<Simplified>,
}

impl Fitted {
    fn new(avatar: Avatar, triangles: Option<usize>) -> Result<Self> {
        let Some(triangles) = triangles else {
            return Ok(Self { avatar, normals: None, simplified: None });
        };
        let fitted = preset::fit(avatar, triangles).or_input()?;
        let FittedAvatar { avatar, normals, before, hidden, after, wanted, .. } = fitted;
        let simplified = Some(Simplified { before, hidden, after, wanted });
        // Simplifying may have removed the lowest vertex.
        Ok(Self { avatar: avatar.standing().or_work()?, normals, simplified })
    }
}
