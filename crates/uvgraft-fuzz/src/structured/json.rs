//! Changes of JSON: a number, how often an element or an entry is there, the length of a string, the
//! depth of a value.

use arbitrary::Arbitrary;
use serde_json::Value;

use super::number::{Many, Number};

/// What stands for a deeply nested value until the text is written: nested values are dropped by recursion.
const NESTED: &str = "a deeply nested value";

/// A change of one of the values of a kind, by its number.
#[derive(Debug, Clone, Arbitrary)]
pub(super) enum Change {
    Number { which: u16, to: Number },
    Fraction { which: u16, exponent: i8 },
    Repeat { which: u16, element: u8, times: Many },
    Lengthen { which: u16, to: Many },
    Remove { which: u16, element: u8 },
    Nest { which: u16 },
}

impl Change {
    pub fn apply(&self, json: &mut Value) {
        match *self {
            Self::Number { which, to } => change(json, which, Value::is_u64, |number| {
                *number = to.instead_of(number.as_u64().unwrap_or_default()).into();
            }),
            Self::Fraction { which, exponent } => change(json, which, Value::is_number, |number| {
                let sign = if exponent < 0 { -1.0 } else { 1.0 };
                *number = (sign * f64::from(exponent).exp2()).into();
            }),
            Self::Repeat { which, element, times } => change(json, which, is_filled, |list| {
                repeat(list, element.into(), times);
            }),
            Self::Lengthen { which, to } => change(json, which, Value::is_string, |text| {
                // Ten times as long as lists are, since strings cost little.
                *text = "x".repeat((10 * to.0).min(super::MAX_BYTES)).into();
            }),
            Self::Remove { which, element } => change(json, which, is_filled, |list| match list {
                Value::Array(list) => drop(list.remove(usize::from(element) % list.len())),
                Value::Object(list) => {
                    let key = list.keys().nth(usize::from(element) % list.len()).cloned();
                    key.and_then(|key| list.remove(&key));
                }
                _ => {}
            }),
            Self::Nest { which } => change(json, which, |_| true, |value| *value = NESTED.into()),
        }
    }
}

/// The text of a value that was changed.
pub(super) fn text(json: &Value) -> String {
    const DEPTH: usize = 10_000;
    let text = json.to_string();
    let nested = format!("\"{NESTED}\"");
    if text.contains(&nested) {
        text.replacen(&nested, &("[".repeat(DEPTH) + &"]".repeat(DEPTH)), 1)
    } else {
        text
    }
}

fn is_filled(value: &Value) -> bool {
    match value {
        Value::Array(list) => !list.is_empty(),
        Value::Object(list) => !list.is_empty(),
        _ => false,
    }
}

/// Changes the value of a kind that the number chooses.
fn change(
    json: &mut Value,
    which: u16,
    is_it: fn(&Value) -> bool,
    change: impl FnOnce(&mut Value),
) {
    let count = count(json, is_it);
    if count > 0 {
        let mut before = usize::from(which) % count;
        nth(json, &mut before, is_it).map(change);
    }
}

fn count(json: &Value, is_it: fn(&Value) -> bool) -> usize {
    let inner: usize = match json {
        Value::Array(list) => list.iter().map(|value| count(value, is_it)).sum(),
        Value::Object(list) => list.values().map(|value| count(value, is_it)).sum(),
        _ => 0,
    };
    inner + usize::from(is_it(json))
}

fn nth<'j>(
    json: &'j mut Value,
    before: &mut usize,
    is_it: fn(&Value) -> bool,
) -> Option<&'j mut Value> {
    if is_it(json) {
        match before.checked_sub(1) {
            Some(rest) => *before = rest,
            None => return Some(json),
        }
    }
    match json {
        Value::Array(list) => list.iter_mut().find_map(|value| nth(value, before, is_it)),
        Value::Object(list) => list.values_mut().find_map(|value| nth(value, before, is_it)),
        _ => None,
    }
}

/// Repeats an element of a list or an entry of an object; strings and keys get a number.
pub(super) fn repeat(list: &mut Value, element: usize, times: Many) {
    match list {
        Value::Array(list) if !list.is_empty() => {
            let copied = list[element % list.len()].clone();
            for at in 0..times.of(copied.to_string().len()) {
                let numbered = copied.as_str().map(|text| format!("{text}{at}").into());
                list.push(numbered.unwrap_or_else(|| copied.clone()));
            }
        }
        Value::Object(list) if !list.is_empty() => {
            let (key, value) = list.iter().nth(element % list.len()).expect("it is not empty");
            // As in TEXCOORD_0.
            let key = key.trim_end_matches(|last: char| last.is_ascii_digit()).to_owned();
            let value = value.clone();
            for at in 0..times.of(key.len() + value.to_string().len()) {
                list.insert(format!("{key}{at}"), value.clone());
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_value_can_be_changed() {
        let plain = json!({ "a": [1, { "b": 2 }], "c": "d" });
        let changed = |change: Change| {
            let mut json = plain.clone();
            change.apply(&mut json);
            text(&json)
        };
        let to = Number::Near(7);
        let number = changed(Change::Number { which: 1, to });
        assert_eq!(number, r#"{"a":[1,{"b":9}],"c":"d"}"#);
        let repeated = Change::Repeat { which: 1, element: 0, times: Many(2) };
        assert_eq!(changed(repeated), r#"{"a":[1,{"b":2},1,1],"c":"d"}"#);
        let named = Change::Repeat { which: 2, element: 0, times: Many(2) };
        assert_eq!(changed(named), r#"{"a":[1,{"b":2,"b0":2,"b1":2}],"c":"d"}"#);
        let removed = changed(Change::Remove { which: 0, element: 1 });
        assert_eq!(removed, r#"{"a":[1,{"b":2}]}"#);
        let longer = changed(Change::Lengthen { which: 0, to: Many(1) });
        assert_eq!(longer, r#"{"a":[1,{"b":2}],"c":"xxxxxxxxxx"}"#);
        assert!(changed(Change::Nest { which: 0 }).starts_with("[[["));
    }
}
