//! Messages about the expressions of body models.

use uvgraft_avatar::body::{BodyKind, ExpressionReport};
use uvgraft_avatar::face::UnmetTarget;
use uvgraft_io::input::Input;
use uvgraft_pipeline::Observer;

/// Reports what the body's face cannot express.
pub(super) fn report(
    model: &Input,
    kind: BodyKind,
    fit: &ExpressionReport,
    observer: &dyn Observer,
) {
    if fit.has_none {
        let kind = kind.name();
        observer.note(format_args!(
            "{model}: {kind} models have no expressions, so the face of the avatar will not move"
        ));
    }
    if let Some(error) = &fit.unmeasured {
        observer.warn(format_args!(
            "{model}: {error}; using its expression components as morph targets"
        ));
    }
    fit.shortfalls
        .iter()
        .for_each(|shortfall| observer.warn(format_args!("{model}: {}", text(shortfall))));
}

fn text(shortfall: &UnmetTarget) -> String {
    let &UnmetTarget { preset, share, strays, is_left_out } = shortfall;
    let mut text = format!(
        "expression `{}` reaches only {:.0} % of its target",
        preset.name(),
        100.0 * share.max(0.0)
    );
    if strays {
        text.push_str(", and moves other parts of the face too");
    }
    if is_left_out {
        text.push_str("; left out");
    }
    text
}
