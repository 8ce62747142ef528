//! Expressions of body models, and what is said about them.

use std::path::Path;

use uvgraft_avatar::body::{BodyKind, Expressiveness};
use uvgraft_avatar::face::Shortfall;

use crate::failure::{note, warn};

/// Tells what a body's face cannot do.
pub(super) fn tell(path: &Path, kind: BodyKind, told: &Expressiveness) {
    let model = path.display();
    if told.has_none {
        let kind = kind.name();
        note(format_args!(
            "{model}: {kind} has no expressions, so the avatar's face does not move"
        ));
    }
    if let Some(error) = &told.unmeasured {
        warn(format_args!(
            "{model}: {error}; its components of expression are morph targets as they are"
        ));
    }
    told.shortfalls.iter().for_each(|shortfall| warn(format_args!("{model}: {}", text(shortfall))));
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
