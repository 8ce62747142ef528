//! Several photographs in one texture: exposures equalised, coarse colours mixed softly and details
//! taken from where they are seen best, so that nothing is seen twice.
//!
//! Two bands are enough for what differs between photographs of a face: light and white balance,
//! which change over centimetres, and pores, which must not be averaged (P. Burt and E. Adelson, "A
//! multiresolution spline with application to image mosaics", 1983).

use uvgraft::Size;
use uvgraft::easing::smoothstep;
use uvgraft::statistics::median;
use uvgraft::threads::{for_each, map_indices};

use crate::raster::Squares;

/// A photograph's share in a texture.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    /// `[texels]`, sRGB, 1.0 for white.
    pub colors: Vec<[f32; 3]>,
    /// `[texels]`, how far each texel is known, 0 to 1.
    pub known: Vec<f32>,
    /// `[texels]`, how far each texel shows something else: hair, glasses, cloth.
    pub denied: Vec<f32>,
    /// `[texels]`, how far from other parts of the head each is, such as an eyeball beside a lid, with
    /// which a photograph that is a hair's breadth off confuses it: 0 to 1.
    pub apart: Vec<f32>,
    /// `[texels]`, the cosine between normal and line of sight.
    pub facing: Vec<f32>,
}

/// What photographs show together.
#[derive(Debug, Clone)]
pub(crate) struct Fused {
    /// `[texels]`, sRGB, 1.0 for white.
    pub colors: Vec<[f32; 3]>,
    /// `[texels]`, how far each texel is known, 0 to 1.
    pub known: Vec<f32>,
    /// `[texels]`, the same where nothing else is beside it.
    pub certain: Vec<f32>,
}

/// Sums of the layers so far.
#[derive(Debug)]
pub(crate) struct Fusion {
    size: Size,
    /// Weighted sums of the coarse band, and of the weights.
    coarse: Vec<[f32; 4]>,
    fine: Vec<[f32; 4]>,
    known: Vec<f32>,
    certain: Vec<f32>,
    /// Weighted votes of the photographs for and against a texel.
    votes: Vec<[f32; 2]>,
    layers: usize,
}

/// Coarse colours are those of squares with this share of the texture's side. Origin not recorded.
const SQUARES: u32 = 128;

/// Powers of the cosine in the weights of the two bands. Origin not recorded.
const COARSE: i32 = 2;
const FINE: i32 = 10;

/// The same in votes on what is face. Origin not recorded.
const VOTE: i32 = 3;

impl Fusion {
    pub fn new(size: Size) -> Self {
        let texels = size.texels();
        Self {
            size,
            coarse: vec![[0.0; 4]; texels],
            fine: vec![[0.0; 4]; texels],
            known: vec![0.0; texels],
            certain: vec![0.0; texels],
            votes: vec![[0.0; 2]; texels],
            layers: 0,
        }
    }

    /// Adds a photograph, equalised with those before it.
    pub fn add(&mut self, mut layer: Layer) {
        if let Some(gain) = self.gain(&layer) {
            for color in &mut layer.colors {
                *color = std::array::from_fn(|k| (color[k] * gain[k]).min(1.0));
            }
        }
        let coarse_of = coarse_band(self.size, &layer);
        let width = self.size.width as usize;
        let rows = self
            .coarse
            .chunks_mut(width)
            .zip(self.fine.chunks_mut(width))
            .zip(self.known.chunks_mut(width))
            .zip(self.certain.chunks_mut(width))
            .zip(self.votes.chunks_mut(width));
        self.layers += 1;
        for_each(rows, |y, ((((coarse, fine), known), certain), votes)| {
            for x in 0..width {
                let texel = y * width + x;
                let is_known = layer.known[texel];
                let facing = layer.facing[texel];
                votes[x][0] += is_known * facing.powi(VOTE);
                votes[x][1] += layer.denied[texel] * facing.powi(VOTE);
                if is_known <= 0.0 {
                    continue;
                }
                let [r, g, b, weight] = coarse_of.at(texel);
                let soft = [r, g, b].map(|value| value / weight.max(1e-9));
                // Never 0, or what is seen edge-on alone would have no colour.
                let weights = [COARSE, FINE].map(|power| is_known * facing.powi(power) + 1e-9);
                for k in 0..3 {
                    coarse[x][k] += weights[0] * soft[k];
                    fine[x][k] += weights[1] * (layer.colors[texel][k] - soft[k]);
                }
                coarse[x][3] += weights[0];
                fine[x][3] += weights[1];
                known[x] = known[x].max(is_known);
                certain[x] = certain[x].max(is_known * layer.apart[texel]);
            }
        });
    }

    /// The factors that give a layer the colours of those before it, where both are known.
    fn gain(&self, layer: &Layer) -> Option<[f32; 3]> {
        const FEWEST: usize = 500;
        const CERTAIN: f32 = 0.6;
        let both: Vec<usize> = (0..self.known.len())
            .filter(|&texel| self.known[texel] > CERTAIN && layer.known[texel] > CERTAIN)
            .collect();
        if both.len() < FEWEST {
            return None;
        }
        let step = both.len().div_ceil(20_000);
        Some(std::array::from_fn(|k| {
            let ratio =
                |&texel: &usize| (self.color(texel)[k] + 0.01) / (layer.colors[texel][k] + 0.01);
            // Shadows and hair that one photograph alone shows do not set its exposure.
            median(both.iter().step_by(step).map(ratio)).unwrap_or(1.0).clamp(0.3, 3.0)
        }))
    }

    fn color(&self, texel: usize) -> [f32; 3] {
        let (coarse, fine) = (self.coarse[texel], self.fine[texel]);
        if coarse[3] <= 0.0 {
            return [0.0; 3];
        }
        std::array::from_fn(|k| (coarse[k] / coarse[3] + fine[k] / fine[3]).clamp(0.0, 1.0))
    }

    /// What all photographs show.
    pub fn finish(self) -> Fused {
        /// Shares of the votes for a texel at which it is not known, and known as well as it is
        /// seen. Origin not recorded.
        const MAJORITY: [f32; 2] = [0.25, 0.55];
        let colors = map_indices(self.known.len(), |texel| self.color(texel));
        let Self { mut known, mut certain, votes, .. } = self;
        if self.layers > 1 {
            for ((known, certain), [for_it, against]) in
                known.iter_mut().zip(&mut certain).zip(votes)
            {
                let share = for_it / (for_it + against).max(f32::MIN_POSITIVE);
                let majority = smoothstep(MAJORITY[0], MAJORITY[1], share);
                *known *= majority;
                *certain *= majority;
            }
        }
        Fused { colors, known, certain }
    }
}

/// The coarse band of a layer: weighted colours and weights over squares, where it is known.
fn coarse_band(size: Size, layer: &Layer) -> Squares<4> {
    let of_texel = |texel: usize| {
        let ([r, g, b], known) = (layer.colors[texel], layer.known[texel]);
        [r * known, g * known, b * known, known]
    };
    Squares::new(size, SQUARES, of_texel).blurred(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(
        size: Size,
        color: impl Fn(u32, u32) -> [f32; 3],
        known: impl Fn(u32) -> f32,
    ) -> Layer {
        let at = |texel: usize| [texel as u32 % size.width, texel as u32 / size.width];
        Layer {
            colors: (0..size.texels()).map(|t| color(at(t)[0], at(t)[1])).collect(),
            known: (0..size.texels()).map(|t| known(at(t)[0])).collect(),
            denied: vec![0.0; size.texels()],
            apart: vec![1.0; size.texels()],
            facing: vec![0.9; size.texels()],
        }
    }

    #[test]
    fn one_photograph_stays_as_it_is() {
        let size = Size::square(64);
        let color = |x: u32, y: u32| [x as f32 / 64.0, y as f32 / 64.0, 0.5];
        let mut fusion = Fusion::new(size);
        let one = layer(size, color, |x| if x < 50 { 1.0 } else { 0.0 });
        fusion.add(one.clone());
        let Fused { colors, known, .. } = fusion.finish();
        assert_eq!(known, one.known);
        for (texel, color) in colors.iter().enumerate().filter(|(texel, _)| texel % 64 < 50) {
            for k in 0..3 {
                assert!((color[k] - one.colors[texel][k]).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn exposures_are_equalised_where_photographs_overlap() {
        let size = Size::square(128);
        let texture = |x: u32, y: u32| {
            let value = 0.4 + 0.1 * ((x / 3 + y / 5) % 2) as f32;
            [value, 0.8 * value, 0.6 * value]
        };
        let mut fusion = Fusion::new(size);
        fusion.add(layer(size, texture, |x| if x < 80 { 1.0 } else { 0.0 }));
        let darker = |x: u32, y: u32| texture(x, y).map(|value| 0.7 * value);
        fusion.add(layer(size, darker, |x| if x >= 40 { 1.0 } else { 0.0 }));
        let colors = fusion.finish().colors;
        for (texel, color) in colors.iter().enumerate() {
            let wanted = texture(texel as u32 % 128, texel as u32 / 128);
            for k in 0..3 {
                assert!((color[k] - wanted[k]).abs() < 0.02, "{texel}: {color:?} {wanted:?}");
            }
        }
    }

    #[test]
    fn what_most_photographs_deny_is_not_known() {
        let size = Size::square(64);
        let skin = |_, _| [0.6, 0.5, 0.4];
        let mut fusion = Fusion::new(size);
        for index in 0..5 {
            let mut layer = layer(size, skin, |x| if index == 0 || x < 32 { 1.0 } else { 0.0 });
            let denied = |texel: usize| if index > 0 && texel % 64 >= 48 { 1.0 } else { 0.0 };
            layer.denied = (0..size.texels()).map(denied).collect();
            fusion.add(layer);
        }
        let known = fusion.finish().known;
        for (texel, known) in known.into_iter().enumerate() {
            assert_eq!(known, if texel % 64 < 48 { 1.0 } else { 0.0 });
        }
    }
}
