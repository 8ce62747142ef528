//! Arrays and strings by name.

use super::error::{ArraysError, listed};
use super::numeric::NumericArray;

/// Numeric arrays and strings by name, in file order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NamedArrays {
    entries: Vec<(String, Held)>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Held {
    Array(NumericArray),
    Text(String),
    /// Neither of them, and why.
    Unusable(String),
    /// Not requested.
    Skipped,
}

impl NamedArrays {
    /// An empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// The names of arrays and strings, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let is_read = |held: &Held| !matches!(held, Held::Unusable(_));
        self.entries.iter().filter(move |(_, held)| is_read(held)).map(|(name, _)| name.as_str())
    }

    /// The array of a name. Scalars are arrays without axes.
    pub fn get(&self, name: &str) -> Option<&NumericArray> {
        match self.held(name)? {
            Held::Array(array) => Some(array),
            _ => None,
        }
    }

    /// The string of a name.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.held(name)? {
            Held::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Why the value of a name was not read.
    pub fn left_out(&self, name: &str) -> Option<&str> {
        match self.held(name)? {
            Held::Unusable(reason) => Some(reason),
            _ => None,
        }
    }

    /// The first names in backticks, and the number of others, for messages.
    pub fn listed(&self) -> String {
        listed(&self.names().map(str::to_owned).collect::<Vec<_>>())
    }

    /// The array of a name.
    ///
    /// # Errors
    /// [`ArraysError::Unusable`] with the reason if the name refers to something else, and
    /// [`ArraysError::Missing`] with the known names if it does not exist.
    pub fn require(&self, name: &str) -> Result<&NumericArray, ArraysError> {
        let reason = match self.held(name) {
            Some(Held::Array(array)) => return Ok(array),
            Some(Held::Text(_)) => "it is a string".to_owned(),
            Some(Held::Unusable(reason)) => reason.clone(),
            Some(Held::Skipped) => "it was not requested".to_owned(),
            None => {
                let names = self.names().map(str::to_owned).collect();
                return Err(ArraysError::Missing { name: name.to_owned(), names });
            }
        };
        Err(ArraysError::Unusable { name: name.to_owned(), reason })
    }

    /// Removes and returns an array; other values are not removed.
    pub fn take(&mut self, name: &str) -> Option<NumericArray> {
        let is_it =
            |(found, held): &(String, Held)| found == name && matches!(held, Held::Array(_));
        let at = self.entries.iter().position(is_it)?;
        match self.entries.remove(at).1 {
            Held::Array(array) => Some(array),
            _ => None,
        }
    }

    /// Removes whatever has a name.
    pub fn remove(&mut self, name: &str) {
        self.entries.retain(|(found, _)| found != name);
    }

    /// Inserts an array, replacing any value of the same name.
    pub fn insert(&mut self, name: impl Into<String>, array: NumericArray) {
        self.hold(name.into(), Held::Array(array));
    }

    /// Inserts a string, replacing any value of the same name.
    pub fn insert_text(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.hold(name.into(), Held::Text(text.into()));
    }

    pub(super) fn hold(&mut self, name: String, held: Held) {
        match self.entries.iter_mut().find(|(found, _)| *found == name) {
            Some(entry) => entry.1 = held,
            None => self.entries.push((name, held)),
        }
    }

    /// Adds all values of another file, replacing those of the same names; values skipped there are
    /// kept here.
    pub fn extend(&mut self, others: Self) {
        for (name, held) in others.entries {
            if !(matches!(held, Held::Skipped) && self.held(&name).is_some()) {
                self.hold(name, held);
            }
        }
    }

    pub(super) fn into_entries(self) -> impl Iterator<Item = (String, Held)> {
        self.entries.into_iter()
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = (&str, &Held)> {
        self.entries.iter().map(|(name, held)| (name.as_str(), held))
    }

    fn held(&self, name: &str) -> Option<&Held> {
        self.entries.iter().find(|(found, _)| found == name).map(|(_, held)| held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_names_say_why() {
        let mut arrays = NamedArrays::new();
        arrays.insert("f", NumericArray::new_i64(vec![1], vec![3]).unwrap());
        arrays.insert_text("gender", "male");
        arrays.hold("joints".to_owned(), Held::Unusable("a dict".to_owned()));
        let why = |name| arrays.require(name).unwrap_err().to_string();
        assert_eq!(arrays.require("f").unwrap().integers(), Some(vec![3]));
        assert_eq!(why("weights"), "no array `weights`; the file has `f`, `gender`");
        assert_eq!(why("joints"), "array `joints` cannot be used: a dict");
        assert_eq!(why("gender"), "array `gender` cannot be used: it is a string");
        assert_eq!(arrays.left_out("joints"), Some("a dict"));
        assert_eq!((arrays.text("f"), arrays.get("gender")), (None, None));
        assert_eq!(arrays.names().collect::<Vec<_>>(), ["f", "gender"]);
        arrays.insert_text("f", "again");
        assert_eq!((arrays.text("f"), arrays.names().count()), (Some("again"), 2));
    }
}
