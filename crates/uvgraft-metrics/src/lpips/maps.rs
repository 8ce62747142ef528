//! Difference maps of every layer, and their means.

use uvgraft::texture::Size;
use uvgraft::threads;

use crate::{Mask, MetricError};

/// The differences in one layer, row-major, at that layer's resolution.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Map {
    width: usize,
    pub(super) values: Vec<f32>,
    height: usize,
}

impl Map {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, values: Vec::with_capacity(width * height) }
    }

    /// Appends rows up to `end` and returns them.
    pub(super) fn extend_to(&mut self, end: usize) -> &mut [f32] {
        let held = self.values.len();
        self.values.resize(end * self.width, 0.0);
        &mut self.values[held..]
    }

    fn mean(&self) -> f64 {
        self.values.iter().map(|&value| f64::from(value)).sum::<f64>() / self.values.len() as f64
    }
}

/// The perceptual difference of two pictures, for each compared layer and texel.
#[derive(Debug, Clone, PartialEq)]
pub struct LpipsMaps {
    size: Size,
    layers: Vec<Map>,
}

impl LpipsMaps {
    pub(super) const fn new(size: Size, layers: Vec<Map>) -> Self {
        Self { size, layers }
    }

    /// LPIPS of the whole pictures: the sum of the layers' means. 0 for equal pictures; higher
    /// means less similar, seldom above 1.
    ///
    /// # Source
    /// As the Python package `lpips` 0.1.4 with `spatial=False`.
    pub fn mean(&self) -> f64 {
        self.layers.iter().map(Map::mean).sum()
    }

    /// LPIPS over a mask. Each layer's map is enlarged bilinearly to the size of the pictures, and
    /// their sum is averaged over the selected texels. With all texels selected this is close to
    /// [`LpipsMaps::mean`] but not equal: if a map is enlarged by a non-integer factor, its texels
    /// have slightly different weights.
    ///
    /// A texel's value also depends on its surroundings, up to about a hundred texels away, even
    /// outside the mask.
    ///
    /// # Errors
    /// [`MetricError::Size`] if the mask differs in size from the pictures.
    ///
    /// # Source
    /// As the Python package `lpips` 0.1.4 with `spatial=True`, averaged over a mask.
    pub fn masked_mean(&self, mask: &Mask) -> Result<f64, MetricError> {
        if mask.size() != self.size {
            let (found, wanted) = (mask.size(), self.size);
            return Err(MetricError::Size { what: "mask", found, wanted });
        }
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let across: Vec<Vec<Lerp>> =
            self.layers.iter().map(|map| enlarge(map.width, width)).collect();
        let down: Vec<Vec<Lerp>> =
            self.layers.iter().map(|map| enlarge(map.height, height)).collect();
        let sums = threads::map_indices(height, |y| {
            let selected = &mask.selected()[y * width..(y + 1) * width];
            if !selected.contains(&true) {
                return 0.0;
            }
            let mut sum = 0.0;
            for ((map, across), down) in self.layers.iter().zip(&across).zip(&down) {
                let Lerp { low, high, weight } = down[y];
                let row = |row: usize| &map.values[row * map.width..(row + 1) * map.width];
                let between: Vec<f32> = row(low)
                    .iter()
                    .zip(row(high))
                    .map(|(low, high)| low + (high - low) * weight)
                    .collect();
                for (at, _) in across.iter().zip(selected).filter(|(_, selected)| **selected) {
                    let (low, high) = (between[at.low], between[at.high]);
                    sum += f64::from(low + (high - low) * at.weight);
                }
            }
            sum
        });
        Ok(sums.iter().sum::<f64>() / mask.count() as f64)
    }
}

/// Two neighbours and the weight of the second.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lerp {
    low: usize,
    high: usize,
    weight: f32,
}

/// Linear interpolation of `many` texels between `few` texels that cover the same length; beyond
/// the outermost centres the outermost value is repeated.
fn enlarge(few: usize, many: usize) -> Vec<Lerp> {
    let scale = few as f64 / many as f64;
    let at = |index: usize| {
        let position = ((index as f64 + 0.5) * scale - 0.5).max(0.0);
        let low = (position as usize).min(few - 1);
        Lerp { low, high: (low + 1).min(few - 1), weight: (position - low as f64) as f32 }
    };
    (0..many).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::mask;

    #[test]
    fn maps_are_enlarged_bilinearly() {
        let places: Vec<_> =
            enlarge(2, 4).into_iter().map(|at| (at.low, at.high, at.weight)).collect();
        assert_eq!(places, [(0, 1, 0.0), (0, 1, 0.25), (0, 1, 0.75), (1, 1, 0.25)]);
        let map = Map { width: 2, height: 1, values: vec![1.0, 3.0] };
        let flat = Map { width: 1, height: 1, values: vec![10.0] };
        let maps = LpipsMaps::new(Size::new(4, 2), vec![map, flat]);
        assert_eq!(maps.mean(), 12.0);
        let masked = |selected: &[(u32, u32)]| {
            maps.masked_mean(&mask((4, 2), |x, y| selected.contains(&(x, y)))).unwrap()
        };
        assert_eq!(masked(&[(0, 1)]), 11.0);
        assert_eq!(masked(&[(1, 0), (2, 0), (3, 1)]), (11.5 + 12.5 + 13.0) / 3.0);
        let wrong = maps.masked_mean(&mask((2, 1), |_, _| true)).unwrap_err();
        assert_eq!(
            wrong.to_string(),
            "the mask must have the size of the first texture, 4×2, got 2×1"
        );
    }
}
