//! What the textures of a batch share: options, the pair or map, the base, the blend, and grafts.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uvgraft::{
    Averaging, Blend, Direction, Filter, FitOptions, Graft, MapOptions, NormalOptions, Overlap,
    Size, Sizes, Texture,
};
use uvgraft_image::WriteOptions;

use crate::base::Base;
use crate::blending::KnownTexels;
use crate::failure::{Blame, Failure, Result};
use crate::layout_checks::LayoutChecks;
use crate::link::Link;
use crate::masks::MaskSizes;
use crate::material::Values;
use crate::transfer::Transfer;
use crate::unchanged::Unchanged;

/// Grafts of more source sizes are not kept: each has memory for the texels that its size reads.
const MAX_SIZES: usize = 64;

/// The options that apply to every texture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    pub(crate) values: Values,
    pub(crate) direction: Direction,
    pub(crate) filter: Filter,
    pub(crate) map: MapOptions,
    pub(crate) overlap: Overlap,
    pub(crate) averaging: Averaging,
    pub(crate) normals: NormalOptions,
    pub(crate) fit: Option<FitOptions>,
    pub(crate) write: WriteOptions,
}

impl Options {
    /// - `values`: what the values of the textures mean.
    pub(crate) fn new(transfer: &Transfer, values: Values) -> Self {
        let Transfer { direction, map, overlap, averaging, normals, fit, write, .. } = *transfer;
        let filter = transfer.filter(values);
        Self { values, direction, filter, map, overlap, averaging, normals, fit, write }
    }
}

/// What textures share. It is prepared once, and used by several threads at once.
pub(crate) struct Shared {
    pub(crate) options: Options,
    pub(crate) link: Arc<Link>,
    pub(crate) base: Base,
    pub(crate) blend: Option<Arc<Blend>>,
    pub(crate) known: Arc<KnownTexels>,
    pub(crate) mask_sizes: Arc<MaskSizes>,
    pub(crate) grafts: Grafts,
    pub(crate) layout_checks: LayoutChecks,
    /// What results have in common, if there may be several and the base is in memory.
    pub(crate) unchanged: Option<Unchanged>,
}

/// One cell for each texture size, and the first graft, whose parts the others share.
#[derive(Default)]
pub(crate) struct Grafts {
    by_size: Mutex<HashMap<Size, Arc<GraftCell>>>,
    first: OnceLock<Arc<Graft>>,
}

/// A graft once it is built, or the reason for failure.
type GraftCell = OnceLock<Result<Arc<Graft>>>;

impl Grafts {
    fn cell(&self, size: Size) -> Arc<GraftCell> {
        let mut by_size = self.by_size.lock().unwrap_or_else(PoisonError::into_inner);
        if by_size.len() >= MAX_SIZES && !by_size.contains_key(&size) {
            by_size.clear();
        }
        by_size.entry(size).or_default().clone()
    }
}

impl Shared {
    /// The graft for textures of `size`, built once while other threads wait for it.
    pub(crate) fn graft(&self, size: Size) -> Result<Arc<Graft>> {
        let cell = self.grafts.cell(size);
        cell.get_or_init(|| self.make_graft(size).map(Arc::new)).clone()
    }

    fn make_graft(&self, size: Size) -> Result<Graft> {
        if let Some(graft) = self.grafts.first.get() {
            return graft.with_texture_size(size).or_work();
        }
        let graft = self.build_graft(size)?;
        let _ = self.grafts.first.set(Arc::new(graft.clone()));
        Ok(graft)
    }

    fn build_graft(&self, from: Size) -> Result<Graft> {
        let Self { options, .. } = self;
        let sizes = Sizes { from, to: self.base.size() };
        let mut builder = self
            .link
            .builder(sizes)
            .direction(options.direction)
            .filter(options.filter)
            .map_options(options.map)
            .overlap(options.overlap)
            .averaging(options.averaging)
            .content(options.values.content(options.normals));
        if let Some(blend) = &self.blend {
            builder = builder.shared_blend(Arc::clone(blend));
        }
        let graft = builder.build().or_work()?;
        let stats = graft.map().stats();
        if stats.linked == 0 {
            let why = stats.why_nothing_is_linked();
            let message = format!("the pair links no texel of a {} result: {why}", sizes.to);
            return Err(Failure::input(message));
        }
        Ok(graft)
    }

    /// The coverage mask; the same for every texture size.
    pub(crate) fn mask(&self) -> Result<Texture> {
        match self.grafts.first.get() {
            Some(graft) => Ok(graft.mask()),
            // No texture needed a graft, so any size does.
            None => Ok(self.build_graft(Size::square(1))?.mask()),
        }
    }
}
