//! Features that heads of body models lack: the interior of the mouth, and a UV island for each
//! eye.

use std::sync::Arc;

use uvgraft::{Mesh, Pair, Texture};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::eyes::{Iris, SeparatedEyes, clean};
use uvgraft_avatar::mouth::{Mouth, MouthError};

use crate::failure::{note, warn};
use crate::heading;

/// Options for mouth and eyes.
#[derive(clap::Args, Clone, Copy)]
#[command(next_help_heading = heading::FEATURES)]
pub(crate) struct FeatureArgs {
    /// Interior of the mouth
    #[arg(long, value_enum, value_name = "MOUTH", default_value_t = MouthName::Fitted)]
    mouth: MouthName,
    /// Appearance of the eyes
    ///
    /// Either way, each eye gets a UV island of its own in the texture.
    #[arg(long, value_enum, value_name = "EYES", default_value_t = EyesName::Keep)]
    eyes: EyesName,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum EyesName {
    /// Keep the eyes of the face texture
    Keep,
    /// Redraw sclera, iris and pupil in the eye colour of the face texture
    Clean,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MouthName {
    /// Fit a cavity with teeth and tongue where the mesh is open between the lips
    Fitted,
    /// Add nothing to the body's mesh
    None,
}

/// A pair whose target has an island for each eye, and how its layout was changed; `None` if both
/// eyes already have their own, or if there is no free space.
pub(super) fn parted(pair: &Pair) -> anyhow::Result<Option<(Arc<Pair>, SeparatedEyes)>> {
    match SeparatedEyes::find(pair.target()) {
        Ok(None) => Ok(None),
        Ok(Some(parted)) => {
            let target = parted.mesh.clone();
            let pair = Pair::from_pieces(pair.source().clone(), target, pair.pieces())?;
            Ok(Some((Arc::new(pair), parted)))
        }
        Err(why) => {
            warn(format_args!("both eyes share the same texels: {why}"));
            Ok(None)
        }
    }
}

/// An avatar with another layout of the same triangles.
pub(super) fn with_layout(avatar: Avatar, layout: &Mesh) -> anyhow::Result<Avatar> {
    let mesh = layout.clone().with_positions(avatar.mesh.positions().to_vec())?;
    Ok(Avatar { mesh, ..avatar })
}

impl FeatureArgs {
    /// Draws the eyes of an avatar, if requested.
    pub(super) fn draw_eyes(self, avatar: &Avatar, texture: &mut Texture, name: &str) {
        if self.eyes == EyesName::Keep {
            return;
        }
        let irises = clean(avatar, texture).irises;
        if irises.is_empty() {
            warn(format_args!(
                "{name}: --eyes clean needs a body with eyeballs; eyes left unchanged"
            ));
        } else if irises.iter().any(|iris: &Iris| !iris.is_found) {
            note(format_args!("{name}: no clear iris in the texture; drawing brown eyes"));
        }
    }

    /// The mouth for an avatar, if requested.
    pub(super) fn fit_mouth(self, avatar: &Avatar) -> Option<Result<Mouth, MouthError>> {
        (self.mouth == MouthName::Fitted).then(|| Mouth::fit(avatar))
    }
}

/// Attaches a fitted mouth to the mesh and the texture of an avatar, or reports why there is none.
/// Also returns the number of its triangles.
pub(super) fn with_mouth(
    avatar: Avatar,
    mouth: Result<Mouth, MouthError>,
    texture: &mut Texture,
    name: &str,
) -> anyhow::Result<(Avatar, Option<usize>)> {
    match mouth {
        Ok(mouth) => {
            mouth.paint(&avatar, texture);
            Ok((mouth.attach(avatar)?, Some(mouth.triangles())))
        }
        Err(why @ (MouthError::Closed | MouthError::OwnMouth { .. })) => {
            note(format_args!("{name}: {why}; mouth left unchanged"));
            Ok((avatar, None))
        }
        Err(why) => {
            warn(format_args!("{name}: cannot add teeth and tongue: {why}"));
            Ok((avatar, None))
        }
    }
}
