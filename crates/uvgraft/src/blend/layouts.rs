//! The same blend on the same surface in another layout.
//!
//! A blend lives at the points of the surface, and so does the tone computed with it; only the
//! positions of the target's texels depend on its layout.

use super::selection::BlendDomain;
use super::{Blend, BlendOptions, RegionError, Tone, ToneCorrection, ToneError};

impl Blend {
    /// The same blend for a domain whose target has the same surface in another layout, such as
    /// that of an [`SourceLayout`](uvgraft_surface::SourceLayout). Its bases must have had their tone changed
    /// already: tones are computed with the original blend and transferred by
    /// [`ToneCorrection::with_layout`].
    ///
    /// # Errors
    /// [`RegionError::Domain`] if the surface is a different one.
    pub fn with_layout(&self, domain: &BlendDomain) -> Result<Self, RegionError> {
        if !self.domain.is_same_surface(domain) {
            return Err(RegionError::Domain);
        }
        Ok(Self {
            selection: self.selection.with_layout(domain),
            domain: domain.clone(),
            options: BlendOptions { tone: Tone::Base, ..self.options },
            skin: None,
            ..self.clone()
        })
    }
}

impl ToneCorrection {
    /// The toning of the texture alone, for [`Blend::with_layout`]. The base, which lies in another
    /// layout, is left unchanged.
    ///
    /// # Errors
    /// [`ToneError::Domain`] if the surface is a different one.
    pub fn with_layout(&self, domain: &BlendDomain) -> Result<Self, ToneError> {
        if !self.domain.is_same_surface(domain) {
            return Err(ToneError::Domain);
        }
        let narrowed = self.narrowed.as_ref().map(|blend| blend.with_layout(domain)).transpose();
        Ok(Self {
            domain: domain.clone(),
            source: self.source.clone(),
            base: None,
            labels: self.labels.clone(),
            narrowed: narrowed.map_err(|_| ToneError::Domain)?.map(std::sync::Arc::new),
            report: self.report.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};
    use uvgraft_surface::source_layout::SourceLayout;

    use super::*;
    use crate::color::Encoding;
    use crate::graft::Graft;
    use crate::texture::{Channels, Size, Sizes, Texels, Texture};

    const SIDE: u32 = 64;

    /// A sheet of eight squares and one metre a side, over all of the source's layout and a quarter
    /// of the target's. The target has one more column, which is not linked.
    fn pair() -> Pair {
        let sheet = |columns: u32, uv_of: fn([f32; 2]) -> [f32; 2]| {
            let points = (0..9).flat_map(|row| (0..=columns).map(move |column| [column, row]));
            let places: Vec<[f32; 2]> = points.map(|at| at.map(|k| k as f32 / 8.0)).collect();
            let at = |column: u32, row: u32| row * (columns + 1) + column;
            let faces: Vec<[u32; 3]> = (0..8)
                .flat_map(|row| (0..columns).map(move |column| [column, row]))
                .flat_map(|[x, y]| {
                    [
                        [at(x, y), at(x + 1, y), at(x + 1, y + 1)],
                        [at(x, y), at(x + 1, y + 1), at(x, y + 1)],
                    ]
                })
                .collect();
            let positions = places.iter().map(|&[x, y]| [x, -y, 0.0]).collect();
            let uv = places.into_iter().map(uv_of).collect();
            Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
        };
        let (source, target) = (sheet(8, |at| at), sheet(9, |[x, y]| [y / 2.0, 0.1 + x / 2.0]));
        let ids: Vec<i64> = (0..81).map(|vertex| vertex / 9 * 10 + vertex % 9).collect();
        Pair::by_vertex_map(source, target, &ids).unwrap()
    }

    fn texture(value: impl Fn(u32, u32) -> u8) -> Texture {
        let values = (0..SIDE * SIDE).map(|texel| value(texel % SIDE, texel / SIDE)).collect();
        Texture::new(Size::square(SIDE), Channels::Grey, Encoding::Srgb, Texels::U8(values))
            .unwrap()
    }

    #[test]
    fn texels_are_unchanged_inside_the_feather() {
        let pair = Arc::new(pair());
        let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
        let options = BlendOptions::default().feather(0.25);
        let blend = Blend::new(&domain.linked(), options).unwrap();
        let own = SourceLayout::new(&pair, blend.touched()).unwrap().unwrap();
        assert_eq!((own.faces.iter().filter(|&&is_own| is_own).count(), own.share), (128, 1.0));
        let there = BlendDomain::new(Arc::clone(&own.pair), Direction::Forward);
        let with_layout = Arc::new(blend.with_layout(&there).unwrap());
        let size = Size::square(SIDE);
        let graft = Graft::builder(Arc::clone(&own.pair), Sizes { from: size, to: size });
        let graft = graft.shared_blend(with_layout).build().unwrap();
        let face = texture(|x, y| ((x * 37 + y * 101) % 200) as u8);
        let found = graft.apply(&face, texture(|_, _| 250)).unwrap();
        let level = |texture: &Texture, x, y| (255.0 * texture.get(x, y, 0)).round();
        // The boundary is the left side of the last column, at 1 m; a quarter of a metre is 16
        // texels.
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let (own, found) = (level(&face, x, y), level(&found, x, y));
            let inside = (63.5 - x as f32) / 16.0;
            let weight = inside.min(1.0).powi(2) * (3.0 - 2.0 * inside.min(1.0));
            let wanted = 250.0 + (own - 250.0) * weight;
            assert!((found - wanted).abs() <= if weight < 1.0 { 1.5 } else { 0.0 }, "{x} {y}");
        }
    }

    #[test]
    fn another_surface_is_refused() {
        let pair = Arc::new(pair());
        let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
        let blend = Blend::new(&domain.linked(), BlendOptions::default()).unwrap();
        let toning = blend.exclusion(&texture(|_, _| 128));
        assert!(blend.with_layout(&domain).is_ok() && toning.with_layout(&domain).is_ok());
        let back = BlendDomain::new(pair, Direction::Reverse);
        assert_eq!(blend.with_layout(&back).unwrap_err(), RegionError::Domain);
        assert_eq!(toning.with_layout(&back).unwrap_err(), ToneError::Domain);
    }
}
