//! Options with few values, by the names that the libraries give them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uvgraft::Choice;

/// A parser of the values of a choice, which are listed in the help.
pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|value| PossibleValue::new(value.name()).help(value.summary()));
    PossibleValuesParser::new(values)
        .map(|name| T::named(&name).expect("a name that the parser lists"))
}
