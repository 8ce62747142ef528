//! The same blend on the same surface in another layout.
//!
//! A blend lives at the points of the surface, and so does the tone that was found with it; only where texels of the
//! target lie asks for its layout.

use super::selection::Ground;
use super::{Blend, BlendOptions, RegionError, Tone, Toning, ToningError};

impl Blend {
    /// The same blend for a ground whose target has the same surface in another layout, such as that of an
    /// [`OwnLayout`](crate::OwnLayout). Bases are taken for such as have changed their tone already: tones are found
    /// with the blend that it comes from, and brought over by [`Toning::relaid`].
    ///
    /// # Errors
    /// [`RegionError::Ground`] if the surface is another.
    pub fn relaid(&self, ground: &Ground) -> Result<Self, RegionError> {
        if !self.ground.is_same_surface(ground) {
            return Err(RegionError::Ground);
        }
        Ok(Self {
            selection: self.selection.relaid(ground),
            ground: ground.clone(),
            options: BlendOptions { tone: Tone::Base, ..self.options },
            skin: None,
            ..self.clone()
        })
    }
}

impl Toning {
    /// What it does to the texture, for [`Blend::relaid`]. The base, which lies in another layout, stays as it is.
    ///
    /// # Errors
    /// [`ToningError::Ground`] if the surface is another.
    pub fn relaid(&self, ground: &Ground) -> Result<Self, ToningError> {
        if !self.ground.is_same_surface(ground) {
            return Err(ToningError::Ground);
        }
        let narrowed = self.narrowed.as_ref().map(|blend| blend.relaid(ground)).transpose();
        Ok(Self {
            ground: ground.clone(),
            source: self.source.clone(),
            base: None,
            labels: self.labels.clone(),
            narrowed: narrowed.map_err(|_| ToningError::Ground)?.map(std::sync::Arc::new),
            report: self.report.clone(),
        })
    }
}
