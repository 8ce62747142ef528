//! SciPy's sparse matrices, converted to dense ones.

use std::ops::AddAssign;

use super::error::MAX_DENSE_NUMBERS;
use super::error::Unread;
use super::numeric::{Numbers, NumericArray};
use crate::pickle::{Class, Object, Value};

fn broken(problem: impl Into<String>) -> Unread {
    Unread::Broken(problem.into())
}

/// The coordinates of the values of a matrix, in order: row and column of each.
struct Coordinates {
    rows: Vec<i64>,
    columns: Vec<i64>,
}

/// The dense matrix; values at the same coordinates are summed, as in SciPy. `spend` receives the
/// number of values before they are allocated; `numbers` reads the arrays of the state.
pub(super) fn dense<'p>(
    matrix: Object<'p>,
    mut numbers: impl FnMut(Value<'p>) -> Result<NumericArray, Unread>,
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<NumericArray, Unread> {
    let shape = matrix.attribute("_shape").or_else(|| matrix.attribute("shape"));
    let side = |value: Value<'_>| value.as_int().and_then(|side| usize::try_from(side).ok());
    let shape: Option<Vec<usize>> = shape
        .and_then(Value::items)
        .filter(|sides| sides.len() == 2)
        .and_then(|sides| sides.map(side).collect());
    let Some(&[height, width]) = shape.as_deref() else {
        return Err(broken("the shape of a sparse matrix must have two dimensions"));
    };
    let count = height.checked_mul(width).filter(|&count| count <= MAX_DENSE_NUMBERS);
    let count = count.ok_or_else(|| {
        Unread::Unusable(format!(
            "a sparse matrix of {height} x {width} (at most {MAX_DENSE_NUMBERS} values are \
             supported)"
        ))
    })?;
    spend(count)?;
    let mut attribute = |name: &'static str| {
        let value = matrix.attribute(name);
        numbers(value.ok_or_else(|| broken(format!("a sparse matrix must have `{name}`")))?)
    };
    let (_, data) = attribute("data")?.into_parts();
    let mut integers = |name| {
        let found = attribute(name)?.integers();
        found.ok_or_else(|| broken(format!("`{name}` of a sparse matrix must hold integers")))
    };
    let places = match matrix.class() {
        Class::SparseCsc => {
            let columns = spread(&integers("indptr")?, width, data.len())?;
            Coordinates { rows: begin(integers("indices")?, columns.len())?, columns }
        }
        Class::SparseCsr => {
            let rows = spread(&integers("indptr")?, height, data.len())?;
            Coordinates { columns: begin(integers("indices")?, rows.len())?, rows }
        }
        _ => match matrix.attribute("coords").and_then(Value::items) {
            Some(coords) => {
                let both: Vec<Value<'_>> = coords.take(3).collect();
                let [rows, columns] = both[..] else {
                    return Err(broken("`coords` of a sparse matrix must be a pair of arrays"));
                };
                let mut integers = |value| {
                    let found = numbers(value)?.integers();
                    found.ok_or_else(|| broken("`coords` of a sparse matrix must hold integers"))
                };
                Coordinates { rows: integers(rows)?, columns: integers(columns)? }
            }
            None => Coordinates { rows: integers("row")?, columns: integers("col")? },
        },
    };
    let numbers = match data {
        Numbers::F32(values) => Numbers::F32(fill(&values, &places, height, width)?),
        Numbers::F64(values) => Numbers::F64(fill(&values, &places, height, width)?),
        Numbers::I64(values) => {
            let values: Vec<f64> = values.iter().map(|&value| value as f64).collect();
            Numbers::F64(fill(&values, &places, height, width)?)
        }
    };
    NumericArray::new(vec![height, width], numbers)
        .ok_or_else(|| broken("the shape of a sparse matrix does not match its values"))
}

/// The row or column of each value: line `i` holds those from `starts[i]` to `starts[i + 1]`.
fn spread(starts: &[i64], lines: usize, numbers: usize) -> Result<Vec<i64>, Unread> {
    let steps = starts.windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = (starts.first(), starts.last());
    // After the last start there may be reserved but unused values.
    let fits = matches!(ends, (Some(0), Some(&last)) if last as u64 <= numbers as u64);
    if starts.len().checked_sub(1) != Some(lines) || !steps || !fits {
        return Err(broken("`indptr` of a sparse matrix does not match its shape and `data`"));
    }
    let mut found = Vec::with_capacity(numbers);
    for (line, pair) in starts.windows(2).enumerate() {
        found.extend(std::iter::repeat_n(line as i64, (pair[1] - pair[0]) as usize));
    }
    Ok(found)
}

/// The used part of an index array, which may have unused entries.
fn begin(mut indices: Vec<i64>, used: usize) -> Result<Vec<i64>, Unread> {
    if indices.len() < used {
        return Err(broken("a sparse matrix has fewer `indices` than values"));
    }
    indices.truncate(used);
    Ok(indices)
}

fn fill<T: Copy + Default + AddAssign>(
    values: &[T],
    places: &Coordinates,
    height: usize,
    width: usize,
) -> Result<Vec<T>, Unread> {
    let Coordinates { rows, columns } = places;
    if rows.len() != columns.len() || rows.len() > values.len() {
        return Err(broken("a sparse matrix has different numbers of coordinates and values"));
    }
    let mut dense = vec![T::default(); height * width];
    for ((&row, &column), &value) in rows.iter().zip(columns).zip(values) {
        let inside = |at: i64, length| usize::try_from(at).ok().filter(|&at| at < length);
        let (Some(row), Some(column)) = (inside(row, height), inside(column, width)) else {
            return Err(broken(format!(
                "a sparse matrix of {height} x {width} has a value at {row}, {column}"
            )));
        };
        dense[row * width + column] += value;
    }
    Ok(dense)
}
