//! How large a step of colour lies between texels and the nearest of some seeds, over the best way there is.
//!
//! Geodesic segmentation (X. Bai and G. Sapiro, "Geodesic matting", IJCV 2009; A. Criminisi et al., "GeoS", 2008): a
//! way costs what colours change along it beyond what is noise. Shading that changes slowly costs nothing however far it
//! goes, and an edge costs its height, wherever a way crosses it: what is all enclosed by edges is far.

use crate::layout_grid::LayoutGrid;

/// Colours of a grid in a space where distances are what one sees.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    /// CIELAB, softened by a texel.
    pub lab: Vec<[f32; 3]>,
    /// Changes up to here, from a texel to the next, are noise.
    pub noise: f32,
}

/// Distances are told in so many parts of a unit.
const PARTS: f32 = 16.0;

/// Distances are told up to here.
pub(crate) const FARTHEST: f32 = 40.0;

impl Steps {
    /// What a step from a texel to the next costs, in [`PARTS`] of a unit: whole numbers, so that texels in one bucket
    /// are equally far and each is visited once.
    fn cost(&self, from: u32, to: u32) -> u32 {
        let (a, b) = (self.lab[from as usize], self.lab[to as usize]);
        let squared: f32 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
        ((squared.sqrt() - self.noise).max(0.0) * PARTS + 0.5) as u32
    }

    /// The distance of each texel from the nearest seed; [`FARTHEST`] where no way is shorter.
    ///
    /// - `is_open`: the texels that ways may lead over.
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

    /// Takes further seeds into account: distances are those from the nearest of all.
    ///
    /// - `is_open`: as for [`Steps::distances`].
    pub fn shorten(
        &self,
        grid: &LayoutGrid,
        distance: &mut [f32],
        seeds: impl Iterator<Item = u32>,
        is_open: impl Fn(u32) -> bool,
    ) {
        let farthest = (FARTHEST * PARTS) as u32;
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); farthest as usize];
        for seed in seeds {
            distance[seed as usize] = 0.0;
            buckets[0].push(seed);
        }
        let in_units = |parts: u32| parts as f32 * (1.0 / PARTS);
        // A bucket grows while it is emptied: most steps cost nothing.
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

/// The texels that hang together with seeds over texels that are open; seeds that are not open are left out.
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

/// Texels and those at most so many texels from them: those that are given first, then others as they are farther.
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

/// The parts into which open texels fall, each as a list.
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
