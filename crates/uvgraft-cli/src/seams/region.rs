//! The region whose rim is measured.

use uvgraft::{Direction, Pair};

/// A part of a layout.
pub(super) struct Region {
    /// What it is, for people.
    pub name: String,
    /// `[triangles]` whether each belongs to it.
    pub inside: Vec<bool>,
}

/// What transfers reach: the triangles with a counterpart, of the layout that `direction` leads to.
pub(super) fn linked(pair: &Pair, direction: Direction) -> Region {
    let mut inside = vec![false; pair.to(direction).faces().len()];
    for link in pair.links() {
        let face = match direction {
            Direction::Forward => link.target,
            Direction::Reverse => link.source,
        };
        inside[face as usize] = true;
    }
    Region { name: "the linked triangles".to_owned(), inside }
}
