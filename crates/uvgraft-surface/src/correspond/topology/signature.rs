//! Signatures of half-edges: what the connectivity around each looks like.
//!
//! Rounds of refinement, in each of which a half-edge's signature is mixed with those of its
//! neighbours (B. Weisfeiler and A. Leman, "The reduction of a graph to canonical form", 1968).
//! Next and previous are told apart, so mirror images differ wherever connectivity itself is not
//! mirror-symmetric about the half-edge.

use super::net::{NONE, Net};
use crate::bits::mixed;

/// Rounds of refinement. Each reaches about one ring farther; near the border of a part that was
/// cut out of a mesh, signatures differ from the whole mesh's up to this far.
const ROUNDS: usize = 4;

/// The signature of each half-edge.
pub(super) fn signatures(net: &Net) -> Vec<u64> {
    let halves = 0..net.points.len() as u32;
    let mut current: Vec<u64> = halves
        .clone()
        .map(|half| {
            let ring = net.halves(net.ring_of[half as usize]).len() as u64;
            let valence = net.valence[net.points[half as usize] as usize];
            combined(&[ring, u64::from(valence)])
        })
        .collect();
    for _ in 0..ROUNDS {
        let at = |half: u32| if half == NONE { 0 } else { current[half as usize] };
        current = halves
            .clone()
            .map(|half| {
                let beyond = net.twin[half as usize];
                let [around, back] = if beyond == NONE {
                    [NONE; 2]
                } else {
                    [net.next(beyond), net.previous(beyond)]
                };
                let near = [half, net.next(half), net.previous(half), beyond, around, back];
                combined(&near.map(at))
            })
            .collect();
    }
    current
}

/// Words mixed into one, in order.
fn combined(words: &[u64]) -> u64 {
    words.iter().fold(0x9e37_79b9_7f4a_7c15, |state, &word| mixed(state ^ word))
}

/// Half-edges of two nets with the same signature.
#[derive(Debug, Clone)]
pub(super) struct Candidates {
    /// Half-edges by signature: `[sorted by signature]` of signature and half-edge.
    of: [Vec<(u64, u32)>; 2],
    /// The signature of each source half-edge.
    of_source: Vec<u64>,
}

impl Candidates {
    pub fn new(source: &Net, target: &Net) -> Self {
        let signatures = [source, target].map(signatures);
        let of = signatures.each_ref().map(|signatures| {
            let mut sorted: Vec<(u64, u32)> = signatures.iter().copied().zip(0..).collect();
            sorted.sort_unstable();
            sorted
        });
        let [of_source, _] = signatures;
        Self { of, of_source }
    }

    /// Every source half-edge whose signature occurs once in each net, with its counterpart.
    pub fn unique(&self) -> Vec<[u32; 2]> {
        let mut found = Vec::new();
        for group in self.of[0].chunk_by(|one, other| one.0 == other.0) {
            if let (&[(_, half)], &[(_, other)]) = (group, self.matching(group[0].0)) {
                found.push([half, other]);
            }
        }
        // In the order of the mesh, so that the result doesn't depend on hash values.
        found.sort_unstable();
        found
    }

    /// The target's half-edges with a signature.
    fn matching(&self, signature: u64) -> &[(u64, u32)] {
        let all = &self.of[1];
        let start = all.partition_point(|entry| entry.0 < signature);
        let length = all[start..].partition_point(|entry| entry.0 == signature);
        &all[start..start + length]
    }

    /// Among source half-edges, the one with the fewest counterparts for which `is_free` holds, and
    /// these.
    pub fn rarest(
        &self,
        halves: impl Iterator<Item = u32>,
        is_free: impl Fn(u32) -> bool,
    ) -> Option<(u32, Vec<u32>)> {
        let counterparts = |signature| {
            self.matching(signature).iter().map(|&(_, half)| half).filter(|&half| is_free(half))
        };
        let mut kinds: Vec<(u64, u32)> =
            halves.map(|half| (self.of_source[half as usize], half)).collect();
        kinds.sort_unstable();
        kinds.dedup_by_key(|(signature, _)| *signature);
        let mut best: Option<(usize, u32, u64)> = None;
        for (signature, half) in kinds {
            // More than the fewest need not be counted.
            let most = best.map_or(usize::MAX, |(fewest, ..)| fewest + 1);
            let count = counterparts(signature).take(most).count();
            if count > 0 && best.is_none_or(|best| (count, half) < (best.0, best.1)) {
                best = Some((count, half, signature));
            }
        }
        best.map(|(_, half, signature)| (half, counterparts(signature).collect()))
    }
}
