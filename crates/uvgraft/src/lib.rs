//! Carries textures between meshes with different UV layouts.
//!
//! Two meshes whose vertices correspond make a [`Pair`]. For a target size the pair makes a
//! [`SamplingMap`]: runs of texels whose source position is affine along a row. A [`Transfer`] fills
//! a base texture through the map:
//!
//! ```
//! use uvgraft::{Channels, Depth, Direction, Encoding, Mesh, Pair, Size, Texture};
//! use uvgraft::{Transfer, TransferOptions};
//!
//! // One square, laid out upright in one mesh and on its side in the other.
//! let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let upright = vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]];
//! let aside = vec![[0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]];
//! let faces = [[0, 1, 2], [0, 2, 3]];
//! let source = Mesh::from_triangles(positions.clone(), upright, &faces, &faces)?;
//! let target = Mesh::from_triangles(positions, aside, &faces, &faces)?;
//!
//! let pair = Pair::by_vertex_map(source, target, &[0, 1, 2, 3])?;
//! let filled = |side, color: [f32; 3]| {
//!     Texture::filled(Size::square(side), Channels::Rgb, Encoding::Srgb, Depth::U8, &color)
//! };
//! let (face, base) = (filled(256, [0.8, 0.6, 0.5])?, filled(512, [0.2, 0.2, 0.2])?);
//! let options = TransferOptions::default();
//! let transfer =
//!     Transfer::new(&pair, Direction::Forward, face.size(), base.size(), &options);
//! let result = transfer.apply(face, base)?;
//! assert_eq!(result.get(256, 256, 0), 0.8);
//! assert_eq!(result.get(0, 0, 0), 0.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The core knows no files, no clock and no command line. With the feature `threads` (default) rows
//! are worked on by the caller's rayon pool; results do not depend on it. See [`threads`].

pub mod baseline;
mod bits;
pub mod blend;
pub mod color;
mod convert;
pub mod correspond;
pub mod fill;
pub mod filter;
pub mod fit;
pub mod islands;
pub mod map;
pub mod mesh;
pub mod metrics;
pub mod normals;
pub mod operator;
pub mod overlay;
mod pad;
pub mod pair;
pub mod raster;
pub mod report;
pub mod resample;
mod resize;
mod rotation;
pub mod seams;
mod simd;
mod surface;
pub mod tangents;
pub mod texture;
pub mod threads;
pub mod transfer;
mod vector;

pub use blend::{Blend, BlendMap, BlendOptions, Ground, Selection, Tone, Toning, ToningError};
pub use color::Encoding;
pub use correspond::{Link, LinkError};
pub use fill::{FillError, fill, with_confidence};
pub use filter::Filter;
pub use fit::{Fit, FitOptions, FitProgress};
pub use map::{MapOptions, Prefer, SamplingMap};
pub use mesh::{Corner, Mesh, MeshError, Part};
pub use normals::{NormalFrames, NormalOptions, NormalY};
pub use operator::Operator;
pub use overlay::Overlay;
pub use pair::{Direction, Pair, PairError};
pub use report::PairReport;
pub use tangents::{TangentFrame, TangentFrames};
pub use texture::{Channels, Depth, Size, TexelFormat, Texels, Texture, TextureError, Value};
pub use transfer::{Overlap, Transfer, TransferError, TransferOptions};
