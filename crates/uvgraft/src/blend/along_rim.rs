//! The tone along a rim, where nothing else is known: what most of it says, taken on over the surface.

use super::harmonic::Harmonic;
use super::rim::{Difference, Rim, Side};
use super::selection::BlendDomain;
use super::tone::{GAINS, Matrix};
use super::toning::{BaseSkin, Recolor, Recolored, ToningError};
use super::{Blend, Measure, Tone};
use crate::color::Encoding;
use crate::mesh::Mesh;
use crate::piece::{FacePiece, mixed, wide};
use crate::sampler::Sampler;
use crate::skin::SkinModel;
use crate::statistics::ColorMatch;
use crate::texture::Texture;
use crate::threads::map_indices;

type Rgb = [f32; 3];

impl Blend {
    /// What both sides get from each other by what their colours along the rim are.
    ///
    /// # Errors
    /// [`ToningError`] where there is nothing to go by.
    pub(super) fn along_rim(
        &self,
        measure: &Measure,
        source: &Texture,
        base: &Texture,
    ) -> Result<Recolored, ToningError> {
        let rim = &measure.rim;
        if rim.points.is_empty() {
            return Err(ToningError::NoRim);
        }
        let [mut of_source, mut of_base] = [rim.source(source, |_| 1.0), rim.base(base, |_| 1.0)];
        for (side, what) in [(&of_source, "texture"), (&of_base, "base")] {
            if side.iter().all(|&(_, area)| area == 0.0) {
                return Err(ToningError::NoColors(what));
            }
        }
        // Of colours as they are, before any of them is changed.
        let base_skin = match self.options.tone {
            Tone::Base => None,
            Tone::Source | Tone::Both => Some(self.base_model(&of_base, base)?),
        };
        let [of_texture, of_body] =
            self.matched_along(source, base, [&mut of_source, &mut of_base])?;
        let (mut of_texture, mut of_body) = (of_texture, of_body);
        if let Some(harmonic) = &measure.harmonic {
            let sides = match self.options.tone {
                Tone::Base | Tone::Both => [&of_source, &of_base],
                Tone::Source => [&of_base, &of_source],
            };
            // Hair at the nape and a collar are no skin; without an estimate of that all counts.
            let models = sides.map(|side| SkinModel::new(&seeds(side), &[]).ok());
            let counts =
                models.map(|model| move |rgb| model.map_or(1.0, |model| model.weight(rgb)));
            let found = rim.difference(sides, Some([&counts[0], &counts[1]]), |_, to| to);
            let found = found.ok_or(ToningError::NoColors("texture"))?;
            let of_rim =
                |share: f64, is_skin: &[bool]| self.gains(rim, harmonic, &found, is_skin, share);
            let everywhere = vec![true; self.inside.len()];
            // Parts that no way leads to are of the same person: ears that are meshes of their own
            // are skin, eyes are not. Of a base only skin changes in any case.
            let parts = || {
                let all = self.source_colors(source);
                self.parts_of_skin(source, SkinModel::new(&seeds(&of_source), &all).ok())
            };
            match self.options.tone {
                Tone::Base => of_texture.gains = of_rim(1.0, &parts()),
                Tone::Source => of_body.gains = of_rim(1.0, &everywhere),
                Tone::Both => {
                    of_texture.gains = of_rim(0.5, &parts());
                    of_body.gains = of_rim(-0.5, &everywhere);
                }
            }
        }
        let base = base_skin.map(|model| (of_body, BaseSkin::Model(model)));
        let source = (self.options.tone != Tone::Source).then_some(of_texture);
        Ok(Recolored { source, base })
    }

    /// What gives one side's skin the statistics of the other's, if that is asked for; the colours beside the rim are
    /// changed so.
    fn matched_along(
        &self,
        source: &Texture,
        base: &Texture,
        [of_source, of_base]: [&mut Side; 2],
    ) -> Result<[Recolor; 2], ToningError> {
        let none = || Recolor { matrix: None, gains: Vec::new() };
        if !self.options.match_skin {
            return Ok([none(), none()]);
        }
        let skin_of = |what, side: &Side, all: Vec<Rgb>| {
            let model = SkinModel::new(&seeds(side), &all)
                .map_err(|reason| ToningError::Skin { what, reason })?;
            Ok::<_, ToningError>(only_skin(&model, &all))
        };
        let texture = skin_of("texture", of_source, self.source_colors(source))?;
        let body = skin_of("base", of_base, self.base_colors(base))?;
        let share = self.options.tone.share() as f32;
        let mut matrices = [None; 2];
        for (matrix, from, to, share, side) in
            [(0, &texture, &body, share, of_source), (1, &body, &texture, 1.0 - share, of_base)]
        {
            if share > 0.0 {
                let found = Matrix::matching(&ColorMatch::new(from, to)?, from, share);
                for (color, _) in side.iter_mut() {
                    *color = found.apply(color.map(|value| value as f32)).map(f64::from);
                }
                matrices[matrix] = Some(found);
            }
        }
        Ok(matrices.map(|matrix| Recolor { matrix, gains: Vec::new() }))
    }

    /// What looks like skin in a base, if no mask says it.
    fn base_model(&self, side: &Side, base: &Texture) -> Result<Option<SkinModel>, ToningError> {
        if self.skin.is_some() {
            return Ok(None);
        }
        let model = SkinModel::new(&seeds(side), &self.base_colors(base))
            .map_err(|reason| ToningError::Skin { what: "base", reason })?;
        Ok(Some(model))
    }

    /// The gains at every point, from their logarithms along the rim.
    ///
    /// - `is_skin`: of a point that is too far from the rim, or from which no way leads there, whether it changes as
    ///   the rim does on the whole.
    /// - `share`: what the logarithms are multiplied by.
    fn gains(
        &self,
        rim: &Rim,
        harmonic: &Harmonic,
        difference: &Difference,
        is_skin: &[bool],
        share: f64,
    ) -> Vec<Rgb> {
        let bounds = GAINS.map(|gain| f64::from(gain.ln()));
        let gains_of =
            |logs: [f64; 3]| logs.map(|log| (share * log).clamp(bounds[0], bounds[1]).exp() as f32);
        let gain = |(point, logs): (usize, Option<[f64; 3]>)| {
            let elsewhere = if is_skin[point] { difference.overall } else { [0.0; 3] };
            let Some(logs) = logs else { return gains_of(elsewhere) };
            let near = self.near_rim(point);
            gains_of([0, 1, 2].map(|k| elsewhere[k] + (logs[k] - elsewhere[k]) * near))
        };
        let extended = harmonic.extend(&difference.log_gains).into_iter().enumerate();
        let mut gains: Vec<Rgb> = extended.map(gain).collect();
        for (&point, &logs) in rim.points.iter().zip(&difference.log_gains) {
            gains[point as usize] = gains_of(logs);
        }
        gains
    }

    /// For each point, whether a good share of the connected part of the region that it belongs to is
    /// skin in a source; nothing is without a model of skin.
    fn parts_of_skin(&self, source: &Texture, model: Option<SkinModel>) -> Vec<bool> {
        let domain = &self.domain;
        let surface = domain.surface();
        let mesh = domain.pair().from(domain.direction());
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
                for &piece in domain.pieces().of_face(face as usize) {
                    let uv = domain.middle(piece, mesh);
                    let [rgb @ .., opacity] = sampler.rgba_as(uv, Encoding::Srgb);
                    let area = surface.area(face) * domain.pieces().share(piece);
                    if opacity >= 0.5 {
                        skin += area * f64::from(model.weight(rgb));
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
    fn source_colors(&self, source: &Texture) -> Vec<Rgb> {
        let domain = &self.domain;
        let mesh = domain.pair().from(domain.direction());
        let pieces = domain.pieces().all();
        colors(source, pieces.len(), |index| {
            let piece = pieces[index];
            self.touched[piece.to as usize].then(|| domain.middle(piece, mesh))
        })
    }

    /// Colours of a base at the middles of all triangles beyond the region.
    fn base_colors(&self, base: &Texture) -> Vec<Rgb> {
        let mesh = self.domain.mesh();
        colors(base, self.touched.len(), |face| {
            (!self.touched[face]).then(|| middle(wide(mesh.uv_triangle(face))))
        })
    }
}

impl BlendDomain {
    /// The middle of a piece in the layout of the mesh that is read.
    pub(super) fn middle(&self, piece: FacePiece, read: &Mesh) -> [f64; 2] {
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
    count: usize,
    uv: impl Fn(usize) -> Option<[f64; 2]> + Sync,
) -> Vec<Rgb> {
    let sampler = Sampler::new(texture);
    let found = map_indices(count, |index| {
        let [r, g, b, opacity] = sampler.rgba_as(uv(index)?, Encoding::Srgb);
        (opacity >= 0.5).then_some([r, g, b])
    });
    found.into_iter().flatten().collect()
}

pub(super) fn middle(corners: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0)
}

/// So much of a part is skin at least, if it is one: ears are redder than the face, and eyes have none.
const SKIN_SHARE: f64 = 0.2;

/// The colours beside a rim, for what skin looks like.
fn seeds(side: &Side) -> Vec<Rgb> {
    let with_color = side.iter().filter(|&&(_, area)| area > 0.0);
    with_color.map(|(color, _)| color.map(|value| value as f32)).collect()
}

/// Those that a model takes for skin.
fn only_skin(model: &SkinModel, colors: &[Rgb]) -> Vec<Rgb> {
    colors.iter().filter(|&&rgb| model.weight(rgb) > 0.5).copied().collect()
}
