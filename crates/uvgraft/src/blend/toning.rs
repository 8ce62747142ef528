//! What one side's colours take on from the other's.

use crate::color::{Encoding, srgb_from_linear};
use crate::mesh::Mesh;
use crate::piece::{FacePiece, mixed, wide};
use crate::texture::Texture;
use crate::threads::map_indices;

use super::harmonic::Harmonic;
use super::rim::{Difference, Rim, Side};
use super::sample::Sampler;
use super::selection::Ground;
use super::tone::{GAINS, Matrix};
use super::{Blend, Tone};
use crate::skin::{SkinError, SkinModel};
use crate::statistics::{ColorMatch, ColorMatchError};

/// What a blend does to the colours of one texture and its base.
#[derive(Debug, Clone)]
pub struct Toning {
    /// Whose points the gains are of.
    pub(super) ground: Ground,
    pub(super) source: Option<Recolor>,
    pub(super) base: Option<(Recolor, Option<SkinModel>)>,
}

/// Another tone for the colours at every point of a surface.
#[derive(Debug, Clone)]
pub(super) struct Recolor {
    /// What is done to all colours first.
    pub matrix: Option<Matrix>,
    /// The gains of red, green and blue at each point; empty for none.
    pub gains: Vec<[f32; 3]>,
}

/// Why colours are left as they are.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToningError {
    /// Data are no colours.
    #[error("data has no tone")]
    Data,
    /// Everything of the region ends where the mesh ends, or all of the mesh is in it.
    #[error("the region has no rim: all of the surface around it is in it")]
    NoRim,
    /// Beside the rim a texture is transparent, or holds no numbers.
    #[error("the {0} has no colours beside the region's rim")]
    NoColors(&'static str),
    /// What is skin was not found out.
    #[error("skin was not found in the {what}: {reason}")]
    Skin {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// Why.
        reason: SkinError,
    },
    /// A tone that was found for another pair or direction.
    #[error("the tone was found for another pair or direction")]
    Ground,
    /// There is nothing to compare.
    #[error(transparent)]
    Match(#[from] ColorMatchError),
}

type Rgb = [f32; 3];

impl Blend {
    /// Finds which colours a texture and a base get from each other; nothing if the options ask for
    /// none.
    ///
    /// - `base`: of any size: beside a base that is one colour, a texel of it is enough.
    /// - `encoding`: in which values are laid over: ratios are between values of that kind.
    ///
    /// # Errors
    /// [`ToningError`] where there is nothing to go by; the texture can still be laid over as it is.
    pub fn toning(
        &self,
        source: &Texture,
        base: &Texture,
        encoding: Encoding,
    ) -> Result<Option<Toning>, ToningError> {
        let Some(measure) = &self.measure else { return Ok(None) };
        if encoding == Encoding::Data {
            return Err(ToningError::Data);
        }
        let rim = &measure.rim;
        if rim.points.is_empty() {
            return Err(ToningError::NoRim);
        }
        let [mut of_source, mut of_base] = [rim.source(source, encoding), rim.base(base, encoding)];
        for (side, what) in [(&of_source, "texture"), (&of_base, "base")] {
            if side.iter().all(|&(_, area)| area == 0.0) {
                return Err(ToningError::NoColors(what));
            }
        }
        let tone = self.options.tone;
        let in_srgb =
            |colors: &[Rgb]| colors.iter().map(|&rgb| srgb(rgb, encoding)).collect::<Vec<_>>();
        let estimates = tone == Tone::Source && self.skin.is_none();
        let base_skin = if self.options.match_skin || estimates {
            let all = self.base_colors(base, encoding);
            let model = SkinModel::new(&in_srgb(&seeds(&of_base)), &in_srgb(&all))
                .map_err(|reason| ToningError::Skin { what: "base", reason })?;
            Some((model, all))
        } else {
            None
        };
        let mut matrix = None;
        if let (true, Some((model, all))) = (self.options.match_skin, &base_skin) {
            let of_texture = self.source_colors(source, encoding);
            let source_model = SkinModel::new(&in_srgb(&seeds(&of_source)), &in_srgb(&of_texture))
                .map_err(|reason| ToningError::Skin { what: "texture", reason })?;
            let [texture, body] = [(&source_model, &of_texture), (model, all)]
                .map(|(model, colors)| only_skin(model, colors, encoding));
            let (found, changed) = match tone {
                Tone::Base => (matched(&texture, &body)?, &mut of_source),
                Tone::Source => (matched(&body, &texture)?, &mut of_base),
            };
            for (color, _) in changed {
                *color = found.apply(color.map(|value| value as f32)).map(f64::from);
            }
            matrix = Some(found);
        }
        let gains = match &measure.harmonic {
            None => Vec::new(),
            Some(harmonic) => {
                let sides = match tone {
                    Tone::Base => [&of_source, &of_base],
                    Tone::Source => [&of_base, &of_source],
                };
                // Hair at the nape and a collar are no skin; without an estimate of that all counts.
                let models = sides.map(|side| SkinModel::new(&in_srgb(&seeds(side)), &[]).ok());
                let counts = models.map(|model| {
                    move |rgb| model.map_or(1.0, |model| model.weight(srgb(rgb, encoding)))
                });
                let found = rim.difference(sides, [&counts[0], &counts[1]]);
                let found = found.ok_or(ToningError::NoColors("texture"))?;
                // Parts that no way leads to are of the same person: ears that are meshes of their own
                // are skin, eyes are not. Of a base only skin changes in any case.
                let is_skin = match tone {
                    Tone::Base => {
                        let all = self.source_colors(source, encoding);
                        let model = SkinModel::new(&in_srgb(&seeds(&of_source)), &in_srgb(&all));
                        self.parts_of_skin(source, encoding, model.ok())
                    }
                    Tone::Source => vec![true; self.inside.len()],
                };
                Self::gains(rim, harmonic, &found, &is_skin)
            }
        };
        let recolor = Recolor { matrix, gains };
        let ground = self.ground.clone();
        Ok(Some(match tone {
            Tone::Base => Toning { ground, source: Some(recolor), base: None },
            Tone::Source => {
                let model = base_skin.map(|(model, _)| model);
                Toning { ground, source: None, base: Some((recolor, model)) }
            }
        }))
    }

    /// The gains at every point, from their logarithms along the rim.
    ///
    /// - `is_skin`: of a point from which no way leads to the rim, whether it changes as the rim does on
    ///   the whole.
    fn gains(
        rim: &Rim,
        harmonic: &Harmonic,
        difference: &Difference,
        is_skin: &[bool],
    ) -> Vec<Rgb> {
        let bounds = GAINS.map(|gain| f64::from(gain.ln()));
        let gains_of =
            |logs: [f64; 3]| logs.map(|log| log.clamp(bounds[0], bounds[1]).exp() as f32);
        let elsewhere = |is_skin: bool| if is_skin { difference.overall } else { [0.0; 3] };
        let extended = harmonic.extend(&difference.log_gains).into_iter();
        let mut gains: Vec<Rgb> = extended
            .zip(is_skin)
            .map(|(logs, &is_skin)| gains_of(logs.unwrap_or_else(|| elsewhere(is_skin))))
            .collect();
        for (&point, &logs) in rim.points.iter().zip(&difference.log_gains) {
            gains[point as usize] = gains_of(logs);
        }
        gains
    }

    /// For each point, whether a good share of the connected part of the region that it belongs to is
    /// skin in a source; nothing is without a model of skin.
    fn parts_of_skin(
        &self,
        source: &Texture,
        encoding: Encoding,
        model: Option<SkinModel>,
    ) -> Vec<bool> {
        let ground = &self.ground;
        let surface = ground.surface();
        let mesh = ground.pair().from(ground.direction());
        let sampler = Sampler::new(source);
        let mut is_skin = vec![false; self.inside.len()];
        let Some(model) = model else { return is_skin };
        let mut is_known = vec![false; self.touched.len()];
        for first in 0..self.touched.len() {
            if !self.touched[first] || is_known[first] {
                continue;
            }
            is_known[first] = true;
            let (mut part, mut next) = (vec![first as u32], 0);
            let (mut skin, mut all) = (0.0, 0.0);
            while let Some(&face) = part.get(next) {
                next += 1;
                for &piece in ground.pieces().of_face(face as usize) {
                    let uv = ground.middle(piece, mesh);
                    let [rgb @ .., opacity] = sampler.rgba_as(uv, encoding);
                    let area = surface.area(face) * ground.pieces().share(piece);
                    if opacity >= 0.5 {
                        skin += area * f64::from(model.weight(srgb(rgb, encoding)));
                        all += area;
                    }
                }
                for &point in &surface.triangles()[face as usize] {
                    for &other in surface.around(point) {
                        if self.touched[other as usize]
                            && !std::mem::replace(&mut is_known[other as usize], true)
                        {
                            part.push(other);
                        }
                    }
                }
            }
            if skin > SKIN_SHARE * all {
                for &point in part.iter().flat_map(|&face| &surface.triangles()[face as usize]) {
                    is_skin[point as usize] = true;
                }
            }
        }
        is_skin
    }

    /// Colours of a source at the middles of all pieces of the region.
    fn source_colors(&self, source: &Texture, encoding: Encoding) -> Vec<Rgb> {
        let ground = &self.ground;
        let mesh = ground.pair().from(ground.direction());
        let pieces = ground.pieces().all();
        colors(source, encoding, pieces.len(), |index| {
            let piece = pieces[index];
            self.touched[piece.to as usize].then(|| ground.middle(piece, mesh))
        })
    }

    /// Colours of a base at the middles of all triangles beyond the region.
    fn base_colors(&self, base: &Texture, encoding: Encoding) -> Vec<Rgb> {
        let mesh = self.ground.mesh();
        colors(base, encoding, self.touched.len(), |face| {
            (!self.touched[face]).then(|| middle(wide(mesh.uv_triangle(face))))
        })
    }
}

impl Ground {
    /// The middle of a piece in the layout of the mesh that is read.
    fn middle(&self, piece: FacePiece, read: &Mesh) -> [f64; 2] {
        let corners = wide(read.uv_triangle(piece.from as usize));
        middle(match self.pieces().part(piece) {
            None => corners,
            Some(part) => part.from.map(|weights| mixed(&corners, weights)),
        })
    }
}

/// The colours at some places of a layout, where there are any.
fn colors(
    texture: &Texture,
    encoding: Encoding,
    count: usize,
    uv: impl Fn(usize) -> Option<[f64; 2]> + Sync,
) -> Vec<Rgb> {
    let sampler = Sampler::new(texture);
    let found = map_indices(count, |index| {
        let [r, g, b, opacity] = sampler.rgba_as(uv(index)?, encoding);
        (opacity >= 0.5).then_some([r, g, b])
    });
    found.into_iter().flatten().collect()
}

fn middle(corners: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0)
}

/// So much of a part is skin at least, if it is one: ears are redder than the face, and eyes have none.
const SKIN_SHARE: f64 = 0.2;

/// The colours beside a rim, for what skin looks like.
fn seeds(side: &Side) -> Vec<Rgb> {
    let with_color = side.iter().filter(|&&(_, area)| area > 0.0);
    with_color.map(|(color, _)| color.map(|value| value as f32)).collect()
}

/// What gives one side's skin the statistics of the other's.
fn matched(from: &[Rgb], to: &[Rgb]) -> Result<Matrix, ColorMatchError> {
    let found = ColorMatch::new(from, to)?;
    let (rows, offset) = (found.matrix(), found.offset());
    let mean = from.iter().map(|rgb| rgb.iter().sum::<f32>()).sum::<f32>() / from.len() as f32;
    Ok(Matrix {
        rows: [0, 1, 2].map(|k| [rows[k][0], rows[k][1], rows[k][2], offset[k]]),
        whole_from: (0.5 * mean).max(1e-3),
    })
}

fn only_skin(model: &SkinModel, colors: &[Rgb], encoding: Encoding) -> Vec<Rgb> {
    let is_skin = |&&rgb: &&Rgb| model.weight(srgb(rgb, encoding)) > 0.5;
    colors.iter().filter(is_skin).copied().collect()
}

/// A colour as sRGB stores it.
pub(super) fn srgb(rgb: Rgb, encoding: Encoding) -> Rgb {
    if encoding == Encoding::Linear { rgb.map(srgb_from_linear) } else { rgb }
}
