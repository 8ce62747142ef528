//! Growth over a grid of texels whose steps cost.

use super::layout::BodyLayout;
use super::steps::{Steps, UNITS};

/// No way leads there.
const FAR: u16 = u16::MAX;

/// The texels that seeds reach over steps of at most so many ΔE in all.
#[derive(Debug, Clone)]
pub(super) struct Growth {
    distance: Vec<u16>,
    most: usize,
    /// Where it began close to edges.
    is_close_seed: Vec<bool>,
}

impl Growth {
    pub fn new(texels: usize, reach: f32) -> Self {
        let most = (reach * UNITS) as usize;
        Self { distance: vec![FAR; texels], most, is_close_seed: vec![false; texels] }
    }

    /// Whether it reached a texel that is not close to an edge, or is of a part that has no other.
    pub fn has_core(&self, steps: &Steps, texel: u32) -> bool {
        let at = texel as usize;
        self.is_close_seed[at] || self.has(texel) && !steps.barrier.wide[at]
    }

    /// Whether it reached a texel.
    pub fn has(&self, texel: u32) -> bool {
        self.distance[texel as usize] != FAR
    }

    /// Grows from seeds over free texels first, then from there into the barriers around them and no farther.
    pub fn add(&mut self, body: &BodyLayout, steps: &Steps, seeds: &[u32], is_open: &[bool]) {
        let outside = |barrier: &[bool]| -> Vec<u32> {
            let is_free = |&seed: &u32| is_open[seed as usize] && !barrier[seed as usize];
            seeds.iter().copied().filter(is_free).collect()
        };
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); self.most + 1];
        buckets[0] = outside(&steps.barrier.wide);
        if buckets[0].is_empty() {
            // Ankles between trousers and shoes are close to edges all over.
            buckets[0] = outside(&steps.barrier.narrow);
            buckets[0].iter().for_each(|&seed| self.is_close_seed[seed as usize] = true);
        }
        for &seed in &buckets[0] {
            self.distance[seed as usize] = 0;
        }
        let mut rim = Vec::new();
        self.spread(body, steps, &mut buckets, |next, from| {
            if steps.barrier.wide[next as usize] {
                rim.push(from);
                return false;
            }
            is_open[next as usize]
        });
        rim.iter()
            .for_each(|&texel| buckets[usize::from(self.distance[texel as usize])].push(texel));
        self.spread(body, steps, &mut buckets, |next, _| {
            is_open[next as usize] && steps.barrier.wide[next as usize]
        });
    }

    fn spread(
        &mut self,
        body: &BodyLayout,
        steps: &Steps,
        buckets: &mut [Vec<u32>],
        mut may_enter: impl FnMut(u32, u32) -> bool,
    ) {
        // A bucket grows while it is emptied: most steps cost nothing.
        for bucket in 0..buckets.len() {
            while let Some(texel) = buckets[bucket].pop() {
                if usize::from(self.distance[texel as usize]) < bucket {
                    continue;
                }
                steps.ways(body, texel, |next, cost| {
                    let there = bucket + usize::from(cost);
                    if there < buckets.len()
                        && there < usize::from(self.distance[next as usize])
                        && may_enter(next, texel)
                    {
                        self.distance[next as usize] = there as u16;
                        buckets[there].push(next);
                    }
                });
            }
        }
    }
}

/// Gives each texel without a side that of the nearest texel that has one; a watershed along the highest steps.
pub(super) fn divided(body: &BodyLayout, steps: &Steps, side: &mut [Option<bool>]) {
    const FARTHEST: usize = 64 * UNITS as usize;
    let mut distance = vec![FAR; side.len()];
    let fixed: Vec<bool> = side.iter().map(Option::is_some).collect();
    let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); FARTHEST];
    for texel in 0..side.len() as u32 {
        if side[texel as usize].is_some() {
            continue;
        }
        for near in body.grid.neighbours(texel).filter(|&near| side[near as usize].is_some()) {
            if std::mem::replace(&mut distance[near as usize], 0) == FAR {
                buckets[0].push(near);
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
            steps.ways(body, texel, |next, cost| {
                let there = bucket + usize::from(cost);
                let is_nearer = there < usize::from(distance[next as usize]);
                if there < FARTHEST && is_nearer && !fixed[next as usize] {
                    distance[next as usize] = there as u16;
                    side[next as usize] = side[texel as usize];
                    buckets[there].push(next);
                }
            });
        }
    }
}

/// The parts into which open texels fall where steps that cost more than `most` ΔE cut them apart.
///
/// - `from`: texels to look at; parts without any of them are left out.
/// - `is_open`: is asked for each texel until it says no.
pub(super) fn parts(
    body: &BodyLayout,
    steps: &Steps,
    most: f32,
    from: impl Iterator<Item = u32>,
    is_open: impl Fn(u32) -> bool,
) -> Vec<Vec<u32>> {
    let most = (most * UNITS) as u16;
    let mut known = vec![false; body.grid.size().texels()];
    let mut parts = Vec::new();
    for first in from {
        if known[first as usize] || !is_open(first) {
            continue;
        }
        known[first as usize] = true;
        let (mut part, mut next) = (vec![first], 0);
        while let Some(&texel) = part.get(next) {
            next += 1;
            steps.ways(body, texel, |other, cost| {
                if cost <= most && !known[other as usize] && is_open(other) {
                    known[other as usize] = true;
                    part.push(other);
                }
            });
        }
        parts.push(part);
    }
    parts
}
