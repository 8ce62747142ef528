//! `avatar --selfie`: the face and the shape of the head from photographs.

use std::path::PathBuf;

use uvgraft::{Pair, Size};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{HumanBone, Skeleton};
use uvgraft_selfie::Likeness;

use super::face::Face;
use crate::failure::{OrBadInput, bad_input};
use crate::heading;
use crate::selfie::{Frames, GivenHead, PhotoArgs, Selfie};

/// Options for photographs in place of a face texture.
#[derive(clap::Args)]
#[command(next_help_heading = heading::PHOTOGRAPHS)]
pub(super) struct SelfieArgs {
    /// Photographs of one person, or a folder of frames, in place of a face texture
    ///
    /// The texture is made as by `uvgraft selfie`, and the head gets the shape of the face.
    #[arg(id = "photos", long = "selfie", value_name = "PHOTO", num_args = 1..)]
    pub(super) photos: Vec<PathBuf>,
    /// How much of the face's shape the head gets, from 0 to 1 [default: 1]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_hyphen_values = true)]
    #[arg(requires = "photos")]
    likeness: Option<f64>,
    #[command(flatten)]
    photographs: PhotoArgs,
}

fn share(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|share| (0.0..=1.0).contains(share));
    value.ok_or_else(|| "must be a number from 0 to 1".to_owned())
}

impl SelfieArgs {
    /// The photographs; `None` if the face is a texture.
    pub(super) fn frames(&self) -> anyhow::Result<Option<Frames>> {
        if self.photos.is_empty() {
            return Ok(None);
        }
        let frames = Frames::new(&self.photos, &self.photographs)?;
        frames.check()?;
        Ok(Some(frames))
    }

    /// Fits the head of a pair to photographs.
    pub(super) fn fit(&self, frames: &Frames, pair: &Pair, head: &str) -> anyhow::Result<Selfie> {
        /// Side of the face texture: more than most photographs have of a face.
        const SIDE: u32 = 2048;
        let head = GivenHead { mesh: pair.source().clone(), name: head, flame: None };
        let selfie = Selfie::new(head, frames, &self.photographs, Size::square(SIDE))?;
        selfie.warn();
        Ok(selfie)
    }

    /// Gives an avatar the shape of the fitted head, joints of eyes and jaw included. Morph targets
    /// stay.
    ///
    /// - `pair`: from the head to the avatar's mesh.
    pub(super) fn shape(
        &self,
        selfie: &Selfie,
        pair: &Pair,
        mut avatar: Avatar,
        name: &str,
    ) -> anyhow::Result<Avatar> {
        let share = self.likeness.unwrap_or(1.0);
        let (anatomy, shaped) = (selfie.head.anatomy(), &selfie.fit.shaped);
        let likeness = Likeness::new(pair, anatomy, shaped, avatar.mesh.positions());
        let likeness = likeness.map_err(|error| bad_input(format!("{name}: {error}")))?;
        let mut joints = avatar.skeleton.joints().to_vec();
        for joint in &mut joints {
            if let Some(HumanBone::LeftEye | HumanBone::RightEye | HumanBone::Jaw) = joint.human {
                joint.position = likeness.point(joint.position, share);
            }
        }
        avatar.skeleton = Skeleton::new(joints).or_bad_input()?;
        avatar.mesh = avatar.mesh.with_positions(likeness.positions(share)).or_bad_input()?;
        Ok(avatar)
    }
}

impl Face {
    /// The texture made of photographs. What they don't show of the face is completed already, so no
    /// texel is left to the body.
    pub(super) fn of_selfie(selfie: &Selfie) -> Self {
        let file = selfie.photos.first().map(|photo| photo.path.clone()).unwrap_or_default();
        Self { texture: selfie.made.texture.clone(), confidence: None, file }
    }
}
