//! Tonings: how the colours of one side adapt to the other's.

use std::sync::Arc;

use uvgraft_surface::statistics::ColorMatchError;
use uvgraft_surface::threads::join;

use super::Blend;
use super::report::ToneReport;
use super::selection::BlendDomain;
use super::skins::Skins;
use super::tone::Matrix;
use crate::color::Encoding;
use crate::labels::Labels;
use crate::skin::{SkinError, SkinModel};
use crate::texture::{Texture, TextureError};

/// How a blend changes the colours of one texture and its base, and what it leaves out of the
/// texture.
#[derive(Debug, Clone)]
pub struct ToneCorrection {
    /// The domain whose points the gains are for.
    pub(super) domain: BlendDomain,
    pub(super) source: Option<Recolor>,
    pub(super) base: Option<(Recolor, BaseSkin)>,
    pub(super) labels: Option<Arc<Labels>>,
    /// The blend of the region without cloth, if some was left out.
    pub(super) narrowed: Option<Arc<Blend>>,
    pub(super) report: ToneReport,
}

/// How skin is recognised in a base.
#[derive(Debug, Clone)]
pub(super) enum BaseSkin {
    /// By its colour; `None` if that was not estimated.
    Model(Option<SkinModel>),
    /// By a mask that is bright on skin.
    Mask(Arc<Texture>),
}

/// The recolouring of each side; `None` for a side that stays as it is.
#[derive(Debug)]
pub(super) struct SideRecolors {
    pub source: Option<Recolor>,
    pub base: Option<(Recolor, BaseSkin)>,
}

/// The recolouring of one side, at the points of the surface: independent of sizes.
#[derive(Debug, Clone)]
pub(super) struct Recolor {
    /// Colour transform applied before the gains.
    pub matrix: Option<Matrix>,
    /// The gains of red, green and blue, on stored sRGB values, at each point of the target's
    /// surface; empty if there are none.
    pub gains: Vec<[f32; 3]>,
}

/// Why colours are left unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToneError {
    /// Data textures hold no colours.
    #[error("data textures have no tone")]
    Data,
    /// The region ends only where the mesh ends, or covers all of it.
    #[error("the region has no boundary: it covers the whole surface")]
    NoBoundary,
    /// Along the boundary a texture is transparent or not finite.
    #[error("the {0} has no colours along the boundary of the region")]
    NoColors(&'static str),
    /// No skin was detected.
    #[error("no skin detected in the {what}: {reason}")]
    Skin {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// The reason.
        reason: SkinError,
    },
    /// The tone was computed for another pair or direction.
    #[error("the tone was computed for another pair or direction")]
    Domain,
    /// There is not enough memory for a skin mask at the target's size.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// There are no colours to compare.
    #[error(transparent)]
    Match(#[from] ColorMatchError),
}

impl ToneCorrection {
    /// Labels of what the texture shows, if it shows a head.
    pub fn labels(&self) -> Option<&Arc<Labels>> {
        self.labels.as_ref()
    }

    /// The blend of the remaining region, if cloth was left out.
    pub fn narrowed(&self) -> Option<&Arc<Blend>> {
        self.narrowed.as_ref()
    }

    /// Figures on how colours change.
    pub fn report(&self) -> &ToneReport {
        &self.report
    }
}

impl Blend {
    /// Computes how the colours of a texture and a base adapt to each other, and what is left out
    /// of the texture; `None` if neither is requested.
    ///
    /// Where the meshes have heads, the tone is matched from skin to skin: one gain from
    /// cheeks to cheeks, and a residual at the boundary that fades out over 5 cm. Elsewhere
    /// the boundary alone decides.
    ///
    /// - `base`: of any size; for a base of one colour a single texel is enough.
    ///
    /// # Errors
    /// [`ToneError`] where there are no colours to go by; the texture can still be laid over
    /// unchanged.
    pub fn toning(
        &self,
        source: &Texture,
        base: &Texture,
    ) -> Result<Option<ToneCorrection>, ToneError> {
        if self.measure.is_some()
            && [source, base].iter().any(|side| side.encoding() == Encoding::Data)
        {
            return Err(ToneError::Data);
        }
        // Both take some time and are independent of each other.
        let (labels, body) = join(
            || self.try_labels(source).transpose(),
            || self.measure.as_ref().and_then(|_| self.body_side(base)),
        );
        let (labels, unlabelled) = match labels {
            Ok(labels) => (labels, None),
            Err(error) => (None, Some(error)),
        };
        let mut toning = self.without_cloth(labels);
        let narrowed = toning.narrowed.clone();
        let blend = narrowed.as_deref().unwrap_or(self);
        let Some(measure) = &blend.measure else {
            return Ok(toning.narrowed.is_some().then_some(toning));
        };
        let labels = toning.labels.clone();
        let skins = labels.as_ref().zip(body).and_then(|(labels, (body, mask))| {
            Some((Skins::new(&self.domain, source, labels, body)?, labels, mask))
        });
        let SideRecolors { source, base } = match skins {
            Some((skins, labels, mask)) => {
                let report = &mut toning.report;
                blend.between_skins(measure, (source, base), &skins, labels, mask, report)?
            }
            None => {
                toning.report.boundary_only = unlabelled.filter(|_| self.domain.head().is_some());
                blend.along_rim(measure, source, base)?
            }
        };
        Ok(Some(ToneCorrection { source, base, ..toning }))
    }

    /// Computes what is left out of a texture, and changes no colours.
    pub fn exclusion(&self, source: &Texture) -> ToneCorrection {
        self.without_cloth(self.labels(source))
    }

    fn without_cloth(&self, labels: Option<Arc<Labels>>) -> ToneCorrection {
        let narrowed = labels.as_ref().and_then(|labels| self.narrowed(labels)).map(Arc::new);
        let left_out = labels.as_ref().map_or(0.0, |labels| self.left_out(labels));
        ToneCorrection {
            domain: self.domain.clone(),
            source: None,
            base: None,
            labels,
            narrowed,
            report: ToneReport { left_out, ..ToneReport::default() },
        }
    }
}
