//! The skin of both sides, sampled over large areas, and the gains that map one to the other.
//!
//! The boundary says little about a face: necks are shaded, and captures end in collars. So one
//! gain comes from the cheeks, which both sides have, and the boundary only decides on the
//! remaining correction there.

use uvgraft_surface::anatomy::{Anatomy, Area};
use uvgraft_surface::mesh::Mesh;

use super::selection::BlendDomain;
use super::tone::{GAINS, toned};
use crate::area_colors::{of_area, of_faces, without_outliers};
use crate::color::delta_e;
use crate::labels::{Label, Labels};
use crate::skin::SkinModel;
use crate::texture::Texture;

type Rgb = [f32; 3];

/// The skin of a texture, sampled where it shows best.
#[derive(Debug, Clone)]
pub(super) struct SkinSample {
    /// Mean colour: stored sRGB, 1.0 is full intensity.
    pub color: Rgb,
    /// The sampled colours, without outliers.
    pub samples: Vec<Rgb>,
}

/// The skin of a texture and of its base.
#[derive(Debug, Clone)]
pub(super) struct Skins {
    pub face: SkinSample,
    pub body: BodySkin,
}

/// The skin of a base.
#[derive(Debug, Clone)]
pub(super) struct BodySkin {
    pub skin: SkinSample,
    /// Model of the base's skin colours.
    pub model: SkinModel,
    /// Whether the sample comes from the base's own cheeks; if not, its head is taken for a
    /// dummy's.
    pub from_cheeks: bool,
}

/// Areas of one person's skin differ by less than this, ΔE 2000: a chest is paler and a neck darker
/// than cheeks. The value's origin is not recorded.
const ALIKE: f64 = 18.0;

/// Nine tenths of a blank face differ from its cheeks by less than this, ΔE 2000; the lips and
/// brows of a real face differ by more. The value's origin is not recorded.
const BLANK: f64 = 5.0;

impl Skins {
    /// Samples the texture; `None` if it shows no skin in the face.
    pub fn new(
        domain: &BlendDomain,
        source: &Texture,
        labels: &Labels,
        body: BodySkin,
    ) -> Option<Self> {
        let head = domain.head()?;
        let read = domain.pair().from(domain.direction());
        let is_skin = |uv| labels.at_uv(Label::Skin, uv) >= 0.8;
        let of = |area| of_area(read, &head.anatomy, area, source, &is_skin);
        let of_face = |area| SkinSample::new(of(area));
        // A beard or a mask may hide the cheeks.
        let face = of_face(Area::Cheeks)
            .or_else(|| of_face(Area::Nose))
            .or_else(|| of_face(Area::Forehead))?;
        let whole = || {
            SkinSample::new([Area::Cheeks, Area::Nose, Area::Forehead, Area::Jaw].map(of).concat())
        };
        // Cheeks blush but hands do not, so other skin than cheeks is compared with the whole face.
        let face = if body.from_cheeks { face } else { whole().unwrap_or(face) };
        Some(Self { face, body })
    }

    /// The gains of the texture and of the base that map both skins to a common colour.
    ///
    /// - `share`: how far the texture moves towards the base, 0 to 1.
    pub fn gains(&self, share: f64) -> [Rgb; 2] {
        let common = self.common(share);
        [&self.face, &self.body.skin].map(|skin| skin.gains_to(common))
    }

    /// The common colour, interpolated geometrically: `face^(1 - share) · body^share` per channel.
    pub fn common(&self, share: f64) -> Rgb {
        [0, 1, 2].map(|k| {
            let [face, body] = [self.face.color[k], self.body.skin.color[k]]
                .map(|value| f64::from(value.max(1e-3)));
            (face.ln() * (1.0 - share) + body.ln() * share).exp() as f32
        })
    }
}

impl BodySkin {
    /// Samples a base; `None` if it shows no skin.
    pub fn new(domain: &BlendDomain, base: &Texture) -> Option<Self> {
        let (skin, from_cheeks) = SkinSample::of_body(domain, base)?;
        let model = SkinModel::new(&skin.samples, &[]).ok()?;
        Some(Self { skin, model, from_cheeks })
    }
}

impl SkinSample {
    /// From colours most of which are skin; `None` if there are too few.
    pub fn new(colors: Vec<Rgb>) -> Option<Self> {
        let samples = without_outliers(colors)?;
        Some(Self { color: mean(&samples), samples })
    }

    /// The skin of a base, and whether it comes from the base's own cheeks.
    ///
    /// The cheeks are used unless the rest of the body contradicts them: a dummy's blank head, or a
    /// head of another tone than neck and hands, would give the body a tone that is not its own.
    fn of_body(domain: &BlendDomain, base: &Texture) -> Option<(Self, bool)> {
        let mesh = domain.mesh();
        let any = |_| true;
        let Some(anatomy) = domain.anatomy() else {
            // Without an anatomy, the body's head lies where the source's head is linked to.
            let head = domain.head()?;
            let cheeks = |face: usize, weights| {
                let piece = domain.pieces().at(face, weights)?;
                let read = domain.pair().from(domain.direction());
                let corners = read.faces()[piece.from as usize];
                let cheeks = head.anatomy.area(Area::Cheeks);
                Some(corners.iter().map(|&vertex| cheeks[vertex as usize]).sum::<f32>() / 3.0)
            };
            let all: Vec<usize> = (0..mesh.faces().len()).collect();
            let found = of_faces(mesh, base, &all, |face, weights, _| {
                cheeks(face, weights).is_some_and(|cheeks| cheeks >= 0.5)
            });
            return Some((Self::new(found)?, true));
        };
        let of = |area| Self::new(of_area(mesh, anatomy, area, base, &any));
        let [cheeks, neck, chest, hands] =
            [Area::Cheeks, Area::Neck, Area::Chest, Area::Hands].map(of);
        let other = |found: Option<Self>| Some((found?, false));
        let Some(cheeks) = cheeks else { return other(neck.or(chest).or(hands)) };
        let distance = |other: &Option<Self>| {
            other.as_ref().map_or(f64::INFINITY, |other| delta_e(cheeks.color, other.color))
        };
        if distance(&neck) > BLANK && neck.is_some() && cheeks.is_all_of(mesh, anatomy, base) {
            return other(hands.or(neck));
        }
        if distance(&neck) < ALIKE || distance(&hands) < ALIKE {
            return Some((cheeks, true));
        }
        // The head may be another person's, unless everything else is clothes.
        let pair = |a: &Option<Self>, b: &Option<Self>| {
            let (a, b) = (a.as_ref()?, b.as_ref()?);
            (delta_e(a.color, b.color) < ALIKE)
                .then(|| Self { samples: [&a.samples[..], &b.samples].concat(), ..b.clone() })
        };
        let is_chest = hands.is_none() && distance(&chest) > ALIKE;
        let of_chest = || if is_chest { pair(&neck, &chest) } else { None };
        other(pair(&neck, &hands).or_else(of_chest)).or(Some((cheeks, true)))
    }

    /// Whether the face shows this colour alone, as a dummy's does.
    fn is_all_of(&self, mesh: &Mesh, anatomy: &Anatomy, base: &Texture) -> bool {
        const FACE: [Area; 5] =
            [Area::Forehead, Area::Nose, Area::Lips, Area::Brows, Area::EyeSockets];
        let found = FACE.map(|area| of_area(mesh, anatomy, area, base, &|_| true)).concat();
        let alike = found.iter().filter(|&&rgb| delta_e(rgb, self.color) < BLANK).count();
        alike * 10 > found.len() * 9
    }

    /// Whether both may belong to one person.
    pub fn is_like(&self, other: &Self) -> bool {
        delta_e(self.color, other.color) < ALIKE
    }

    /// The gains that give the samples another mean colour.
    pub fn gains_to(&self, color: Rgb) -> Rgb {
        [0, 1, 2].map(|k| {
            let mut gain = 1.0_f32;
            // The shoulder takes some of the gain away from highlights, so the gain is found by
            // iteration.
            for _ in 0..12 {
                let sum: f64 =
                    self.samples.iter().map(|rgb| f64::from(toned(rgb[k], gain, 1.0))).sum();
                let now = (sum / self.samples.len() as f64) as f32;
                gain = (gain * (color[k].max(1e-3) / now.max(1e-3))).clamp(GAINS[0], GAINS[1]);
            }
            gain
        })
    }
}

pub(super) fn mean(colors: &[Rgb]) -> Rgb {
    let sum = |k: usize| colors.iter().map(|rgb| f64::from(rgb[k])).sum::<f64>();
    [0, 1, 2].map(|k| (sum(k) / colors.len() as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skins_are_alike_whatever_the_area_but_not_whatever_the_person() {
        let sample = |color| SkinSample { color, samples: vec![color] };
        let cheeks = sample([0.78, 0.6, 0.51]);
        for (other, is_like) in [
            ([0.78, 0.6, 0.51], true),
            ([0.85, 0.7, 0.62], true),
            ([0.68, 0.5, 0.41], true),
            ([0.36, 0.24, 0.18], false),
            ([0.2, 0.35, 0.7], false),
        ] {
            assert_eq!(cheeks.is_like(&sample(other)), is_like, "{other:?}");
        }
        assert_eq!(mean(&[[0.25, 0.5, 0.0], [0.75, 0.5, 1.0]]), [0.5; 3]);
    }

    #[test]
    fn gains_reach_a_colour_or_their_limit() {
        let sample = SkinSample { color: [0.5; 3], samples: vec![[0.4; 3], [0.6; 3]] };
        let gains = sample.gains_to([0.4, 0.5, 0.6]);
        for (gain, wanted) in gains.into_iter().zip([0.4, 0.5, 0.6]) {
            let found = (toned(0.4, gain, 1.0) + toned(0.6, gain, 1.0)) / 2.0;
            assert!((found - wanted).abs() < 1e-3, "{found}, wanted {wanted}");
        }
        assert_eq!(sample.gains_to([0.0; 3]), [GAINS[0]; 3]);
    }
}
