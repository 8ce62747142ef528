//! Colour evidence: deviation of a texture's colours from the skin of cheeks and nose.

use uvgraft_surface::statistics::order_statistic;
use uvgraft_surface::threads::map_indices;

use super::geodesic::Steps;
use super::head::HeadLayout;
use crate::color::{LabTables, lab_distance};
use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::skin::{SkinError, SkinModel};

/// Colour evidence for each texel of the grid.
#[derive(Debug, Clone)]
pub(super) struct Evidence {
    /// Distance of the hue from skin's, in standard deviations. Deviations towards more saturated
    /// colours of the same hue, as where skin shades skin, are weighted less.
    pub hue: Vec<f32>,
    /// How much less saturated than skin the colour is, in standard deviations; negative where
    /// more.
    pub pale: Vec<f32>,
    /// Logarithm of the lightness relative to the surrounding skin.
    pub light: Vec<f32>,
    /// Logarithm of the lightness relative to the cheeks.
    pub light_of_face: Vec<f32>,
    /// At the lips, redness relative to the surrounding skin, in a* of CIELAB: positive on lips,
    /// negative on teeth; 0 elsewhere.
    pub red: Vec<f32>,
    /// Geodesic colour distance from cheeks, forehead and nose, in ΔE above noise.
    pub step: Vec<f32>,
    pub steps: Steps,
    /// Mean alpha of each texel: how much of it the texture determines.
    pub known: Vec<f32>,
}

/// The known colours of an area's texels, evenly subsampled to some thousands.
fn colors_of(colors: &GridColors, area: &[f32]) -> Vec<[f32; 3]> {
    const MAX: usize = 4096;
    let is_in = |&texel: &usize| area[texel] >= 0.5 && colors.known[texel] >= 0.5;
    let all: Vec<usize> = (0..area.len()).filter(is_in).collect();
    let step = all.len().div_ceil(MAX).max(1);
    all.into_iter().step_by(step).map(|texel| colors.rgb[texel]).collect()
}

impl Evidence {
    /// Computes the evidence for the texels of a grid.
    ///
    /// A model of skin from cheeks and nose gives the deviations. Lightness and redness are
    /// relative to the local mean of skin-coloured texels, as the shading varies over the
    /// head. The geodesic distance starts from plain skin on cheeks, nose and forehead.
    ///
    /// # Errors
    /// [`SkinError`] if cheeks and nose have no uniform colour.
    pub fn new(head: &HeadLayout, colors: GridColors) -> Result<Self, SkinError> {
        let (grid, areas) = (&head.grid, &head.areas);
        let mut seeds = colors_of(&colors, &areas.cheeks);
        // Noses have highlights, so they get fewer samples than the cheeks: a third at most.
        let nose = colors_of(&colors, &areas.nose);
        let most = seeds.len() / 3;
        seeds.extend(nose.iter().step_by((nose.len() / most.max(1)).max(1)).take(most));
        let skin = SkinModel::new(&seeds, &[])?;
        let deviations = skin.deviations();
        // Texels outside the islands are compared once, for all.
        let of_none = deviations([0.0; 3]);
        let deviation = map_indices(colors.rgb.len(), |texel| {
            if grid.faces()[texel] == NONE { of_none } else { deviations(colors.rgb[texel]) }
        });
        let light_of_face: Vec<f32> = deviation.iter().map(|deviation| deviation.light).collect();
        let is_skin = |texel: usize| {
            let deviation = &deviation[texel];
            colors.known[texel] >= 0.5
                && areas.eyes[texel] < 0.5
                && deviation.hue < 2.5
                && deviation.light.abs() < 0.7
        };
        let steps = steps(head, &colors);
        let width = grid.size().width as usize;
        let place = |texel: usize| (texel % width, texel / width);
        let around =
            LocalAverage::new(grid, |texel| is_skin(texel).then_some(light_of_face[texel]));
        let light = map_indices(light_of_face.len(), |texel| {
            let (x, y) = place(texel);
            light_of_face[texel] - around.at(x, y)
        });
        let redness = |texel: usize| steps.lab[texel][1];
        let around = LocalAverage::new(grid, |texel| is_skin(texel).then(|| redness(texel)));
        let red = map_indices(light_of_face.len(), |texel| {
            let (x, y) = place(texel);
            if areas.lips[texel] > 0.0 { redness(texel) - around.at(x, y) } else { 0.0 }
        });
        let is_seed = |&texel: &u32| {
            let texel = texel as usize;
            let area = areas.cheeks[texel].max(areas.nose[texel]).max(areas.forehead[texel]);
            area >= 0.5 && is_skin(texel) && light[texel].abs() < 0.4 && deviation[texel].hue < 2.0
        };
        let seeds = (0..light.len() as u32).filter(is_seed);
        let step = steps.distances(grid, seeds, |texel| {
            areas.eyes[texel as usize] < 0.5 && colors.known[texel as usize] >= 0.5
        });
        Ok(Self {
            hue: deviation.iter().map(|deviation| deviation.hue).collect(),
            pale: deviation.iter().map(|deviation| deviation.pale).collect(),
            light,
            light_of_face,
            red,
            step,
            steps,
            known: colors.known,
        })
    }
}

/// Perceptual colours of the grid and their noise level: 1.2 times the 90th percentile of
/// the changes between adjacent texels of the cheeks, within 0.6 to 4 ΔE.
fn steps(head: &HeadLayout, colors: &GridColors) -> Steps {
    let grid = &head.grid;
    let labs = LabTables::new();
    let plain: Vec<[f32; 3]> = map_indices(colors.rgb.len(), |texel| {
        if grid.faces()[texel] == NONE { [0.0; 3] } else { labs.of(colors.rgb[texel]) }
    });
    let lab: Vec<[f32; 3]> = map_indices(plain.len(), |texel| {
        // Average with the neighbours, so single noisy texels don't make edges.
        let (mut sum, mut total) = (plain[texel].map(|value| value * 2.0), 2.0);
        grid.each_neighbour(texel as u32, |near| {
            if colors.known[near as usize] >= 0.5 {
                for (sum, value) in sum.iter_mut().zip(plain[near as usize]) {
                    *sum += 0.5 * value;
                }
                total += 0.5;
            }
        });
        sum.map(|sum| sum / total)
    });
    let mut steps = Steps { lab, noise: 0.0 };
    let cheeks = (0..plain.len() as u32).filter(|&texel| head.areas.cheeks[texel as usize] >= 0.5);
    let changes = cheeks
        .flat_map(|texel| grid.neighbours(texel).map(move |near| (texel, near)))
        .filter(|&(texel, near)| texel < near)
        .map(|(texel, near)| lab_distance(steps.lab[texel as usize], steps.lab[near as usize]))
        .filter(|change| change.is_finite());
    let noise = order_statistic(changes, |count| count * 9 / 10).unwrap_or(0.0);
    // A factor of 0.6 costs a white collar 0.05 of IoU; with 2.4, the collars of a captured and of
    // a grey face are not found at all. Nor is the latter's with a lower limit of 1.2, while one of
    // 0.3 changes nothing. A factor of 1.5 or 1.8, or a limit of 0.9, finds all collars as well or
    // better (the white one 0.90 -> 0.95).
    steps.noise = (1.2 * noise).clamp(0.6, 4.0);
    steps
}

/// A smooth local mean of a value that only some texels have, defined everywhere.
///
/// The value is averaged in cells of 8 × 8 texels; cells with few or no samples are filled
/// from coarser levels. A plain blur over the known texels would be undefined inside large
/// gaps such as beards.
struct LocalAverage {
    side: [usize; 2],
    cells: Vec<f32>,
}

/// Side of a cell, in texels of the grid. At 4, teeth of a grey capture become lips (IoU 0.54 ->
/// 0.35); at 12 and 16, they are found better (0.69 and 0.80), but its collar worse (0.86 -> 0.77)
/// and not at all.
const CELL: usize = 8;

impl LocalAverage {
    fn new(grid: &LayoutGrid, value: impl Fn(usize) -> Option<f32>) -> Self {
        let [width, height] = [grid.size().width, grid.size().height].map(|side| side as usize);
        let side = [width.div_ceil(CELL), height.div_ceil(CELL)];
        let mut sums = vec![(0.0, 0.0); side[0] * side[1]];
        for texel in 0..width * height {
            if let Some(value) = value(texel) {
                let sum = &mut sums[texel / width / CELL * side[0] + texel % width / CELL];
                sum.0 += value;
                sum.1 += 1.0;
            }
        }
        let full = (CELL * CELL) as f32;
        let cells: Vec<(f32, f32)> = sums
            .into_iter()
            .map(|(sum, count)| (sum / f32::max(count, 1.0), count / full))
            .collect();
        Self { side, cells: pull_push(&cells, side) }
    }

    /// The value at a texel, bilinear between cell centres.
    fn at(&self, x: usize, y: usize) -> f32 {
        let place = |at: usize, side: usize| {
            let at = ((at as f32 + 0.5) / CELL as f32 - 0.5).clamp(0.0, (side - 1) as f32);
            let first = at as usize;
            (first, (first + 1).min(side - 1), at - first as f32)
        };
        let (left, right, s) = place(x, self.side[0]);
        let (top, bottom, t) = place(y, self.side[1]);
        let value = |x: usize, y: usize| self.cells[y * self.side[0] + x];
        let above = value(left, top) + (value(right, top) - value(left, top)) * s;
        let below = value(left, bottom) + (value(right, bottom) - value(left, bottom)) * s;
        above + (below - above) * t
    }
}

/// Fills cells whose weight is less than 1 from coarser levels ("pull-push", S. Gortler et
/// al., 1996).
fn pull_push(cells: &[(f32, f32)], [width, height]: [usize; 2]) -> Vec<f32> {
    if width <= 2 && height <= 2 {
        let total: f32 = cells.iter().map(|cell| cell.1).sum();
        let mean = cells.iter().map(|cell| cell.0 * cell.1).sum::<f32>() / total.max(1e-6);
        return vec![mean; cells.len()];
    }
    let coarse = [width.div_ceil(2), height.div_ceil(2)];
    let mut sums = vec![(0.0, 0.0); coarse[0] * coarse[1]];
    for (index, &(value, weight)) in cells.iter().enumerate() {
        let sum = &mut sums[index / width / 2 * coarse[0] + index % width / 2];
        sum.0 += value * weight;
        sum.1 += weight;
    }
    let sums: Vec<(f32, f32)> = sums
        .into_iter()
        .map(|(sum, weight)| (sum / f32::max(weight, 1e-6), weight.min(1.0)))
        .collect();
    let filled = pull_push(&sums, coarse);
    cells
        .iter()
        .enumerate()
        .map(|(index, &(value, weight))| {
            let beneath = filled[index / width / 2 * coarse[0] + index % width / 2];
            beneath + (value - beneath) * weight.min(1.0)
        })
        .collect()
}
