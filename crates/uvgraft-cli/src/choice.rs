//! Options with few values, by the names that the libraries give them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uvgraft::Choice;
use uvgraft_pipeline::spelled;

/// A parser of the values of a choice, which are listed in the help.
pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|value| {
        let named = PossibleValue::new(value.name());
        match value.summary() {
            "" => named,
            summary => named.help(spelled(summary, as_option)),
        }
    });
    PossibleValuesParser::new(values)
        .map(|name| T::named(&name).expect("a name that the parser lists"))
}

/// The option for what a library calls `source_mask`; `None` for what is not a name.
fn as_option(name: &str) -> Option<String> {
    let is_name = name.chars().all(|letter| letter.is_ascii_lowercase() || letter == '_');
    is_name.then(|| format!("--{}", name.replace('_', "-")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_options_are_spelled_as_such() {
        let text = "Run `uvgraft transfer` by `normal_y_out` and `prefer`";
        let wanted = "Run `uvgraft transfer` by --normal-y-out and --prefer";
        assert_eq!(spelled(text, as_option), wanted);
    }
}
