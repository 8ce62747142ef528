//! What heads of body models lack: a mouth behind the lips.

use uvgraft::Texture;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::mouth::{Mouth, MouthError};

use crate::failure::{note, warn};

/// Options for mouth and eyes.
#[derive(clap::Args, Clone, Copy)]
pub(crate) struct FeatureArgs {
    /// What is behind the lips
    #[arg(long, value_enum, value_name = "MOUTH", default_value_t = MouthName::Fitted)]
    mouth: MouthName,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MouthName {
    /// A cavity with teeth and a tongue, fitted to the lips, where the head is open between them
    Fitted,
    /// What the body has
    None,
}

impl FeatureArgs {
    /// Gives an avatar a mouth, in mesh and texture.
    pub(super) fn with_mouth(
        self,
        avatar: Avatar,
        texture: &mut Texture,
        name: &str,
    ) -> anyhow::Result<(Avatar, Option<usize>)> {
        if self.mouth == MouthName::None {
            return Ok((avatar, None));
        }
        match Mouth::fit(&avatar) {
            Ok(mouth) => {
                mouth.paint(&avatar, texture);
                Ok((mouth.attach(avatar)?, Some(mouth.triangles())))
            }
            Err(why @ (MouthError::Closed | MouthError::OwnMouth { .. })) => {
                note(format_args!("{name}: {why}; it is left as it is"));
                Ok((avatar, None))
            }
            Err(why) => {
                warn(format_args!("{name}: no teeth and tongue: {why}"));
                Ok((avatar, None))
            }
        }
    }
}
