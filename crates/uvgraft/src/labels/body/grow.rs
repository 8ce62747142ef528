//! Growth over a grid of texels whose steps cost.

use crate::layout_grid::LayoutGrid;

use super::steps::{Steps, UNITS};

/// The texels that seeds reach over steps of at most `reach` ΔE in all.
pub(super) fn grown(
    grid: &LayoutGrid,
    steps: &Steps,
    seeds: impl Iterator<Item = u32>,
    reach: f32,
    is_open: impl Fn(u32) -> bool,
) -> Vec<bool> {
    let most = (reach * UNITS) as usize;
    let mut distance = vec![u16::MAX; grid.size().texels()];
    let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); most + 1];
    for seed in seeds {
        distance[seed as usize] = 0;
        buckets[0].push(seed);
    }
    // A bucket grows while it is emptied: most steps cost nothing.
    for bucket in 0..=most {
        while let Some(texel) = buckets[bucket].pop() {
            if usize::from(distance[texel as usize]) < bucket {
                continue;
            }
            for (next, cost) in steps.ways(grid, texel) {
                let there = bucket + usize::from(cost);
                if there <= most && there < usize::from(distance[next as usize]) && is_open(next) {
                    distance[next as usize] = there as u16;
                    buckets[there].push(next);
                }
            }
        }
    }
    distance.into_iter().map(|distance| distance != u16::MAX).collect()
}

/// Gives each texel without a side that of the nearest texel that has one; a watershed along the highest steps.
pub(super) fn divided(grid: &LayoutGrid, steps: &Steps, side: &mut [Option<bool>]) {
    const FARTHEST: usize = 64 * UNITS as usize;
    let mut distance = vec![u16::MAX; side.len()];
    let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); FARTHEST];
    for texel in 0..side.len() as u32 {
        if side[texel as usize].is_some() {
            distance[texel as usize] = 0;
            let mut beside = grid.neighbours(texel);
            if beside.any(|near| side[near as usize].is_none()) {
                buckets[0].push(texel);
            }
        }
    }
    for bucket in 0..FARTHEST {
        // In the order in which they were found, so that sides meet halfway where nothing costs.
        let mut index = 0;
        while let Some(&texel) = buckets[bucket].get(index) {
            index += 1;
            if usize::from(distance[texel as usize]) < bucket {
                continue;
            }
            for (next, cost) in steps.ways(grid, texel) {
                let there = bucket + usize::from(cost);
                if there < FARTHEST && there < usize::from(distance[next as usize]) {
                    distance[next as usize] = there as u16;
                    side[next as usize] = side[texel as usize];
                    buckets[there].push(next);
                }
            }
        }
    }
}

/// The parts into which open texels fall where steps that cost more than `most` ΔE cut them apart.
pub(super) fn parts(
    grid: &LayoutGrid,
    steps: &Steps,
    most: f32,
    is_open: impl Fn(u32) -> bool,
) -> Vec<Vec<u32>> {
    let most = (most * UNITS) as u16;
    let mut known = vec![false; grid.size().texels()];
    let mut parts = Vec::new();
    for first in 0..known.len() as u32 {
        if !is_open(first) || std::mem::replace(&mut known[first as usize], true) {
            continue;
        }
        let (mut part, mut next) = (vec![first], 0);
        while let Some(&texel) = part.get(next) {
            next += 1;
            for (other, cost) in steps.ways(grid, texel) {
                if cost <= most
                    && is_open(other)
                    && !std::mem::replace(&mut known[other as usize], true)
                {
                    part.push(other);
                }
            }
        }
        parts.push(part);
    }
    parts
}

/// The texels that are at most so many texels from those of a set.
pub(super) fn widened(grid: &LayoutGrid, set: &[bool], texels: usize) -> Vec<bool> {
    let mut wide = set.to_vec();
    let mut edge: Vec<u32> = (0..set.len() as u32).filter(|&texel| set[texel as usize]).collect();
    for _ in 0..texels {
        let mut next = Vec::new();
        for texel in edge {
            for near in grid.neighbours(texel) {
                if !std::mem::replace(&mut wide[near as usize], true) {
                    next.push(near);
                }
            }
        }
        edge = next;
    }
    wide
}
