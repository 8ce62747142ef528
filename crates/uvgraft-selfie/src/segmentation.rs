//! What of a photograph on a head's layout is the face: not hair, cloth, glasses, the inside of the
//! mouth or the background.
//!
//! Where a texel lies decides first: cheeks and nose are the face unless their colour is far from
//! skin; ears, forehead and neck are it only where their colour is nearer to skin than to the hair
//! that is seen on the scalp. The parts that landmarks outline (brows, eyes, lips) are what they
//! are, whatever their colour.
//!
//! Limits here, in `color_model` and in `projection` were halved and doubled, one at a time, on
//! five photographs of `selfie_report` (front, dark skin, fringe, glasses, collar) with their true
//! cameras and shape: PSNR is that of what is known, and known a share of the face.

use glam::Vec3;
use uvgraft::color::lab;
use uvgraft::easing::smoothstep;
use uvgraft::statistics::median_color;
use uvgraft::threads::map_indices;
use uvgraft::{Area, Label, Labels};

use crate::color_model::ColorModel;
use crate::head::Head;
use crate::layout_texels::LayoutTexels;
use crate::outline::FaceOutlines;
use crate::raster::blurred;

/// What is known of the texels of a photograph.
pub(crate) struct Evidence<'a> {
    pub head: &'a Head,
    pub texels: &'a LayoutTexels,
    /// `[texels]`, sRGB, 1.0 for white, with the light taken out as far as possible.
    pub colors: &'a [[f32; 3]],
    /// `[texels]`: how well each is seen, 0 to 1.
    pub seen: &'a [f32],
    /// `[texels]`: the cosine between normal and line of sight.
    pub facing: &'a [f32],
    /// `[texels]`: where in the photograph it is seen, in pixels.
    pub px: &'a [[f32; 2]],
    pub outlines: &'a FaceOutlines,
    /// Distance between the eyes in the photograph, in pixels.
    pub unit_px: f64,
    pub labels: Option<&'a Labels>,
    /// `[vertices]`: height above the eyes, in distances between them.
    pub heights: &'a [f32],
}

/// The result.
pub(crate) struct Segmentation {
    /// `[texels]`: how far each is the face, 0 to 1.
    pub face: Vec<f32>,
    /// The colour on the scalp, hair or skin, if it is seen.
    pub scalp: Option<[f32; 3]>,
}

/// A brow in a photograph.
struct Brow {
    /// Whether there is skin between it and the hair, 0 to 1. A fringe that covers it looks like it.
    bare: f32,
    /// CIELAB.
    color: [f32; 3],
    /// How much darker it may be elsewhere, as a share of its contrast with skin.
    darker: f32,
}

impl Brow {
    /// How far a colour may be the brow's with skin between its hairs, 0 to 1. Rims of glasses, which can
    /// be as dark, mostly have another.
    fn has(&self, color: [f32; 3], skin: &ColorModel) -> f32 {
        /// Distances in CIELAB. Halved, 3 % less of the dark face is known; doubled, the one with
        /// glasses gains 0.8 dB.
        const NEAR: [f32; 2] = [7.0, 12.0];
        let [color, from, to] = [lab(color), self.color, lab(skin.color)].map(Vec3::from);
        let along = (color - from).dot(to - from) / (to - from).length_squared().max(1.0);
        let nearest = from + (to - from) * along.clamp(-self.darker, 1.0);
        1.0 - smoothstep(NEAR[0], NEAR[1], color.distance(nearest))
    }
}

/// Distances from skin, in standard deviations, up to which texels are skin: where skin is certain
/// by place, and elsewhere; and those at which they are not. Halved, the first makes 1.6 % less
/// known, 0.3 dB better; doubled, 3.8 % of what is known is glasses. The second, halved, makes 12 %
/// less known, and PSNR falls by 3 dB; doubled, 0.9 % more, nearly as well.
const CERTAIN: [f32; 2] = [4.5, 7.0];
const DOUBTFUL: [f32; 2] = [1.9, 2.9];

impl Evidence<'_> {
    /// Separates the face from everything else.
    pub fn segment(&self) -> Segmentation {
        let skin = ColorModel::new(&self.samples(&[Area::Cheeks, Area::Nose], 0.6, 0.5));
        let on_scalp = ColorModel::new(&self.samples(&[Area::Scalp], 0.9, 0.35));
        let size = self.texels.size();
        let scalp = on_scalp.as_ref().map(|model| model.color);
        let Some(skin) = skin else {
            return Segmentation { face: self.seen.to_vec(), scalp };
        };
        // A bald head's scalp is no hair.
        let hair = on_scalp.filter(|hair| skin.distance(hair.color) > 2.5);
        let brows = self.brows(&skin, hair.as_ref());
        let raw = map_indices(size.texels(), |texel| {
            // Where nothing is seen there is nothing to keep away from.
            if self.seen[texel] > 0.0 {
                self.share(texel, &skin, hair.as_ref(), &brows)
            } else {
                [1.0; 2]
            }
        });
        // What is beside hair or cloth is mixed with it, and edges must not show.
        let radius = (size.width.max(size.height) as usize / 250).max(1);
        let around = blurred(size, &raw, radius);
        let face = raw.iter().zip(around);
        let face = face.map(|(raw, around)| raw[0] * smoothstep(0.7, 1.0, around[1])).collect();
        Segmentation { face, scalp }
    }

    /// How the brows look.
    fn brows(&self, skin: &ColorModel, hair: Option<&ColorModel>) -> [Brow; 2] {
        /// How far above the brow one looks, in distances between the eyes. Origin not recorded.
        const ABOVE: f64 = 0.22;
        const STEP: usize = 5;
        /// Skin that is lighter than the brow by less tells nothing, in L* of CIELAB. Origin not
        /// recorded.
        const CONTRAST: f32 = 10.0;
        /// Where hairs are dense they are darker than within the landmarks, by this share of the
        /// contrast. Origin not recorded.
        const DARKER: f32 = 0.7;
        let [up_x, up_y] = self.outlines.up;
        let shift = ABOVE * self.unit_px;
        let seen = || (0..self.seen.len()).step_by(STEP).filter(|&texel| self.seen[texel] > 0.3);
        let darker = DARKER * (1.0 - self.glasses(skin));
        [0, 1].map(|side| {
            let is_in = |[x, y]: [f64; 2]| self.outlines.brows[side].depth([x, y], 1.0) > 0.0;
            let (mut brow, mut above) = (Vec::new(), Vec::new());
            for texel in seen() {
                let [x, y] = self.px[texel].map(f64::from);
                if is_in([x, y]) {
                    brow.push(self.colors[texel]);
                }
                if is_in([x - shift * up_x, y - shift * up_y]) {
                    above.push(self.colors[texel]);
                }
            }
            // Between the hairs is skin, and landmarks are not exact: the dark half is the brow.
            brow.sort_by(|a, b| lightness(*a).total_cmp(&lightness(*b)));
            brow.truncate(brow.len().div_ceil(2));
            let color = median_color(brow).unwrap_or(skin.color);
            let dark = lightness(color);
            let contrast = lightness(skin.color) - dark;
            // Skin of any colour, by the light on it, is lighter than brows and unlike hair.
            let is_bare = |color: &[f32; 3]| {
                let distance = skin.distance(*color) as f32;
                let near = 1.0 - smoothstep(DOUBTFUL[0], DOUBTFUL[1], distance);
                let is_light = contrast > CONTRAST;
                let light = if is_light { (lightness(*color) - dark) / contrast } else { 0.0 };
                near.max(smoothstep(0.4, 0.7, light) * unlike(hair, *color, distance))
            };
            let count = above.len().max(1) as f32;
            let share = above.iter().map(is_bare).sum::<f32>() / count;
            let bare = if above.is_empty() { 1.0 } else { smoothstep(0.4, 0.7, share) };
            Brow { bare, color: lab(color), darker }
        })
    }

    /// Whether there are glasses, 0 to 1, whose rims are as dark as brows: they are seen below the eyes, too.
    fn glasses(&self, skin: &ColorModel) -> f32 {
        /// The height at which one looks, in distances between the eyes. Origin not recorded.
        const BELOW: [f32; 2] = [-0.5, -0.12];
        /// Shares of it that are dark, without glasses and with them. Flat halved; doubled, the
        /// face with glasses gains 0.3 dB.
        const DARK: [f32; 2] = [0.03, 0.09];
        const STEP: usize = 7;
        let is_below = |&texel: &usize| {
            self.seen[texel] > 0.3
                && self.facing[texel] > 0.4
                && (BELOW[0]..BELOW[1]).contains(&self.height(texel))
                && self.at(Area::Ears, texel) < 0.1
                && self.outlined_eye(texel) <= 0.0
        };
        let (mut dark, mut count) = (0.0_f32, 0.0_f32);
        for texel in (0..self.seen.len()).step_by(STEP).filter(is_below) {
            let color = self.colors[texel];
            let is_dark = lightness(color) < lightness(skin.color);
            count += 1.0;
            if is_dark && skin.distance(color) > f64::from(CERTAIN[1]) {
                dark += 1.0;
            }
        }
        smoothstep(DARK[0], DARK[1], dark / count.max(1.0))
    }

    /// How far a texel is in or near an eye, 0 to 1.
    fn outlined_eye(&self, texel: usize) -> f32 {
        let px = self.px[texel].map(f64::from);
        let depth = |side: usize| self.outlines.eyes[side].depth(px, 0.1 * self.unit_px);
        smoothstep(-0.05, 0.0, (depth(0).max(depth(1)) / self.unit_px) as f32)
    }

    /// How far a texel is the face; and the same if what is between the lips were.
    ///
    /// - `brows`: of [`Evidence::brows`].
    fn share(
        &self,
        texel: usize,
        skin: &ColorModel,
        hair: Option<&ColorModel>,
        brows: &[Brow; 2],
    ) -> [f32; 2] {
        let px = self.px[texel].map(f64::from);
        let unit = self.unit_px;
        let depth = |outline: &crate::outline::Outline, reach: f64| {
            (outline.depth(px, reach * unit) / unit) as f32
        };
        // Teeth and the dark between the lips.
        let opening = smoothstep(-0.015, 0.01, depth(&self.outlines.mouth, 0.1));
        if opening >= 1.0 {
            return [0.0, 1.0];
        }
        let inside = self.at(Area::MouthInterior, texel);
        let color = self.colors[texel];
        let distance = skin.distance(color) as f32;
        // Brows are often broader than their landmarks, and what lies beyond the face's edge is not they.
        let ahead = smoothstep(0.3, 0.5, self.facing[texel]);
        let brow = |side: usize| {
            let depth = depth(&self.outlines.brows[side], 0.2);
            let near = ahead * smoothstep(-0.19, -0.12, depth);
            let spread = if near > 0.0 { near * brows[side].has(color, skin) } else { 0.0 };
            brows[side].bare * smoothstep(-0.06, 0.0, depth).max(spread)
        };
        let outlined = [
            smoothstep(-0.06, 0.0, depth(&self.outlines.lips, 0.1)),
            brow(0),
            brow(1),
            self.outlined_eye(texel),
        ];
        let outlined = outlined.into_iter().fold(0.0, f32::max);
        let certain = [Area::Cheeks, Area::Nose, Area::EyeSockets, Area::Jaw, Area::Lips]
            .into_iter()
            .map(|area| self.at(area, texel))
            .fold(0.0, f32::max);
        // Within the face and not above the brows, where fringes are.
        let within = smoothstep(0.08, 0.3, depth(&self.outlines.oval, 0.3));
        let below_brows = 1.0 - smoothstep(0.1, 0.3, self.height(texel));
        let certain = certain.max(within * below_brows);
        let scalp = self.at(Area::Scalp, texel);
        let is_near = |[near, far]: [f32; 2]| 1.0 - smoothstep(near, far, distance);
        // Beards and shadows are the face.
        let by_place = is_near(CERTAIN).max(smoothstep(0.5, 0.9, self.at(Area::Jaw, texel)));
        let like_skin = unlike(hair, color, distance);
        // Behind ears is hair, and on them its shadow.
        let ears = self.at(Area::Ears, texel);
        let by_color = is_near(DOUBTFUL.map(|limit| limit * (1.0 - 0.25 * ears)));
        // From the front ears are thin lines beside hair.
        let glimpsed = ears * (1.0 - smoothstep(0.4, 0.7, self.facing[texel]));
        let by_color =
            by_color * (1.0 - glimpsed) * like_skin * (1.0 - smoothstep(0.1, 0.4, scalp));
        let by_label = self.labels.map_or(1.0, |labels| {
            let uv = self.uv(texel);
            let other = labels.at_uv(Label::Cloth, uv).max(labels.at_uv(Label::Hair, uv));
            1.0 - smoothstep(0.2, 0.6, other)
        });
        let by_color = by_color * by_label;
        let certain = smoothstep(0.3, 0.8, certain);
        let share = by_color + (by_place - by_color) * certain;
        let share = share.max(outlined);
        [share * (1.0 - opening) * (1.0 - smoothstep(0.3, 0.7, inside)), share]
    }

    /// Height of a texel above the eyes, in distances between them.
    fn height(&self, texel: usize) -> f32 {
        let Some(place) = self.texels.place(texel) else { return 0.0 };
        let corners = self.head.mesh.faces()[place.face as usize];
        (0..3).map(|k| place.weights[k] as f32 * self.heights[corners[k] as usize]).sum()
    }

    fn uv(&self, texel: usize) -> [f64; 2] {
        let size = self.texels.size();
        let width = size.width as usize;
        [
            ((texel % width) as f64 + 0.5) / f64::from(size.width),
            ((texel / width) as f64 + 0.5) / f64::from(size.height),
        ]
    }

    /// An area's weight at a texel.
    fn at(&self, area: Area, texel: usize) -> f32 {
        let Some(place) = self.texels.place(texel) else { return 0.0 };
        let weights = self.head.anatomy.area(area);
        let corners = self.head.mesh.faces()[place.face as usize];
        (0..3).map(|k| place.weights[k] as f32 * weights[corners[k] as usize]).sum()
    }

    /// Colours where one of some areas is certain and seen well.
    fn samples(&self, areas: &[Area], certain: f32, seen: f32) -> Vec<[f32; 3]> {
        const MOST: usize = 6000;
        let faces: Vec<bool> = self
            .head
            .mesh
            .faces()
            .iter()
            .map(|face| {
                areas.iter().any(|&area| {
                    let weights = self.head.anatomy.area(area);
                    face.iter().all(|&vertex| weights[vertex as usize] >= certain)
                })
            })
            .collect();
        let is_sample = |&texel: &usize| {
            self.seen[texel] >= seen
                && self.texels.face(texel).is_some_and(|face| faces[face as usize])
        };
        let found: Vec<usize> = (0..self.seen.len()).filter(is_sample).collect();
        let step = found.len().div_ceil(MOST).max(1);
        found.into_iter().step_by(step).map(|texel| self.colors[texel]).collect()
    }
}

/// How much nearer a colour is to skin than to hair, 0 to 1.
///
/// - `distance`: from skin.
fn unlike(hair: Option<&ColorModel>, color: [f32; 3], distance: f32) -> f32 {
    // Halved, 5.5 % more of the dark face is known, doubled 3.7 % less; others do not change.
    hair.map_or(1.0, |hair| smoothstep(0.3, 1.8, hair.distance(color) as f32 - distance))
}

/// L* of CIELAB.
fn lightness(color: [f32; 3]) -> f32 {
    lab(color)[0]
}
