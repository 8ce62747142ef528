//! The rows of a feature map that are still needed, for both pictures.

/// A sliding window of consecutive rows of a feature map. Both pictures move in step; a row holds
/// the first picture's texels, then the second's: `[rows, 2, width, channels]`.
pub(super) struct Rows {
    pub(super) width: usize,
    /// Height of the whole map, in rows.
    pub(super) height: usize,
    pub(super) channels: usize,
    /// Index of the first row held.
    first: usize,
    values: Vec<f32>,
}

impl Rows {
    pub(super) const fn new(width: usize, height: usize, channels: usize) -> Self {
        Self { width, height, channels, first: 0, values: Vec::new() }
    }

    /// Number of values in one row of one picture.
    pub(super) const fn row_length(&self) -> usize {
        self.width * self.channels
    }

    /// Index of the first row that has not been computed yet.
    pub(super) const fn end(&self) -> usize {
        self.first + self.values.len() / (2 * self.row_length())
    }

    /// One row of one picture; `None` above and below the map.
    pub(super) fn row(&self, row: Option<usize>, picture: usize) -> Option<&[f32]> {
        let row = row.filter(|&row| row < self.height)?;
        let start = (2 * (row - self.first) + picture) * self.row_length();
        Some(&self.values[start..start + self.row_length()])
    }

    /// Appends rows up to `end` and returns them.
    pub(super) fn extend_to(&mut self, end: usize) -> &mut [f32] {
        let held = self.values.len();
        let length = (end - self.first) * 2 * self.row_length();
        // No spare capacity: every strip needs as much as the one before, so it would never be
        // used.
        self.values.reserve_exact(length.saturating_sub(held));
        self.values.resize(length, 0.0);
        &mut self.values[held..]
    }

    /// Drops the rows before `row`, as far as they have been computed.
    pub(super) fn forget_before(&mut self, row: usize) {
        let row = row.min(self.end());
        let count = row.saturating_sub(self.first);
        self.values.drain(..count * 2 * self.row_length());
        self.first += count;
    }
}
