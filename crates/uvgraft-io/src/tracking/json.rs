//! JSON files of frames, within limits.

use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

use serde::de::{DeserializeOwned, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::MAX_FRAMES;
use super::error::{ReadTrackingError, TrackingError};
use uvgraft_files::input::Input;

/// Maximum size of a JSON file. Recordings of 16 cameras have about 60 MB.
pub(super) const MAX_JSON_BYTES: u64 = 1 << 28;

/// Reads a file.
///
/// - `wanted`: what it must hold, for errors.
pub(super) fn read<T: DeserializeOwned>(
    path: &Path,
    wanted: &'static str,
) -> Result<T, ReadTrackingError> {
    Input::from(path).parse(MAX_JSON_BYTES, |bytes| {
        serde_json::from_slice(bytes)
            .map_err(|error| TrackingError::Json { wanted, reason: error.to_string() })
    })
}

/// At most [`MAX_FRAMES`] items.
#[derive(Debug)]
pub(super) struct Frames<T>(pub(super) Vec<T>);

/// The first item; the others are skipped.
#[derive(Debug)]
pub(super) struct First<T>(pub(super) Option<T>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Frames<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let items = deserializer.deserialize_seq(UpTo { most: MAX_FRAMES, item: PhantomData })?;
        if items.len() > MAX_FRAMES {
            let problem = format_args!("must have at most {MAX_FRAMES} frames, got more");
            return Err(serde::de::Error::custom(problem));
        }
        Ok(Self(items))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for First<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let items = deserializer.deserialize_seq(UpTo { most: 0, item: PhantomData })?;
        Ok(Self(items.into_iter().next()))
    }
}

/// Reads one item more than `most`, which tells that there are too many, and skips the rest.
struct UpTo<T> {
    most: usize,
    item: PhantomData<T>,
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for UpTo<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of frames")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Vec<T>, A::Error> {
        let mut found = Vec::new();
        while found.len() <= self.most {
            match items.next_element()? {
                Some(item) => found.push(item),
                None => return Ok(found),
            }
        }
        while items.next_element::<IgnoredAny>()?.is_some() {}
        Ok(found)
    }
}

/// The name of a camera, which may be stored as a number.
#[derive(Debug)]
pub(super) struct Name(pub(super) String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NameVisitor).map(Self)
    }
}

struct NameVisitor;

impl Visitor<'_> for NameVisitor {
    type Value = String;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string or an integer")
    }

    fn visit_str<E>(self, text: &str) -> Result<String, E> {
        Ok(text.to_owned())
    }

    fn visit_u64<E>(self, number: u64) -> Result<String, E> {
        Ok(number.to_string())
    }
}
