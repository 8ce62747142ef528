//! Sparse matrices that stay sparse.

use super::collect::{Collector, single};
use super::error::{ArraysError, Unread};
use super::named::NamedArrays;
use super::numeric::{Numbers, NumericArray};
use super::sparse::{Coordinates, Format, coordinates};
use crate::obj::shown;
use crate::pickle::{Array, Class, Value};

/// Maximum number of rows or columns of a sparse matrix: its shape is only a claim, and rows without
/// elements take 12 bytes. Heads and bodies have up to a million vertices.
pub const MAX_SPARSE_SIDE: usize = 1 << 22;

/// Maximum number of elements other than zero. Deformation-transfer matrices have three in a row.
pub const MAX_SPARSE_ELEMENTS: usize = 1 << 26;

/// The same for matrices that are stored dense: more than one in ten or so is no sparse matrix.
const MAX_ELEMENTS_OF_DENSE: usize = 1 << 24;

/// A matrix of which only elements other than zero are stored, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    shape: [usize; 2],
    starts: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// A matrix with some elements, in any order. Those at the same place are summed, as in SciPy, and
    /// zeros are left out.
    ///
    /// - `shape`: rows and columns.
    /// - `elements`: row, column and value.
    ///
    /// # Errors
    /// [`ArraysError::Array`] with an empty name for elements outside of the shape, and beyond
    /// [`MAX_SPARSE_SIDE`] and [`MAX_SPARSE_ELEMENTS`].
    pub fn from_elements(
        shape: [usize; 2],
        elements: &[(u32, u32, f64)],
    ) -> Result<Self, ArraysError> {
        let (rows, columns) =
            elements.iter().map(|&(row, column, _)| (i64::from(row), i64::from(column))).unzip();
        let values = Numbers::F64(elements.iter().map(|element| element.2).collect());
        let array = |values: Vec<i64>| NumericArray::new_i64(vec![values.len()], values);
        let (rows, columns) = (array(rows), array(columns));
        let count = elements.len();
        let data = NumericArray::new(vec![count], values);
        let found = coordinates(Format::Coo, shape, |name| {
            let part = match name {
                "row" => &rows,
                "col" => &columns,
                _ => &data,
            };
            part.clone().ok_or_else(|| Unread::broken("too many elements"))
        });
        found.and_then(Self::compressed).map_err(|unread| unread.into_error(""))
    }

    /// A pickled SciPy matrix of the formats CSC, CSR and COO; `None` for other values.
    ///
    /// - `name`: the name of the value in errors.
    ///
    /// # Errors
    /// [`ArraysError`] for a damaged matrix, and beyond the limits of this module.
    pub fn from_pickle(value: Value<'_>, name: &str) -> Option<Result<Self, ArraysError>> {
        let object = single(value).as_object()?;
        if !matches!(object.class(), Class::SparseCsc | Class::SparseCsr | Class::SparseCoo) {
            return None;
        }
        // Each of its arrays is read once, so that none is repeated.
        let found = Collector::new(None, usize::MAX).coordinates(object).and_then(Self::compressed);
        Some(found.map_err(|unread| unread.into_error(name)))
    }

    /// The matrix of an archive of `scipy.sparse.save_npz`; `None` for other archives, which don't have
    /// `format`, `shape` and `data`.
    ///
    /// # Errors
    /// [`ArraysError`] for other formats than CSC, CSR and COO, for a damaged matrix, and beyond the
    /// limits of this module.
    pub fn from_npz(arrays: &NamedArrays) -> Option<Result<Self, ArraysError>> {
        let format = arrays.text("format")?;
        arrays.get("data")?;
        let shape = arrays.get("shape")?;
        Some(Self::from_parts(format, shape, arrays))
    }

    fn from_parts(
        format: &str,
        shape: &NumericArray,
        arrays: &NamedArrays,
    ) -> Result<Self, ArraysError> {
        let format = match format {
            "csc" => Format::Csc,
            "csr" => Format::Csr,
            "coo" => Format::Coo,
            other => {
                let other = shown(other.as_bytes());
                let problem = format!("must be csc, csr or coo, got {other} (use .tocsr())");
                return Err(ArraysError::array("format", problem));
            }
        };
        let sides = shape.integers().unwrap_or_default();
        let side = |at: usize| sides.get(at).and_then(|&side| usize::try_from(side).ok());
        let (Some(height), Some(width), 2) = (side(0), side(1), sides.len()) else {
            return Err(ArraysError::array("shape", "must be two lengths"));
        };
        let mut refusal = None;
        let found = coordinates(format, [height, width], |name| match arrays.require(name) {
            Ok(array) => Ok(array.clone()),
            Err(error) => {
                refusal = Some(error);
                Err(Unread::Broken(String::new()))
            }
        });
        let matrix = found.and_then(Self::compressed);
        matrix.map_err(|unread| refusal.unwrap_or_else(|| unread.into_error("data")))
    }

    /// The elements of a dense pickled array of two axes other than zero; `None` for other arrays.
    ///
    /// - `name`: the name of the array in errors.
    ///
    /// # Errors
    /// [`ArraysError`] beyond the limits of this module, and for integers beyond 63 bits.
    pub fn from_dense(array: &Array<'_>, name: &str) -> Option<Result<Self, ArraysError>> {
        let &[height, width] = array.shape() else { return None };
        // Line by line: a dense matrix of SMPL-X has half a gigabyte.
        let is_fortran = array.is_fortran_order();
        let line = if is_fortran { height } else { width };
        let lines = array.bytes().chunks((line * array.dtype().width).max(1));
        let lines = lines.map(|bytes| NumericArray::decode(vec![line], array.dtype(), bytes));
        Some(Self::from_lines([height, width], is_fortran, lines, name))
    }

    /// The elements of a dense array of two axes other than zero; `None` for other arrays.
    ///
    /// # Errors
    /// As [`SparseMatrix::from_dense`].
    pub fn from_numeric(array: &NumericArray, name: &str) -> Option<Result<Self, ArraysError>> {
        let &[height, width] = array.shape() else { return None };
        let values = array.f64s();
        let lines = values
            .chunks(width.max(1))
            .map(|line| NumericArray::new_f64(vec![line.len()], line.to_vec()));
        Some(Self::from_lines([height, width], false, lines, name))
    }

    fn from_lines(
        shape: [usize; 2],
        is_fortran: bool,
        lines: impl Iterator<Item = Option<NumericArray>>,
        name: &str,
    ) -> Result<Self, ArraysError> {
        let mut elements = Vec::new();
        for (at, line) in lines.enumerate() {
            let line = line.ok_or_else(|| ArraysError::array(name, "has too large integers"))?;
            for (along, &value) in line.f64s().iter().enumerate() {
                if value == 0.0 {
                    continue;
                }
                if elements.len() == MAX_ELEMENTS_OF_DENSE || at.max(along) >= MAX_SPARSE_SIDE {
                    let most = MAX_ELEMENTS_OF_DENSE as u64;
                    let what = "matrix elements other than zero";
                    return Err(ArraysError::TooMany { what, most });
                }
                let (at, along) = (at as u32, along as u32);
                elements.push(if is_fortran { (along, at, value) } else { (at, along, value) });
            }
        }
        Self::from_elements(shape, &elements).map_err(|error| match error {
            ArraysError::Array { problem, .. } => ArraysError::array(name, problem),
            other => other,
        })
    }

    /// Sorts elements by row and column.
    fn compressed(found: Coordinates) -> Result<Self, Unread> {
        let Coordinates { shape, rows, columns, values } = found;
        let [height, width] = shape;
        let too_many = |what, most: usize| {
            Err(Unread::Refused(ArraysError::TooMany { what, most: most as u64 }))
        };
        if height.max(width) > MAX_SPARSE_SIDE {
            return too_many("rows and columns of a sparse matrix", MAX_SPARSE_SIDE);
        }
        if rows.len() > MAX_SPARSE_ELEMENTS {
            return too_many("elements of a sparse matrix", MAX_SPARSE_ELEMENTS);
        }
        let mut next = vec![0_u32; height + 1];
        for &row in &rows {
            next[row as usize + 1] += 1;
        }
        for row in 0..height {
            next[row + 1] += next[row];
        }
        let bounds = next.clone();
        let mut sorted = vec![(0_u32, 0.0); rows.len()];
        let values = values.into_doubles();
        for ((&row, &column), &value) in rows.iter().zip(&columns).zip(&values) {
            let at = &mut next[row as usize];
            sorted[*at as usize] = (column as u32, value);
            *at += 1;
        }
        let mut matrix = Self {
            shape,
            starts: Vec::with_capacity(height + 1),
            columns: Vec::with_capacity(rows.len()),
            values: Vec::with_capacity(rows.len()),
        };
        matrix.starts.push(0);
        for row in bounds.windows(2) {
            let row = &mut sorted[row[0] as usize..row[1] as usize];
            // Stable, so that sums are those of the file's order.
            row.sort_by_key(|element| element.0);
            for same in row.chunk_by(|a, b| a.0 == b.0) {
                let sum: f64 = same.iter().map(|element| element.1).sum();
                if sum != 0.0 {
                    matrix.columns.push(same[0].0);
                    matrix.values.push(sum);
                }
            }
            matrix.starts.push(matrix.columns.len() as u32);
        }
        Ok(matrix)
    }

    /// Rows and columns.
    pub const fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// `[rows + 1]` offsets into [`SparseMatrix::columns`] and [`SparseMatrix::values`].
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// The columns of the elements, row by row, ascending within each.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// The elements, row by row; none is 0.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Columns and elements of each row.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = (&[u32], &[f64])> {
        self.starts.windows(2).map(|pair| {
            let row = pair[0] as usize..pair[1] as usize;
            (&self.columns[row.clone()], &self.values[row])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_sorted_and_summed() {
        let elements =
            [(2, 3, 1.0), (0, 4, 0.25), (2, 0, 5.0), (0, 1, 2.0), (0, 4, 0.5), (1, 1, 0.0)];
        let matrix = SparseMatrix::from_elements([4, 5], &elements).unwrap();
        assert_eq!(matrix.starts(), [0, 2, 2, 4, 4]);
        assert_eq!(matrix.columns(), [1, 4, 0, 3]);
        assert_eq!(matrix.values(), [2.0, 0.75, 5.0, 1.0]);
        let rows: Vec<_> = matrix.rows().collect();
        assert_eq!((rows.len(), rows[0]), (4, (&[1, 4][..], &[2.0, 0.75][..])));
        let empty = SparseMatrix::from_elements([0, 0], &[]).unwrap();
        assert_eq!((empty.rows().len(), empty.starts()), (0, &[0][..]));
    }

    #[test]
    fn shapes_are_claims() {
        let error = |shape| SparseMatrix::from_elements(shape, &[(1, 1, 1.0)]).unwrap_err();
        let found = error([1, 5]).to_string();
        assert!(found.contains("of 1 x 5 has a value at 1, 1"), "{found}");
        let found = error([usize::MAX, 5]).to_string();
        assert_eq!(found, "must have at most 4194304 rows and columns of a sparse matrix");
    }

    fn npz(format: &str, shape: &[i64], parts: &[(&str, &[i64])]) -> NamedArrays {
        let mut arrays = NamedArrays::new();
        arrays.insert_text("format", format);
        let array = |values: &[i64]| NumericArray::new_i64(vec![values.len()], values.to_vec());
        arrays.insert("shape", array(shape).unwrap());
        for (name, values) in parts {
            arrays.insert(*name, array(values).unwrap());
        }
        arrays
    }

    #[test]
    fn archives_of_every_format_are_the_same_matrix() {
        let wanted = SparseMatrix::from_elements([2, 3], &[(0, 2, 7.0), (1, 0, 8.0)]).unwrap();
        let data: (&str, &[i64]) = ("data", &[7, 8]);
        let turned: (&str, &[i64]) = ("data", &[8, 7]);
        for arrays in [
            npz("csr", &[2, 3], &[data, ("indptr", &[0, 1, 2]), ("indices", &[2, 0])]),
            npz("csc", &[2, 3], &[turned, ("indptr", &[0, 1, 1, 2]), ("indices", &[1, 0])]),
            npz("coo", &[2, 3], &[data, ("row", &[0, 1]), ("col", &[2, 0])]),
        ] {
            assert_eq!(SparseMatrix::from_npz(&arrays).unwrap().unwrap(), wanted);
        }
        let error = |arrays| SparseMatrix::from_npz(&arrays).unwrap().unwrap_err().to_string();
        assert!(error(npz("dia", &[2, 3], &[data])).contains("`format`: must be csc, csr or coo"));
        assert!(error(npz("coo", &[2], &[data])).contains("`shape`: must be two lengths"));
        assert!(error(npz("coo", &[2, 3], &[data, ("row", &[0])])).contains("no array `col`"));
        let beyond = npz("coo", &[2, 3], &[data, ("row", &[0, 2]), ("col", &[2, 0])]);
        assert!(error(beyond).contains("has a value at 2, 0"));
        assert!(SparseMatrix::from_npz(&NamedArrays::new()).is_none());
    }

    #[test]
    fn dense_matrices() {
        let array = NumericArray::new_f32(vec![2, 2], vec![0.0, 0.5, 1.5, 0.0]).unwrap();
        let wanted = SparseMatrix::from_elements([2, 2], &[(0, 1, 0.5), (1, 0, 1.5)]).unwrap();
        assert_eq!(SparseMatrix::from_numeric(&array, "matrix").unwrap().unwrap(), wanted);
        let flat = NumericArray::new_f32(vec![2], vec![0.0, 0.5]).unwrap();
        assert!(SparseMatrix::from_numeric(&flat, "matrix").is_none());
    }
}
