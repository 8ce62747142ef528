//! Tone correction from skin to skin: one gain over each side, and a residual at the
//! boundary that fades out near it.

use std::sync::Arc;

use uvgraft_surface::anatomy::Area;
use uvgraft_surface::statistics::ColorMatch;
use uvgraft_surface::threads::map_indices;

use super::report::{ToneReport, lightness};
use super::rim::{Rim, SideColors};
use super::skins::{BodySkin, SkinSample, Skins, mean};
use super::tone::{GAINS, Matrix, gain_between, toned};
use super::toning::{BaseSkin, Recolor, SideRecolors, ToneError};
use super::{Blend, Measure, Tone};
use crate::area_colors;
use crate::color::Encoding;
use crate::color::delta_e;
use crate::labels::{Label, Labels, body_skin};
use crate::sampler::Sampler;
use crate::skin::SkinModel;
use crate::texture::Texture;

type Rgb = [f32; 3];

/// Range of the factor on the contrast between cheeks and chest that the gains leave. Origin not
/// recorded.
const CONTRAST: [f32; 2] = [0.4, 2.5];

/// How one side's colours change everywhere.
#[derive(Debug, Clone, Copy)]
struct Overall {
    matrix: Option<Matrix>,
    gains: Rgb,
}

impl Overall {
    /// The colour after the transform that matches statistics.
    fn matched(&self, rgb: Rgb) -> Rgb {
        self.matrix.map_or(rgb, |matrix| matrix.apply(rgb))
    }

    /// A matched colour after the gains.
    fn toned(&self, rgb: Rgb) -> Rgb {
        [0, 1, 2].map(|k| toned(rgb[k], self.gains[k], 1.0))
    }

    fn apply(&self, rgb: Rgb) -> Rgb {
        self.toned(self.matched(rgb))
    }
}

impl Blend {
    /// Recolours both sides by the skin of large areas and, near the boundary, by what differs
    /// there.
    ///
    /// At each point the log gain is `overall + fade · residual`, with the residual extended
    /// harmonically from the boundary. The boundary alone would spread its shade over the whole
    /// face; without the residual an edge would remain.
    ///
    /// # Errors
    /// [`ToneError`] where one side has no skin.
    pub(super) fn between_skins(
        &self,
        measure: &Measure,
        (source, base): (&Texture, &Texture),
        skins: &Skins,
        labels: &Labels,
        mask: Option<BaseSkin>,
        report: &mut ToneReport,
    ) -> Result<SideRecolors, ToneError> {
        let mut overall = self.overall((source, base), skins, labels)?;
        let chest = mask.as_ref().and_then(|mask| self.chest(base, skins, mask));
        if let Some(chest) = chest {
            overall[1].gains = keeping_contrast(&overall, [&skins.face, &skins.body.skin], &chest);
        }
        let rim = &measure.rim;
        let of_source = rim.source(source, |uv| labels.at_uv(Label::Skin, uv));
        let of_base = rim.base(base, |rgb| skins.body.model.likeness(rgb));
        let residual = self.residual(rim, [&of_source, &of_base], &overall);
        report.lightness = [
            lightness(overall[0].apply(skins.face.color)) - lightness(skins.face.color),
            lightness(overall[1].apply(skins.body.skin.color)) - lightness(skins.body.skin.color),
        ];
        report.clipped = [
            clipped(&skins.face.samples, &overall[0]),
            clipped(&skins.body.skin.samples, &overall[1]),
        ];
        report.boundary_delta_e = residual.as_ref().map(|residual| residual.delta_e);
        let gains = |side: usize| -> Vec<Rgb> {
            if !self.options.membrane {
                return Vec::new();
            }
            let harmonic = residual.as_ref().zip(measure.harmonic.as_ref());
            let mut logs =
                vec![overall[side].gains.map(|gain| f64::from(gain.ln())); self.inside.len()];
            if let Some((residual, harmonic)) = harmonic {
                let given = &residual.log_gains[side];
                let extended = harmonic.extend(given);
                let on_rim =
                    rim.points.iter().zip(given).map(|(&point, &log)| (point as usize, log));
                let beyond =
                    extended.into_iter().enumerate().filter_map(|(point, log)| Some((point, log?)));
                // The extension has no value at the rim, which is given.
                for (point, log) in beyond.chain(on_rim) {
                    let share = self.near_rim(point);
                    for (sum, log) in logs[point].iter_mut().zip(log) {
                        *sum += share * log;
                    }
                }
            }
            let bounds = GAINS.map(|gain| f64::from(gain.ln()));
            let gain = |log: f64| log.clamp(bounds[0], bounds[1]).exp() as f32;
            logs.into_iter().map(|logs| logs.map(gain)).collect()
        };
        let recolor = |side: usize| Recolor { matrix: overall[side].matrix, gains: gains(side) };
        let base = mask.map(|skin| (recolor(1), skin));
        let gives_way = self.options.tone != Tone::Source
            || self.options.membrane && !self.cloth_weight.is_empty();
        let source = gives_way.then(|| recolor(0));
        Ok(SideRecolors { source, base })
    }

    /// How the texture and the base change everywhere.
    fn overall(
        &self,
        (source, base): (&Texture, &Texture),
        skins: &Skins,
        labels: &Labels,
    ) -> Result<[Overall; 2], ToneError> {
        let share = self.options.tone.share();
        if !self.options.match_skin {
            return Ok(skins.gains(share).map(|gains| Overall { matrix: None, gains }));
        }
        let face = self.skin_of_source(source, labels);
        let body = self.skin_of_body(base, &skins.body.model);
        let one_way = |from: &[Rgb], to: &[Rgb], share: f32| {
            if share <= 0.0 || from.is_empty() || to.is_empty() {
                return Ok(Overall { matrix: None, gains: [1.0; 3] });
            }
            // Means of large areas include more than clear skin: all of a face has the shadows of
            // its brows, all of a body its soles.
            let found = ColorMatch::keeping_contrast(from, to)?;
            let matrix = Matrix::matching(&found, from, share);
            Ok::<_, ToneError>(Overall { matrix: Some(matrix), gains: [1.0; 3] })
        };
        let share = share as f32;
        let mut overall = [one_way(&face, &body, share)?, one_way(&body, &face, 1.0 - share)?];
        // Cheeks are made to match, regardless of the means of all skin.
        let common = skins.common(f64::from(share));
        for (overall, skin) in overall.iter_mut().zip([&skins.face, &skins.body.skin]) {
            if let Some(matrix) = overall.matrix {
                let changed: Vec<Rgb> = skin.samples.iter().map(|&rgb| matrix.apply(rgb)).collect();
                let found = mean(&changed);
                overall.gains = [0, 1, 2].map(|k| gain_between(found[k], common[k]));
            }
        }
        Ok(overall)
    }

    /// The skin of the base's chest, if it is bare and the base's cheeks belong to the same person.
    fn chest(&self, base: &Texture, skins: &Skins, mask: &BaseSkin) -> Option<SkinSample> {
        let anatomy = self.domain.anatomy().filter(|_| skins.body.from_cheeks)?;
        let mask = match (&self.skin, mask) {
            (Some(mask), _) => Some(mask),
            (None, BaseSkin::Mask(mask)) => Some(&**mask),
            (None, BaseSkin::Model(_)) => None,
        };
        let is_skin = |uv| mask.is_none_or(|mask| Sampler::new(mask).brightness(uv) >= 0.8);
        let found = area_colors::of_area(self.domain.mesh(), anatomy, Area::Chest, base, &is_skin);
        SkinSample::new(found).filter(|chest| chest.is_like(&skins.body.skin))
    }

    /// How much of the boundary's residual applies at a point: 1 at the boundary, 0 where it has
    /// faded out.
    pub(super) fn near_rim(&self, point: usize) -> f64 {
        let Some(fade) = self.fade else { return 1.0 };
        let t = (f64::from(self.inside[point]).abs() / fade).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    }

    /// The correction that remains at the boundary beyond the overall change, as log gains; `None`
    /// where no skin meets skin.
    ///
    /// Next to cloth the texture takes on all of the base's tone regardless of the options, and the
    /// base keeps its own there.
    fn residual(
        &self,
        rim: &Rim,
        sides: [&SideColors; 2],
        overall: &[Overall; 2],
    ) -> Option<Residual> {
        if rim.points.is_empty() {
            return None;
        }
        let changed = |by: &dyn Fn(usize, Rgb) -> Rgb| {
            [0, 1].map(|side| {
                let change = |&(color, area): &([f64; 3], f64)| {
                    (by(side, color.map(|value| value as f32)).map(f64::from), area)
                };
                sides[side].iter().map(change).collect::<SideColors>()
            })
        };
        let matched = changed(&|side, rgb| overall[side].matched(rgb));
        let share = self.options.tone.share();
        let residual = |side: usize, aim: &dyn Fn(Rgb, Rgb) -> Rgb| -> Option<Vec<[f64; 3]>> {
            // The gain for the whole change, minus the overall one: because of the shoulder, two
            // gains in sequence bend a curve differently from one.
            let found = rim.difference([&matched[side], &matched[1 - side]], None, aim)?;
            let everywhere = overall[side].gains.map(|gain| f64::from(gain.ln()));
            let remaining = |log: &[f64; 3]| [0, 1, 2].map(|k| log[k] - everywhere[k]);
            Some(found.log_gains.iter().map(remaining).collect())
        };
        let by_tone = |side: usize, share: f64| {
            residual(side, &|from, to| [0, 1, 2].map(|k| between(from[k], to[k], share)))
        };
        let mut of_source = by_tone(0, share)?;
        let mut of_base = by_tone(1, 1.0 - share)?;
        if share < 1.0 && !self.cloth_weight.is_empty() {
            let gives_way = residual(0, &|_, to| overall[1].toned(to))?;
            for (index, &point) in rim.points.iter().enumerate() {
                let cloth = f64::from(self.cloth_weight[point as usize]);
                for k in 0..3 {
                    of_source[index][k] += cloth * (gives_way[index][k] - of_source[index][k]);
                    of_base[index][k] *= 1.0 - cloth;
                }
            }
        }
        let toned = changed(&|side, rgb| overall[side].apply(rgb));
        let means = toned.map(|side| {
            let with_color = side.iter().filter(|(_, area)| *area > 0.0);
            mean(&with_color.map(|(rgb, _)| rgb.map(|value| value as f32)).collect::<Vec<_>>())
        });
        Some(Residual { log_gains: [of_source, of_base], delta_e: delta_e(means[0], means[1]) })
    }

    /// The skin of a base, and how it is recognised if the base changes.
    pub(super) fn body_side(&self, base: &Texture) -> Option<(BodySkin, Option<BaseSkin>)> {
        self.domain.head()?;
        let skin = BodySkin::new(&self.domain, base)?;
        let find = || {
            if self.skin.is_some() {
                return BaseSkin::Model(None);
            }
            let model = (!skin.from_cheeks).then_some(&skin.model);
            let mask = self.domain.body().and_then(|body| body_skin(body, base, model).ok());
            mask.map_or(BaseSkin::Model(Some(skin.model)), |mask| BaseSkin::Mask(Arc::new(mask)))
        };
        let mask = (self.options.tone != Tone::Base).then(find);
        Some((skin, mask))
    }

    /// Colours of the texture's skin, over all linked pieces.
    fn skin_of_source(&self, source: &Texture, labels: &Labels) -> Vec<Rgb> {
        let domain = &self.domain;
        let mesh = domain.pair().from(domain.direction());
        let sampler = Sampler::new(source);
        let pieces = domain.pieces().all();
        let found = map_indices(pieces.len(), |index| {
            let uv = domain.centroid(pieces[index], mesh);
            if labels.at_uv(Label::Skin, uv) < 0.8 {
                return None;
            }
            let [r, g, b, alpha] = sampler.rgba_as(uv, Encoding::Srgb);
            (alpha >= 0.5).then_some([r, g, b])
        });
        found.into_iter().flatten().collect()
    }

    /// Colours of the base's skin, over the whole body.
    fn skin_of_body(&self, base: &Texture, model: &SkinModel) -> Vec<Rgb> {
        let mesh = self.domain.mesh();
        let sampler = Sampler::new(base);
        let found = map_indices(mesh.faces().len(), |face| {
            let uv =
                super::along_rim::centroid(uvgraft_surface::piece::wide(mesh.uv_triangle(face)));
            let [r, g, b, alpha] = sampler.rgba_as(uv, Encoding::Srgb);
            (alpha >= 0.5 && model.weight([r, g, b]) > 0.5).then_some([r, g, b])
        });
        found.into_iter().flatten().collect()
    }
}

/// The correction that remains at a boundary.
struct Residual {
    /// For both sides, the logarithms of the gains at the boundary points.
    log_gains: [Vec<[f64; 3]>; 2],
    /// How much both sides differ in mean colour, ΔE 2000.
    delta_e: f64,
}

/// A value between two, interpolated geometrically.
fn between(from: f32, to: f32, share: f64) -> f32 {
    let [from, to] = [from, to].map(|value| f64::from(value.max(1e-3)).ln());
    (from + (to - from) * share).exp() as f32
}

/// The gains of the base after which its chest differs from the cheeks, ΔE 2000, as much as before:
/// gains for another skin would increase or decrease that. The base's own cheeks are hidden by then, so
/// the contrast is measured against the texture's. It is scaled by a factor found by bisection.
///
/// - `cheeks`: those of the texture, and the base's own.
fn keeping_contrast(overall: &[Overall; 2], cheeks: [&SkinSample; 2], chest: &SkinSample) -> Rgb {
    let own = delta_e(cheeks[1].color, chest.color);
    let cheeks = overall[0].apply(cheeks[0].color);
    let toned = mean(&chest.samples.iter().map(|&rgb| overall[1].apply(rgb)).collect::<Vec<_>>());
    let farther =
        |by: f32| [0, 1, 2].map(|k| (cheeks[k] + by * (toned[k] - cheeks[k])).clamp(0.0, 1.0));
    let [mut low, mut high] = CONTRAST;
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if delta_e(cheeks, farther(middle)) < own { low = middle } else { high = middle }
    }
    let matched = chest.samples.iter().map(|&rgb| overall[1].matched(rgb)).collect();
    SkinSample { color: chest.color, samples: matched }.gains_to(farther(low))
}

/// The fraction of colours that newly clip in a channel.
fn clipped(samples: &[Rgb], overall: &Overall) -> f64 {
    const FULL: f32 = 254.5 / 255.0;
    let is_full = |rgb: Rgb| rgb.iter().any(|&value| value >= FULL);
    let count = samples.iter().filter(|&&rgb| !is_full(rgb) && is_full(overall.apply(rgb))).count();
    count as f64 / samples.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAME: Overall = Overall { matrix: None, gains: [1.0; 3] };

    fn plain(color: Rgb) -> SkinSample {
        SkinSample { color, samples: vec![color; 4] }
    }

    /// Doubles all colours, however dark.
    fn doubling() -> Overall {
        let row = |k: usize| [0, 1, 2, 3].map(|column| if column == k { 2.0 } else { 0.0 });
        let matrix = Matrix { rows: [row(0), row(1), row(2)], whole_from: 1e-3 };
        Overall { matrix: Some(matrix), ..SAME }
    }

    #[test]
    fn colours_are_matched_and_then_toned() {
        assert_eq!(SAME.apply([0.2, 0.4, 0.6]), [0.2, 0.4, 0.6]);
        assert_eq!(doubling().apply([0.1, 0.2, 0.3]), [0.2, 0.4, 0.6]);
        let darker = Overall { gains: [0.5, 1.0, 1.0], ..doubling() };
        let found = darker.apply([0.1, 0.2, 0.3]);
        assert!(found[0] < 0.15 && found[1..] == [0.4, 0.6], "{found:?}");
    }

    #[test]
    fn only_colours_that_were_not_full_can_clip() {
        let samples = [[0.6, 0.2, 0.2], [1.0, 0.9, 0.9], [0.2; 3], [0.3; 3]];
        assert_eq!(clipped(&samples, &doubling()), 0.25);
        assert_eq!(clipped(&samples, &SAME), 0.0);
        assert_eq!(clipped(&[], &doubling()), 0.0);
    }

    #[test]
    fn a_chest_differs_from_the_cheeks_as_before() {
        let (face, own) = (plain([0.85, 0.66, 0.55]), plain([0.55, 0.38, 0.3]));
        for chest in [[0.62, 0.45, 0.36], [0.5, 0.34, 0.28]] {
            let before = delta_e(own.color, chest);
            let chest = plain(chest);
            let overall = [SAME, Overall { gains: own.gains_to(face.color), ..SAME }];
            let gains = keeping_contrast(&overall, [&face, &own], &chest);
            let after = delta_e(face.color, Overall { gains, ..SAME }.apply(chest.color));
            assert!((after - before).abs() < 1.0, "{before} before, {after} after");
        }
    }
}
