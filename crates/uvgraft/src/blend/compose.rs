//! Composites sampled values over a base: weighted by the feather, and recoloured.

use std::ops::Range;

use fearless_simd::Level;
use uvgraft_surface::threads::for_each_with;

use super::controls::{self, VALUES};
use super::field::{Line, LinearValue};
use super::stretch::{self, Span, lerp};
use super::tone::{Matrix, toned};
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::map::{Run, SamplingMap};
use crate::resample::{load, store};
use crate::texture::{Channels, Value};

/// How the texels of a map are laid over a base.
#[derive(Debug, Clone)]
pub(crate) struct Composition<'a> {
    pub map: &'a SamplingMap,
    /// For each patch, the signed distance from the boundary, in the target mesh's unit, positive
    /// inside.
    pub inside: &'a [[LinearValue; 1]],
    /// Distance over which the weight grows from 0 to 1, in the target mesh's unit.
    pub feather: f32,
    /// For each patch, the gains of red, green and blue; empty if there are none.
    pub gains: &'a [[LinearValue; 3]],
    /// Colour transform applied before the gains.
    pub matrix: Option<Matrix>,
    /// Whether values are encoded normals, which are renormalised after blending.
    pub normals: bool,
    /// Whether values are linear light. Tones act on stored sRGB values whatever the working
    /// encoding, so that results do not depend on it.
    pub is_linear: bool,
    /// Whether labels make some texels transfer less than fully.
    pub leaves_out: bool,
}

impl Composition<'_> {
    /// Composites the texels of a map, sampled into `layer`, over the rows from `first_row` on. If
    /// the last channel is alpha, `layer` includes it.
    ///
    /// - `layer`, `rows`: whole rows as wide as the map, with the values of `channels` per texel;
    ///   of `layer`, only the map's texels count.
    /// - `controls`: per-texel controls of the rows, [`controls::VALUES`] each; empty if there are
    ///   none.
    ///
    /// # Panics
    /// If `layer` and `rows` have different lengths.
    pub fn lay<T: Value>(
        &self,
        channels: Channels,
        has_alpha: bool,
        first_row: u32,
        layer: &[T],
        rows: &mut [T],
        controls: &[u8],
    ) {
        let lay = match (channels.count(), has_alpha) {
            (1, _) => Self::lay_rows::<T, 1, false>,
            (2, false) => Self::lay_rows::<T, 2, false>,
            (2, true) => Self::lay_rows::<T, 2, true>,
            (3, _) => Self::lay_rows::<T, 3, false>,
            (_, false) => Self::lay_rows::<T, 4, false>,
            (_, true) => Self::lay_rows::<T, 4, true>,
        };
        lay(self, first_row, layer, rows, controls);
    }

    /// Adds the columns of a row at which an opaque layer leaves nothing of the base.
    pub fn push_full(&self, row: u32, columns: &mut Vec<Range<u32>>) {
        for run in self.map.row(row) {
            let inside = self.inside[run.patch as usize][0].line(run.x, row);
            let ends = [inside.at(0), inside.at(run.len - 1)];
            if !ends.iter().all(|&end| end >= self.feather) {
                continue;
            }
            match columns.last_mut() {
                Some(last) if last.end == run.x => last.end += run.len,
                _ => columns.push(run.x..run.x + run.len),
            }
        }
    }

    /// Composites each run of the map in the cheapest way that gives the exact result: runs outside
    /// the region are skipped, opaque runs that stay unchanged are copied, plain adjacent runs are
    /// joined to a span for [`stretch::lay_span`], and the rest is done texel by texel. Runs are
    /// short, so they would rarely fill a vector on their own.
    fn lay_rows<T: Value, const C: usize, const ALPHA: bool>(
        &self,
        first_row: u32,
        layer: &[T],
        band: &mut [T],
        controls: &[u8],
    ) {
        assert_eq!(layer.len(), band.len());
        let width = self.map.size().width as usize;
        let level = Level::new();
        for_each_with(band.chunks_mut(width * C), Span::default, |span, index, texels| {
            let row = first_row + index as u32;
            let layer = &layer[index * width * C..][..width * C];
            let controls_of = |columns: Range<usize>| {
                let first = index * width;
                let values = (first + columns.start) * VALUES..(first + columns.end) * VALUES;
                if controls.is_empty() { controls } else { &controls[values] }
            };
            let lay_span = |span: &mut Span, texels: &mut [T]| {
                let columns = span.columns();
                if columns.is_empty() {
                    return;
                }
                let part = columns.start * C..columns.end * C;
                let (layer, texels) = (&layer[part.clone()], &mut texels[part]);
                stretch::lay_span::<T, C>(level, span, controls_of(columns), layer, texels);
                span.clear();
            };
            for run in self.map.row(row) {
                let columns = run.x as usize..(run.x + run.len) as usize;
                let change = self.change_of(run, row);
                // Spans know no alpha, normals, matrices or linear light, and no step within a run.
                let is_per_texel = ALPHA
                    || self.normals
                    || self.matrix.is_some()
                    || (self.is_linear && change.is_recolored)
                    || (change.reach == Reach::Partly && self.feather <= 0.0);
                let is_copied = change.reach == Reach::Wholly
                    && !(ALPHA || change.is_recolored || self.leaves_out);
                let is_of_span = change.reach != Reach::Nowhere && !is_copied && !is_per_texel;
                if !is_of_span || span.columns().end != columns.start {
                    lay_span(span, texels);
                }
                if is_of_span {
                    let inside = (change.reach == Reach::Partly).then_some(change.inside);
                    span.push(columns, inside, self.feather, &change.gains);
                    continue;
                }
                if change.reach == Reach::Nowhere {
                    continue;
                }
                let part = columns.start * C..columns.end * C;
                let (layer, texels) = (&layer[part.clone()], &mut texels[part]);
                if is_copied {
                    texels.copy_from_slice(layer);
                    continue;
                }
                let controls = controls_of(columns);
                let texels = texels.chunks_exact_mut(C).zip(layer.chunks_exact(C));
                for (k, (texel, layer)) in (0..).zip(texels) {
                    let is_whole = change.reach == Reach::Wholly;
                    let weight = if is_whole { 1.0 } else { self.weight(change.inside.at(k)) };
                    let [tone, share] = controls::at(controls, k as usize);
                    let change = Change { gains: change.gains.map(|gain| gain.at(k)), tone };
                    self.texel::<T, C, ALPHA>(layer, weight * share, &change, texel);
                }
            }
            lay_span(span, texels);
        });
    }

    /// The change along a run of the map.
    fn change_of(&self, run: &Run, row: u32) -> RunChange {
        let patch = run.patch as usize;
        let inside = self.inside[patch][0].line(run.x, row);
        // Values are linear along a run: what holds at both ends holds in between.
        let ends = [inside.at(0), inside.at(run.len - 1)];
        let reach = if ends.iter().all(|&end| end < 0.0) {
            Reach::Nowhere
        } else if ends.iter().all(|&end| end >= self.feather) {
            Reach::Wholly
        } else {
            Reach::Partly
        };
        let gains = self.gains.get(patch);
        let gains = gains.filter(|gains| gains.iter().any(|gain| !gain.is_constant(1.0)));
        RunChange {
            reach,
            inside,
            is_recolored: gains.is_some() || self.matrix.is_some(),
            gains: gains.map_or([Line::ONE; 3], |gains| gains.map(|gain| gain.line(run.x, row))),
        }
    }

    #[inline(always)]
    fn weight(&self, inside: f32) -> f32 {
        if self.feather > 0.0 {
            stretch::weight(inside, self.feather)
        } else {
            f32::from(u8::from(inside >= 0.0))
        }
    }

    /// Composites one texel: the specification that [`stretch::lay_span`] is tested against.
    ///
    /// `below + (recoloured - below) · weight` per channel; with alpha, the layer's alpha times
    /// `weight` is composited over the texel.
    #[inline(always)]
    fn texel<T: Value, const C: usize, const ALPHA: bool>(
        &self,
        layer: &[T],
        weight: f32,
        change: &Change,
        texel: &mut [T],
    ) {
        if weight <= 0.0 {
            return;
        }
        let one = T::ONE.to_level();
        let mut levels = load::<T, C, false>(layer);
        let colors = if ALPHA { C - 1 } else { C };
        self.recolor(&mut levels[..colors], one, change);
        if ALPHA {
            let alpha = levels[C - 1] / one * weight;
            for channel in 0..colors {
                levels[channel] *= alpha;
            }
            levels[C - 1] *= weight;
            store::<T, C, true>(levels, texel);
        } else {
            for channel in 0..colors {
                let below = texel[channel].to_level();
                if weight < 1.0 {
                    levels[channel] = below + (levels[channel] - below) * weight;
                }
            }
            if self.normals && weight < 1.0 {
                renormalise(&mut levels, one);
            }
            store::<T, C, false>(levels, texel);
        }
    }
}

impl Composition<'_> {
    /// Recolours a texel.
    #[inline(always)]
    fn recolor(&self, levels: &mut [f32], one: f32, change: &Change) {
        let colors = levels.len();
        let is_light = self.is_linear && (self.matrix.is_some() || change.gains != [1.0; 3]);
        let [to_stored, to_light]: [fn(f32) -> f32; 2] =
            if is_light { [srgb_from_linear, linear_from_srgb] } else { [|value| value; 2] };
        let mut stored = [0.0; 4];
        for (stored, &level) in stored.iter_mut().zip(levels.iter()) {
            *stored = if is_light { to_stored(level / one) * one } else { level };
        }
        let before = stored;
        if let (Some(matrix), 1 | 3) = (&self.matrix, colors) {
            // Grey is a colour with equal channels.
            let rgb = [0, 1, 2].map(|channel| stored[channel.min(colors - 1)] / one);
            for (level, value) in stored[..colors].iter_mut().zip(matrix.apply(rgb)) {
                *level = value * one;
            }
        }
        for channel in 0..colors {
            let value = toned(stored[channel], change.gains[channel % 3], one);
            let value = lerp(before[channel], value, change.tone);
            levels[channel] = if is_light { to_light(value / one) * one } else { value };
        }
    }
}

/// The change along a run of a map.
struct RunChange {
    reach: Reach,
    /// Signed distance from the boundary.
    inside: Line,
    is_recolored: bool,
    gains: [Line; 3],
}

/// How much of a layer is composited along a run.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reach {
    Nowhere,
    Partly,
    Wholly,
}

/// How a texel's colours change.
struct Change {
    gains: [f32; 3],
    /// How much of the change is applied, 0 to 1.
    tone: f32,
}

/// Renormalises an encoded normal; one without a direction is left unchanged.
fn renormalise(levels: &mut [f32], one: f32) {
    if let [x, y, z, ..] = levels {
        let normal = [*x, *y, *z].map(|level| level / one * 2.0 - 1.0);
        let length = normal.iter().map(|value| value * value).sum::<f32>().sqrt();
        if length > 1e-3 {
            [*x, *y, *z] = normal.map(|value| (value / length * 0.5 + 0.5) * one);
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};

    use super::*;
    use crate::map::MapOptions;
    use crate::texture::Size;

    /// A square texture of eight texels a side, with one triangle over half of it, one unit per
    /// texel.
    fn map() -> SamplingMap {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let positions = uv.iter().map(|&[x, y]| [x * 8.0, y * 8.0, 0.0]).collect();
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let pair = Pair::by_vertex_map(mesh.clone(), mesh, &[0, 1, 2]).unwrap();
        SamplingMap::new(&pair, Direction::Forward, Size::square(8), &MapOptions::with_gutter(0))
    }

    #[test]
    fn weights_and_gains_by_hand() {
        let map = map();
        let mesh = {
            let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
            Mesh::from_triangles(vec![[0.0; 3]; 3], uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap()
        };
        let surface = {
            let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            let faces = [[0, 1, 2]];
            let uv = mesh.uv().to_vec();
            uvgraft_surface::surface::Surface::new(
                &Mesh::from_triangles(positions, uv, &faces, &faces).unwrap(),
            )
        };
        // Outside at the left edge, and one unit further in with every texel.
        let inside = super::super::field::linear_values(&map, &mesh, &surface, |_, point| {
            [if point == 1 { 7.0 } else { -1.0 }]
        });
        let composition = Composition {
            map: &map,
            inside: &inside,
            feather: 4.0,
            gains: &[],
            matrix: None,
            normals: false,
            is_linear: false,
            leaves_out: false,
        };
        let layer = [200_u8; 64];
        let mut values = [100; 64];
        composition.lay(Channels::Grey, false, 0, &layer, &mut values, &[]);
        // Distances are -0.5, 0.5, 1.5, 2.5, 3.5, 4.5 ...
        let weight = |t: f64| t * t * (3.0 - 2.0 * t);
        let wanted =
            [0.5, 1.5, 2.5, 3.5].map(|at| (100.0 + 100.0 * weight(at / 4.0)).round() as u8);
        assert_eq!(values[0], 100);
        assert_eq!(values[1..5], wanted);
        assert_eq!(values[5..7], [200, 200]);

        // A gain of a half with its toe, without a feather: nothing outside, everything inside.
        let gains = vec![[LinearValue::constant(0.5); 3]];
        let composition = Composition {
            map: &map,
            inside: &inside,
            feather: 0.0,
            gains: &gains,
            matrix: None,
            normals: false,
            is_linear: false,
            leaves_out: false,
        };
        let mut values = [80; 64];
        composition.lay(Channels::Grey, false, 0, &layer, &mut values, &[]);
        let toe: f32 = 0.85 * 0.25 * 200.0 / 255.0;
        let level = (100.0 / (1.0 - toe)).round() as u8;
        assert_eq!(values[..3], [80, level, level]);

        // With alpha: coverage is the product of weight and alpha.
        let composition = Composition {
            map: &map,
            inside: &inside,
            feather: 1.0,
            gains: &[],
            matrix: None,
            normals: false,
            is_linear: false,
            leaves_out: false,
        };
        let layer = [1.0_f32, 0.5].repeat(64);
        let mut values = [0.0, 1.0].repeat(64);
        composition.lay(Channels::GreyAlpha, true, 0, &layer, &mut values, &[]);
        assert_eq!(values[..6], [0.0, 1.0, 0.25, 1.0, 0.5, 1.0]);
    }

    /// Runs of any length, at every SIMD level of this machine.
    fn compare<T: Value + std::fmt::Debug, const C: usize>(value: fn(&mut fastrand::Rng) -> T) {
        let mut rng = fastrand::Rng::with_seed(C as u64);
        let map = map();
        for len in [1, 15, 63, 64, 65, 150] {
            for (feather, most) in [(0.5, 1.0), (0.2, 3.0), (1.0, 1.0)] {
                let mut line = |least: f32, most: f32| {
                    let values = [0, 1, 2].map(|_| least + (most - least) * rng.f32());
                    let corners = [[0.0, 0.0], [f64::from(len), 0.0], [0.0, 9.0]];
                    LinearValue::new(corners, values).line(0, 3)
                };
                // Two adjacent runs.
                let runs = [0..len / 3, len / 3..len]
                    .map(|run| (run, line(-0.3, 1.0), [(); 3].map(|()| line(0.4, most))));
                let layer: Vec<T> = (0..len as usize * C).map(|_| value(&mut rng)).collect();
                let base: Vec<T> = (0..len as usize * C).map(|_| value(&mut rng)).collect();
                let labelled = if rng.bool() { len as usize * VALUES } else { 0 };
                let controls: Vec<u8> =
                    (0..labelled).map(|_| *rng.choice(&[0, 255, 100, 254]).unwrap()).collect();
                let composition = Composition {
                    map: &map,
                    inside: &[],
                    feather,
                    gains: &[],
                    matrix: None,
                    normals: false,
                    is_linear: false,
                    leaves_out: true,
                };
                let mut wanted = base.clone();
                for (run, inside, gains) in &runs {
                    for (k, at) in run.clone().enumerate() {
                        let (k, at) = (k as u32, at as usize);
                        let layer = &layer[at * C..][..C];
                        let weight = composition.weight(inside.at(k));
                        let [tone, share] = controls::at(&controls, at);
                        let change = Change { gains: gains.map(|gain| gain.at(k)), tone };
                        let texel = &mut wanted[at * C..][..C];
                        composition.texel::<T, C, false>(layer, weight * share, &change, texel);
                    }
                }
                for level in [Level::new(), Level::baseline()] {
                    let mut found = base.clone();
                    let mut span = Span::default();
                    for (run, inside, gains) in &runs {
                        let columns = run.start as usize..run.end as usize;
                        span.push(columns, Some(*inside), feather, gains);
                    }
                    stretch::lay_span::<T, C>(level, &span, &controls, &layer, &mut found);
                    assert_eq!(found, wanted);
                }
            }
        }
    }

    #[test]
    fn spans_match_single_texels_bit_for_bit() {
        compare::<u8, 1>(|rng| rng.u8(..));
        compare::<u8, 3>(|rng| rng.u8(..));
        compare::<u16, 3>(|rng| rng.u16(..));
        compare::<u16, 4>(|rng| rng.u16(..));
        compare::<f32, 2>(fastrand::Rng::f32);
        compare::<f32, 3>(fastrand::Rng::f32);
    }
}
