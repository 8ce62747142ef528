//! Features that heads of body models lack: the interior of the mouth, and a UV island for each
//! eye.

use std::sync::Arc;

use uvgraft::{Mesh, Pair, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::eyes::{Iris, SeparatedEyes, clean};
use uvgraft_avatar::mouth::{Mouth, MouthError};
use uvgraft_pipeline::{Blame, Observer, Result};

use super::request::{AvatarRequest, EyeStyle, MouthStyle};

/// A pair whose target has an island for each eye, and how its layout was changed; `None` if both
/// eyes already have their own, or if there is no free space.
pub(super) fn parted(
    pair: &Pair,
    observer: &dyn Observer,
) -> Result<Option<(Arc<Pair>, SeparatedEyes)>> {
    match SeparatedEyes::find(pair.target()) {
        Ok(None) => Ok(None),
        Ok(Some(parted)) => {
            let target = parted.mesh.clone();
            let pair = Pair::from_pieces(pair.source().clone(), target, pair.pieces()).or_work()?;
            Ok(Some((Arc::new(pair), parted)))
        }
        Err(why) => {
            observer.warn(format_args!("both eyes share the same texels: {why}"));
            Ok(None)
        }
    }
}

/// An avatar with another layout of the same triangles.
pub(super) fn with_layout(avatar: Avatar, layout: &Mesh) -> Result<Avatar> {
    let positions = avatar.mesh.positions().to_vec();
    let mesh = layout.clone().with_positions(positions).or_work()?;
    Ok(Avatar { mesh, ..avatar })
}

impl AvatarRequest {
    /// Draws the eyes of an avatar, if requested.
    pub(super) fn draw_eyes(
        &self,
        avatar: &Avatar,
        texture: &mut Texture,
        name: &str,
        observer: &dyn Observer,
    ) {
        if self.eyes == EyeStyle::Keep {
            return;
        }
        let irises = clean(avatar, texture).irises;
        if irises.is_empty() {
            observer.warn(format_args!(
                "{name}: `eyes` clean needs a body with eyeballs; eyes left unchanged"
            ));
        } else if irises.iter().any(|iris: &Iris| !iris.is_found) {
            observer.note(format_args!("{name}: no clear iris in the texture; drawing brown eyes"));
        }
    }

    /// The mouth for an avatar, if requested.
    pub(super) fn fit_mouth(
        &self,
        avatar: &Avatar,
    ) -> Option<std::result::Result<Mouth, MouthError>> {
        (self.mouth == MouthStyle::Fitted).then(|| Mouth::fit(avatar))
    }
}

/// Attaches a fitted mouth to the mesh and the texture of an avatar, or reports why there is none.
/// Also returns the number of its triangles.
pub(super) fn with_mouth(
    avatar: Avatar,
    mouth: std::result::Result<Mouth, MouthError>,
    texture: &mut Texture,
    name: &str,
    observer: &dyn Observer,
) -> Result<(Avatar, Option<usize>)> {
    match mouth {
        Ok(mouth) => {
            mouth.paint(&avatar, texture);
            Ok((mouth.attach(avatar).or_work()?, Some(mouth.triangles())))
        }
        Err(why @ (MouthError::Closed | MouthError::OwnMouth { .. })) => {
            observer.note(format_args!("{name}: {why}; mouth left unchanged"));
            Ok((avatar, None))
        }
        Err(why) => {
            observer.warn(format_args!("{name}: cannot add teeth and tongue: {why}"));
            Ok((avatar, None))
        }
    }
}
