//! Geodesic colour distances: the least sum of colour steps on any path from texels to seeds.
//!
//! Geodesic segmentation (X. Bai and G. Sapiro, "Geodesic matting", IJCV 2009; A. Criminisi et al.,
//! "GeoS", 2008): the length of a path is the sum of its colour changes above the noise level. Slow
//! shading costs nothing over any distance, while an edge costs its height wherever a path crosses
//! it, so areas enclosed by edges are far away.

use crate::layout_grid::LayoutGrid;

/// Colours of a grid in a perceptual colour space, with their noise level.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    /// CIELAB, blurred over one texel.
    pub lab: Vec<[f32; 3]>,
    /// Changes up to this value between adjacent texels are noise.
    pub noise: f32,
}

/// Distances are quantised to 1/16 ΔE.
const SCALE: f32 = 16.0;

/// Upper limit of distances, in ΔE. Ten times what makes cloth, so that nothing is decided there.
pub(crate) const FARTHEST: f32 = 40.0;

impl Steps {
    /// The cost of a step between adjacent texels, in 1/[`SCALE`] ΔE: an integer, so that all
    /// texels in a bucket have the same distance and each is expanded once.
    fn cost(&self, from: u32, to: u32) -> u32 {
        let (a, b) = (self.lab[from as usize], self.lab[to as usize]);
        let squared: f32 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
        ((squared.sqrt() - self.noise).max(0.0) * SCALE + 0.5) as u32
    }

    /// The distance of each texel from the nearest seed; [`FARTHEST`] where no path is shorter.
    ///
    /// - `is_open`: the texels that paths may cross.
    pub fn distances(
        &self,
        grid: &LayoutGrid,
        seeds: impl Iterator<Item = u32>,
        is_open: impl Fn(u32) -> bool,
    ) -> Vec<f32> {
        let mut distance = vec![FARTHEST; self.lab.len()];
        self.shorten(grid, &mut distance, seeds, is_open);
        distance
    }

    /// Adds seeds: lowers `distance` to the distance from the nearest old or new seed.
    ///
    /// Dijkstra's algorithm with a bucket for each distance instead of a heap (Dial 1969),
    /// which small integer costs allow.
    ///
    /// - `is_open`: as for [`Steps::distances`].
    pub fn shorten(
        &self,
        grid: &LayoutGrid,
        distance: &mut [f32],
        seeds: impl Iterator<Item = u32>,
        is_open: impl Fn(u32) -> bool,
    ) {
        let farthest = (FARTHEST * SCALE) as u32;
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); farthest as usize];
        for seed in seeds {
            distance[seed as usize] = 0.0;
            buckets[0].push(seed);
        }
        let in_units = |steps: u32| steps as f32 * (1.0 / SCALE);
        // A bucket grows while it is drained, as most steps cost nothing.
        for here in 0..farthest {
            while let Some(texel) = buckets[here as usize].pop() {
                if distance[texel as usize] < in_units(here) {
                    continue;
                }
                grid.each_neighbour(texel, |next| {
                    if distance[next as usize] <= in_units(here) {
                        return;
                    }
                    let there = here + self.cost(texel, next);
                    if in_units(there) < distance[next as usize] && is_open(next) {
                        distance[next as usize] = in_units(there);
                        buckets[there as usize].push(next);
                    }
                });
            }
        }
    }
}

/// Flood fill: the open texels that are connected to open seeds.
pub(crate) fn flood(
    grid: &LayoutGrid,
    seeds: impl Iterator<Item = u32>,
    is_open: impl Fn(u32) -> bool,
) -> Vec<bool> {
    let mut found = vec![false; grid.size().texels()];
    let mut next: Vec<u32> = Vec::new();
    for seed in seeds {
        if is_open(seed) && !std::mem::replace(&mut found[seed as usize], true) {
            next.push(seed);
        }
    }
    while let Some(texel) = next.pop() {
        grid.each_neighbour(texel, |other| {
            if !found[other as usize] && is_open(other) {
                found[other as usize] = true;
                next.push(other);
            }
        });
    }
    found
}

/// The texels of `of` and all within `texels` steps of them, in order of distance.
pub(crate) fn widened(grid: &LayoutGrid, of: impl Iterator<Item = u32>, texels: usize) -> Vec<u32> {
    let mut known = vec![false; grid.size().texels()];
    let mut found: Vec<u32> = of.collect();
    found.iter().for_each(|&texel| known[texel as usize] = true);
    let mut first = 0;
    for _ in 0..texels {
        let end = found.len();
        for index in first..end {
            grid.each_neighbour(found[index], |near| {
                if !std::mem::replace(&mut known[near as usize], true) {
                    found.push(near);
                }
            });
        }
        first = end;
    }
    found
}

/// The connected components of the open texels, each as a list of texels.
pub(crate) fn parts(grid: &LayoutGrid, is_open: &[bool]) -> Vec<Vec<u32>> {
    let mut known = vec![false; is_open.len()];
    let mut parts = Vec::new();
    for first in 0..is_open.len() as u32 {
        if !is_open[first as usize] || std::mem::replace(&mut known[first as usize], true) {
            continue;
        }
        let (mut part, mut next) = (vec![first], 0);
        while let Some(&texel) = part.get(next) {
            next += 1;
            grid.each_neighbour(texel, |other| {
                if is_open[other as usize] && !std::mem::replace(&mut known[other as usize], true) {
                    part.push(other);
                }
            });
        }
        parts.push(part);
    }
    parts
}
