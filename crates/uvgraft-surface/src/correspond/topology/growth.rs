//! Growing a match of two nets from a pair of half-edges over their neighbours.

use std::collections::{BTreeMap, VecDeque};

use super::net::{NONE, Net};

/// Which points and rings of two nets correspond so far.
#[derive(Debug, Clone)]
pub(super) struct Match {
    /// The target point of each source point, or [`NONE`].
    pub target_of: Vec<u32>,
    /// The source point of each target point, or [`NONE`].
    pub source_of: Vec<u32>,
    /// The target ring of each source ring, or [`NONE`].
    pub ring: Vec<u32>,
    /// Whether a target ring corresponds to a source ring.
    pub is_taken: Vec<bool>,
}

/// What one growth added.
#[derive(Debug, Clone, Default)]
pub(super) struct Grown {
    /// Source rings, in the order in which they were matched.
    pub rings: Vec<u32>,
    /// Source points.
    pub points: Vec<u32>,
    /// Places where the two nets go on differently.
    pub contradictions: usize,
}

/// The steps that a search may still take: polygons that are matched, and points that are compared.
#[derive(Debug)]
pub(super) struct Work {
    left: u64,
}

impl Work {
    pub fn new(most: u64) -> Self {
        Self { left: most }
    }

    /// Takes some steps; false if there are no more, now and from now on.
    pub fn take(&mut self, steps: usize) -> bool {
        self.left = self.left.saturating_sub(steps as u64);
        !self.is_done()
    }

    /// Whether all steps were taken.
    pub fn is_done(&self) -> bool {
        self.left == 0
    }
}

/// Pairs of half-edges to grow over: those with the least strain first, and of these the first.
#[derive(Debug, Default)]
struct Queue {
    by_strain: BTreeMap<usize, VecDeque<[u32; 2]>>,
}

impl Queue {
    fn push(&mut self, strain: usize, halves: [u32; 2]) {
        self.by_strain.entry(strain).or_default().push_back(halves);
    }

    fn pop(&mut self) -> Option<(usize, [u32; 2])> {
        let mut least = self.by_strain.first_entry()?;
        let strain = *least.key();
        let halves = least.get_mut().pop_front();
        if least.get().is_empty() {
            least.remove();
        }
        halves.map(|halves| (strain, halves))
    }
}

impl Match {
    pub fn new(source: &Net, target: &Net) -> Self {
        Self {
            target_of: vec![NONE; source.valence.len()],
            source_of: vec![NONE; target.valence.len()],
            ring: vec![NONE; source.rings()],
            is_taken: vec![false; target.rings()],
        }
    }

    /// Grows from two half-edges that are taken to correspond.
    ///
    /// Rings that contradict what is matched already are left out. Points whose valences agree are
    /// passed first: across an inserted or removed edge everything would be one ring off, and so
    /// it stays the last to be tried. Growth is given up, and undone, where contradictions
    /// abound, and at the end of the `work` that may be done.
    pub fn grow(&mut self, nets: [&Net; 2], seed: [u32; 2], work: &mut Work) -> Option<Grown> {
        let mut grown = Grown::default();
        let mut queue = Queue::default();
        queue.push(0, seed);
        while let Some((strain, halves)) = queue.pop() {
            let rings = [0, 1].map(|side| nets[side].ring_of[halves[side] as usize]);
            if self.ring[rings[0] as usize] != NONE {
                grown.contradictions += usize::from(self.ring[rings[0] as usize] != rings[1]);
                continue;
            }
            let corners = nets[0].halves(rings[0]).len();
            if !work.take(1 + corners / 8) {
                self.undo(&grown);
                return None;
            }
            if !self.add(nets, halves, &mut grown) {
                grown.contradictions += 1;
                if grown.contradictions > 8 + grown.rings.len() / 6 {
                    self.undo(&grown);
                    return None;
                }
                continue;
            }
            let mut pair = halves;
            loop {
                let twins = [0, 1].map(|side| nets[side].twin[pair[side] as usize]);
                if !twins.contains(&NONE) {
                    let ends = [pair, [0, 1].map(|side| nets[side].next(pair[side]))];
                    let differ = |halves: &[u32; 2]| {
                        let [a, b] = [0, 1].map(|side: usize| {
                            let point = nets[side].points[halves[side] as usize];
                            nets[side].valence[point as usize]
                        });
                        usize::from(a != b)
                    };
                    queue.push(strain + ends.iter().map(differ).sum::<usize>(), twins);
                }
                pair = [0, 1].map(|side| nets[side].next(pair[side]));
                if pair == halves {
                    break;
                }
            }
        }
        Some(grown)
    }

    /// Matches the rings of two half-edges if they have the same number of corners and nothing
    /// contradicts.
    fn add(&mut self, nets: [&Net; 2], halves: [u32; 2], grown: &mut Grown) -> bool {
        let rings = [0, 1].map(|side| nets[side].ring_of[halves[side] as usize]);
        let sizes = [0, 1].map(|side| nets[side].halves(rings[side]).len());
        if sizes[0] != sizes[1] || self.is_taken[rings[1] as usize] {
            return false;
        }
        let corners = || {
            let mut pair = halves;
            (0..sizes[0]).map(move |_| {
                let points = [0, 1].map(|side| nets[side].points[pair[side] as usize]);
                pair = [0, 1].map(|side| nets[side].next(pair[side]));
                points
            })
        };
        let fits = |[source, target]: [u32; 2]| {
            let known = [self.target_of[source as usize], self.source_of[target as usize]];
            known == [NONE; 2] || known == [target, source]
        };
        if !corners().all(fits) {
            return false;
        }
        for [source, target] in corners() {
            if self.target_of[source as usize] == NONE {
                self.target_of[source as usize] = target;
                self.source_of[target as usize] = source;
                grown.points.push(source);
            }
        }
        self.ring[rings[0] as usize] = rings[1];
        self.is_taken[rings[1] as usize] = true;
        grown.rings.push(rings[0]);
        true
    }

    /// Takes back what a growth added.
    pub fn undo(&mut self, grown: &Grown) {
        for &point in &grown.points {
            let target = std::mem::replace(&mut self.target_of[point as usize], NONE);
            self.source_of[target as usize] = NONE;
        }
        for &ring in &grown.rings {
            let target = std::mem::replace(&mut self.ring[ring as usize], NONE);
            self.is_taken[target as usize] = false;
        }
    }

    /// The source points of matched rings.
    pub fn ring_points(&self, source: &Net) -> Vec<u32> {
        let of_ring = |ring: u32| source.halves(ring).map(|half| source.points[half as usize]);
        let matched = (0..).zip(&self.ring).filter(|(_, target)| **target != NONE);
        let mut points: Vec<u32> = matched.flat_map(|(ring, _)| of_ring(ring)).collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// Number of source rings with a counterpart.
    pub fn rings(&self) -> usize {
        self.ring.iter().filter(|&&ring| ring != NONE).count()
    }
}
