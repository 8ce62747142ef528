//! Which things hang together, by what joins two of them at a time.

/// Things numbered from 0, in sets that grow as they are joined.
///
/// # Example
/// ```
/// let mut sets = uvgraft::disjoint::DisjointSets::new(4);
/// sets.join(3, 1);
/// assert_eq!(sets.root(3), sets.root(1));
/// assert_ne!(sets.root(0), sets.root(1));
/// ```
#[derive(Debug, Clone)]
pub struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// Each thing is a set of its own.
    pub fn new(count: u32) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The lowest thing of the set that one is in, which stands for it.
    ///
    /// # Panics
    /// If there is no such thing.
    pub fn root(&mut self, mut thing: u32) -> u32 {
        while self.parents[thing as usize] != thing {
            let above = self.parents[self.parents[thing as usize] as usize];
            self.parents[thing as usize] = above;
            thing = above;
        }
        thing
    }

    /// Makes one set of those that two things are in.
    ///
    /// # Panics
    /// If there is no such thing.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}
