//! Dense arithmetic of the factorisation, on matrices stored column by column.
//!
//! Rows are packed into panels of eight, whose values are consecutive for each column: products of two
//! panels then run from registers and the nearest cache. Zeros fill the last panel up.

use std::ops::Range;

use fearless_simd::{Level, Simd, SimdBase, SimdFrom, dispatch, f64x8};

use crate::threads;

/// Rows of a panel.
const ROWS: usize = 8;
/// Columns whose products are in registers at once.
const COLUMNS: usize = 4;
/// Columns that are eliminated before the rest is updated. Their panels take 4 KiB each, so that
/// two stay in the nearest cache.
const BLOCK: usize = 64;

/// Rows of a block of eliminated columns: panel by panel, then column by column.
type Panels = Vec<[f64; ROWS]>;

/// The front of a group of columns: what is known of them, and what they change of the rest.
pub(super) struct Front<'a> {
    pub width: usize,
    pub height: usize,
    /// `[width * height]`: the group's columns, which become those of the factors.
    pub own: &'a mut [f64],
    /// `[(height - width)²]`: what is added to the columns of the rows below.
    pub rest: &'a mut [f64],
    /// Whether all threads take part.
    pub is_parallel: bool,
}

/// Buffers.
#[derive(Default)]
pub(super) struct Buffers {
    /// The rows of a diagonal block, with the inverses of the diagonal in its place.
    corner: Vec<[f64; BLOCK]>,
    /// The rows of the group's later columns, and those below the group.
    own: Panels,
    below: Panels,
}

impl Front<'_> {
    /// A column, and the number of rows above its first value.
    pub fn column(&mut self, column: usize) -> (&mut [f64], usize) {
        let (width, height) = (self.width, self.height);
        if column < width {
            (&mut self.own[column * height..][..height], 0)
        } else {
            let below = height - width;
            (&mut self.rest[(column - width) * below..][..below], width)
        }
    }

    /// Eliminates the group's columns; false if a pivot is not positive.
    pub fn eliminate(&mut self, buffers: &mut Buffers) -> bool {
        let level = Level::new();
        // Block by block: `L₁₁ L₁₁ᵀ = A₁₁`, then `L₂₁ = A₂₁ L₁₁⁻ᵀ`, then `A₂₂ -= L₂₁ L₂₁ᵀ`.
        for begin in (0..self.width).step_by(BLOCK) {
            let end = (begin + BLOCK).min(self.width);
            if !dispatch!(level, simd => self.corner(simd, begin..end, &mut buffers.corner)) {
                return false;
            }
            let Buffers { corner, own, below } = buffers;
            let (columns, later) = self.own.split_at_mut(end * self.height);
            let columns = &mut columns[begin * self.height..];
            let mut solve = |rows: Range<usize>, panels: &mut Panels| {
                solve_rows(
                    level,
                    self.is_parallel,
                    (&mut *columns, self.height),
                    rows,
                    corner,
                    panels,
                );
            };
            solve(end..self.width, own);
            solve(self.width..self.height, below);
            // A corner's columns are the block's width.
            let depth = end - begin;
            for_each_chunk(self.is_parallel, later, self.height * ROWS, |index, columns| {
                let first = end + index * ROWS;
                let across = &own[index * depth..][..depth];
                let mut subtract = |panels: &[[f64; ROWS]], start: usize, rows: usize| {
                    dispatch!(level, simd => subtract_products(
                        simd, panels, across, columns, (self.height, start, rows)));
                };
                subtract(&own[index * depth..], first, self.width - first);
                subtract(below, self.width, self.height - self.width);
            });
            let height = self.height - self.width;
            if height > 0 {
                for_each_chunk(self.is_parallel, self.rest, height * ROWS, |index, columns| {
                    let across = &below[index * depth..][..depth];
                    let panels = &below[index * depth..];
                    let shape = (height, index * ROWS, height - index * ROWS);
                    dispatch!(level, simd =>
                        subtract_products(simd, panels, across, columns, shape));
                });
            }
        }
        true
    }

    /// Factorises a block on the diagonal, and copies its rows.
    #[inline(always)]
    fn corner<S: Simd>(
        &mut self,
        _: S,
        block: Range<usize>,
        corner: &mut Vec<[f64; BLOCK]>,
    ) -> bool {
        let height = self.height;
        corner.clear();
        corner.resize(block.len(), [0.0; BLOCK]);
        for column in block.clone() {
            let (before, from) = self.own.split_at_mut(column * height);
            let values = &mut from[column..block.end];
            for (k, before) in before[block.start * height..].chunks_exact(height).enumerate() {
                let factor = corner[column - block.start][k];
                for (value, before) in values.iter_mut().zip(&before[column..block.end]) {
                    *value -= factor * before;
                }
            }
            // False for NaN, too.
            if !(values[0] > 0.0 && values[0] < f64::INFINITY) {
                return false;
            }
            let pivot = values[0].sqrt();
            values[0] = pivot;
            for value in &mut values[1..] {
                *value /= pivot;
            }
            let k = column - block.start;
            // Each row is then solved by products alone; divisions take several times as long.
            corner[k][k] = 1.0 / pivot;
            for (row, &value) in corner[k + 1..].iter_mut().zip(&values[1..]) {
                row[k] = value;
            }
        }
        true
    }
}

/// Eliminates the columns of a block from some rows, in place, and packs these.
///
/// - `columns`: the block's columns, with `height` rows.
fn solve_rows(
    level: Level,
    is_parallel: bool,
    (columns, height): (&mut [f64], usize),
    rows: Range<usize>,
    corner: &[[f64; BLOCK]],
    panels: &mut Panels,
) {
    let depth = corner.len();
    panels.clear();
    panels.resize(rows.len().div_ceil(ROWS) * depth, [0.0; ROWS]);
    {
        let columns = &*columns;
        for_each_chunk(is_parallel, panels, depth * PANELS, |chunk, panels| {
            for (index, panel) in panels.chunks_exact_mut(depth).enumerate() {
                let first = rows.start + (chunk * PANELS + index) * ROWS;
                let count = ROWS.min(rows.end - first);
                for (packed, column) in panel.iter_mut().zip(columns.chunks_exact(height)) {
                    packed[..count].copy_from_slice(&column[first..first + count]);
                }
                dispatch!(level, simd => solve_panel(simd, panel, corner));
            }
        });
    }
    for (panel, first) in panels.chunks_exact(depth).zip(rows.clone().step_by(ROWS)) {
        let count = ROWS.min(rows.end - first);
        for (packed, column) in panel.iter().zip(columns.chunks_exact_mut(height)) {
            column[first..first + count].copy_from_slice(&packed[..count]);
        }
    }
}

/// Panels of a work item.
const PANELS: usize = 16;

fn for_each_chunk<T: Send>(
    is_parallel: bool,
    values: &mut [T],
    chunk: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    if is_parallel {
        threads::for_each_chunk(values, chunk, work);
    } else {
        values.chunks_mut(chunk).enumerate().for_each(|(index, values)| work(index, values));
    }
}

/// `X = A C⁻ᵀ` of eight rows `A`, with the triangle `C` whose diagonal is inverted.
#[inline(always)]
fn solve_panel<S: Simd>(simd: S, panel: &mut [[f64; ROWS]], corner: &[[f64; BLOCK]]) {
    for (column, factors) in corner.iter().enumerate() {
        let (before, from) = panel.split_at_mut(column);
        let mut sum = f64x8::simd_from(simd, from[0]);
        for (before, &factor) in before.iter().zip(factors) {
            sum -= f64x8::simd_from(simd, *before) * factor;
        }
        from[0] = (sum * factors[column]).into();
    }
}

/// Subtracts the products of some panels with one panel from its eight columns, or as many as there
/// are.
///
/// - `shape`: the height of the columns, the first of them that the panels stand for, and their
///   number.
#[inline(always)]
fn subtract_products<S: Simd>(
    simd: S,
    panels: &[[f64; ROWS]],
    across: &[[f64; ROWS]],
    columns: &mut [f64],
    (height, start, rows): (usize, usize, usize),
) {
    let depth = across.len();
    for (panel, first) in panels.chunks_exact(depth).zip((0..rows).step_by(ROWS)) {
        let count = ROWS.min(rows - first);
        for (half, columns) in columns.chunks_mut(height * COLUMNS).enumerate() {
            let products = if half == 0 {
                products::<S, 0>(simd, panel, across)
            } else {
                products::<S, COLUMNS>(simd, panel, across)
            };
            for (column, products) in columns.chunks_exact_mut(height).zip(products) {
                let column = &mut column[start + first..][..count];
                if let Ok(column) = <&mut [f64; ROWS]>::try_from(&mut *column) {
                    *column = (f64x8::simd_from(simd, *column) - products).into();
                } else {
                    let products: [f64; ROWS] = products.into();
                    for (value, product) in column.iter_mut().zip(products) {
                        *value -= product;
                    }
                }
            }
        }
    }
}

/// The products of eight rows with four.
#[inline(always)]
fn products<S: Simd, const FIRST: usize>(
    simd: S,
    panel: &[[f64; ROWS]],
    across: &[[f64; ROWS]],
) -> [f64x8<S>; COLUMNS] {
    let mut sums = [f64x8::splat(simd, 0.0); COLUMNS];
    for (rows, factors) in panel.iter().zip(across) {
        let rows = f64x8::simd_from(simd, *rows);
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += rows * factors[FIRST + k];
        }
    }
    sums
}
