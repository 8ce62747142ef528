//! Messages about the expressions of body models.

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::{BodyKind, ExpressionReport};
use uvgraft_avatar::face::UnmetTarget;
use uvgraft_files::input::Input;
use uvgraft_pipeline::Observer;

/// Reports what the body's face cannot express.
///
/// - `avatar`: with the expressions of another model, if there are any: they are not reported missing.
pub(super) fn report(
    model: &Input,
    kind: BodyKind,
    fit: &ExpressionReport,
    avatar: &Avatar,
    observer: &dyn Observer,
) {
    if fit.has_none && avatar.expressions.is_empty() {
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
    let is_there = |shortfall: &&UnmetTarget| {
        let is_it = |preset| preset == Some(shortfall.preset);
        shortfall.is_left_out && avatar.expressions.iter().any(|other| is_it(other.preset))
    };
    fit.shortfalls
        .iter()
        .filter(|shortfall| !is_there(shortfall))
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

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use uvgraft_avatar::rig::{Expression, ExpressionPreset};
    use uvgraft_figure::Figure;
    use uvgraft_pipeline::Event;

    use super::*;

    #[derive(Default)]
    struct Log(Mutex<Vec<String>>);

    impl Observer for Log {
        fn event(&self, event: Event<'_>) {
            if let Event::Note(text) | Event::Warning(text) = event {
                self.0.lock().unwrap().push(text.to_owned());
            }
        }
    }

    fn warnings(fit: &ExpressionReport, avatar: &Avatar) -> Vec<String> {
        let log = Log::default();
        report(&Input::from("body.npz"), BodyKind::SmplX, fit, avatar, &log);
        log.0.into_inner().unwrap()
    }

    #[test]
    fn what_another_model_expresses_is_not_reported_missing() {
        let unmet =
            |preset, share| UnmetTarget { preset, share, strays: false, is_left_out: share < 0.5 };
        let shortfalls =
            vec![unmet(ExpressionPreset::Sad, 0.2), unmet(ExpressionPreset::Angry, 0.7)];
        let fit = ExpressionReport { shortfalls, ..ExpressionReport::default() };
        let mut avatar = Figure::new().avatar();
        avatar.expressions.clear();
        let wanted = [
            "body.npz: expression `sad` reaches only 20 % of its target; left out",
            "body.npz: expression `angry` reaches only 70 % of its target",
        ];
        assert_eq!(warnings(&fit, &avatar), wanted);
        let none = ExpressionReport { has_none: true, ..ExpressionReport::default() };
        assert_eq!(warnings(&none, &avatar).len(), 1);
        // Carried from another model.
        avatar.expressions.push(Expression::preset(ExpressionPreset::Sad, vec![(0, 1.0)]));
        assert_eq!(warnings(&fit, &avatar), wanted[1..]);
        assert_eq!(warnings(&none, &avatar), [""; 0]);
    }
}
