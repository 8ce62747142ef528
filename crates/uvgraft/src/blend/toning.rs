//! What one side's colours take on from the other's.

use std::sync::Arc;

use crate::color::Encoding;
use crate::labels::Labels;
use crate::skin::{SkinError, SkinModel};
use crate::statistics::ColorMatchError;
use crate::texture::{Texture, TextureError};

use super::Blend;
use super::report::ToneReport;
use super::selection::BlendDomain;
use super::skins::Skins;
use super::tone::Matrix;
use crate::threads::join;

/// What a blend does to the colours of one texture and its base, and what of the texture it leaves out.
#[derive(Debug, Clone)]
pub struct Toning {
    /// Whose points the gains are of.
    pub(super) domain: BlendDomain,
    pub(super) source: Option<Recolor>,
    pub(super) base: Option<(Recolor, BaseSkin)>,
    pub(super) labels: Option<Arc<Labels>>,
    /// The blend of what is left of the region without cloth.
    pub(super) narrowed: Option<Arc<Blend>>,
    pub(super) report: ToneReport,
}

/// What is skin in a base.
#[derive(Debug, Clone)]
pub(super) enum BaseSkin {
    /// What looks like it, if it was estimated at all.
    Model(Option<SkinModel>),
    /// Where a mask is bright.
    Mask(Arc<Texture>),
}

/// Another tone for both sides.
#[derive(Debug)]
pub(super) struct Recolored {
    pub source: Option<Recolor>,
    pub base: Option<(Recolor, BaseSkin)>,
}

/// Another tone for the colours at every point of a surface.
#[derive(Debug, Clone)]
pub(super) struct Recolor {
    /// What is done to all colours first.
    pub matrix: Option<Matrix>,
    /// The gains of red, green and blue at each point; empty for none.
    pub gains: Vec<[f32; 3]>,
}

/// Why colours are left as they are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToningError {
    /// Data are no colours.
    #[error("data textures have no tone")]
    Data,
    /// Everything of the region ends where the mesh ends, or all of the mesh is in it.
    #[error("the region has no border: it covers the whole surface")]
    NoRim,
    /// Beside the rim a texture is transparent, or holds no numbers.
    #[error("the {0} has no colours along the border of the region")]
    NoColors(&'static str),
    /// What is skin was not found out.
    #[error("no skin detected in the {what}: {reason}")]
    Skin {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// Why.
        reason: SkinError,
    },
    /// A tone that was found for another pair or direction.
    #[error("the tone was computed for another pair or direction")]
    Domain,
    /// There is no memory for a mask of skin at the target's size.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// There is nothing to compare.
    #[error(transparent)]
    Match(#[from] ColorMatchError),
}

impl Toning {
    /// What the texture shows, if it is one of a head.
    pub fn labels(&self) -> Option<&Arc<Labels>> {
        self.labels.as_ref()
    }

    /// The blend of what is left of the region, where cloth was left out.
    pub fn narrowed(&self) -> Option<&Arc<Blend>> {
        self.narrowed.as_ref()
    }

    /// How colours change, in numbers.
    pub fn report(&self) -> &ToneReport {
        &self.report
    }
}

impl Blend {
    /// Finds which colours a texture and a base get from each other, and what of the texture is left out; nothing if
    /// neither is asked for.
    ///
    /// Where the meshes show heads, tone goes from skin to skin: one gain from cheeks to cheeks, and what is left at
    /// the rim fades out over 5 cm. Elsewhere the rim decides alone.
    ///
    /// - `base`: of any size: beside a base that is one colour, a texel of it is enough.
    ///
    /// # Errors
    /// [`ToningError`] where there is nothing to go by; the texture can still be laid over as it is.
    pub fn toning(&self, source: &Texture, base: &Texture) -> Result<Option<Toning>, ToningError> {
        if self.measure.is_some()
            && [source, base].iter().any(|side| side.encoding() == Encoding::Data)
        {
            return Err(ToningError::Data);
        }
        // Both take some time, and neither asks for the other.
        let (labels, body) = join(
            || self.found_labels(source).transpose(),
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
        let Recolored { source, base } = match skins {
            Some((skins, labels, mask)) => {
                let report = &mut toning.report;
                blend.between_skins(measure, (source, base), &skins, labels, mask, report)?
            }
            None => {
                toning.report.rim_alone = unlabelled.filter(|_| self.domain.head().is_some());
                blend.along_rim(measure, source, base)?
            }
        };
        Ok(Some(Toning { source, base, ..toning }))
    }

    /// Finds what of a texture is left out of the region, and changes no colour.
    pub fn narrowing(&self, source: &Texture) -> Toning {
        self.without_cloth(self.labels(source))
    }

    fn without_cloth(&self, labels: Option<Arc<Labels>>) -> Toning {
        let narrowed = labels.as_ref().and_then(|labels| self.narrowed(labels)).map(Arc::new);
        let left_out = labels.as_ref().map_or(0.0, |labels| self.left_out(labels));
        Toning {
            domain: self.domain.clone(),
            source: None,
            base: None,
            labels,
            narrowed,
            report: ToneReport { left_out, ..ToneReport::default() },
        }
    }
}
