//! Measures of what is made of photographs.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{Channels, Encoding, Size, Texels, Texture, threads};

use super::shot::Photograph;
use super::subject::{Content, Subject};

/// A texture made of photographs.
#[derive(Debug, Clone, Copy)]
pub struct Found<'a> {
    /// Colours, of the size of the subject's texture.
    pub texture: &'a Texture,
    /// How far each texel is known; from one half on it counts as known.
    pub known: &'a Texture,
}

/// How a texture compares with the true one. Shares are of the known texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// Of the known texels, after one gain per channel in linear space, in decibels.
    pub psnr_db: f64,
    /// The same without the eyeballs.
    pub skin_psnr_db: f64,
    /// The gains.
    pub gains: [f64; 3],
    /// Share of the face's texels seen at less than 60° that are known.
    pub coverage: f64,
    /// Share on hair.
    pub hair: f64,
    /// Share on cloth.
    pub cloth: f64,
    /// Share on glasses.
    pub glasses: f64,
    /// Share that no photograph sees, where it can only show something else.
    pub hidden: f64,
}

impl Judgement {
    /// Compares with what was photographed.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn new(subject: &Subject, photographs: &[Photograph], found: Found<'_>) -> Self {
        let size = subject.texture.size();
        assert_eq!((found.texture.size(), found.known.size()), (size, size));
        let known = found.known_texels(subject);
        let seen = threads::map_indices(known.len(), |texel| {
            let Some(spot) = &subject.spots[texel] else { return [false; 2] };
            let point = DVec3::from(spot.position.map(f64::from));
            let normal = DVec3::from(spot.normal.map(f64::from));
            let sees = |photograph: &&Photograph| photograph.sees(point, normal);
            let mut seeing = photographs.iter().filter(sees).peekable();
            let is_seen = seeing.peek().is_some();
            let cosine =
                |from: &Photograph| (from.camera.eye() - point).normalize().dot(normal) > 0.5;
            [is_seen, seeing.any(cosine)]
        });
        let share = |is_counted: &dyn Fn(usize) -> bool, is_of: &dyn Fn(usize) -> bool| {
            let all = (0..known.len()).filter(|&texel| is_of(texel));
            let (mut count, mut counted) = (0_u32, 0_u32);
            for texel in all {
                count += 1;
                counted += u32::from(is_counted(texel));
            }
            f64::from(counted) / f64::from(count.max(1))
        };
        let is_known = |texel: usize| known[texel];
        let of = |content| share(&|texel| subject.content[texel] == content, &is_known);
        let is_clear = |texel: usize| subject.content[texel] == Content::Face && seen[texel][1];
        let gains = found.gains(subject, &known);
        let skin: Vec<bool> =
            (0..known.len()).map(|texel| known[texel] && !subject.is_eye[texel]).collect();
        Self {
            psnr_db: found.psnr(subject, &known, gains),
            skin_psnr_db: found.psnr(subject, &skin, gains),
            gains,
            coverage: share(&is_known, &is_clear),
            hair: of(Content::Hair),
            cloth: of(Content::Cloth),
            glasses: of(Content::Glasses),
            hidden: share(&|texel| !seen[texel][0], &is_known),
        }
    }

    /// Share of what is known but does not belong to a face.
    pub fn foreign(&self) -> f64 {
        self.hair + self.cloth + self.glasses + self.hidden
    }
}

impl Found<'_> {
    /// `[texels]`: whether each counts as known. Outside the layout none does.
    pub fn known_texels(&self, subject: &Subject) -> Vec<bool> {
        let size = self.known.size();
        let value = |texel: usize| at(self.known, size, texel, 0);
        let is_known = |texel: usize| subject.spots[texel].is_some() && value(texel) >= 0.5;
        (0..size.texels()).map(is_known).collect()
    }

    /// Factors that bring the found colours closest to the true ones in linear space.
    fn gains(&self, subject: &Subject, known: &[bool]) -> [f64; 3] {
        let size = subject.texture.size();
        [0, 1, 2].map(|channel| {
            let (mut products, mut squares) = (0.0, f64::MIN_POSITIVE);
            for texel in (0..known.len()).filter(|&texel| known[texel]) {
                let linear = |from| f64::from(linear_from_srgb(at(from, size, texel, channel)));
                let (found, truth) = (linear(self.texture), linear(&subject.texture));
                products += found * truth;
                squares += found * found;
            }
            products / squares
        })
    }

    fn psnr(&self, subject: &Subject, known: &[bool], gains: [f64; 3]) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for texel in (0..known.len()).filter(|&texel| known[texel]) {
            for difference in self.differences(subject, texel, gains) {
                sum += difference * difference;
                count += 1.0;
            }
        }
        -10.0 * (sum / f64::max(count, 1.0)).max(1e-12).log10()
    }

    /// Found minus true colour, sRGB.
    fn differences(&self, subject: &Subject, texel: usize, gains: [f64; 3]) -> [f64; 3] {
        let size = subject.texture.size();
        [0, 1, 2].map(|k| {
            let found = f64::from(linear_from_srgb(at(self.texture, size, texel, k))) * gains[k];
            let found = f64::from(srgb_from_linear(found as f32)).clamp(0.0, 1.0);
            found - f64::from(at(&subject.texture, size, texel, k))
        })
    }
}

/// The differences from the true texture, five times as large around grey; dark where nothing is
/// known, red where what is known does not belong to a face.
pub fn error_map(subject: &Subject, found: Found<'_>) -> Texture {
    let known = found.known_texels(subject);
    let gains = found.gains(subject, &known);
    let texel = |texel: usize| match (known[texel], subject.content[texel]) {
        (false, _) => [24; 3],
        (true, Content::Face) => found
            .differences(subject, texel, gains)
            .map(|difference| (128.0 + 5.0 * 255.0 * difference).clamp(0.0, 255.0) as u8),
        (true, _) => [255, 0, 0],
    };
    let size = subject.texture.size();
    let texels = threads::map_indices(size.texels(), texel).into_flattened();
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
        .expect("as many values as texels")
}

/// How far a camera's rotation is off, as a rotation vector in degrees: about the picture's
/// horizontal axis, its vertical axis and the line of sight.
pub fn pose_error_degrees(found: DMat3, truth: DMat3) -> DVec3 {
    let (axis, angle) = DQuat::from_mat3(&(found * truth.transpose())).to_axis_angle();
    // The shorter way round.
    let angle = if angle > PI { angle - TAU } else { angle };
    axis * angle.to_degrees()
}

/// The median distance between landmarks found in a photograph and where the photograph shows those
/// of the head, in millimetres at their distances from the camera.
///
/// - `points`: on the head, in metres.
/// - `images`: in pixels.
pub fn landmark_error_mm(
    photograph: &Photograph,
    points: impl IntoIterator<Item = DVec3>,
    images: impl IntoIterator<Item = [f64; 2]>,
) -> f64 {
    let error = |(point, [x, y]): (DVec3, [f64; 2])| {
        let [wanted_x, wanted_y, depth] = photograph.camera.project(point);
        let px = (x - wanted_x).hypot(y - wanted_y);
        1000.0 * px * depth / photograph.camera.focal_px
    };
    let mut errors: Vec<f64> = points.into_iter().zip(images).map(error).collect();
    let middle = errors.len() / 2;
    if errors.is_empty() {
        f64::NAN
    } else {
        *errors.select_nth_unstable_by(middle, f64::total_cmp).1
    }
}

fn at(texture: &Texture, size: Size, texel: usize, channel: usize) -> f32 {
    texture.get(texel as u32 % size.width, texel as u32 / size.width, channel)
}
