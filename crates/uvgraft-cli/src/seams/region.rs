//! The region whose rim is measured.

use uvgraft::blend::Ground;
use uvgraft::{Blend, BlendOptions, Direction, Pair};

use crate::failure::bad_input;
use crate::length::Unit;
use crate::region::RegionArgs;

/// A part of a layout.
pub(super) struct Region {
    /// What it is, for people.
    pub name: String,
    /// `[triangles]` whether each belongs to it.
    pub inside: Vec<bool>,
}

/// What options select of what transfers reach, of the layout that `direction` leads to: the triangles that
/// are in it, wholly or in part.
pub(super) fn of(
    args: &RegionArgs,
    pair: &Pair,
    direction: Direction,
    unit: Unit,
) -> anyhow::Result<Region> {
    let ground = Ground::new(pair, direction);
    let selection = args.select(&ground, unit)?;
    let blend = Blend::new(&ground, &selection, BlendOptions::default()).map_err(bad_input)?;
    let name = if args.is_everything() { "the linked triangles" } else { "the selected triangles" };
    Ok(Region { name: name.to_owned(), inside: blend.touched().to_vec() })
}
