//! Whether a transferred face matches the skin tone of its body.
//!
//! Seams do not show this: a blend that carries the tone across the boundary hides it, whatever
//! colour the cheeks have.

use palette::white_point::D65;
use palette::{FromColor, Lab, Srgb};
use uvgraft::anatomy::{Anatomy, Area};
use uvgraft::area_colors::{of_area as colors_of, without_outliers};
use uvgraft::color::Encoding;
use uvgraft::color::delta_e;
use uvgraft::map::{MapOptions, Run, SamplingMap};
use uvgraft::mesh::Mesh;
use uvgraft::statistics::median;
use uvgraft::texture::Texture;
use uvgraft::threads::map_indices;

use super::pasted::TransferredFace;
use super::sample::texel;
use super::{SeamError, check_region};

type Rgb = [f32; 3];

/// Mean skin colours in the face and below it: sRGB, 1.0 at full intensity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinColors {
    /// Mean colour of the cheeks.
    pub cheeks: [f32; 3],
    /// Mean colour of the chest, or of the neck if there is no chest.
    pub chest: [f32; 3],
    /// The source of `chest`: [`Area::Chest`] or [`Area::Neck`].
    pub chest_area: Area,
}

/// Reference textures for a tone measurement. All are optional; each allows further results.
#[derive(Debug, Clone, Copy, Default)]
pub struct ToneReferences<'a> {
    /// The base before the transfer, in the layout and size of the texture.
    pub base: Option<&'a Texture>,
    /// The face before blending, transferred to the size of the texture.
    pub face: Option<&'a TransferredFace>,
}

/// How well the tone of a transferred face matches the body; from [`measure_tone`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ToneMatch {
    /// Skin colours of the texture; `None` if the cheeks, or both chest and neck, have no colour.
    pub skin: Option<SkinColors>,
    /// Skin colours of the base; `None` without one.
    pub own: Option<SkinColors>,
    /// Median difference (CIEDE2000) of hair and brows from the original face; `None` without a
    /// face, or if no hair is labelled in it.
    pub hair_shift: Option<f64>,
    /// The fraction of the transferred skin, `0.0..=1.0`, with a saturated channel that was not
    /// saturated in the face. Without a face, the fraction of all transferred texels with a
    /// saturated channel. `None` if nothing is transferred.
    pub clipped: Option<f64>,
}

/// Labels with a smaller weight are not trusted.
const CERTAIN: f32 = 0.8;
/// Values from here on are stored as 255 in 8 bits.
const FULL: f32 = 254.5 / 255.0;

impl SkinColors {
    /// Measures the skin of a texture: means in CIELAB after removing outliers from the median,
    /// over four samples of each triangle. `None` if there are too few.
    ///
    /// - `mesh`, `anatomy`: the anatomy must be that of the mesh.
    /// - `texture`: of any size; colours with alpha below one half are ignored.
    ///
    /// # Panics
    /// If the anatomy refers to more vertices than the mesh has.
    pub fn of(mesh: &Mesh, anatomy: &Anatomy, texture: &Texture) -> Option<Self> {
        let of_area =
            |area| mean(&without_outliers(colors_of(mesh, anatomy, area, texture, &|_| true))?);
        let cheeks = of_area(Area::Cheeks)?;
        let (chest, chest_area) = [Area::Chest, Area::Neck]
            .into_iter()
            .find_map(|area| of_area(area).map(|color| (color, area)))?;
        Some(Self { cheeks, chest, chest_area })
    }

    /// The perceptual difference of the two (CIEDE2000).
    pub fn delta_e(&self) -> f64 {
        delta_e(self.cheeks, self.chest)
    }
}

impl ToneMatch {
    /// The largest magnitude of [`ToneMatch::excess`] at which the face matches the body's tone.
    pub const MAX_EXCESS: f64 = 4.0;
    /// The largest clipped fraction of the transferred skin that is not visible.
    pub const MAX_CLIPPED: f64 = 0.01;

    /// How much more cheeks and chest differ than in the base (CIEDE2000); negative if
    /// they differ less.
    pub fn excess(&self) -> Option<f64> {
        Some(self.skin?.delta_e() - self.own?.delta_e())
    }

    /// Whether cheeks and chest differ about as much as in the base; true if that is unknown.
    pub fn matches_body(&self) -> bool {
        self.excess().is_none_or(|excess| excess.abs() <= Self::MAX_EXCESS)
    }

    /// Whether so much of the transferred skin is clipped that it looks overexposed.
    pub fn is_clipped(&self) -> bool {
        self.clipped.is_some_and(|clipped| clipped > Self::MAX_CLIPPED)
    }
}

/// Measures how well the tone of a transferred face matches the body.
///
/// - `mesh`, `anatomy`: a mesh with a head, and its anatomy.
/// - `texture`: sRGB or linear, in the mesh's layout.
/// - `inside`: `[triangles]`, whether the face was transferred to each.
/// - `references`: the base and the face before the transfer, where available.
///
/// The result does not depend on the number of threads.
///
/// # Errors
/// [`SeamError::NotColor`] for a texture or a base of data, [`SeamError::Region`] if `inside`
/// does not match the mesh, [`SeamError::Size`] for a base or a face that differs in size
/// from the texture.
///
/// # Panics
/// If the anatomy refers to more vertices than the mesh has.
pub fn measure_tone(
    mesh: &Mesh,
    anatomy: &Anatomy,
    texture: &Texture,
    inside: &[bool],
    references: ToneReferences<'_>,
) -> Result<ToneMatch, SeamError> {
    let ToneReferences { base, face } = references;
    if [Some(texture), base].into_iter().flatten().any(|it| it.encoding() == Encoding::Data) {
        return Err(SeamError::NotColor);
    }
    check_region(mesh, inside)?;
    let wanted = texture.size();
    let sizes = [("base", base.map(Texture::size)), ("face", face.map(TransferredFace::size))];
    for (what, found) in sizes {
        if let Some(found) = found.filter(|&found| found != wanted) {
            return Err(SeamError::Size { what, found, wanted });
        }
    }
    let tally = Tally::of(mesh, texture, inside, face);
    Ok(ToneMatch {
        skin: SkinColors::of(mesh, anatomy, texture),
        own: base.and_then(|base| SkinColors::of(mesh, anatomy, base)),
        clipped: (tally.skin > 0).then(|| tally.clipped as f64 / tally.skin as f64),
        hair_shift: median(tally.shifts),
    })
}

/// Counts over the texels of the transferred region.
#[derive(Debug, Default)]
struct Tally {
    skin: usize,
    clipped: usize,
    /// Differences of hair and brows from the original face.
    shifts: Vec<f64>,
}

impl Tally {
    fn of(mesh: &Mesh, texture: &Texture, inside: &[bool], face: Option<&TransferredFace>) -> Self {
        let map = SamplingMap::of_layout(mesh, texture.size(), &MapOptions::with_gutter(0));
        let is_inside = |run: &&Run| inside[map.patches()[run.patch as usize].face as usize];
        let rows = map_indices(texture.size().height as usize, |y| {
            let y = y as u32;
            let mut tally = Self::default();
            for run in map.row(y).iter().filter(is_inside) {
                (run.x..run.x + run.len).for_each(|x| tally.add(texture, face, [x, y]));
            }
            tally
        });
        rows.into_iter().fold(Self::default(), |mut all, row| {
            all.skin += row.skin;
            all.clipped += row.clipped;
            all.shifts.extend(row.shifts);
            all
        })
    }

    fn add(&mut self, texture: &Texture, face: Option<&TransferredFace>, [x, y]: [u32; 2]) {
        let (color, alpha) = texel(texture, x, y);
        if alpha <= 0.0 || !color.iter().all(|value| value.is_finite()) {
            return;
        }
        let before = face.and_then(|face| face.color(x, y));
        if face.is_some() && before.is_none() {
            return;
        }
        let shown = face.and_then(|face| face.shown(x, y));
        if shown.is_none_or(|shown| shown.skin > CERTAIN) {
            let was_full = |k: usize| before.is_some_and(|before| before[k] >= FULL);
            self.skin += 1;
            self.clipped += usize::from((0..3).any(|k| color[k] >= FULL && !was_full(k)));
        }
        if let (Some(before), Some(shown)) = (before, shown)
            && shown.hair > CERTAIN
        {
            self.shifts.push(delta_e(before, color));
        }
    }
}

/// The mean in CIELAB.
fn mean(colors: &[Rgb]) -> Option<Rgb> {
    let mut sum = Lab::<D65, f64>::new(0.0, 0.0, 0.0);
    for color in colors {
        let [red, green, blue] = color.map(|value| f64::from(value.clamp(0.0, 1.0)));
        sum += Lab::from_color(Srgb::new(red, green, blue));
    }
    let count = colors.len() as f64;
    let Srgb { red, green, blue, .. } = Srgb::from_color(sum / count);
    (count > 0.0).then(|| [red, green, blue].map(|value| value.clamp(0.0, 1.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skin(cheeks: Rgb, chest: Rgb) -> Option<SkinColors> {
        Some(SkinColors { cheeks, chest, chest_area: Area::Chest })
    }

    #[test]
    fn verdicts() {
        let (tan, pale) = ([0.78, 0.58, 0.48], [0.93, 0.80, 0.73]);
        let unknown = ToneMatch { skin: None, own: None, hair_shift: None, clipped: None };
        let alone = ToneMatch { skin: skin(tan, pale), ..unknown };
        // Without a base the body's own difference is unknown.
        for unjudged in [unknown, alone] {
            assert!(
                unjudged.matches_body() && !unjudged.is_clipped() && unjudged.excess().is_none()
            );
        }
        let toned = ToneMatch { own: skin(pale, tan), ..alone };
        assert!(toned.matches_body() && toned.excess() == Some(0.0));
        let browner = ToneMatch { own: skin(pale, pale), ..alone };
        assert!(!browner.matches_body() && browner.excess().unwrap() > 10.0);
        let evened = ToneMatch { skin: skin(pale, pale), own: skin(tan, pale), ..unknown };
        assert!(!evened.matches_body() && evened.excess().unwrap() < -10.0);
        for (clipped, wanted) in [(0.0, false), (0.01, false), (0.011, true)] {
            assert_eq!(ToneMatch { clipped: Some(clipped), ..unknown }.is_clipped(), wanted);
        }
    }

    #[test]
    fn means_are_taken_in_cielab() {
        assert_eq!(mean(&[]), None);
        let color = [0.8, 0.6, 0.5];
        let found = mean(&[color; 3]).unwrap();
        assert!((0..3).all(|k| (found[k] - color[k]).abs() < 1e-5), "{found:?}");
        // L* = 50, half as light as white in CIELAB, is 0.466 in sRGB.
        let grey = mean(&[[0.0; 3], [1.0; 3]]).unwrap();
        assert!(grey.iter().all(|value| (value - 0.4663).abs() < 1e-3), "{grey:?}");
    }
}
