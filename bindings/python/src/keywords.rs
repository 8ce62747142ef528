//! Keyword arguments of calls that have dozens of them.
//!
//! Each is taken once, by its name and as what it must be; what is left in the end is unknown. Defaults
//! are those of the requests: an argument that is `None` is one that was not given.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use uvgraft::{Choice, Encoding, Size};
use uvgraft_pipeline::Input;

use crate::arguments::size_or;
use crate::error::{bad_type, of_option};
use crate::inputs;

/// Keyword arguments by name.
pub(crate) struct Keywords<'py> {
    left: Bound<'py, PyDict>,
}

impl<'py> Keywords<'py> {
    /// - `given`: stays as it is.
    pub(crate) fn new(given: &Bound<'py, PyDict>) -> PyResult<Self> {
        Ok(Self { left: given.copy()? })
    }

    /// Whether an argument that was not taken yet is given.
    pub(crate) fn has(&self, name: &str) -> PyResult<bool> {
        Ok(self.left.get_item(name)?.is_some_and(|value| !value.is_none()))
    }

    /// An argument as it was given.
    pub(crate) fn take(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(value) = self.left.get_item(name)? else { return Ok(None) };
        self.left.del_item(name)?;
        Ok(Some(value).filter(|value| !value.is_none()))
    }

    /// An argument that callers always pass, and that must not be `None`.
    ///
    /// # Errors
    /// `TypeError` without it.
    pub(crate) fn required(&self, name: &str) -> PyResult<Bound<'py, PyAny>> {
        self.take(name)?.ok_or_else(|| bad_type(format_args!("{name} must be given, got None")))
    }

    /// Refuses an argument that means nothing without another one.
    ///
    /// # Errors
    /// `uvgraft.Error`, with both names.
    pub(crate) fn needs(&self, name: &str, other: &str) -> PyResult<()> {
        match self.has(name)? && !self.has(other)? {
            true => Err(of_option(name, format_args!("needs `{other}`"))),
            false => Ok(()),
        }
    }

    /// Whether an argument is true; false by default.
    pub(crate) fn flag(&self, name: &str) -> PyResult<bool> {
        let given = self.take(name)?;
        given.map_or(Ok(false), |value| extracted(&value, name, "a bool"))
    }

    /// A string.
    pub(crate) fn text(&self, name: &str) -> PyResult<Option<String>> {
        self.take(name)?.map(|value| extracted(&value, name, "a str")).transpose()
    }

    /// One string or several, none by default.
    pub(crate) fn texts(&self, name: &str) -> PyResult<Vec<String>> {
        self.one_or_several(name, "a str or a sequence of these")
    }

    /// A path.
    pub(crate) fn path(&self, name: &str) -> PyResult<Option<PathBuf>> {
        self.take(name)?.map(|value| extracted(&value, name, "a path")).transpose()
    }

    /// One path or several, none by default.
    pub(crate) fn paths(&self, name: &str) -> PyResult<Vec<PathBuf>> {
        self.one_or_several(name, "a path or a sequence of these")
    }

    fn one_or_several<T: FromPyObjectOwned<'py>>(
        &self,
        name: &str,
        wanted: &str,
    ) -> PyResult<Vec<T>> {
        let Some(value) = self.take(name)? else { return Ok(Vec::new()) };
        if let Ok(one) = value.extract() {
            return Ok(vec![one]);
        }
        let items = value.try_iter().map_err(|_| of_type(&value, name, wanted))?;
        items.map(|item| extracted(&item?, name, wanted)).collect()
    }

    /// One of a few named values.
    ///
    /// # Errors
    /// `uvgraft.Error` with all names.
    pub(crate) fn choice<T: Choice>(&self, name: &str) -> PyResult<Option<T>> {
        let named = |text: String| {
            T::named(&text).ok_or_else(|| {
                of_option(name, format_args!("must be {}, got {text:?}", T::names()))
            })
        };
        self.text(name)?.map(named).transpose()
    }

    /// What a text means; a number will do as well, and is parsed as Python writes it.
    ///
    /// # Errors
    /// `uvgraft.Error` with what the text must be.
    pub(crate) fn parsed<T, E: Display>(
        &self,
        name: &str,
        parse: impl Fn(&str) -> Result<T, E>,
    ) -> PyResult<Option<T>> {
        let Some(value) = self.take(name)? else { return Ok(None) };
        let text: String = match value.extract() {
            Ok(text) => text,
            Err(_) => format!("{:?}", extracted::<f64>(&value, name, "a str or a number")?),
        };
        parse(&text).map(Some).map_err(|wanted| of_option(name, format_args!("{text:?}: {wanted}")))
    }

    /// A whole number.
    ///
    /// # Errors
    /// `uvgraft.Error` for one outside of the range.
    pub(crate) fn whole<T: TryFrom<i64> + Into<i64> + Copy>(
        &self,
        name: &str,
        range: RangeInclusive<T>,
    ) -> PyResult<Option<T>> {
        let Some(value) = self.take(name)? else { return Ok(None) };
        let number = match value.extract::<i64>() {
            Ok(number) => number as f64,
            Err(_) => extracted::<f64>(&value, name, "a whole number")?,
        };
        let [least, most] = [*range.start(), *range.end()].map(Into::into);
        let is_within = number.fract() == 0.0 && (least as f64..=most as f64).contains(&number);
        let whole = is_within.then(|| T::try_from(number as i64).ok()).flatten();
        whole.map(Some).ok_or_else(|| {
            of_option(
                name,
                format_args!("must be a whole number from {least} to {most}, got {value}"),
            )
        })
    }

    /// A number.
    pub(crate) fn number(&self, name: &str) -> PyResult<Option<f64>> {
        self.take(name)?.map(|value| extracted(&value, name, "a number")).transpose()
    }

    /// A size: a side, or `(height, width)`.
    ///
    /// # Errors
    /// `uvgraft.Error` for sizes that no texture can have.
    pub(crate) fn size(&self, name: &str) -> PyResult<Option<Size>> {
        let size = |value| size_or(name, &value, |wanted| of_option(name, wanted));
        self.take(name)?.map(size).transpose()
    }

    /// An image: a path, an array or a PIL image, of colours.
    pub(crate) fn image(&self, name: &str) -> PyResult<Option<Input>> {
        let image = |value| inputs::image(&value, name, Encoding::Srgb);
        self.take(name)?.map(image).transpose()
    }

    /// Refuses arguments that were not taken.
    ///
    /// # Errors
    /// `TypeError` with the name of the first.
    pub(crate) fn finish(self) -> PyResult<()> {
        match self.left.keys().iter().next() {
            Some(name) => Err(bad_type(format_args!("unexpected keyword argument '{name}'"))),
            None => Ok(()),
        }
    }
}

/// A value as a type.
///
/// # Errors
/// `TypeError` with what it must be.
pub(crate) fn extracted<'py, T: FromPyObjectOwned<'py>>(
    value: &Bound<'py, PyAny>,
    name: &str,
    wanted: &str,
) -> PyResult<T> {
    value.extract().map_err(|_| of_type(value, name, wanted))
}

/// The error of a value of another type.
pub(crate) fn of_type(value: &Bound<'_, PyAny>, name: &str, wanted: &str) -> PyErr {
    match value.get_type().name() {
        Ok(found) => bad_type(format_args!("{name} must be {wanted}, got {found}")),
        Err(error) => error,
    }
}
