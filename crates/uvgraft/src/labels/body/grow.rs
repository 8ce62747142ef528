//! Region growing by path cost.

use super::layout::BodyLayout;
use super::steps::{Steps, UNITS};

/// The distance of texels that were not reached.
const FAR: u16 = u16::MAX;

/// The texels within a total path cost of the seeds.
#[derive(Debug, Clone)]
pub(super) struct Growth {
    distance: Vec<u16>,
    most: usize,
    /// Seeds inside the wide barrier, used where a region has no others.
    is_close_seed: Vec<bool>,
}

impl Growth {
    pub fn new(texels: usize, reach: f32) -> Self {
        let most = (reach * UNITS) as usize;
        Self { distance: vec![FAR; texels], most, is_close_seed: vec![false; texels] }
    }

    /// Whether it reached a texel outside the wide barrier, or one of the seeds inside it.
    pub fn has_core(&self, steps: &Steps, texel: u32) -> bool {
        let at = texel as usize;
        self.is_close_seed[at] || self.has(texel) && !steps.barrier.wide[at]
    }

    /// Whether it reached a texel.
    pub fn has(&self, texel: u32) -> bool {
        self.distance[texel as usize] != FAR
    }

    /// Grows from seeds over texels outside the wide barrier first, then from there into the
    /// barrier, but not out of it again: growth that crossed barriers would leak through gaps
    /// in edges.
    ///
    /// Dijkstra's algorithm with a bucket for each cost, as in `geodesic`.
    pub fn add(&mut self, body: &BodyLayout, steps: &Steps, seeds: &[u32], is_open: &[bool]) {
        let outside = |barrier: &[bool]| -> Vec<u32> {
            let is_free = |&seed: &u32| is_open[seed as usize] && !barrier[seed as usize];
            seeds.iter().copied().filter(is_free).collect()
        };
        let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); self.most + 1];
        buckets[0] = outside(&steps.barrier.wide);
        if buckets[0].is_empty() {
            // Ankles between trousers and shoes lie entirely within the wide barrier.
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
        // A bucket grows while it is drained, as most steps cost nothing.
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

/// Gives each undecided texel the side of the decided texel with the least path cost to it. Like a
/// watershed, this puts the dividing line on the highest steps.
pub(super) fn divided(body: &BodyLayout, steps: &Steps, side: &mut [Option<bool>]) {
    const MAX_COST: usize = 64 * UNITS as usize;
    let mut distance = vec![FAR; side.len()];
    let fixed: Vec<bool> = side.iter().map(Option::is_some).collect();
    let mut buckets: Vec<Vec<u32>> = vec![Vec::new(); MAX_COST];
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
    for bucket in 0..MAX_COST {
        // First in, first out, so that sides meet halfway where steps cost nothing.
        let mut index = 0;
        while let Some(&texel) = buckets[bucket].get(index) {
            index += 1;
            if usize::from(distance[texel as usize]) < bucket {
                continue;
            }
            steps.ways(body, texel, |next, cost| {
                let there = bucket + usize::from(cost);
                let is_nearer = there < usize::from(distance[next as usize]);
                if there < MAX_COST && is_nearer && !fixed[next as usize] {
                    distance[next as usize] = there as u16;
                    side[next as usize] = side[texel as usize];
                    buckets[there].push(next);
                }
            });
        }
    }
}

/// The connected components of the open texels, separated by steps of more than `most` ΔE.
///
/// - `from`: seeds; components without any of them are left out.
/// - `is_open`: may be called several times for the same texel.
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
