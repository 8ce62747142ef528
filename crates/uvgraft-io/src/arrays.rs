//! Arrays of numbers by their names.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// Arrays by their names.
#[derive(Debug, Clone, Default)]
pub struct NamedArrays {
    arrays: BTreeMap<String, NumericArray>,
}

/// An array of numbers.
#[derive(Debug, Clone)]
pub struct NumericArray {
    shape: Vec<usize>,
    values: Values,
}

#[derive(Debug, Clone)]
enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I64(Vec<i64>),
}

impl NamedArrays {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn insert(&mut self, name: impl Into<String>, array: NumericArray) {
        self.arrays.insert(name.into(), array);
    }

    /// The array with this name.
    pub fn get(&self, name: &str) -> Option<&NumericArray> {
        self.arrays.get(name)
    }

    /// The text with this name.
    pub fn text(&self, _name: &str) -> Option<&str> {
        None
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.arrays.keys().map(String::as_str)
    }
}

impl NumericArray {
    fn new(shape: Vec<usize>, values: Values, count: usize) -> Option<Self> {
        (shape.iter().product::<usize>() == count).then_some(Self { shape, values })
    }

    /// Nothing unless there are as many values as the shape says.
    pub fn new_f32(shape: Vec<usize>, values: Vec<f32>) -> Option<Self> {
        let count = values.len();
        Self::new(shape, Values::F32(values), count)
    }

    /// Nothing unless there are as many values as the shape says.
    pub fn new_f64(shape: Vec<usize>, values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        Self::new(shape, Values::F64(values), count)
    }

    /// Nothing unless there are as many values as the shape says.
    pub fn new_i64(shape: Vec<usize>, values: Vec<i64>) -> Option<Self> {
        let count = values.len();
        Self::new(shape, Values::I64(values), count)
    }

    /// The lengths of its axes.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// As 32-bit floats.
    pub fn f32s(&self) -> Cow<'_, [f32]> {
        match &self.values {
            Values::F32(values) => Cow::Borrowed(values),
            Values::F64(values) => values.iter().map(|&value| value as f32).collect(),
            Values::I64(values) => values.iter().map(|&value| value as f32).collect(),
        }
    }

    /// As 64-bit floats.
    pub fn f64s(&self) -> Cow<'_, [f64]> {
        match &self.values {
            Values::F32(values) => values.iter().map(|&value| f64::from(value)).collect(),
            Values::F64(values) => Cow::Borrowed(values),
            Values::I64(values) => values.iter().map(|&value| value as f64).collect(),
        }
    }

    /// As integers, if all are.
    pub fn integers(&self) -> Option<Vec<i64>> {
        match &self.values {
            Values::I64(values) => Some(values.clone()),
            _ => None,
        }
    }
}
