//! Several textures in one call: lists of them, and arrays of shape `(n, height, width, channels)`.

use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::arrays::shape_text;
use crate::error::{bad_type, bad_value};

/// Textures, bases or results of one call.
pub(crate) struct Batch<'py> {
    items: Vec<Bound<'py, PyAny>>,
    /// Whether they are one array, so that results shall be one.
    is_array: bool,
}

impl<'py> Batch<'py> {
    /// The items of a list, a tuple, or an array with four axes; `None` for anything else.
    pub(crate) fn of(given: &Bound<'py, PyAny>) -> PyResult<Option<Self>> {
        if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
            let items = given.try_iter()?.collect::<PyResult<_>>()?;
            return Ok(Some(Self { items, is_array: false }));
        }
        let axes = given.getattr_opt(intern!(given.py(), "ndim"))?;
        if !axes.is_some_and(|axes| axes.extract::<usize>().is_ok_and(|axes| axes == 4)) {
            return Ok(None);
        }
        let items =
            (0..given.len()?).map(|index| given.get_item(index)).collect::<PyResult<_>>()?;
        Ok(Some(Self { items, is_array: true }))
    }

    /// What belongs to each of some textures: one for all of them, or one for each.
    ///
    /// - `name`: of the argument.
    /// - `count`: of the textures.
    pub(crate) fn one_or_each(
        given: Option<&Bound<'py, PyAny>>,
        name: &str,
        count: usize,
    ) -> PyResult<Shared<'py>> {
        let Some(given) = given else { return Ok(Shared::One(None)) };
        match Self::of(given)? {
            None => Ok(Shared::One(Some(given.clone()))),
            Some(batch) if batch.items.len() == count => Ok(Shared::Each(batch.items)),
            Some(batch) => Err(bad_value(format_args!(
                "{name} must be one, or one for each of {count} textures, got {}",
                batch.items.len()
            ))),
        }
    }

    /// Does something with each item, and collects what comes of it as the items were.
    ///
    /// - `out`: what results were written to, which then is returned in their place.
    ///
    /// # Errors
    /// Those of `make`, and `ValueError` for results that do not fit into one array.
    pub(crate) fn map(
        self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
        make: impl Fn(usize, &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let count = self.items.len();
        if self.is_array && count == 0 {
            return Err(bad_value(
                "texture must have at least one item along its first axis, got 0",
            ));
        }
        let list = PyList::empty(py);
        let mut stack: Option<Stack<'py>> = None;
        // Items that are no longer needed need not be kept.
        for (index, item) in self.items.into_iter().enumerate() {
            let result = make(index, &item)?;
            match out {
                Some(_) => {}
                None if self.is_array => match &stack {
                    Some(stack) => stack.put(index, &result)?,
                    None => {
                        let first = Stack::like(count, &result)?;
                        first.put(index, &result)?;
                        stack = Some(first);
                    }
                },
                None => list.append(result)?,
            }
        }
        Ok(match (out, stack) {
            (Some(out), _) => out.clone(),
            (None, Some(stack)) => stack.all.into_any(),
            (None, None) => list.into_any(),
        })
    }

    /// The number of items.
    pub(crate) fn len(&self) -> usize {
        self.items.len()
    }
}

/// What textures share, or have one each of.
pub(crate) enum Shared<'py> {
    One(Option<Bound<'py, PyAny>>),
    Each(Vec<Bound<'py, PyAny>>),
}

/// Refuses several of something for a single texture.
///
/// # Errors
/// `TypeError`, if they are several.
pub(crate) fn check_single(given: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<()> {
    match given.map(Batch::of).transpose()?.flatten() {
        Some(_) => Err(bad_type(format_args!(
            "{name} must be a single one for a single texture; give the texture as a list, [texture], to \
             have several"
        ))),
        None => Ok(()),
    }
}

/// An array of results of one shape.
struct Stack<'py> {
    all: Bound<'py, PyUntypedArray>,
}

impl<'py> Stack<'py> {
    fn like(count: usize, first: &Bound<'py, PyAny>) -> PyResult<Self> {
        let first = first.cast::<PyUntypedArray>()?;
        let shape: Vec<usize> =
            std::iter::once(count).chain(first.shape().iter().copied()).collect();
        let numpy = first.py().import(intern!(first.py(), "numpy"))?;
        let all = numpy.call_method1(intern!(first.py(), "empty"), (shape, first.dtype()))?;
        Ok(Self { all: all.cast_into()? })
    }

    fn put(&self, index: usize, result: &Bound<'py, PyAny>) -> PyResult<()> {
        let result = result.cast::<PyUntypedArray>()?;
        let shape = &self.all.shape()[1..];
        if result.shape() != shape || !result.dtype().is_equiv_to(&self.all.dtype()) {
            return Err(bad_value(format_args!(
                "results must have one shape and dtype to be one array, {} {}, got {} {} for base[{index}]; \
                 give textures as a list: list(texture)",
                self.all.dtype().str()?,
                shape_text(shape),
                result.dtype().str()?,
                shape_text(result.shape()),
            )));
        }
        self.all.set_item(index, result)
    }
}
