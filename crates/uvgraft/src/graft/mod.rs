//! A prepared transfer: everything that transfers textures does so through a [`Graft`].

mod builder;
mod error;

pub use builder::GraftBuilder;
pub use error::GraftError;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use uvgraft_surface::pair::{Direction, Pair};

use crate::blend::{Blend, BlendMap, Collapsed, EyeRims, ToneCorrection, ToneError, ToningMap};
use crate::color::Encoding;
use crate::content::Content;
use crate::copies;
use crate::filter::Filter;
use crate::fit::{FitOptions, FitProgress, FitSummary, FitSystem};
use crate::formats::{Averaging, Formats};
use crate::map::{MapOptions, SamplingMap};
use crate::normals::{NormalFrames, NormalOptions};
use crate::operator::Operator;
use crate::overlay::{Layer, Overlay};
use crate::plan::{Plan, PlanError};
#[cfg(doc)]
use crate::resampler::Overlap;
use crate::resampler::{MapInputs, Resampler};
use crate::texture::{Size, Sizes, TexelFormat, Texture};

/// A transfer ready to be applied: a pair, a direction, texture sizes, filtering, and blending into
/// the base.
///
/// It owns or shares everything it needs, so it can be kept in a `static`, sent to other threads
/// and used by several at once. Preparation takes milliseconds to tens of milliseconds; clones
/// share the result.
///
/// ```
/// use uvgraft::{Channels, Depth, Encoding, Graft, Mesh, Pair, Size, Sizes, Texture};
///
/// // One square, laid out upright in one mesh and on its side in the other.
/// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let upright = vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]];
/// let aside = vec![[0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]];
/// let faces = [[0, 1, 2], [0, 2, 3]];
/// let source = Mesh::from_triangles(positions.clone(), upright, &faces, &faces)?;
/// let target = Mesh::from_triangles(positions, aside, &faces, &faces)?;
/// let pair = Pair::by_vertex_map(source, target, &[0, 1, 2, 3])?;
///
/// let filled = |side, color: [f32; 3]| {
///     Texture::filled(Size::square(side), Channels::Rgb, Encoding::Srgb, Depth::U8, &color)
/// };
/// let (face, base) = (filled(256, [0.8, 0.6, 0.5])?, filled(512, [0.2, 0.2, 0.2])?);
/// let graft = Graft::builder(pair, Sizes { from: face.size(), to: base.size() }).build()?;
/// let result = graft.apply(&face, &base)?;
/// assert_eq!(result.get(256, 256, 0), 0.8);
/// assert_eq!(result.get(0, 0, 0), 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Graft {
    /// `None` for a map of another origin.
    pair: Option<Arc<Pair>>,
    direction: Direction,
    sizes: Sizes,
    map_options: MapOptions,
    averaging: Averaging,
    content: Content,
    resampler: Arc<Resampler>,
    blend: Option<GraftBlend>,
    /// For [`Content::Normals`] only.
    frames: Option<(Arc<NormalFrames>, NormalOptions)>,
    /// Made for the first texture that is fitted.
    fit: OnceLock<Arc<FitSystem>>,
}

/// What says where the texels of the target come from.
#[derive(Debug, Clone)]
enum Link {
    Pair(Arc<Pair>),
    Map(Arc<SamplingMap>),
}

/// A blend at the texels of the map, and what it fills in.
#[derive(Debug, Clone)]
struct GraftBlend {
    blend: Arc<Blend>,
    blend_map: Arc<BlendMap>,
    hidden: HiddenAreas,
}

/// Areas of the target that captures do not see, the rims of eyes and mouth interiors: filled in
/// for blends that use labels.
#[derive(Debug, Clone, Default)]
struct HiddenAreas {
    eye_rims: Option<Arc<EyeRims>>,
    collapsed: Option<Arc<Collapsed>>,
}

impl HiddenAreas {
    const fn is_some(&self) -> bool {
        self.eye_rims.is_some() || self.collapsed.is_some()
    }

    fn new(blend: &Blend, map: &Arc<SamplingMap>, content: Content, from: Size) -> Self {
        if content != Content::Color || !blend.options().needs_labels() {
            return Self::default();
        }
        let domain = blend.domain();
        Self {
            eye_rims: EyeRims::new(domain, from).map(Arc::new),
            collapsed: Collapsed::new(domain, map, from).map(Arc::new),
        }
    }
}

/// A fitted texture; from [`Graft::fit`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FittedTransfer {
    /// The texture, ready to be laid over a base.
    pub overlay: Overlay,
    /// Outcome of the fit.
    pub summary: FitSummary,
}

impl Graft {
    /// Starts building a graft.
    pub fn builder(pair: impl Into<Arc<Pair>>, sizes: Sizes) -> GraftBuilder {
        GraftBuilder::new(Link::Pair(pair.into()), sizes)
    }

    /// Starts building a graft through a map of any origin, such as
    /// [`SamplingMap::from_positions`], in place of a pair's map.
    ///
    /// - `from`: the size of the textures; that of the bases is the map's.
    ///
    /// Without meshes there is no region, no blend, no fit and no content of normals, the source has
    /// no islands to pad, and options of the pair's map are ignored.
    pub fn through_map(map: impl Into<Arc<SamplingMap>>, from: Size) -> GraftBuilder {
        let map = map.into();
        let sizes = Sizes { from, to: map.size() };
        GraftBuilder::new(Link::Map(map), sizes)
    }

    /// Lays a texture over a base.
    ///
    /// The result has all channels of both, the greater depth of both, and the base's encoding; for
    /// data and normals, [`Encoding::Data`]. If the blend matches tones, the tone is estimated from
    /// this texture and this base. [`Overlay::lay`] says how values are composited.
    ///
    /// Owned textures are processed in place; borrowed ones are copied, textures only as far as the map
    /// reads them.
    ///
    /// # Errors
    /// [`GraftError::Size`] if a texture has another size than the graft was made for,
    /// [`GraftError::Channels`] for normals in fewer than three channels,
    /// [`GraftError::ToneCorrection`] if no tone can be estimated.
    pub fn apply<'t>(
        &self,
        texture: impl Into<Cow<'t, Texture>>,
        base: impl Into<Cow<'t, Texture>>,
    ) -> Result<Texture, GraftError> {
        let (texture, base) = (texture.into(), base.into());
        check_size("base", &base, self.sizes.to)?;
        let base_format = base.format();
        let toning = self.toning(&texture, &base, base_format)?;
        let overlay = self.overlay(texture, base_format)?;
        let overlay = match &toning {
            Some(toning) => overlay.with_tone(toning)?,
            None => overlay,
        };
        Ok(overlay.lay(0, self.reinterpret(copies::owned(base)))?)
    }

    /// Prepares a texture to be laid over a base of the given format, band by band. If the blend
    /// matches tones, apply the tone with [`Overlay::with_tone`].
    ///
    /// # Errors
    /// As [`Graft::apply`], except for those of the base and the tone.
    pub fn overlay<'t>(
        &self,
        texture: impl Into<Cow<'t, Texture>>,
        base: TexelFormat,
    ) -> Result<Overlay, GraftError> {
        let texture = texture.into();
        self.check(&texture)?;
        let texture = if self.blend.as_ref().is_some_and(|blend| blend.hidden.is_some()) {
            // Also reads what the map does not.
            copies::owned(texture)
        } else {
            copies::owned_in(texture, self.resampler.source_tiles())
        };
        let texture = self.prepared(texture);
        let formats = self.formats(texture.format(), base);
        let source = self.resampler.source(&formats, texture);
        let smooth = self.blend.as_ref().and_then(|GraftBlend { blend, hidden, .. }| {
            let collapsed = hidden.collapsed.as_ref()?;
            Some(collapsed.smooth(blend.domain(), &source.texture))
        });
        let overlay = self.make_overlay(formats, Layer::Sampled(Arc::new(source)));
        Ok(match smooth {
            Some(smooth) => overlay.smoothed(smooth),
            None => overlay,
        })
    }

    /// Estimates the tone that matches a texture and a base; `None` if the blend matches no tones,
    /// or if the content is not colour.
    ///
    /// - `base`: its colours, at any size; for a base of one colour a single texel is enough.
    /// - `base_format`: format of the base that the texture is laid over.
    ///
    /// # Errors
    /// [`ToneError`] where there is no basis for an estimate; the texture can still be laid over
    /// without a tone.
    pub fn toning(
        &self,
        texture: &Texture,
        base: &Texture,
        base_format: TexelFormat,
    ) -> Result<Option<ToneCorrection>, ToneError> {
        match &self.blend {
            Some(GraftBlend { blend, .. }) if self.content == Content::Color => {
                // Data is refused, whatever the base.
                let encoding = self.formats(texture.format(), base_format).working_encoding();
                if encoding == Encoding::Data && blend.options().needs_colors() {
                    return Err(ToneError::Data);
                }
                blend.toning(texture, base)
            }
            _ => Ok(None),
        }
    }

    /// Finds what a blend leaves out of a texture, such as a collar, without changing any colour:
    /// for [`Overlay::with_exclusion`].
    pub fn exclusion(&self, texture: &Texture) -> Option<ToneCorrection> {
        let blend = self.blend()?;
        let toning = blend.exclusion(texture);
        toning.narrowed().is_some().then_some(toning)
    }

    /// Solves for the texture that reads back best with the same filter, instead of sampling it,
    /// and prepares it to be laid over a base. Integer depths clamp to their range. The gutter is
    /// sampled.
    ///
    /// - `progress`: called before the first step and after each.
    ///
    /// # Errors
    /// As [`Graft::overlay`]; [`GraftError::NotFinite`] if a float texture contains a NaN or an
    /// infinity; [`GraftError::Fit`] for normals, for [`Overlap::Average`] where islands do overlap
    /// (there is no single island to solve for), for [`Filter::Nearest`], which never blends
    /// texels, for a graft through a map, which has no way back, and for options that are not finite or negative weights.
    pub fn fit<'t>(
        &self,
        texture: impl Into<Cow<'t, Texture>>,
        base: TexelFormat,
        options: &FitOptions,
        progress: &mut dyn FnMut(FitProgress),
    ) -> Result<FittedTransfer, GraftError> {
        if self.frames.is_some() {
            return Err(GraftError::Fit("normal maps cannot be fitted"));
        }
        let Some(inputs) = self.map_inputs() else {
            return Err(GraftError::Fit("a map without meshes has no way back"));
        };
        if self.resampler.beneath().is_some() {
            return Err(GraftError::Fit("overlapping islands cannot be averaged in a fit"));
        }
        if self.filter() == Filter::Nearest {
            return Err(GraftError::Fit(
                "the filter nearest cannot be fitted, since it does not blend texels",
            ));
        }
        let weights = [options.regularization, options.smoothness.unwrap_or(0.0)];
        let is_weight = |weight: f32| (0.0..f32::INFINITY).contains(&weight);
        if !(options.min_gain.is_finite() && weights.into_iter().all(is_weight)) {
            return Err(GraftError::Fit(
                "least gain, regularization and smoothness must be finite, the latter two also \
                 non-negative",
            ));
        }
        let texture = texture.into();
        self.check(&texture)?;
        let texture = self.prepared(copies::owned(texture));
        let formats = self.formats(texture.format(), base);
        let system =
            self.fit.get_or_init(|| Arc::new(FitSystem::new(&inputs, Arc::clone(&self.resampler))));
        let (layer, summary) = system
            .solve(&formats, texture, options, progress)
            .map_err(|error| GraftError::NotFinite { x: error.texel[0], y: error.texel[1] })?;
        Ok(FittedTransfer {
            overlay: self.make_overlay(formats, Layer::Solved(Arc::new(layer))),
            summary,
        })
    }

    /// The transfer as a matrix.
    pub fn operator(&self) -> Operator {
        Operator::new(Arc::clone(&self.resampler))
    }

    /// The transfer as plain numbers.
    ///
    /// # Errors
    /// [`PlanError`] if it is more than sampling.
    pub fn plan(&self) -> Result<Plan, PlanError> {
        if self.blend.is_some() {
            return Err(PlanError::Blend);
        }
        if self.frames.is_some() {
            return Err(PlanError::Normals);
        }
        if self.resampler.beneath().is_some() {
            return Err(PlanError::Average);
        }
        Ok(Plan {
            resampler: Arc::clone(&self.resampler),
            averaging: self.averaging,
            content: self.content,
        })
    }

    /// The texels that are transferred, as an 8-bit grey texture: white where pieces own them, grey
    /// where the base shows through a feather, black elsewhere, including the gutter.
    pub fn mask(&self) -> Texture {
        match &self.blend {
            Some(GraftBlend { blend_map, .. }) => {
                blend_map.weights(self.map(), &ToningMap::default())
            }
            None => self.map().mask(),
        }
    }

    /// The same transfer for textures of another size; shares everything that does not depend on
    /// it.
    ///
    /// # Errors
    /// [`GraftError::Texture`] if a texture cannot have that size.
    pub fn with_texture_size(&self, from: Size) -> Result<Self, GraftError> {
        builder::check_size(from)?;
        let map = Arc::clone(self.resampler.map());
        let resampler = Arc::new(match self.map_inputs() {
            Some(inputs) => {
                let maps = (map, self.resampler.beneath().cloned());
                Resampler::new(&inputs, maps, from, self.filter())
            }
            None => Resampler::of_map(map, from, self.filter()),
        });
        let sizes = Sizes { from, ..self.sizes };
        let blend = self.blend.clone().map(|blending| {
            let map = self.resampler.map();
            let hidden = HiddenAreas::new(&blending.blend, map, self.content, from);
            GraftBlend { hidden, ..blending }
        });
        Ok(Self { sizes, resampler, blend, fit: OnceLock::new(), ..self.clone() })
    }

    /// The rows of a texture that [`Graft::overlay`] depends on; the content of other rows does not
    /// matter. All rows with a blend, for whose labels and tones any of them may count.
    /// [`Graft::fit`] always depends on all rows, whatever this returns.
    pub fn texture_rows(&self) -> Range<u32> {
        match self.blend {
            Some(_) => 0..self.sizes.from.height,
            None => self.resampler.source_rows(),
        }
    }

    /// The map, which holds the source position of each texel.
    pub fn map(&self) -> &Arc<SamplingMap> {
        self.resampler.map()
    }

    /// The pair; `None` for a graft through a map of another origin.
    pub fn pair(&self) -> Option<&Arc<Pair>> {
        self.pair.as_ref()
    }

    /// The direction of the transfer.
    pub fn direction(&self) -> Direction {
        self.direction
    }

    /// The sizes of textures and bases.
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }

    /// The interpolation filter.
    pub fn filter(&self) -> Filter {
        self.resampler.filter()
    }

    /// What the values of textures mean.
    pub fn content(&self) -> Content {
        self.content
    }

    /// The blend, if there is one.
    pub fn blend(&self) -> Option<&Arc<Blend>> {
        self.blend.as_ref().map(|blending| &blending.blend)
    }

    /// What the map was made from; `None` for a map of another origin.
    fn map_inputs(&self) -> Option<MapInputs<'_>> {
        Some(MapInputs {
            pair: self.pair.as_ref()?,
            direction: self.direction,
            target_size: self.sizes.to,
            map: self.map_options,
        })
    }

    fn formats(&self, texture: TexelFormat, base: TexelFormat) -> Formats {
        match self.content {
            Content::Color => Formats::new(texture, base, self.averaging),
            Content::Data => {
                let base = TexelFormat { encoding: Encoding::Data, ..base };
                Formats::new(texture, base, self.averaging)
            }
            Content::Normals(_) => Formats::new(texture, base, Averaging::Encoded).of_normals(),
        }
    }

    /// Overrides the encoding of a texture or a base according to the content.
    fn reinterpret(&self, texture: Texture) -> Texture {
        match self.content {
            Content::Color => texture,
            Content::Data | Content::Normals(_) => texture.with_encoding(Encoding::Data),
        }
    }

    fn check(&self, texture: &Texture) -> Result<(), GraftError> {
        check_size("texture", texture, self.sizes.from)?;
        if self.frames.is_some() && !texture.channels().has_color() {
            return Err(GraftError::Channels { found: texture.channels() });
        }
        Ok(())
    }

    /// A texture as it is resampled: in the content's encoding, and with the rims of eyes.
    fn prepared(&self, texture: Texture) -> Texture {
        let mut texture = self.reinterpret(texture);
        if let Some(rims) = self.blend.as_ref().and_then(|blend| blend.hidden.eye_rims.as_ref()) {
            rims.fill(&mut texture);
        }
        texture
    }

    fn make_overlay(&self, formats: Formats, layer: Layer) -> Overlay {
        let mut overlay = Overlay::new(Arc::clone(&self.resampler), formats, layer);
        if let Some((frames, options)) = &self.frames {
            overlay = overlay.of_normals(Arc::clone(frames), *options);
        }
        match &self.blend {
            Some(GraftBlend { blend_map, .. }) => overlay.blended(Arc::clone(blend_map)),
            None => overlay,
        }
    }
}

/// Checks the size of a texture.
fn check_size(what: &'static str, texture: &Texture, wanted: Size) -> Result<(), GraftError> {
    let found = texture.size();
    if found == wanted { Ok(()) } else { Err(GraftError::Size { what, found, wanted }) }
}

impl From<Texture> for Cow<'_, Texture> {
    fn from(texture: Texture) -> Self {
        Self::Owned(texture)
    }
}

impl<'t> From<&'t Texture> for Cow<'t, Texture> {
    fn from(texture: &'t Texture) -> Self {
        Self::Borrowed(texture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_shareable() {
        fn is_shareable<T: Send + Sync + 'static>() {}
        is_shareable::<Graft>();
        is_shareable::<Overlay>();
        is_shareable::<Operator>();
        is_shareable::<Blend>();
        is_shareable::<crate::BlendDomain>();
        is_shareable::<crate::Selection>();
        is_shareable::<NormalFrames>();
    }
}
