//! The shape of the face in photographs, for the head of an avatar.

use uvgraft::{Pair, Size};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{HumanBone, Skeleton};
use uvgraft_pipeline::{Blame, Failure, Observer, Result};
use uvgraft_selfie::Likeness;

use super::request::AvatarRequest;
use crate::selfie::{FittedSelfie, Frames, GivenHead};

impl AvatarRequest {
    /// Fits the head of a pair to photographs.
    pub(super) fn fit(
        &self,
        frames: &Frames,
        pair: &Pair,
        head: &str,
        observer: &dyn Observer,
    ) -> Result<FittedSelfie> {
        /// Side of the face texture: more than most photographs have of a face.
        const SIDE: u32 = 2048;
        let head = GivenHead { mesh: pair.source().clone(), name: head.to_owned(), flame: None };
        let options = &self.photo_options;
        let selfie = FittedSelfie::new(head, frames, options, Size::square(SIDE), observer)?;
        selfie.warn(observer);
        Ok(selfie)
    }

    /// Gives an avatar the shape of the fitted head, joints of eyes and jaw included. Morph targets
    /// stay.
    ///
    /// - `pair`: from the head to the avatar's mesh.
    pub(super) fn shaped(
        &self,
        selfie: &FittedSelfie,
        pair: &Pair,
        mut avatar: Avatar,
        name: &str,
    ) -> Result<Avatar> {
        let share = self.likeness;
        let (anatomy, shaped) = (selfie.head.anatomy(), &selfie.fit.shaped);
        let likeness = Likeness::new(pair, anatomy, shaped, avatar.mesh.positions());
        let likeness = likeness.map_err(|error| Failure::input(format!("{name}: {error}")))?;
        let mut joints = avatar.skeleton.joints().to_vec();
        for joint in &mut joints {
            if let Some(HumanBone::LeftEye | HumanBone::RightEye | HumanBone::Jaw) = joint.human {
                joint.position = likeness.point(joint.position, share);
            }
        }
        avatar.skeleton = Skeleton::new(joints).or_input()?;
        avatar.mesh = avatar.mesh.with_positions(likeness.positions(share)).or_input()?;
        Ok(avatar)
    }
}
