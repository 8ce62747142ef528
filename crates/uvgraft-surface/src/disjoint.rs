//! Disjoint-set forest (union-find), used to find connected components.

/// A partition of the items `0..count` into sets that can be merged.
///
/// Path halving in [`DisjointSets::root`]; a set is represented by its lowest item, so the result
/// doesn't depend on the order of the joins.
///
/// # Example
/// ```
/// let mut sets = uvgraft_surface::disjoint::DisjointSets::new(4);
/// sets.join(3, 1);
/// assert_eq!(sets.root(3), sets.root(1));
/// assert_ne!(sets.root(0), sets.root(1));
/// ```
#[derive(Debug, Clone)]
pub struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Puts each of `count` items into a set by itself.
    #[inline]
    pub fn new(count: u32) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The lowest item of the set that contains `item`, which represents the set.
    ///
    /// # Panics
    /// If `item` is out of range.
    #[inline]
    pub fn root(&mut self, mut item: u32) -> u32 {
        while self.parents[item as usize] != item {
            let next = self.parents[self.parents[item as usize] as usize];
            self.parents[item as usize] = next;
            item = next;
        }
        item
    }

    /// Merges the sets that contain `a` and `b`.
    ///
    /// # Panics
    /// If either is out of range.
    #[inline]
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}
