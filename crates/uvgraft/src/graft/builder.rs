//! Builder of grafts.

use std::sync::{Arc, OnceLock};

use uvgraft_surface::pair::{Direction, Pair};

use super::{Graft, GraftBlend, GraftError, HiddenAreas, Link};
use crate::blend::{Blend, BlendDomain, BlendMap, BlendOptions, Selection};
use crate::content::Content;
use crate::filter::Filter;
use crate::formats::Averaging;
use crate::labels::Labels;
use crate::map::{MapOptions, Prefer, SamplingMap};
use crate::normals::NormalFrames;
use crate::resampler::{MapInputs, Overlap, Resampler};
use crate::texture::{Size, Sizes, Texture, TextureError};

/// Configures a [`Graft`]; from [`Graft::builder`].
#[derive(Debug, Clone)]
#[must_use]
pub struct GraftBuilder {
    link: Link,
    sizes: Sizes,
    direction: Direction,
    filter: Option<Filter>,
    map: MapOptions,
    overlap: Overlap,
    averaging: Averaging,
    content: Content,
    region: Option<Selection>,
    blend: Option<BlendOptions>,
    skin: Option<Texture>,
    labels: Option<Arc<Labels>>,
    shared_blend: Option<Arc<Blend>>,
}

impl GraftBuilder {
    pub(super) fn new(link: Link, sizes: Sizes) -> Self {
        Self {
            link,
            sizes,
            direction: Direction::default(),
            filter: None,
            map: MapOptions::default(),
            overlap: Overlap::default(),
            averaging: Averaging::default(),
            content: Content::default(),
            region: None,
            blend: None,
            skin: None,
            labels: None,
            shared_blend: None,
        }
    }

    /// Direction of the transfer (default: forward).
    pub fn direction(self, direction: Direction) -> Self {
        Self { direction, ..self }
    }

    /// Interpolation filter (default: Lanczos-3 for colours, bilinear for data and normals).
    pub fn filter(self, filter: Filter) -> Self {
        Self { filter: Some(filter), ..self }
    }

    /// Options of the sampling map (default: a gutter of 16 texels).
    pub fn map_options(self, map: MapOptions) -> Self {
        Self { map, ..self }
    }

    /// Gutter around UV islands, in texels.
    pub fn gutter_px(self, gutter_px: u32) -> Self {
        Self { map: MapOptions::with_gutter(gutter_px).prefer(self.map.prefer), ..self }
    }

    /// Which of several overlapping islands of the target owns the shared texels.
    pub fn prefer(self, prefer: Prefer) -> Self {
        Self { map: self.map.prefer(prefer), ..self }
    }

    /// What shows at texels that several islands of the target cover.
    pub fn overlap(self, overlap: Overlap) -> Self {
        Self { overlap, ..self }
    }

    /// The space in which colours are averaged.
    pub fn averaging(self, averaging: Averaging) -> Self {
        Self { averaging, ..self }
    }

    /// What the values of textures mean.
    pub fn content(self, content: Content) -> Self {
        Self { content, ..self }
    }

    /// Part of the target's surface that is transferred (default: everything linked). With a region or
    /// a blend that means the triangles that pieces fill: [`BlendDomain::linked`].
    pub fn region(self, region: Selection) -> Self {
        Self { region: Some(region), ..self }
    }

    /// How the texture is blended into the base (default: pasted with a hard edge).
    pub fn blend(self, blend: BlendOptions) -> Self {
        Self { blend: Some(blend), ..self }
    }

    /// Skin mask of the base: white on black, in the target's layout (default: estimated). Only for
    /// blends that take their tone from the texture.
    pub fn skin(self, mask: Texture) -> Self {
        Self { skin: Some(mask), ..self }
    }

    /// Semantic labels of the texture: skin, hair, cloth and so on (default: inferred from each
    /// texture).
    pub fn labels(self, labels: impl Into<Arc<Labels>>) -> Self {
        Self { labels: Some(labels.into()), ..self }
    }

    /// An existing blend, to be shared by several grafts; replaces [`GraftBuilder::region`],
    /// [`GraftBuilder::blend`], [`GraftBuilder::skin`] and [`GraftBuilder::labels`].
    pub fn shared_blend(self, blend: Arc<Blend>) -> Self {
        Self { shared_blend: Some(blend), ..self }
    }

    /// Builds the graft.
    ///
    /// # Errors
    /// [`GraftError::Texture`] for impossible sizes, or if there is not enough memory;
    /// [`GraftError::Region`] if no linked triangle is left in the region; [`GraftError::Domain`]
    /// if the region or the blend belongs to another pair or direction; [`GraftError::NoMeshes`]
    /// for a region, a blend or normals through a map.
    pub fn build(self) -> Result<Graft, GraftError> {
        check_size(self.sizes.from)?;
        check_size(self.sizes.to)?;
        match &self.link {
            Link::Pair(pair) => {
                let pair = Arc::clone(pair);
                self.build_with(pair)
            }
            Link::Map(map) => {
                let map = Arc::clone(map);
                self.build_through(map)
            }
        }
    }

    fn build_through(self, map: Arc<SamplingMap>) -> Result<Graft, GraftError> {
        if matches!(self.content, Content::Normals(_)) {
            return Err(GraftError::NoMeshes("normal maps need the tangent frames of two meshes"));
        }
        if self.region.is_some() || self.blend.is_some() || self.shared_blend.is_some() {
            return Err(GraftError::NoMeshes("regions and blends need the surface of a mesh"));
        }
        let filter = self.filter_or_default();
        let direction = map.direction();
        Ok(Graft {
            pair: None,
            direction,
            sizes: self.sizes,
            map_options: self.map,
            averaging: self.averaging,
            content: self.content,
            resampler: Arc::new(Resampler::of_map(map, self.sizes.from, filter)),
            blend: None,
            frames: None,
            fit: OnceLock::new(),
        })
    }

    fn filter_or_default(&self) -> Filter {
        self.filter.unwrap_or(match self.content {
            Content::Color => Filter::default(),
            // Overshoot would put values into data that none of its texels has.
            Content::Data | Content::Normals(_) => Filter::Bilinear,
        })
    }

    fn build_with(self, pair: Arc<Pair>) -> Result<Graft, GraftError> {
        let filter = self.filter_or_default();
        let Self { sizes, direction, map, overlap, averaging, content, .. } = self;
        let blend = match (self.shared_blend, self.region, self.blend) {
            (Some(blend), _, _) => Some(blend),
            (None, None, None) => None,
            (None, region, options) => {
                let region = region
                    .unwrap_or_else(|| BlendDomain::new(Arc::clone(&pair), direction).linked());
                let options =
                    options.unwrap_or_else(|| BlendOptions::default().gutter_px(map.gutter_px));
                check_domain("region", region.domain(), &pair, direction)?;
                let blend = Blend::new(&region, options)?;
                let blend = match self.skin {
                    Some(mask) => blend.with_skin(mask),
                    None => blend,
                };
                Some(Arc::new(match self.labels {
                    Some(labels) => blend.with_labels(labels),
                    None => blend,
                }))
            }
        };
        let inputs = MapInputs { pair: &pair, direction, target_size: sizes.to, map };
        let resampler = Arc::new(Resampler::new(&inputs, inputs.maps(overlap), sizes.from, filter));
        let frames = match content {
            Content::Normals(options) => {
                Some((Arc::new(NormalFrames::new(&pair, direction)), options))
            }
            Content::Color | Content::Data => None,
        };
        let blend = match blend {
            None => None,
            Some(blend) => {
                check_domain("blend", blend.domain(), &pair, direction)?;
                let blend_map = Arc::new(BlendMap::new(Arc::clone(&blend), resampler.map())?);
                let hidden = HiddenAreas::new(&blend, resampler.map(), content, sizes.from);
                Some(GraftBlend { blend, blend_map, hidden })
            }
        };
        Ok(Graft {
            pair: Some(pair),
            direction,
            sizes,
            map_options: map,
            averaging,
            content,
            resampler,
            blend,
            frames,
            fit: OnceLock::new(),
        })
    }
}

/// Checks that textures may have a size.
pub(super) fn check_size(size: Size) -> Result<(), TextureError> {
    if size.texels() == 0 {
        Err(TextureError::Empty(size))
    } else if size.width.max(size.height) > Texture::MAX_SIDE {
        Err(TextureError::TooLarge(size))
    } else {
        Ok(())
    }
}

/// Checks that a domain belongs to the graft's pair and direction.
///
/// - `what`: the object that was made on the domain.
fn check_domain(
    what: &'static str,
    domain: &BlendDomain,
    pair: &Arc<Pair>,
    wanted: Direction,
) -> Result<(), GraftError> {
    let found = domain.direction();
    if domain.is_of(pair, wanted) {
        Ok(())
    } else {
        let is_other_pair = !domain.is_of(pair, found);
        Err(GraftError::Domain { what, is_other_pair, found, wanted })
    }
}
