//! A sparse matrix, column by column.

/// The entries of each column, in ascending order of their rows, each row once.
#[derive(Debug)]
pub(crate) struct Matrix {
    /// `columns + 1` offsets into `rows` and `values`.
    pub(super) starts: Vec<u32>,
    pub(super) rows: Vec<u32>,
    values: Vec<f64>,
}

impl Matrix {
    /// - `entries`: row, column and value, in any order. Values at the same place add up, in the
    ///   order in which they are given.
    pub fn new(columns: usize, entries: impl Iterator<Item = (u32, u32, f64)> + Clone) -> Self {
        let mut next = vec![0_u32; columns + 1];
        for (_, column, _) in entries.clone() {
            next[column as usize + 1] += 1;
        }
        for column in 0..columns {
            next[column + 1] += next[column];
        }
        let mut all = vec![(0_u32, 0.0); next[columns] as usize];
        for (row, column, value) in entries {
            let place = &mut next[column as usize];
            all[*place as usize] = (row, value);
            *place += 1;
        }
        // Each offset is now the next column's.
        let mut matrix = Self {
            starts: Vec::with_capacity(columns + 1),
            rows: Vec::with_capacity(all.len()),
            values: Vec::with_capacity(all.len()),
        };
        matrix.starts.push(0);
        let mut start = 0;
        for &end in &next[..columns] {
            let column = &mut all[start..end as usize];
            start = end as usize;
            // Stable, so that sums have one order.
            column.sort_by_key(|&(row, _)| row);
            for same in column.chunk_by(|a, b| a.0 == b.0) {
                matrix.rows.push(same[0].0);
                matrix.values.push(same.iter().map(|&(_, value)| value).sum());
            }
            matrix.starts.push(matrix.rows.len() as u32);
        }
        matrix
    }

    pub fn columns(&self) -> usize {
        self.starts.len() - 1
    }

    /// Row, column and value of all entries, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (u32, u32, f64)> + Clone {
        (0..self.columns()).flat_map(|column| {
            let (rows, values) = self.column(column);
            rows.iter().zip(values).map(move |(&row, &value)| (row, column as u32, value))
        })
    }

    /// The rows of a column, and its values.
    pub fn column(&self, column: usize) -> (&[u32], &[f64]) {
        let range = self.starts[column] as usize..self.starts[column + 1] as usize;
        (&self.rows[range.clone()], &self.values[range])
    }
}
