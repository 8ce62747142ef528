//! What a transfer from files to files is asked to do, and what it did.

use std::path::PathBuf;
use std::sync::Arc;

use uvgraft::{
    Averaging, Blend, Direction, Filter, FitOptions, MapOptions, NormalOptions, Overlap, Size,
};
use uvgraft_io::image::WriteOptions;
use uvgraft_io::pair_file::PairFile;

use crate::blending::Blending;
use crate::failure::{Failure, Fault};
use crate::material::{Role, Values};
use crate::onto::Onto;
use crate::region::Region;

/// Which textures are carried.
#[derive(Debug, Clone, PartialEq)]
pub enum Inputs {
    /// Textures that are laid over one base, one each.
    Textures {
        /// Image files, and folders of them.
        sources: Vec<PathBuf>,
        /// What they are laid over; nothing, which needs [`Transfer::size`], if there is none.
        onto: Option<Onto>,
        /// What their values are.
        values: Values,
    },
    /// The maps of one material.
    Material(Vec<MaterialMap>),
}

/// A map of a material.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialMap {
    /// What it is; the output is named for it.
    pub role: Role,
    /// The image file.
    pub source: PathBuf,
    /// What it is laid over; nothing, which needs [`Transfer::size`], if there is none.
    pub onto: Option<Onto>,
}

/// What becomes of outputs that are there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Existing {
    /// All are made anew.
    #[default]
    Replace,
    /// Those that are up to date are left: that are as they were written, from inputs with the same content and with
    /// the same options, by this version. What each was made from is noted in `.uvgraft-manifest.jsonl` beside them;
    /// what was made without that is made anew.
    KeepUpToDate,
}

/// Which textures are carried, how, and where the results go.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Transfer {
    /// The pair file.
    pub pair: PathBuf,
    /// The textures, and what they are laid over.
    pub inputs: Inputs,
    /// A file; or a folder, made if it is missing, for several textures and for materials.
    pub output: PathBuf,
    /// Which way textures are carried.
    pub direction: Direction,
    /// Size of the results; base images are resized to it. Theirs, if there is none.
    pub size: Option<Size>,
    /// The interpolation filter; if there is none, Lanczos-3 for colours and bilinear for data.
    pub filter: Option<Filter>,
    /// How the map is built.
    pub map: MapOptions,
    /// What shows where islands overlap.
    pub overlap: Overlap,
    /// What colours are while they are averaged.
    pub averaging: Averaging,
    /// Which way the green channels of normal maps point.
    pub normals: NormalOptions,
    /// Whether textures are solved for rather than sampled, and how.
    pub fit: Option<FitOptions>,
    /// Which part of what is linked is meant.
    pub region: Region,
    /// How textures are blended in; all of what is linked is pasted if there is none and no region.
    pub blending: Option<Blending>,
    /// Where textures can be trusted: an image, white on black, in their layout.
    pub source_mask: Option<PathBuf>,
    /// A mean texture, in the textures' layout, for what they lack.
    pub fill: Option<PathBuf>,
    /// Extension of the results' format, where there are several; each source's own, if there is none.
    pub format: Option<String>,
    /// How results are written.
    pub write: WriteOptions,
    /// Where a mask of the texels that are carried is written.
    pub mask: Option<PathBuf>,
    /// Where a picture of what a texture shows is drawn, as labels; for one texture.
    pub draw_labels: Option<PathBuf>,
    /// What becomes of outputs that are there already.
    pub existing: Existing,
    /// How many textures are carried at once; one a thread, if it is not said.
    pub jobs: Option<u16>,
    /// Bytes for textures that are carried at once: fewer are, where they would not fit.
    pub memory: u64,
    /// Files that the caller writes itself: checked with the outputs.
    pub also_written: Vec<PathBuf>,
}

/// What was done.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Transferred {
    /// Textures that were written.
    pub written: usize,
    /// Textures that were up to date.
    pub up_to_date: usize,
    /// Why others were not written, in their order.
    pub failures: Vec<Failure>,
    /// The pair; none if everything was up to date.
    pub pair: Option<PairFile>,
    /// The blend, if there was one.
    pub blend: Option<Arc<Blend>>,
}

impl Transferred {
    /// Whose fault the worst failure is: one at work weighs more than a bad file.
    pub fn worst(&self) -> Option<Fault> {
        let faults = || self.failures.iter().map(Failure::fault);
        faults().find(|&fault| fault == Fault::Work).or_else(|| faults().next())
    }
}

impl Transfer {
    /// A transfer with everything as it is by default.
    pub fn new(pair: impl Into<PathBuf>, inputs: Inputs, output: impl Into<PathBuf>) -> Self {
        Self {
            pair: pair.into(),
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
            jobs: None,
            memory: 2 << 30,
            also_written: Vec::new(),
        }
    }

    /// The filter for textures of some kind.
    pub(crate) fn filter(&self, values: Values) -> Filter {
        self.filter.unwrap_or_else(|| values.filter())
    }
}
