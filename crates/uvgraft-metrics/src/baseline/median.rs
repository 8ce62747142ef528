//! Median filter over a square window, using a histogram that slides along the row.
//!
//! Based on Huang, Yang and Tang 1979, "A fast two-dimensional median filtering algorithm".

use uvgraft::texture::Size;
use uvgraft::threads::for_each_chunk;

/// The median of each channel of 8-bit RGB texels over a window of `side` × `side` texels, `side`
/// being odd. Edge texels are repeated outwards.
pub fn median(values: &[u8], size: Size, side: u32) -> Vec<u8> {
    let (width, height) = (size.width as usize, size.height as usize);
    let radius = side as usize / 2;
    let half = (side * side / 2) as i32;
    let mut out = vec![0; values.len()];
    for_each_chunk(&mut out, width * 3, |y, out| {
        let rows: Vec<&[u8]> = (0..side as usize)
            .map(|k| (y + k).saturating_sub(radius).min(height - 1))
            .map(|row| &values[row * width * 3..][..width * 3])
            .collect();
        for channel in 0..3 {
            let at = |x: usize| (x.saturating_sub(radius)).min(width - 1) * 3 + channel;
            let mut window = Histogram::default();
            // Column 0 of the window is `radius` left of the picture's edge.
            for column in 0..side as usize {
                rows.iter().for_each(|row| window.add(row[at(column)]));
            }
            for x in 0..width {
                out[x * 3 + channel] = window.value_at(half);
                for row in &rows {
                    window.remove(row[at(x)]);
                    window.add(row[at(x + side as usize)]);
                }
            }
        }
    });
    out
}

/// Counts of each value, and the number of values below the median found last.
struct Histogram {
    counts: [i32; 256],
    value: usize,
    below: i32,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: [0; 256], value: 0, below: 0 }
    }
}

impl Histogram {
    fn add(&mut self, value: u8) {
        self.counts[value as usize] += 1;
        self.below += i32::from((value as usize) < self.value);
    }

    fn remove(&mut self, value: u8) {
        self.counts[value as usize] -= 1;
        self.below -= i32::from((value as usize) < self.value);
    }

    /// The value at `rank` in ascending order. The search starts at the previous result, which is
    /// usually close.
    fn value_at(&mut self, rank: i32) -> u8 {
        while self.below > rank {
            self.value -= 1;
            self.below -= self.counts[self.value];
        }
        while self.below + self.counts[self.value] <= rank {
            self.below += self.counts[self.value];
            self.value += 1;
        }
        self.value as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_median_of_the_window() {
        let mut rng = fastrand::Rng::with_seed(4);
        for (size, side) in [(Size::new(23, 19), 5), (Size::new(4, 3), 17), (Size::new(1, 1), 3)] {
            let values: Vec<u8> = (0..size.texels() * 3).map(|_| rng.u8(..)).collect();
            let found = median(&values, size, side);
            let radius = side as i32 / 2;
            for y in 0..size.height as i32 {
                for x in 0..size.width as i32 {
                    for channel in 0..3 {
                        let at = |x: i32, y: i32| {
                            let x = x.clamp(0, size.width as i32 - 1);
                            let y = y.clamp(0, size.height as i32 - 1);
                            (y * size.width as i32 + x) as usize * 3 + channel
                        };
                        let mut window: Vec<u8> = (-radius..=radius)
                            .flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy)))
                            .map(|(dx, dy)| values[at(x + dx, y + dy)])
                            .collect();
                        window.sort_unstable();
                        assert_eq!(found[at(x, y)], window[window.len() / 2]);
                    }
                }
            }
        }
    }
}
