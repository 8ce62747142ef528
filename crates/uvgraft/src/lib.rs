//! Carries textures between meshes with different UV layouts.
//!
//! Two meshes and the [`Piece`]s of their triangles that correspond form a [`Pair`]. A [`Graft`] is
//! a transfer prepared for one pair, one direction and one pair of sizes: it fills a base texture
//! through a [`SamplingMap`] (runs of texels whose source position is affine along a row) and
//! blends the result into the base.
//!
//! ```
//! use uvgraft::{Graft, Mesh, Pair, Sizes, Texture};
//!
//! fn transfer(head: Mesh, body: Mesh, vertex_map: &[i64], face: &Texture, base: &Texture)
//!     -> Result<Texture, Box<dyn std::error::Error>> {
//!     let pair = Pair::by_vertex_map(head, body, vertex_map)?;
//!     let graft = Graft::builder(pair, Sizes { from: face.size(), to: base.size() }).build()?;
//!     Ok(graft.apply(face, base)?)
//! }
//! ```
//!
//! The core does no file access, no timing and no command-line parsing. With the feature `threads`
//! (default), rows are processed in parallel on the caller's rayon pool; results do not depend on
//! the number of threads. See [`threads`].

pub mod area_colors;
pub mod blend;
pub mod color;
pub mod content;
mod convert;
mod copies;
pub mod dots;
pub mod fill;
pub mod filter;
pub mod fit;
pub mod formats;
pub mod graft;
pub mod labels;
mod layout_grid;
pub mod layout_match;
pub mod map;
pub mod matrix;
pub mod mesh_report;
mod non_finite;
pub mod normals;
pub mod operator;
pub mod overlay;
mod pad;
pub mod plan;
pub mod report;
pub mod resample;
mod resampler;
mod resize;
pub mod sampler;
mod simd;
pub mod skin;
pub mod texture;
pub mod tile_atlas;

pub use blend::{
    Blend, BlendDomain, BlendOptions, Selection, Tone, ToneCorrection, ToneError, ToneReport,
};
pub use color::Encoding;
pub use content::Content;
pub use fill::{FillError, fill, with_confidence};
pub use filter::Filter;
pub use fit::{FitOptions, FitProgress, FitSummary};
pub use formats::Averaging;
pub use graft::{FittedTransfer, Graft, GraftBuilder, GraftError};
pub use labels::{Label, LabelError, Labels};
pub use map::{MapOptions, PositionsError, Prefer, SamplingMap};
pub use matrix::{MatrixRows, OperatorMatrix};
pub use mesh_report::MeshReport;
pub use normals::{NormalFrames, NormalOptions, NormalY};
pub use operator::Operator;
pub use overlay::{BandError, BaseConversion, Overlay};
pub use plan::{Plan, PlanError};
pub use report::PairReport;
pub use resampler::Overlap;
pub use simd::simd_level;
pub use texture::{
    Channels, Depth, Size, Sizes, TexelFormat, Texels, TexelsMut, Texture, TextureError, Value,
};
pub use tile_atlas::StitchError;
pub use uvgraft_surface::{
    Anatomy, AnatomyError, Area, Choice, Corner, Direction, Extent, Fingerprint, HeadFrame,
    Landmark, LinkError, Mesh, MeshError, MeshPart, Pair, PairError, Piece, PieceError,
    Recognition, Side, SourceLayout, TangentFrame, TangentFrames, Tile, TileAtlas, TileAtlasError,
    TileError, Weights, anatomy, choice, choices, connectivity, correspond, deform, disjoint,
    easing, edges, islands, known, listing, mesh, pair, piece, raster, recognise, source_layout,
    statistics, surface_field, surface_index, tangents, threads, tile,
};
