//! The skin of both sides in large areas, and the gains that take one to the other.
//!
//! A rim says little about a face: necks are shaded, and captures end in collars. So one gain is found from the cheeks,
//! which both sides have, and the rim only decides on what is left there.

use super::selection::BlendDomain;
use super::tone::{GAINS, toned};
use crate::anatomy::{Anatomy, Area};
use crate::area_colors::{of_area, of_faces, without_outliers};
use crate::color::delta_e;
use crate::labels::{Label, Labels};
use crate::mesh::Mesh;
use crate::skin::SkinModel;
use crate::texture::Texture;

type Rgb = [f32; 3];

/// The skin of a texture where it shows best.
#[derive(Debug, Clone)]
pub(super) struct SkinSample {
    /// Its mean: sRGB as stored, 1.0 for full.
    pub color: Rgb,
    /// Colours of it, those that are far from most left out.
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
    /// Which colours of the base are skin.
    pub model: SkinModel,
    /// Whether the base's cheeks say so; its head is a dummy's if not.
    pub is_of_cheeks: bool,
}

/// Areas of one skin differ less than this, ΔE 2000: a chest is paler and a neck darker than cheeks.
const ALIKE: f64 = 18.0;

/// Nine tenths of a blank face differ by less, ΔE 2000: lips and brows of a face differ by more.
const BLANK: f64 = 5.0;

impl Skins {
    /// Looks at the texture; nothing where it shows no skin in the face.
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
        // Cheeks blush and hands do not.
        let face = if body.is_of_cheeks { face } else { whole().unwrap_or(face) };
        Some(Self { face, body })
    }

    /// The gains of the texture and of the base that take both skins to a colour between them.
    ///
    /// - `share`: how far the texture gives way, from 0 to 1.
    pub fn gains(&self, share: f64) -> [Rgb; 2] {
        let middle = self.middle(share);
        [&self.face, &self.body.skin].map(|skin| skin.gains_to(middle))
    }

    /// The colour between both skins, as their ratios go.
    pub fn middle(&self, share: f64) -> Rgb {
        [0, 1, 2].map(|k| {
            let [face, body] = [self.face.color[k], self.body.skin.color[k]]
                .map(|value| f64::from(value.max(1e-3)));
            (face.ln() * (1.0 - share) + body.ln() * share).exp() as f32
        })
    }
}

impl BodySkin {
    /// Looks at a base; nothing where it shows none.
    pub fn new(domain: &BlendDomain, base: &Texture) -> Option<Self> {
        let (skin, is_of_cheeks) = SkinSample::of_body(domain, base)?;
        let model = SkinModel::new(&skin.samples, &[]).ok()?;
        Some(Self { skin, model, is_of_cheeks })
    }
}

impl SkinSample {
    /// From colours, most of which are skin.
    pub fn new(colors: Vec<Rgb>) -> Option<Self> {
        let samples = without_outliers(colors)?;
        Some(Self { color: mean(&samples), samples })
    }

    /// What a base's own cheeks show, unless all else of its body says otherwise; and whether it is theirs.
    fn of_body(domain: &BlendDomain, base: &Texture) -> Option<(Self, bool)> {
        let mesh = domain.mesh();
        let any = |_| true;
        let Some(anatomy) = domain.anatomy() else {
            // The body's head is where the other one's is.
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
        // A head may be another's, unless all else is clothes.
        let pair = |a: &Option<Self>, b: &Option<Self>| {
            let (a, b) = (a.as_ref()?, b.as_ref()?);
            (delta_e(a.color, b.color) < ALIKE)
                .then(|| Self { samples: [&a.samples[..], &b.samples].concat(), ..b.clone() })
        };
        let is_chest = hands.is_none() && distance(&chest) > ALIKE;
        let of_chest = || if is_chest { pair(&neck, &chest) } else { None };
        other(pair(&neck, &hands).or_else(of_chest)).or(Some((cheeks, true)))
    }

    /// Whether a face shows this colour alone, as a dummy's does.
    fn is_all_of(&self, mesh: &Mesh, anatomy: &Anatomy, base: &Texture) -> bool {
        const FACE: [Area; 5] =
            [Area::Forehead, Area::Nose, Area::Lips, Area::Brows, Area::EyeSockets];
        let found = FACE.map(|area| of_area(mesh, anatomy, area, base, &|_| true)).concat();
        let alike = found.iter().filter(|&&rgb| delta_e(rgb, self.color) < BLANK).count();
        alike * 10 > found.len() * 9
    }

    /// Whether both may be of one person.
    pub fn is_like(&self, other: &Self) -> bool {
        delta_e(self.color, other.color) < ALIKE
    }

    /// The gains after which the mean of its colours is another one.
    pub fn gains_to(&self, color: Rgb) -> Rgb {
        [0, 1, 2].map(|k| {
            let mut gain = 1.0_f32;
            // The shoulder takes some away from highlights, so the gain is found step by step.
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
