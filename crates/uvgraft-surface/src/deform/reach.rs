//! Which points of the target may move.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::samples::Samples;
use crate::surface::Surface;

/// A triangle has a counterpart if pieces cover more than this share of it. Origin not recorded.
pub(super) const COVERED: f64 = 0.05;

/// The free points and their rows in the equations.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    /// For each point its row, if it is free.
    row_of_point: Vec<Option<u32>>,
    rows: usize,
    is_paired: Vec<bool>,
}

impl Reach {
    /// A point is free if a triangle at it corresponds to one that moves, or if no triangle at it
    /// corresponds to any and the way to such a point, over points of the same kind, is short.
    pub fn new(
        surface: &Surface,
        samples: &Samples,
        is_moving: impl Fn(u32) -> bool,
        reach: f64,
    ) -> Self {
        let points = surface.positions().len();
        let mut is_paired = vec![false; points];
        let mut distance = vec![f64::INFINITY; points];
        let mut queue = BinaryHeap::new();
        for (triangle, corners) in (0..).zip(surface.triangles()) {
            if samples.covered(triangle) < COVERED {
                continue;
            }
            let moves = is_moving(triangle);
            for &point in corners {
                is_paired[point as usize] = true;
                if moves && distance[point as usize] > 0.0 {
                    distance[point as usize] = 0.0;
                    queue.push(Reverse((0, point)));
                }
            }
        }
        // The bits of positive floats have the same order as the floats.
        while let Some(Reverse((bits, point))) = queue.pop() {
            let from = f64::from_bits(bits);
            if from > distance[point as usize] {
                continue;
            }
            for &triangle in surface.around(point) {
                for &other in &surface.triangles()[triangle as usize] {
                    let found = from + surface.length(point, other);
                    if !is_paired[other as usize]
                        && found < distance[other as usize]
                        && found <= reach
                    {
                        distance[other as usize] = found;
                        queue.push(Reverse((found.to_bits(), other)));
                    }
                }
            }
        }
        let mut rows = 0;
        let row_of_point = distance
            .into_iter()
            .map(|distance| {
                distance.is_finite().then(|| {
                    rows += 1;
                    rows - 1
                })
            })
            .collect();
        Self { row_of_point, rows: rows as usize, is_paired }
    }

    /// The row of a point in the equations; `None` if it stays.
    pub fn row(&self, point: u32) -> Option<usize> {
        self.row_of_point[point as usize].map(|row| row as usize)
    }

    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Whether a triangle at the point has a counterpart.
    pub fn is_paired(&self, point: u32) -> bool {
        self.is_paired[point as usize]
    }
}
