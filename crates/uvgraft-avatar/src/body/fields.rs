//! Reads the arrays of a model and validates their shapes and values.

use std::borrow::Cow;

use uvgraft_io::arrays::{NamedArrays, NumericArray};

use super::BodyError;

/// The length that an axis must have.
#[derive(Clone, Copy)]
pub(super) enum Axis {
    Is(usize),
    /// At least one; the name stands for the length in messages.
    Any(&'static str),
}

/// Typed access to arrays by key.
pub(super) struct Fields<'a>(pub &'a NamedArrays);

impl<'a> Fields<'a> {
    /// Whether the key exists, as an array or unreadable, rather than being missing or skipped.
    pub(super) fn has(&self, key: &str) -> bool {
        self.0.get(key).is_some() || self.0.left_out(key).is_some() || self.0.text(key).is_some()
    }

    /// The array, checked against the required number and lengths of axes.
    fn shaped(&self, key: &'static str, wanted: &[Axis]) -> Result<&'a NumericArray, BodyError> {
        let array = self.0.require(key)?;
        let shape = array.shape();
        let fits = |(&found, wanted): (&usize, &Axis)| match *wanted {
            Axis::Is(wanted) => found == wanted,
            Axis::Any(_) => found > 0,
        };
        if shape.len() == wanted.len() && shape.iter().zip(wanted).all(fits) {
            return Ok(array);
        }
        let wanted = wanted.iter().map(|axis| match axis {
            Axis::Is(length) => length.to_string(),
            Axis::Any(name) => (*name).to_owned(),
        });
        let wanted = format!("[{}]", wanted.collect::<Vec<_>>().join(", "));
        Err(BodyError::Shape { key, found: shape.to_vec(), wanted })
    }

    /// Finite numbers and their shape.
    pub(super) fn floats(
        &self,
        key: &'static str,
        wanted: &[Axis],
    ) -> Result<(Cow<'a, [f32]>, &'a [usize]), BodyError> {
        let array = self.shaped(key, wanted)?;
        let values = array.f32s();
        match values.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(BodyError::NotFinite { key, at, found: values[at] }),
            None => Ok((values, array.shape())),
        }
    }

    /// Points, one in a row.
    pub(super) fn points(&self, key: &'static str) -> Result<Vec<[f32; 3]>, BodyError> {
        let (values, _) = self.floats(key, &[Axis::Any("vertices"), Axis::Is(3)])?;
        Ok(values.as_chunks::<3>().0.to_vec())
    }

    /// Integers and their shape.
    pub(super) fn integers(
        &self,
        key: &'static str,
        wanted: &[Axis],
    ) -> Result<(Vec<i64>, &'a [usize]), BodyError> {
        let array = self.shaped(key, wanted)?;
        let values = array.integers().ok_or(BodyError::NotIntegers { key })?;
        Ok((values, array.shape()))
    }

    /// Triangles, with vertex indices checked.
    pub(super) fn triangles(
        &self,
        key: &'static str,
        vertices: usize,
    ) -> Result<Vec<[u32; 3]>, BodyError> {
        let (values, _) = self.integers(key, &[Axis::Any("triangles"), Axis::Is(3)])?;
        let index = |(at, &found): (usize, &i64)| {
            let wanted = vertices;
            let index = usize::try_from(found).ok().filter(|&index| index < wanted);
            index.map(|index| index as u32).ok_or(BodyError::Index {
                key,
                at,
                found,
                below: wanted,
            })
        };
        let corners: Vec<u32> = values.iter().enumerate().map(index).collect::<Result<_, _>>()?;
        Ok(corners.as_chunks::<3>().0.to_vec())
    }
}
