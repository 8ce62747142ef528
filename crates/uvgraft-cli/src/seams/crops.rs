//! Close-ups of bad seams: the texture on both sides of an edge, and both sides joined as on the
//! surface.

use uvgraft::{Size, Texture};
use uvgraft_metrics::seams::{SeamEdge, Step, Unfolded};

use super::colors::{BEHIND, shown};
use super::report::texel;
use uvgraft_assembly::drawing::Pen;
use uvgraft_assembly::drawing::{Rgb, Sheet};

/// Side of a crop, in pixels.
pub(super) const CROP: u32 = 156;
/// Texels across a crop, unless the sampling distance requires more.
const TEXELS: f64 = 20.0;

const WHITE: Rgb = [255; 3];
const BLACK: Rgb = [0; 3];

/// A close-up of an edge.
pub(super) struct EdgeCrop<'a> {
    texture: &'a Texture,
    edge: &'a SeamEdge,
    step: Step,
    /// Texels across a crop.
    texels: f64,
}

impl<'a> EdgeCrop<'a> {
    pub fn new(texture: &'a Texture, edge: &'a SeamEdge, step: Step) -> Self {
        let reach = |k: usize| distance(texel(step.uv[k], texture.size()), taken(texture, step, k));
        let texels = TEXELS.max(3.0 * reach(0).max(reach(1)));
        Self { texture, edge, step, texels }
    }

    /// The texture around the step on one side, with the edge and the sampling position.
    pub fn side(&self, side: usize) -> anyhow::Result<Sheet> {
        let center = texel(self.step.uv[side], self.texture.size());
        let mut picture = Sheet::new(Size::square(CROP), BEHIND);
        for y in 0..CROP {
            for x in 0..CROP {
                let [right, down] = [x, y].map(|pixel| self.texels_from_middle(pixel));
                let color = self.texel_at([center[0] + right, center[1] + down]);
                picture.set(x, y, color.unwrap_or(BEHIND));
            }
        }
        let pixel = |at: [f64; 2]| {
            let zoom = f64::from(CROP) / self.texels;
            [0, 1].map(|k| f64::from(CROP) / 2.0 + (at[k] - center[k]) * zoom)
        };
        let ends =
            self.edge.sides[side].uv.map(|uv| pixel(texel(uv.map(f64::from), self.texture.size())));
        let taken = pixel(taken(self.texture, self.step, side));
        picture.draw(|canvas| {
            canvas.line(ends, Pen::round(BLACK, 150, 3.6));
            canvas.line(ends, Pen::round(WHITE, 255, 1.6));
            canvas.ring(taken, 4.0, Pen::round(BLACK, 170, 3.2));
            canvas.ring(taken, 4.0, Pen::round(WHITE, 255, 1.4));
        })?;
        Ok(picture)
    }

    /// Both sides as they lie on the surface: the first one left of the edge, which stands upright
    /// between two marks, the second one right of it.
    pub fn unfolded(&self, surface: &Unfolded<'_>) -> anyhow::Result<Sheet> {
        // Scaled to the side of the edge with more texels.
        let texels_along = |k: usize| {
            let [a, b] =
                self.edge.sides[k].uv.map(|uv| texel(uv.map(f64::from), self.texture.size()));
            distance(a, b)
        };
        let per_texel = self.edge.length / texels_along(0).max(texels_along(1)).max(1e-9);
        let mut picture = Sheet::new(Size::square(CROP), BEHIND);
        for y in 0..CROP {
            for x in 0..CROP {
                let [across, forward] =
                    [x, y].map(|pixel| self.texels_from_middle(pixel) * per_texel);
                let uv = surface.uv(self.edge, self.step.along, across, forward);
                let color = uv.and_then(|uv| self.texel_at(texel(uv, self.texture.size())));
                picture.set(x, y, color.unwrap_or(BEHIND));
            }
        }
        let middle = f64::from(CROP) / 2.0;
        picture.draw(|canvas| {
            for ends in [[0.0, 12.0], [f64::from(CROP) - 12.0, f64::from(CROP)]] {
                let ends = ends.map(|y| [middle, y]);
                canvas.line(ends, Pen::round(BLACK, 150, 3.6));
                canvas.line(ends, Pen::round(WHITE, 255, 1.6));
            }
        })?;
        Ok(picture)
    }

    /// Distance of a pixel column or row from the centre of a crop.
    fn texels_from_middle(&self, pixel: u32) -> f64 {
        (f64::from(pixel) + 0.5 - f64::from(CROP) / 2.0) * self.texels / f64::from(CROP)
    }

    /// The texel at a position, so that texels appear as squares.
    fn texel_at(&self, [x, y]: [f64; 2]) -> Option<Rgb> {
        let size = self.texture.size();
        let is_inside = x >= 0.0 && y >= 0.0 && x < size.width.into() && y < size.height.into();
        is_inside.then(|| shown(self.texture, x as u32, y as u32))
    }
}

/// The sampling position on a side, in texels.
fn taken(texture: &Texture, step: Step, side: usize) -> [f64; 2] {
    texel(step.sampled[side], texture.size())
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
