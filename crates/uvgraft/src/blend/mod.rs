//! Blends a transferred texture into a base texture, on the mesh rather than in the image.
//!
//! The boundary of the transferred region crosses UV islands at will, so distances and colour
//! corrections are stored at the points of the mesh and interpolated over its triangles:
//!
//! - a [`Selection`] is the part of the surface that is transferred;
//! - the **feather** fades the texture into the base near the selection's boundary, by
//!   distance along the surface;
//! - the **membrane** extends the ratio of the two sides' colours harmonically from the boundary
//!   over the surface, so that one side takes on the other's tone there (after P. Pérez et al.,
//!   "Poisson image editing", 2003, on a mesh and with ratios instead of differences).

mod along_rim;
mod base_layer;
mod between_skins;
mod collapsed;
mod compose;
mod controls;
mod cut;
mod extent;
mod eye_rims;
mod field;
mod geodesic;
mod harmonic;
mod layouts;
mod painted;
mod report;
mod rim;
mod selection;
mod skin_mask;
mod skins;
mod stretch;
mod tone;
mod toning;

use std::sync::Arc;

use crate::color::Encoding;
use crate::labels::{Label, LabelError, Labels};
use crate::map::{MapOptions, SamplingMap};
use crate::skin::SkinModel;
use crate::texture::{Channels, Texels, Texture, TextureError};
use base_layer::{BaseLayer, SkinCriterion};
pub(crate) use collapsed::{Collapsed, Smooth};
use compose::Composition;
pub(crate) use controls::Controls;
pub use cut::CutMesh;
pub(crate) use eye_rims::EyeRims;
use field::{LinearValue, linear_values};
use harmonic::Harmonic;
pub use report::ToneReport;
use rim::Rim;
pub use selection::{BlendDomain, Growth, RegionError, Selection};
use uvgraft_surface::easing::smoothstep;
use uvgraft_surface::pair::Direction;

use skin_mask::SkinMask;
use tone::Matrix;
use toning::{BaseSkin, Recolor};
pub use toning::{ToneCorrection, ToneError};
pub use uvgraft_surface::pair::Side;

/// Distance from the boundary at which a tone correction measured there has faded out, in multiples
/// of the distance between the eyes: 5 cm. Origin not recorded.
const TONE_FADE: f64 = 0.8;

/// Width of the margin around cloth that is left out too, in multiples of the distance between the
/// eyes: 4 mm. Collars shade the skin next to them and bleed their colour into it.
const CLOTH_MARGIN: f64 = 0.065;

/// Distance inside the requested region's own boundary from which on a boundary point is treated
/// fully as next to cloth, in multiples of the distance between the eyes: 15 mm.
const CLOTH_FADE: f32 = 0.25;

/// How much wider a feather may be than a region is deep: as much as rounding to three digits, in which
/// people are told the depth, could add.
const FEATHER_SLACK: f64 = 1.005;

/// Options for blending a texture into the base.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BlendOptions {
    /// Length of the feather, inwards from the boundary along the surface, in the target mesh's
    /// unit. Negative and NaN mean 0.
    pub feather: f64,
    /// Whether a membrane matches the tone of both sides along the boundary.
    pub membrane: bool,
    /// Whether one side's skin is matched to the mean and covariance of the other's.
    pub match_skin: bool,
    /// Which side sets the tone.
    pub tone: Tone,
    /// Whether cloth and background at the neck stay in the region.
    pub keep_all: bool,
    /// Width of the gutter around UV islands in which the base's skin changes too, in texels: as
    /// wide as the base's own gutter.
    pub gutter_px: u32,
}

impl BlendOptions {
    /// Sets the length of the feather.
    #[must_use]
    pub const fn feather(self, feather: f64) -> Self {
        Self { feather, ..self }
    }

    /// Turns the membrane on.
    #[must_use]
    pub const fn membrane(self) -> Self {
        Self { membrane: true, ..self }
    }

    /// Turns on matching one side's skin to the other's.
    #[must_use]
    pub const fn match_skin(self) -> Self {
        Self { match_skin: true, ..self }
    }

    /// Sets the side that the tone is taken from.
    #[must_use]
    pub const fn tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    /// Keeps the whole region, including cloth and background at the neck.
    #[must_use]
    pub const fn keep_all(self) -> Self {
        Self { keep_all: true, ..self }
    }

    /// Sets the width of the base's own gutter, in texels.
    #[must_use]
    pub const fn gutter_px(self, gutter_px: u32) -> Self {
        Self { gutter_px, ..self }
    }

    /// Whether colours of the base must be sampled before anything is laid over it.
    pub const fn needs_colors(&self) -> bool {
        self.membrane || self.match_skin
    }

    /// Whether labels are needed: regions with a soft boundary leave out cloth, and
    /// only skin takes on a tone.
    pub fn needs_labels(&self) -> bool {
        self.needs_colors() || self.feather > 0.0
    }
}

impl Default for BlendOptions {
    /// A hard boundary and unchanged colours.
    fn default() -> Self {
        let gutter_px = MapOptions::default().gutter_px;
        Self {
            feather: 0.0,
            membrane: false,
            match_skin: false,
            tone: Tone::Base,
            keep_all: false,
            gutter_px,
        }
    }
}

/// Which side the tone is taken from; the other side is adapted to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tone {
    /// The texture takes on the base's tone.
    Base,
    /// The base's skin takes on the texture's tone. The texture itself changes only near the
    /// boundary, next to cloth that was left out.
    Source,
    /// Both sides move halfway.
    Both,
}

impl Tone {
    /// How far the texture moves towards the base's tone, 0 to 1; the base moves the rest of the
    /// way.
    const fn share(self) -> f64 {
        match self {
            Self::Base => 1.0,
            Self::Source => 0.0,
            Self::Both => 0.5,
        }
    }
}

/// The blend of one region: distances from its boundary and the factorised membrane. Made once,
/// then used for any number of textures of any size.
#[derive(Debug, Clone)]
pub struct Blend {
    domain: BlendDomain,
    /// The requested region, limited to what is linked.
    selection: Selection,
    options: BlendOptions,
    /// For each triangle of the target, whether it is in the region, wholly or in part.
    touched: Vec<bool>,
    /// Signed distance of each point of the surface from the boundary, in the target mesh's unit,
    /// positive inside, clamped to the range that the feather and the tone need.
    inside: Vec<f32>,
    /// Distance from the boundary at which a tone correction has faded out, in the target mesh's
    /// unit; `None` without a head, where it never fades.
    fade: Option<f64>,
    feather_fit: FeatherFit,
    measure: Option<Measure>,
    /// For each point, the weight with which a boundary there is treated as next to cloth, 0 to
    /// 1; empty if nothing was left out. There the texture is corrected at the boundary
    /// whatever the [`Tone`], because a collar's shade and the light it reflects onto skin are
    /// not part of a person's tone.
    cloth_weight: Vec<f32>,
    /// Skin mask of the base; `None` to estimate it.
    skin: Option<Texture>,
    /// Labels of what textures show; `None` to detect them.
    labels: Option<Arc<Labels>>,
}

/// Whether a feather suits the size of its region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FeatherFit {
    /// The texture is opaque somewhere, or there is no feather.
    Opaque,
    /// It is opaque nowhere: all points are closer to the boundary than the feather is wide.
    TooWide {
        /// The distance of the innermost point from the boundary, in the target mesh's unit.
        depth: f64,
    },
    /// The feather does nothing, because the region has no boundary.
    NoBoundary,
}

/// Colour samples along the boundary and the membrane, from which tones are computed.
#[derive(Debug, Clone)]
struct Measure {
    rim: Rim,
    harmonic: Option<Harmonic>,
}

/// A blend sampled at the texels of one map.
#[derive(Debug)]
pub(crate) struct BlendMap {
    blend: Arc<Blend>,
    /// For each patch of the map, the signed distance from the boundary, as [`Blend::inside`].
    inside: Vec<[LinearValue; 1]>,
    /// The target's whole layout, if the base changes too.
    layout: Option<Arc<SamplingMap>>,
    /// Skin weight of each texel, if a mask was given.
    skin: Option<Arc<SkinMask>>,
}

/// A toning sampled at the texels of one map. Clones share it.
#[derive(Debug, Clone, Default)]
pub(crate) struct ToningMap(Option<Arc<SampledTone>>);

#[derive(Debug)]
struct SampledTone {
    /// Recolouring of the texture.
    source: Option<RecolorMap>,
    /// Recolouring of the base, and where the base is skin.
    base: Option<(RecolorMap, SkinTexels)>,
    /// The blend of the remaining region, if cloth was left out.
    narrowed: Option<BlendMap>,
    controls: Option<Controls>,
}

/// Where the base is skin, at the texels of a map.
#[derive(Debug)]
enum SkinTexels {
    Model(SkinModel),
    Mask(Arc<SkinMask>),
}

/// A [`Recolor`] at the texels of one map.
#[derive(Debug)]
struct RecolorMap {
    matrix: Option<Matrix>,
    /// For each patch, the gains of red, green and blue; empty if there are none.
    gains: Vec<[LinearValue; 3]>,
}

impl Blend {
    /// Prepares the blend of the linked part of a selection.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if nothing of it is linked.
    pub fn new(selection: &Selection, options: BlendOptions) -> Result<Self, RegionError> {
        let domain = selection.domain().clone();
        let linked = domain.linked();
        let selection = selection.intersection(&linked)?;
        // Larger than any mesh, and small enough for `f32`.
        let feather = if options.feather > 0.0 { options.feather.min(1e30) } else { 0.0 };
        let options = BlendOptions { feather, ..options };
        let touched = domain.touched(&selection);
        if !touched.contains(&true) {
            let cuts_only =
                !domain.touched(&linked).contains(&true) && domain.pair().piece_count() > 0;
            return Err(RegionError::Empty(if cuts_only {
                "it contains no wholly linked triangle, only parts of triangles"
            } else {
                "it contains no linked triangle"
            }));
        }
        let fade = if options.needs_colors() {
            domain.eye_distance().map(|eyes| TONE_FADE * eyes)
        } else {
            None
        };
        // Distances beyond the limit are clamped. The longest edge is added so that triangles that
        // reach into the feather or the fade have true distances at all three corners.
        let limit = options.feather.max(fade.unwrap_or(0.0)) + domain.longest_edge();
        let inside = domain.signed_distances(&selection, limit);
        // A point within one edge beyond the feather has a true distance if there is any such point.
        let feather_fit = match extent::innermost(&touched, &domain, &inside) {
            _ if options.feather <= 0.0 => FeatherFit::Opaque,
            Some(depth) if depth * FEATHER_SLACK < options.feather => FeatherFit::TooWide { depth },
            Some(_) => FeatherFit::Opaque,
            None => FeatherFit::NoBoundary,
        };
        let measure = options.needs_colors().then(|| {
            let rim = Rim::new(&domain, &touched, &inside, options.feather);
            let harmonic = options.membrane.then(|| {
                let is_near = |corners: &[u32; 3]| match fade {
                    Some(fade) => corners.iter().any(|&point| inside[point as usize].abs() < fade),
                    None => true,
                };
                // The base's skin changes outside the boundary too.
                let beyond = options.tone != Tone::Base;
                let triangles = domain.surface().triangles().iter().zip(&touched);
                let faces: Vec<bool> = triangles
                    .map(|(corners, &touched)| (touched || beyond) && is_near(corners))
                    .collect();
                Harmonic::new(domain.surface(), &faces, &rim.points)
            });
            Measure { rim, harmonic }
        });
        let inside = inside.into_iter().map(|inside| inside.clamp(-limit, limit) as f32).collect();
        Ok(Self {
            domain,
            selection,
            options,
            touched,
            inside,
            fade,
            feather_fit,
            measure,
            cloth_weight: Vec::new(),
            skin: None,
            labels: None,
        })
    }

    /// Precomputes everything that textures will need. Otherwise each of several textures that are
    /// transferred in parallel would compute it for itself.
    #[must_use]
    pub fn prepared(self) -> Self {
        if self.measure.is_some() && self.options.tone != Tone::Base && self.skin.is_none() {
            self.domain.body();
        }
        self
    }

    /// Sets the labels of what textures show, instead of detecting them in each texture.
    #[must_use]
    pub fn with_labels(self, labels: impl Into<Arc<Labels>>) -> Self {
        Self { labels: Some(labels.into()), ..self }
    }

    /// Whether labels were set.
    pub fn has_labels(&self) -> bool {
        self.labels.is_some()
    }

    /// Labels of what a texture shows; `None` if they are not needed, or if it does not show a
    /// head.
    pub fn labels(&self, source: &Texture) -> Option<Arc<Labels>> {
        self.try_labels(source)?.ok()
    }

    /// As [`Blend::labels`], with the reason if there are none.
    fn try_labels(&self, source: &Texture) -> Option<Result<Arc<Labels>, LabelError>> {
        if !self.options.needs_labels() {
            return None;
        }
        let labels = match &self.labels {
            Some(labels) => Ok(Arc::clone(labels)),
            None => self.domain.labels(source).map(Arc::new),
        };
        Some(labels.map(|labels| {
            let keeps_all = self.options.keep_all && labels.has_cloth();
            if keeps_all { Arc::new((*labels).clone().keeping_all()) } else { labels }
        }))
    }

    /// The blend without cloth and background and a margin around them; `None` if there are none.
    fn narrowed(&self, labels: &Labels) -> Option<Self> {
        if !labels.has_cloth() {
            return None;
        }
        let head = self.domain.head();
        let margin = head.map_or(1.0, |head| CLOTH_MARGIN * head.texels_per_unit(labels.size()));
        let side = match self.domain.direction() {
            Direction::Forward => Side::Source,
            Direction::Reverse => Side::Target,
        };
        let kept = self.domain.painted(side, &labels.kept(margin)).ok()?;
        let selection = self.selection.intersection(&kept).ok()?;
        let Self { skin, labels, .. } = self.clone();
        let reach = CLOTH_FADE * self.domain.eye_distance().unwrap_or(1.0) as f32;
        let cloth_weight =
            self.inside.iter().map(|&inside| smoothstep(0.0, reach, inside)).collect();
        // If nothing is left the whole region stays: the labels are not those of a head then.
        Some(Self { cloth_weight, skin, labels, ..Self::new(&selection, self.options).ok()? })
    }

    /// The fraction of the region's surface area that is cloth or background.
    fn left_out(&self, labels: &Labels) -> f64 {
        let domain = &self.domain;
        let mesh = domain.pair().from(domain.direction());
        let (mut cloth, mut all) = (0.0, 0.0);
        for piece in domain.pieces().all() {
            if self.touched[piece.to as usize] {
                let area = domain.surface().area(piece.to) * domain.pieces().share(*piece);
                let uv = domain.centroid(*piece, mesh);
                cloth += area * f64::from(labels.at_uv(Label::Cloth, uv));
                all += area;
            }
        }
        if all > 0.0 { cloth / all } else { 0.0 }
    }

    /// Sets the skin mask of the base: white is skin, black is not. It is resized to the base's
    /// size.
    #[must_use]
    pub fn with_skin(self, mask: Texture) -> Self {
        Self { skin: Some(mask), ..self }
    }

    /// The domain that it was made on.
    pub fn domain(&self) -> &BlendDomain {
        &self.domain
    }

    /// The options that it was made with.
    pub fn options(&self) -> &BlendOptions {
        &self.options
    }

    /// Whether the feather suits the region's size.
    pub fn feather_fit(&self) -> FeatherFit {
        self.feather_fit
    }

    /// For each triangle of the target, whether it is transferred, wholly or in part.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }
}

impl BlendMap {
    /// Samples a blend at the texels of a map of the same pair and direction.
    ///
    /// # Errors
    /// [`TextureError`] if there is not enough memory for a skin mask at the map's size.
    pub fn new(blend: Arc<Blend>, map: &SamplingMap) -> Result<Self, TextureError> {
        assert_eq!(map.direction(), blend.domain.direction());
        let changes_base = blend.measure.is_some() && blend.options.tone != Tone::Base;
        let layout = changes_base.then(|| {
            let options = MapOptions::with_gutter(blend.options.gutter_px);
            Arc::new(SamplingMap::of_layout(blend.domain.mesh(), map.size(), &options))
        });
        let skin = blend.skin.as_ref().map(|mask| SkinMask::new(mask, map.size())).transpose()?;
        let inside = blend.inside_of(map);
        Ok(Self { blend, inside, layout, skin: skin.map(Arc::new) })
    }

    /// How the texels of its map are composited over a base.
    ///
    /// - `normals`: whether values are encoded normals.
    /// - `encoding`: encoding of the values.
    ///
    /// # Panics
    /// If the blend was sampled for another map.
    pub fn composition<'b>(
        &'b self,
        map: &'b SamplingMap,
        toning: &'b ToningMap,
        normals: bool,
        encoding: Encoding,
    ) -> Composition<'b> {
        let at = toning.0.as_ref().and_then(|toning| toning.narrowed.as_ref()).unwrap_or(self);
        assert_eq!(map.patches().len(), at.inside.len(), "the blend is one of another map");
        let recoloring = toning.0.as_ref().and_then(|toning| toning.source.as_ref());
        Composition {
            map,
            inside: &at.inside,
            feather: self.blend.options.feather as f32,
            gains: recoloring.map_or(&[], |recoloring| &recoloring.gains),
            matrix: recoloring.and_then(|recoloring| recoloring.matrix),
            normals,
            is_linear: encoding == Encoding::Linear,
            leaves_out: toning.controls().is_some_and(Controls::leaves_out),
        }
    }

    /// How the base is recoloured before the texture is laid over it; `None` if it stays unchanged.
    pub fn base_change<'b>(&'b self, toning: &'b ToningMap) -> Option<BaseLayer<'b>> {
        let (RecolorMap { matrix, gains }, skin) = toning.0.as_ref()?.base.as_ref()?;
        let skin = match (&self.skin, skin) {
            (Some(mask), _) | (None, SkinTexels::Mask(mask)) => SkinCriterion::Mask(mask),
            (None, SkinTexels::Model(model)) => SkinCriterion::Model(*model),
        };
        Some(BaseLayer { map: self.layout.as_deref()?, gains, matrix: *matrix, skin })
    }

    /// Samples a toning at the texels of its map.
    ///
    /// - `colors`: whether colours change; if not, only the narrowed region is applied.
    ///
    /// # Errors
    /// [`ToneError::Domain`] if the toning belongs to another domain, [`ToneError::Texture`] if
    /// there is not enough memory for a mask.
    pub fn toning_map(
        &self,
        map: &Arc<SamplingMap>,
        toning: &ToneCorrection,
        colors: bool,
    ) -> Result<ToningMap, ToneError> {
        if !self.blend.domain.is_compatible(&toning.domain) {
            return Err(ToneError::Domain);
        }
        let recoloring = |map: &SamplingMap, recolor| self.recoloring(map, recolor);
        let source =
            toning.source.as_ref().filter(|_| colors).map(|recolor| recoloring(map, recolor));
        let base = match (toning.base.as_ref().filter(|_| colors), &self.layout) {
            (Some((recolor, skin)), Some(layout)) => {
                let skin = match (skin, &self.skin) {
                    (_, Some(mask)) => Some(SkinTexels::Mask(Arc::clone(mask))),
                    (BaseSkin::Mask(mask), None) => {
                        Some(SkinTexels::Mask(Arc::new(SkinMask::new(mask, map.size())?)))
                    }
                    (BaseSkin::Model(model), None) => model.map(SkinTexels::Model),
                };
                skin.map(|skin| (recoloring(layout, recolor), skin))
            }
            _ => None,
        };
        let narrowed = toning.narrowed.as_ref().map(|blend| Self {
            inside: blend.inside_of(map),
            blend: Arc::clone(blend),
            layout: None,
            skin: None,
        });
        let controls = match &toning.labels {
            Some(labels) if source.is_some() || narrowed.is_some() => {
                Some(Controls::new(&self.blend.domain, map, labels, narrowed.is_some()))
            }
            _ => None,
        };
        Ok(ToningMap(Some(Arc::new(SampledTone { source, base, narrowed, controls }))))
    }

    fn recoloring(&self, map: &SamplingMap, recolor: &Recolor) -> RecolorMap {
        let Recolor { matrix, gains } = recolor;
        let domain = &self.blend.domain;
        let gains = if gains.is_empty() {
            Vec::new()
        } else {
            linear_values(map, domain.mesh(), domain.surface(), |_, point| gains[point as usize])
        };
        RecolorMap { matrix: *matrix, gains }
    }

    /// The weight of the texture at each texel as an 8-bit grey texture: white where only the
    /// texture shows, black where only the base does. The gutter is black.
    ///
    /// - `toning`: holds the narrowed region of a texture.
    pub fn weights(&self, map: &SamplingMap, toning: &ToningMap) -> Texture {
        let size = map.size();
        let white = vec![255_u8; size.texels()];
        let mut values = vec![0; size.texels()];
        let composition = Composition {
            gains: &[],
            matrix: None,
            ..self.composition(map, toning, false, Encoding::Data)
        };
        let mut controls = Vec::new();
        if let Some(of) = toning.controls() {
            of.rows(0, size.height, &mut controls);
        }
        composition.lay(Channels::Grey, false, 0, &white, &mut values, &controls);
        if let Texels::U8(mask) = map.mask().texels() {
            values.iter_mut().zip(mask).for_each(|(value, &mask)| *value &= mask);
        }
        Texture::new(size, Channels::Grey, Encoding::Data, Texels::U8(values))
            .expect("a map's size is that of a texture")
    }
}

impl Blend {
    /// The signed distance from the boundary over the patches of a map.
    fn inside_of(&self, map: &SamplingMap) -> Vec<[LinearValue; 1]> {
        let value = |face: u32, point: u32| {
            // Triangles outside the region lie beyond its boundary, even if all their corners are
            // on it.
            [if self.touched[face as usize] {
                self.inside[point as usize]
            } else {
                f32::NEG_INFINITY
            }]
        };
        linear_values(map, self.domain.mesh(), self.domain.surface(), value)
    }
}

impl ToningMap {
    /// Per-texel controls from labels, if there are any.
    pub fn controls(&self) -> Option<&Controls> {
        self.0.as_ref()?.controls.as_ref()
    }
}
