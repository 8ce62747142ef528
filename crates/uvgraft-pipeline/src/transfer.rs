//! The request and the result of a transfer between files.

use std::path::PathBuf;
use std::sync::Arc;

use uvgraft::{
    Averaging, Blend, Direction, Filter, FitOptions, MapOptions, NormalOptions, Overlap, Size,
};
use uvgraft_files::input::Input;
use uvgraft_image::WriteOptions;
use uvgraft_io::pair_file::PairFile;

use crate::base_source::BaseSource;
use crate::blending::Blending;
use crate::failure::{Failure, Fault};
use crate::material::{Role, Values};
use crate::region::Region;
use crate::shard::Shard;
use crate::texture_list::TextureList;

/// What says where each texel of the result comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Correspondence {
    /// A pair file.
    Pair(Input),
    /// A map in a format of other tools: [`uvgraft_io::sampling_map::read`]. It determines the size
    /// of results. It knows no meshes: there is no region, no blending, no fit, no other direction,
    /// and normal maps cannot be transferred.
    Map(Input),
}

impl Correspondence {
    /// The file.
    pub fn input(&self) -> &Input {
        match self {
            Self::Pair(input) | Self::Map(input) => input,
        }
    }
}

/// Which textures are transferred.
#[derive(Debug, Clone, PartialEq)]
pub enum Inputs {
    /// Textures that share one base.
    Textures {
        /// Images, and folders of them. Outputs in a folder are named after them.
        sources: Vec<Input>,
        /// Their base; without one, [`Transfer::size`] is required.
        onto: Option<BaseSource>,
        /// What their values mean.
        values: Values,
    },
    /// Textures that a text file lists, and that share one base.
    Listed {
        /// The list.
        list: TextureList,
        /// Their base; without one, [`Transfer::size`] is required.
        onto: Option<BaseSource>,
        /// What their values mean.
        values: Values,
    },
    /// The maps of one material.
    Material(Vec<MaterialMap>),
}

/// A map of a material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialMap {
    /// Its role; the output is named after it.
    pub role: Role,
    /// The image.
    pub source: Input,
    /// Its base; without one, [`Transfer::size`] is required.
    pub onto: Option<BaseSource>,
}

/// What happens to existing outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Existing {
    /// All are overwritten.
    #[default]
    Replace,
    /// Outputs that are up to date are skipped: those unchanged since they were written, from
    /// inputs with the same content, with the same options, by this version. A [`Manifest`] is kept
    /// in their folder; outputs without a record in it are overwritten.
    ///
    /// [`Manifest`]: crate::Manifest
    KeepUpToDate,
}

/// A transfer: which textures, how, and where the results go.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Transfer {
    /// The pair or the map.
    pub correspondence: Correspondence,
    /// The textures and their bases.
    pub inputs: Inputs,
    /// A file; or a folder, created if missing, for several textures, lists and materials.
    pub output: PathBuf,
    /// The direction of the transfer.
    pub direction: Direction,
    /// Size of the results; base images are resized to it. By default the size of the base image.
    pub size: Option<Size>,
    /// The interpolation filter; by default Lanczos-3 for colours and bilinear for data.
    pub filter: Option<Filter>,
    /// Options of the sampling map.
    pub map: MapOptions,
    /// How overlapping islands are combined.
    pub overlap: Overlap,
    /// The encoding in which colours are averaged.
    pub averaging: Averaging,
    /// Green channel conventions of normal maps.
    pub normals: NormalOptions,
    /// Solves for textures by least squares instead of sampling, with these options.
    pub fit: Option<FitOptions>,
    /// The region of the linked surface to use.
    pub region: Region,
    /// How textures are blended in; without it and without a region, they are pasted as they are.
    pub blending: Option<Blending>,
    /// The trusted texels of textures: an image, white on black, in their layout.
    pub source_mask: Option<Input>,
    /// A mean texture, in the layout of the textures, for unseen areas.
    pub fill: Option<Input>,
    /// Extension of the outputs if there are several; by default that of each source.
    pub format: Option<String>,
    /// How results are encoded.
    pub write: WriteOptions,
    /// Where to write a mask of the texels that are covered.
    pub mask: Option<PathBuf>,
    /// Where to draw the labels of the texture; for a single texture only.
    pub draw_labels: Option<PathBuf>,
    /// What happens to existing outputs.
    pub existing: Existing,
    /// The part of the textures to transfer; by default all of them. Several processes may transfer
    /// the shards of a batch into one folder at the same time.
    pub shard: Option<Shard>,
    /// Number of textures processed in parallel; by default one per thread.
    pub jobs: Option<u16>,
    /// Bound on the memory of the process, in bytes. Fewer textures are processed in parallel where
    /// they would exceed it, and what could exceed it alone is refused. By default textures that are
    /// processed at once take 2 GiB together, and a larger one is processed alone.
    pub memory: Option<u64>,
    /// Files that the caller writes itself, to be checked along with the outputs.
    pub extra_outputs: Vec<PathBuf>,
}

/// The result of a transfer.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Transferred {
    /// Number of textures written.
    pub written: usize,
    /// Number of textures that were up to date.
    pub up_to_date: usize,
    /// Why the other textures were not written, in order.
    pub failures: Vec<Failure>,
    /// The pair; `None` if everything was up to date, and for a map.
    pub pair: Option<PairFile>,
    /// The blend, if there was one.
    pub blend: Option<Arc<Blend>>,
}

impl Transferred {
    /// The worst fault among the failures: a failure during the work outranks a bad input.
    pub fn worst(&self) -> Option<Fault> {
        let faults = || self.failures.iter().map(Failure::fault);
        faults().find(|&fault| fault == Fault::Work).or_else(|| faults().next())
    }
}

impl Inputs {
    /// Textures that share one base, by default with colours.
    pub fn textures<S: Into<Input>>(
        sources: impl IntoIterator<Item = S>,
        onto: impl Into<Option<BaseSource>>,
    ) -> Self {
        let sources = sources.into_iter().map(Into::into).collect();
        Self::Textures { sources, onto: onto.into(), values: Values::default() }
    }
}

impl Transfer {
    /// A transfer by a pair file, with default options.
    pub fn new(pair: impl Into<Input>, inputs: Inputs, output: impl Into<PathBuf>) -> Self {
        Self::by(Correspondence::Pair(pair.into()), inputs, output)
    }

    /// A transfer with default options.
    pub fn by(correspondence: Correspondence, inputs: Inputs, output: impl Into<PathBuf>) -> Self {
        Self {
            correspondence,
            inputs,
            output: output.into(),
            direction: Direction::default(),
            size: None,
            filter: None,
            map: MapOptions::default(),
            overlap: Overlap::default(),
            averaging: Averaging::default(),
            normals: NormalOptions::default(),
            fit: None,
            region: Region::default(),
            blending: None,
            source_mask: None,
            fill: None,
            format: None,
            write: WriteOptions::default(),
            mask: None,
            draw_labels: None,
            existing: Existing::default(),
            shard: None,
            jobs: None,
            memory: None,
            extra_outputs: Vec::new(),
        }
    }

    /// The filter for textures of the given kind.
    pub(crate) fn filter(&self, values: Values) -> Filter {
        self.filter.unwrap_or_else(|| values.filter())
    }
}
