//! Selection of the texels that a metric compares.

use uvgraft::map::SamplingMap;
use uvgraft::texture::{Size, Texture};

use super::MetricError;

/// The texels that a metric compares, at least one, in textures of one size; a region of the surface is
/// a [`Selection`](uvgraft::blend::Selection).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    size: Size,
    selected: Vec<bool>,
}

impl Mask {
    /// The texels whose first channel is at least one half.
    ///
    /// # Errors
    /// [`MetricError::EmptyMask`] if there are none.
    pub fn from_texture(texture: &Texture) -> Result<Self, MetricError> {
        let size = texture.size();
        let selected = (0..size.height)
            .flat_map(|y| (0..size.width).map(move |x| texture.get(x, y, 0) >= 0.5))
            .collect();
        Self::new(size, selected)
    }

    /// The texels that a map fills inside UV islands, without the gutter.
    ///
    /// # Errors
    /// [`MetricError::EmptyMask`] if there are none.
    pub fn from_map(map: &SamplingMap) -> Result<Self, MetricError> {
        Self::from_texture(&map.mask())
    }

    fn new(size: Size, selected: Vec<bool>) -> Result<Self, MetricError> {
        if !selected.contains(&true) {
            return Err(MetricError::EmptyMask(""));
        }
        Ok(Self { size, selected })
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Whether each texel is selected, row-major.
    pub fn selected(&self) -> &[bool] {
        &self.selected
    }

    /// Number of selected texels.
    pub fn count(&self) -> usize {
        self.selected.iter().filter(|selected| **selected).count()
    }
}
