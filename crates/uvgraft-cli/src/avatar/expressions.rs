//! Expressions of body models, and what is said about them.

use std::path::Path;

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::Shaped;
use uvgraft_avatar::face::Shortfall;

use crate::failure::{note, warn};

/// Gives a body its expressions, and tells what it cannot do.
pub(super) fn give(path: &Path, shaped: &Shaped<'_>, avatar: &mut Avatar) -> anyhow::Result<()> {
    let told = shaped.give_expressions(avatar)?;
    let model = path.display();
    if !shaped.has_expressions() {
        let kind = shaped.model().kind().name();
        note(format_args!(
            "{model}: {kind} has no expressions, so the avatar's face does not move"
        ));
    }
    if let Some(error) = told.unmeasured {
        warn(format_args!(
            "{model}: {error}; its components of expression are morph targets as they are"
        ));
    }
    told.shortfalls.iter().for_each(|shortfall| warn(format_args!("{model}: {}", text(shortfall))));
    Ok(())
}

fn text(shortfall: &Shortfall) -> String {
    let &Shortfall { preset, share, strays, is_left_out } = shortfall;
    let mut text =
        format!("its expressions make {:.0} % of `{}`", 100.0 * share.max(0.0), preset.name());
    if strays {
        text.push_str(", and only by moving the rest of the face too");
    }
    if is_left_out {
        text.push_str("; it is left out");
    }
    text
}
