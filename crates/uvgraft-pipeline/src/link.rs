//! The pair or the map of a transfer, and what a map rules out.

use std::sync::Arc;

use uvgraft::{Direction, Graft, GraftBuilder, Overlap, Pair, SamplingMap, Size, Sizes};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::sampling_map;

use crate::failure::{Blame, Failure, Result};
use crate::material::Values;
use crate::transfer::{Correspondence, Inputs, Transfer};

/// What says where each texel comes from, read from its file.
pub(crate) enum Link {
    Pair(PairFile),
    Map(Arc<SamplingMap>),
}

impl Link {
    pub(crate) fn read(correspondence: &Correspondence) -> Result<Self> {
        Ok(match correspondence {
            Correspondence::Pair(input) => Self::Pair(pair_file::read(input).or_input()?),
            Correspondence::Map(input) => {
                Self::Map(Arc::new(sampling_map::read(input).or_input()?))
            }
        })
    }

    /// The pair, which blends need.
    pub(crate) fn pair(&self) -> Option<&Arc<Pair>> {
        match self {
            Self::Pair(file) => Some(&file.pair),
            Self::Map(_) => None,
        }
    }

    /// The pair, with the names of its source and its target.
    pub(crate) fn named_pair(&self) -> Option<(&Pair, [&str; 2])> {
        match self {
            Self::Pair(file) => Some((&file.pair, [&file.source_name, &file.target_name])),
            Self::Map(_) => None,
        }
    }

    pub(crate) fn into_pair_file(self) -> Option<PairFile> {
        match self {
            Self::Pair(file) => Some(file),
            Self::Map(_) => None,
        }
    }

    /// Starts a graft for textures and bases of some sizes.
    pub(crate) fn builder(&self, sizes: Sizes) -> GraftBuilder {
        match self {
            Self::Pair(file) => Graft::builder(Arc::clone(&file.pair), sizes),
            Self::Map(map) => Graft::through_map(Arc::clone(map), sizes.from),
        }
    }

    /// The size of results, if it is given by the map.
    ///
    /// - `wanted`: the size in the options.
    pub(crate) fn size(&self, wanted: Option<Size>) -> Result<Option<Size>> {
        match (self, wanted) {
            (Self::Pair(_), wanted) => Ok(wanted),
            (Self::Map(map), Some(wanted)) if wanted != map.size() => Err(Failure::option(
                format!("`size` must be that of the map, {}, got {wanted}", map.size()),
            )),
            (Self::Map(map), _) => Ok(Some(map.size())),
        }
    }
}

impl Transfer {
    /// Checks for options that a map rules out, since it knows no meshes.
    pub(crate) fn check_map(&self) -> Result<()> {
        if matches!(self.correspondence, Correspondence::Pair(_)) {
            return Ok(());
        }
        let normals = match &self.inputs {
            Inputs::Textures { values, .. } | Inputs::Listed { values, .. } => {
                *values == Values::Normals
            }
            Inputs::Material(maps) => maps.iter().any(|map| map.role.values() == Values::Normals),
        };
        let blends = self.blending.is_some() || self.draw_labels.is_some();
        let ruled_out = [
            (self.fit.is_some(), "`fit`", "a fit needs the way back, which only a pair has"),
            (
                !self.region.is_everything(),
                "`region`, `exclude` or `grow`",
                "regions are parts of a mesh, and a map has none",
            ),
            (
                blends,
                "`blend`, `feather`, `match_skin`, `labels` or `preview`",
                "blends are computed on the surface of a mesh, and a map has none",
            ),
            (self.region.unit.is_some(), "`unit`", "a map has no lengths"),
            (normals, "normal maps", "they need the tangent frames of two meshes"),
            (
                self.direction == Direction::Reverse,
                "`reverse`",
                "a map has one direction; export another one with `uvgraft map --reverse`",
            ),
            (
                self.overlap == Overlap::Average,
                "`overlap` average",
                "a map has one position for each texel",
            ),
        ];
        match ruled_out.into_iter().find(|(is_asked, ..)| *is_asked) {
            Some((_, what, why)) => {
                Err(Failure::option(format!("`with_map` cannot be used with {what}: {why}")))
            }
            None => Ok(()),
        }
    }
}
