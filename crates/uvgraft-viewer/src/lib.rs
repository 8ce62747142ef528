//! One self-contained HTML page that shows an avatar: whoever opens it needs no network and no server.
//!
//! The page is written in `page/` (JavaScript, three.js), made into one file by
//! `scripts/build-viewer.sh` and held by this crate with the feature `bundled`. [`Page`] puts an avatar
//! and further textures into it.

#![forbid(unsafe_code)]

mod glb;
mod page;
mod picture;

pub use glb::{Glb, GlbError};
pub use page::{LookAt, Page, Template, TemplateError};
pub use picture::Picture;

/// The page without an avatar; nothing without the feature `bundled`.
pub const PAGE: Option<&str> = page_text();

#[cfg(feature = "bundled")]
const fn page_text() -> Option<&'static str> {
    Some(include_str!(env!("UVGRAFT_VIEWER_PAGE")))
}

#[cfg(not(feature = "bundled"))]
const fn page_text() -> Option<&'static str> {
    None
}
