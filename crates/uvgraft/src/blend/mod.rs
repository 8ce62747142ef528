//! How a texture that is laid over another becomes one with it, on the mesh rather than in the image.
//!
//! The border of what is transferred runs over the surface and crosses UV islands as it likes, so
//! distances and corrections of colour live at the points of the mesh and are interpolated over its
//! triangles:
//!
//! - a [`Selection`] says which part of the surface is transferred;
//! - the **feather** lets the base show through near the selection's rim, by the distance along the
//!   surface;
//! - the **membrane** extends the ratio of the two sides' colours along the rim harmonically over the
//!   surface, so that one side takes on the other's tone there (after P. Pérez et al., "Poisson image
//!   editing", 2003, on a mesh and with ratios for differences).

mod along_rim;
mod base_layer;
mod between_skins;
mod collapsed;
mod compose;
mod controls;
mod cut;
mod eye_rims;
mod field;
mod geodesic;
mod harmonic;
mod painted;
mod relaid;
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
use crate::easing::smoothstep;
use crate::labels::{Label, LabelError, Labels};
use crate::map::{MapOptions, SamplingMap};
use crate::pair::Direction;
use crate::skin::SkinModel;
use crate::texture::{Channels, Texels, Texture, TextureError};
use base_layer::{BaseLayer, SkinCriterion};
pub(crate) use collapsed::{Collapsed, Smooth};
use compose::Composition;
pub(crate) use controls::Controls;
pub use cut::CutMesh;
pub(crate) use eye_rims::EyeRims;
use field::{Slope, slopes};
use harmonic::Harmonic;
pub use report::ToneReport;
use rim::Rim;
pub use selection::{BlendDomain, Growth, RegionError, Selection, Side};
use skin_mask::SkinMask;
use tone::Matrix;
use toning::{BaseSkin, Recolor};
pub use toning::{Toning, ToningError};

/// How far from the rim a tone that was found there has faded out, in distances between the eyes: 5 cm.
const FADE: f64 = 0.8;

/// So wide beside cloth a texture is left out too, in distances between the eyes: 4 mm, where collars shade skin and
/// their colour bleeds into it.
const MARGIN: f64 = 0.065;

/// So far within the asked region's own rim a texture gives way beside cloth, in distances between the eyes: 15 mm.
const BESIDE_CLOTH: f32 = 0.25;

/// How a texture becomes one with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BlendOptions {
    /// Over which length along the surface the base gives way to the texture, inwards from the rim, in
    /// the target mesh's unit. What is negative or NaN is 0.
    pub feather: f64,
    /// Whether a membrane takes the tone of one side along the rim to the other.
    pub membrane: bool,
    /// Whether one side's skin gets the mean and the covariance of the other's.
    pub match_skin: bool,
    /// Which side the tone is taken from.
    pub tone: Tone,
    /// Whether cloth and background at a neck stay in the region.
    pub keep_all: bool,
    /// Texels beyond the islands in which a base's skin changes too: as many as its own gutter has.
    pub gutter_px: u32,
}

impl BlendOptions {
    /// The same with a feather of this length.
    #[must_use]
    pub const fn feather(self, feather: f64) -> Self {
        Self { feather, ..self }
    }

    /// The same with a membrane.
    #[must_use]
    pub const fn membrane(self) -> Self {
        Self { membrane: true, ..self }
    }

    /// The same, with one side's skin matched to the other's.
    #[must_use]
    pub const fn match_skin(self) -> Self {
        Self { match_skin: true, ..self }
    }

    /// The same with the tone taken from this side.
    #[must_use]
    pub const fn tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    /// The same with all of the region kept, cloth and background at a neck too.
    #[must_use]
    pub const fn keep_all(self) -> Self {
        Self { keep_all: true, ..self }
    }

    /// The same for a base whose own gutter is so wide.
    #[must_use]
    pub const fn gutter_px(self, gutter_px: u32) -> Self {
        Self { gutter_px, ..self }
    }

    /// Whether colours of the base are looked at before anything is laid over it.
    pub const fn needs_colors(&self) -> bool {
        self.membrane || self.match_skin
    }

    /// Whether it matters what textures show: cloth leaves regions that have no hard border, and only skin takes tone.
    pub fn asks_for_labels(&self) -> bool {
        self.needs_colors() || self.feather > 0.0
    }
}

impl Default for BlendOptions {
    /// A hard border, and no colour changed.
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

/// Which side the tone is taken from; the other one gives way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tone {
    /// The texture takes on the tone that the base has.
    Base,
    /// The base's skin takes on the tone that the texture has. Only beside cloth that was left out the texture gives way near the
    /// rim.
    Source,
    /// Both give way half.
    Both,
}

impl Tone {
    /// How far the texture gives way, from 0 to 1; the base does for the rest.
    const fn share(self) -> f64 {
        match self {
            Self::Base => 1.0,
            Self::Source => 0.0,
            Self::Both => 0.5,
        }
    }
}

/// A blend of one region: distances, and the factorised membrane. Made once, used for any number of
/// textures of any size.
#[derive(Debug, Clone)]
pub struct Blend {
    domain: BlendDomain,
    /// What was asked for, within what is linked.
    selection: Selection,
    options: BlendOptions,
    touched: Vec<bool>,
    /// Signed distance of each point from the rim, within what the feather and the tone need.
    inside: Vec<f32>,
    /// How far from the rim a tone that was found there has faded out; without a head it goes on everywhere.
    fade: Option<f64>,
    measure: Option<Measure>,
    /// How far the rim at each point is beside cloth, from 0 to 1; empty where nothing was left out. There the texture
    /// gives way at the rim whatever the tone, for a collar's shade and light on skin are no tone of a person's.
    beside_cloth: Vec<f32>,
    /// What is skin in the base, if it is not to be estimated.
    skin: Option<Texture>,
    /// What textures show, if it is not to be found out.
    labels: Option<Arc<Labels>>,
}

/// What a tone is found with.
#[derive(Debug, Clone)]
struct Measure {
    rim: Rim,
    harmonic: Option<Harmonic>,
}

/// A blend at the texels of one map.
#[derive(Debug)]
pub(crate) struct BlendMap {
    blend: Arc<Blend>,
    /// For each patch of the map, the signed distance from the rim.
    inside: Vec<[Slope; 1]>,
    /// All of the target's layout, if the base changes too.
    layout: Option<Arc<SamplingMap>>,
    /// How far each texel is skin, where a mask says it.
    skin: Option<Arc<SkinMask>>,
}

/// A toning at the texels of one map. Clones share it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gains(Option<Arc<ToneGains>>);

#[derive(Debug)]
struct ToneGains {
    /// Of the texture.
    source: Option<Recoloring>,
    /// Of the base, and what is skin in it.
    base: Option<(Recoloring, SkinTexels)>,
    /// The blend of what is left of the region.
    narrowed: Option<BlendMap>,
    controls: Option<Controls>,
}

/// What is skin at the texels of a map.
#[derive(Debug)]
enum SkinTexels {
    Model(SkinModel),
    Mask(Arc<SkinMask>),
}

/// Another tone for the texels of a map.
#[derive(Debug)]
struct Recoloring {
    matrix: Option<Matrix>,
    /// For each patch, the gains of red, green and blue; empty for none.
    gains: Vec<[Slope; 3]>,
}

impl Blend {
    /// Prepares the blend of what is selected and linked.
    ///
    /// # Errors
    /// [`RegionError::Empty`] if that is nothing.
    pub fn new(selection: &Selection, options: BlendOptions) -> Result<Self, RegionError> {
        let domain = selection.domain().clone();
        let linked = domain.linked();
        let selection = selection.within(&linked)?;
        // Far beyond any mesh, and so that 32 bits hold it.
        let feather = if options.feather > 0.0 { options.feather.min(1e30) } else { 0.0 };
        let options = BlendOptions { feather, ..options };
        let touched = domain.touched(&selection);
        if !touched.contains(&true) {
            let cuts_only =
                !domain.touched(&linked).contains(&true) && domain.pair().piece_count() > 0;
            return Err(RegionError::Empty(if cuts_only {
                "no whole triangle is linked in it, only parts of triangles"
            } else {
                "no linked triangle is left in it"
            }));
        }
        let fade = if options.needs_colors() {
            domain.eye_distance().map(|eyes| FADE * eyes)
        } else {
            None
        };
        // Farther points are as good as endless; a triangle's corners must be told apart up to there.
        let limit = options.feather.max(fade.unwrap_or(0.0)) + domain.longest_edge();
        let inside = domain.signed_distances(&selection, limit);
        let measure = options.needs_colors().then(|| {
            let rim = Rim::new(&domain, &touched, &inside, options.feather);
            let harmonic = options.membrane.then(|| {
                let is_near = |corners: &[u32; 3]| match fade {
                    Some(fade) => corners.iter().any(|&point| inside[point as usize].abs() < fade),
                    None => true,
                };
                // Of the base skin changes beyond the rim too.
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
            measure,
            beside_cloth: Vec::new(),
            skin: None,
            labels: None,
        })
    }

    /// The same with all that textures will ask for: where several are carried at once, each would find it for itself.
    #[must_use]
    pub fn prepared(self) -> Self {
        if self.measure.is_some() && self.options.tone != Tone::Base && self.skin.is_none() {
            self.domain.body();
        }
        self
    }

    /// The same with labels that say what textures show, rather than what is found out of each.
    #[must_use]
    pub fn with_labels(self, labels: impl Into<Arc<Labels>>) -> Self {
        Self { labels: Some(labels.into()), ..self }
    }

    /// Whether it was said what textures show.
    pub fn has_labels(&self) -> bool {
        self.labels.is_some()
    }

    /// What a texture shows; nothing if that does not matter, or if it is not one of a head.
    pub fn labels(&self, source: &Texture) -> Option<Arc<Labels>> {
        self.found_labels(source)?.ok()
    }

    /// As [`Blend::labels`], with the reason why there are none.
    fn found_labels(&self, source: &Texture) -> Option<Result<Arc<Labels>, LabelError>> {
        if !self.options.asks_for_labels() {
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

    /// The same without cloth and background, and a margin around them; nothing if there are none.
    fn narrowed(&self, labels: &Labels) -> Option<Self> {
        if !labels.has_cloth() {
            return None;
        }
        let head = self.domain.head();
        let margin = head.map_or(1.0, |head| MARGIN * head.texels_per_unit(labels.size()));
        let side = match self.domain.direction() {
            Direction::Forward => Side::Source,
            Direction::Reverse => Side::Target,
        };
        let kept = self.domain.painted(side, &labels.kept(margin)).ok()?;
        let selection = self.selection.within(&kept).ok()?;
        let Self { skin, labels, .. } = self.clone();
        let reach = BESIDE_CLOTH * self.domain.eye_distance().unwrap_or(1.0) as f32;
        let beside_cloth =
            self.inside.iter().map(|&inside| smoothstep(0.0, reach, inside)).collect();
        // If nothing is left the whole region stays: then it is no head that is labelled.
        Some(Self { beside_cloth, skin, labels, ..Self::new(&selection, self.options).ok()? })
    }

    /// The share of the region's surface that is cloth or background.
    fn left_out(&self, labels: &Labels) -> f64 {
        let domain = &self.domain;
        let mesh = domain.pair().from(domain.direction());
        let (mut cloth, mut all) = (0.0, 0.0);
        for piece in domain.pieces().all() {
            if self.touched[piece.to as usize] {
                let area = domain.surface().area(piece.to) * domain.pieces().share(*piece);
                let uv = domain.middle(*piece, mesh);
                cloth += area * f64::from(labels.at_uv(Label::Cloth, uv));
                all += area;
            }
        }
        if all > 0.0 { cloth / all } else { 0.0 }
    }

    /// The same with a mask of what is skin in the base: white for all, black for none. It is brought to
    /// the base's size.
    #[must_use]
    pub fn with_skin(self, mask: Texture) -> Self {
        Self { skin: Some(mask), ..self }
    }

    /// What it is made on.
    pub fn domain(&self) -> &BlendDomain {
        &self.domain
    }

    /// How it was asked for.
    pub fn options(&self) -> &BlendOptions {
        &self.options
    }

    /// Which triangles of the target are transferred, wholly or in part.
    pub fn touched(&self) -> &[bool] {
        &self.touched
    }
}

impl BlendMap {
    /// A blend at the texels of a map of the same pair and direction.
    ///
    /// # Errors
    /// [`TextureError`] if there is no memory for a mask of skin at the map's size.
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

    /// How the texels of its map are laid over a base.
    ///
    /// - `normals`: whether values are encoded normals.
    /// - `encoding`: of the values.
    ///
    /// # Panics
    /// If it is the blend of another map.
    pub fn composition<'b>(
        &'b self,
        map: &'b SamplingMap,
        gains: &'b Gains,
        normals: bool,
        encoding: Encoding,
    ) -> Composition<'b> {
        let at = gains.0.as_ref().and_then(|gains| gains.narrowed.as_ref()).unwrap_or(self);
        assert_eq!(map.patches().len(), at.inside.len(), "the blend is one of another map");
        let recoloring = gains.0.as_ref().and_then(|gains| gains.source.as_ref());
        Composition {
            map,
            inside: &at.inside,
            feather: self.blend.options.feather as f32,
            gains: recoloring.map_or(&[], |recoloring| &recoloring.gains),
            matrix: recoloring.and_then(|recoloring| recoloring.matrix),
            normals,
            is_linear: encoding == Encoding::Linear,
            leaves_out: gains.controls().is_some_and(Controls::leaves_out),
        }
    }

    /// What is done to the base first, where that changes.
    pub fn base_change<'b>(&'b self, gains: &'b Gains) -> Option<BaseLayer<'b>> {
        let (Recoloring { matrix, gains }, skin) = gains.0.as_ref()?.base.as_ref()?;
        let skin = match (&self.skin, skin) {
            (Some(mask), _) | (None, SkinTexels::Mask(mask)) => SkinCriterion::Mask(mask),
            (None, SkinTexels::Model(model)) => SkinCriterion::Model(*model),
        };
        Some(BaseLayer { map: self.layout.as_deref()?, gains, matrix: *matrix, skin })
    }

    /// A toning at the texels of its map.
    ///
    /// - `colors`: whether colours change; else only what is left of the region counts.
    ///
    /// # Errors
    /// [`ToningError::Domain`] if it is another domain's, [`ToningError::Texture`] if there is no memory for a mask.
    pub fn gains(
        &self,
        map: &Arc<SamplingMap>,
        toning: &Toning,
        colors: bool,
    ) -> Result<Gains, ToningError> {
        if !self.blend.domain.is_like(&toning.domain) {
            return Err(ToningError::Domain);
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
        Ok(Gains(Some(Arc::new(ToneGains { source, base, narrowed, controls }))))
    }

    fn recoloring(&self, map: &SamplingMap, recolor: &Recolor) -> Recoloring {
        let Recolor { matrix, gains } = recolor;
        let domain = &self.blend.domain;
        let gains = if gains.is_empty() {
            Vec::new()
        } else {
            slopes(map, domain.mesh(), domain.surface(), |_, point| gains[point as usize])
        };
        Recoloring { matrix: *matrix, gains }
    }

    /// How much of the texture there is at each texel, as an 8-bit grey texture: white where it is all,
    /// black where it is nothing. The gutter is black.
    ///
    /// - `gains`: what is left of the region for a texture.
    pub fn weights(&self, map: &SamplingMap, gains: &Gains) -> Texture {
        let size = map.size();
        let white = vec![255_u8; size.texels()];
        let mut values = vec![0; size.texels()];
        let composition = Composition {
            gains: &[],
            matrix: None,
            ..self.composition(map, gains, false, Encoding::Data)
        };
        let mut controls = Vec::new();
        if let Some(of) = gains.controls() {
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
    /// The signed distance from the rim over the patches of a map.
    fn inside_of(&self, map: &SamplingMap) -> Vec<[Slope; 1]> {
        let value = |face: u32, point: u32| {
            // What is not in the region is beyond its rim, even where all its corners are on it.
            [if self.touched[face as usize] {
                self.inside[point as usize]
            } else {
                f32::NEG_INFINITY
            }]
        };
        slopes(map, self.domain.mesh(), self.domain.surface(), value)
    }
}

impl Gains {
    /// What labels say about each texel, if there are any.
    pub fn controls(&self) -> Option<&Controls> {
        self.0.as_ref()?.controls.as_ref()
    }
}
