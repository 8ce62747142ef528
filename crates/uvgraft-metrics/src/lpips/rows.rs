//! The rows of a feature map that are still needed, of both pictures.

/// A window of consecutive rows that slides down a feature map. Both pictures move in step; a row
/// holds the first picture's texels, then the second's: `[rows, 2, width, channels]`.
pub(super) struct Rows {
    pub(super) width: usize,
    /// Rows of the whole map.
    pub(super) height: usize,
    pub(super) channels: usize,
    /// The number of the first row that is held.
    first: usize,
    values: Vec<f32>,
}

impl Rows {
    pub(super) const fn new(width: usize, height: usize, channels: usize) -> Self {
        Self { width, height, channels, first: 0, values: Vec::new() }
    }

    /// Values in one row of one picture.
    pub(super) const fn row_length(&self) -> usize {
        self.width * self.channels
    }

    /// The number of the first row that has not come yet.
    pub(super) const fn end(&self) -> usize {
        self.first + self.values.len() / (2 * self.row_length())
    }

    /// One row of one picture, or nothing above and below the map.
    pub(super) fn row(&self, row: Option<usize>, picture: usize) -> Option<&[f32]> {
        let row = row.filter(|&row| row < self.height)?;
        let start = (2 * (row - self.first) + picture) * self.row_length();
        Some(&self.values[start..start + self.row_length()])
    }

    /// Makes room for the rows up to `end` and gives it.
    pub(super) fn extend_to(&mut self, end: usize) -> &mut [f32] {
        let held = self.values.len();
        let wanted = (end - self.first) * 2 * self.row_length();
        // No spare room: every strip takes as much as the one before, so it would never be used.
        self.values.reserve_exact(wanted.saturating_sub(held));
        self.values.resize(wanted, 0.0);
        &mut self.values[held..]
    }

    /// Forgets the rows before `row`, as far as they came.
    pub(super) fn forget_before(&mut self, row: usize) {
        let row = row.min(self.end());
        let count = row.saturating_sub(self.first);
        self.values.drain(..count * 2 * self.row_length());
        self.first += count;
    }
}
