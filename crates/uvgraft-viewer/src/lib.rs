//! One self-contained HTML page that shows an avatar and opens without a network or a server.
//!
//! The source of the page is in `page/` (JavaScript, three.js). `scripts/build-viewer.sh` bundles
//! it into one file, which this crate embeds with the feature `bundled`. [`Page`] adds an avatar
//! and further textures to it.

#![forbid(unsafe_code)]

mod glb;
mod page;
mod web_image;

pub use glb::{Glb, GlbError};
pub use page::{LookAt, Page, Template, TemplateError};
pub use web_image::WebImage;

/// The page without an avatar; `None` without the feature `bundled`.
pub const PAGE: Option<&str> = page_text();

#[cfg(feature = "bundled")]
const fn page_text() -> Option<&'static str> {
    Some(include_str!(env!("UVGRAFT_VIEWER_PAGE")))
}

#[cfg(not(feature = "bundled"))]
const fn page_text() -> Option<&'static str> {
    None
}
