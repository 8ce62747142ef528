//! SciPy's sparse matrices, in pickles and in archives of `scipy.sparse.save_npz`.
//!
//! Source: SciPy 1.2 to 1.17. Matrices are pickled as the dict of their attributes: `_shape` (`shape`
//! in old ones), `data`, and `indices` and `indptr`, or for COO `row` and `col`, since 1.13 `coords`.

use std::ops::AddAssign;

use super::error::MAX_DENSE_NUMBERS;
use super::error::Unread;
use super::numeric::{Numbers, NumericArray};
use crate::numpy::length;
use crate::pickle::{Class, Object, Value};

/// How the coordinates of values are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Csc,
    Csr,
    Coo,
}

/// The values of a matrix with their coordinates, which are within its shape. Values at the same
/// coordinates are summed, as in SciPy.
pub(super) struct Coordinates {
    pub(super) shape: [usize; 2],
    pub(super) rows: Vec<i64>,
    pub(super) columns: Vec<i64>,
    /// At least as many as there are coordinates; the others are unused.
    pub(super) values: Numbers,
}

/// The shape of a pickled matrix.
pub(super) fn shape(matrix: Object<'_>) -> Result<[usize; 2], Unread> {
    let shape = matrix.attribute("_shape").or_else(|| matrix.attribute("shape"));
    let side = |value: Value<'_>| u64::try_from(value.as_int()?).ok().map(length);
    let shape: Option<Vec<usize>> = shape
        .and_then(Value::items)
        .filter(|sides| sides.len() == 2)
        .and_then(|sides| sides.map(side).collect());
    let Some(&[height, width]) = shape.as_deref() else {
        return Err(Unread::broken("the shape of a sparse matrix must have two dimensions"));
    };
    Ok([height, width])
}

/// The values of a pickled matrix; `numbers` reads the arrays of the state.
pub(super) fn pickled<'p>(
    matrix: Object<'p>,
    shape: [usize; 2],
    mut numbers: impl FnMut(Value<'p>) -> Result<NumericArray, Unread>,
) -> Result<Coordinates, Unread> {
    let format = match matrix.class() {
        Class::SparseCsc => Format::Csc,
        Class::SparseCsr => Format::Csr,
        _ => Format::Coo,
    };
    let coords = match matrix.attribute("coords").and_then(Value::items) {
        Some(coords) => match coords.take(3).collect::<Vec<Value<'_>>>()[..] {
            [rows, columns] => Some([rows, columns]),
            _ => {
                return Err(Unread::broken("`coords` of a sparse matrix must be a pair of arrays"));
            }
        },
        None => None,
    };
    coordinates(format, shape, |name| {
        let value = match (name, coords) {
            ("row", Some([rows, _])) => Some(rows),
            ("col", Some([_, columns])) => Some(columns),
            _ => matrix.attribute(name),
        };
        numbers(value.ok_or_else(|| Unread::broken(format!("a sparse matrix must have `{name}`")))?)
    })
}

/// The values of a matrix; `part` returns its arrays by their names in SciPy.
pub(super) fn coordinates(
    format: Format,
    shape: [usize; 2],
    mut part: impl FnMut(&'static str) -> Result<NumericArray, Unread>,
) -> Result<Coordinates, Unread> {
    let (_, values) = part("data")?.into_parts();
    let mut integers = |name| {
        let found = part(name)?.integers();
        found.ok_or_else(|| {
            Unread::broken(format!("`{name}` of a sparse matrix must hold integers"))
        })
    };
    let [height, width] = shape;
    let (rows, columns) = match format {
        Format::Csc => {
            let columns = spread(&integers("indptr")?, width, values.len())?;
            (begin(integers("indices")?, columns.len())?, columns)
        }
        Format::Csr => {
            let rows = spread(&integers("indptr")?, height, values.len())?;
            let columns = begin(integers("indices")?, rows.len())?;
            (rows, columns)
        }
        Format::Coo => (integers("row")?, integers("col")?),
    };
    if rows.len() != columns.len() || rows.len() > values.len() {
        return Err(Unread::broken(
            "a sparse matrix has different numbers of coordinates and values",
        ));
    }
    let inside = |at: i64, length| usize::try_from(at).is_ok_and(|at| at < length);
    for (&row, &column) in rows.iter().zip(&columns) {
        if !(inside(row, height) && inside(column, width)) {
            return Err(Unread::broken(format!(
                "a sparse matrix of {height} x {width} has a value at {row}, {column}"
            )));
        }
    }
    Ok(Coordinates { shape, rows, columns, values })
}

/// The dense form of a pickled matrix. `spend` receives the number of values before they are
/// allocated; `numbers` reads the arrays of the state.
pub(super) fn dense<'p>(
    matrix: Object<'p>,
    numbers: impl FnMut(Value<'p>) -> Result<NumericArray, Unread>,
    spend: impl FnOnce(usize) -> Result<(), Unread>,
) -> Result<NumericArray, Unread> {
    let [height, width] = shape(matrix)?;
    let count = height.checked_mul(width).filter(|&count| count <= MAX_DENSE_NUMBERS);
    let count = count.ok_or_else(|| {
        Unread::Unusable(format!(
            "a sparse matrix of {height} x {width} (at most {MAX_DENSE_NUMBERS} values are \
             supported)"
        ))
    })?;
    spend(count)?;
    let found = pickled(matrix, [height, width], numbers)?;
    let numbers = match &found.values {
        Numbers::F32(values) => Numbers::F32(fill(values, &found)),
        Numbers::F64(values) => Numbers::F64(fill(values, &found)),
        Numbers::I64(values) => {
            let values: Vec<f64> = values.iter().map(|&value| value as f64).collect();
            Numbers::F64(fill(&values, &found))
        }
    };
    NumericArray::new(vec![height, width], numbers)
        .ok_or_else(|| Unread::broken("the shape of a sparse matrix does not match its values"))
}

/// The row or column of each value: line `i` holds those from `starts[i]` to `starts[i + 1]`.
fn spread(starts: &[i64], lines: usize, numbers: usize) -> Result<Vec<i64>, Unread> {
    let steps = starts.windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = (starts.first(), starts.last());
    // After the last start there may be reserved but unused values.
    let fits = matches!(ends, (Some(0), Some(&last)) if last as u64 <= numbers as u64);
    if starts.len().checked_sub(1) != Some(lines) || !steps || !fits {
        return Err(Unread::broken(
            "`indptr` of a sparse matrix does not match its shape and `data`",
        ));
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
        return Err(Unread::broken("a sparse matrix has fewer `indices` than values"));
    }
    indices.truncate(used);
    Ok(indices)
}

fn fill<T: Copy + Default + AddAssign>(values: &[T], found: &Coordinates) -> Vec<T> {
    let [height, width] = found.shape;
    let mut dense = vec![T::default(); height * width];
    for ((&row, &column), &value) in found.rows.iter().zip(&found.columns).zip(values) {
        dense[row as usize * width + column as usize] += value;
    }
    dense
}
