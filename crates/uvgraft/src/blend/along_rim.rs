//! Tone correction from the colours along the boundary alone: their robust ratio, extended over the
//! surface.

use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::piece::{FacePiece, mixed, wide};
use uvgraft_surface::statistics::ColorMatch;
use uvgraft_surface::threads::map_indices;

use super::harmonic::Harmonic;
use super::rim::{Difference, Rim, SideColors};
use super::selection::BlendDomain;
use super::tone::{GAINS, Matrix};
use super::toning::{BaseSkin, Recolor, SideRecolors, ToneError};
use super::{Blend, Measure, Tone};
use crate::color::Encoding;
use crate::sampler::Sampler;
use crate::skin::SkinModel;
use crate::texture::Texture;

type Rgb = [f32; 3];

impl Blend {
    /// Recolours both sides by their colours along the boundary, where no skin can be
    /// compared over larger areas.
    ///
    /// The statistics of both sides' skin are matched first, if requested. The membrane then
    /// extends the remaining ratio along the boundary harmonically over the surface, since one gain
    /// for all of it would leave a visible edge where the ratio varies.
    ///
    /// # Errors
    /// [`ToneError`] if the region has no boundary, a side has no colours along it,
    /// or its skin is not detected.
    pub(super) fn along_rim(
        &self,
        measure: &Measure,
        source: &Texture,
        base: &Texture,
    ) -> Result<SideRecolors, ToneError> {
        let rim = &measure.rim;
        if rim.points.is_empty() {
            return Err(ToneError::NoBoundary);
        }
        let [mut of_source, mut of_base] = [rim.source(source, |_| 1.0), rim.base(base, |_| 1.0)];
        for (side, what) in [(&of_source, "texture"), (&of_base, "base")] {
            if side.iter().all(|&(_, area)| area == 0.0) {
                return Err(ToneError::NoColors(what));
            }
        }
        // Estimated from the original colours, before any of them change.
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
            // Hair at the nape and collars are not skin; without a skin model all colours weigh the
            // same.
            let models = sides.map(|side| SkinModel::new(&seeds(side), &[]).ok());
            let weights =
                models.map(|model| move |rgb| model.map_or(1.0, |model| model.weight(rgb)));
            let found = rim.difference(sides, Some([&weights[0], &weights[1]]), |_, to| to);
            let found = found.ok_or(ToneError::NoColors("texture"))?;
            let of_rim =
                |share: f64, is_skin: &[bool]| self.gains(rim, harmonic, &found, is_skin, share);
            let everywhere = vec![true; self.inside.len()];
            // Parts that are not connected to the boundary belong to the same person: ears that are
            // separate meshes are skin, eyes are not. On a base only skin changes in any case.
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
        Ok(SideRecolors { source, base })
    }

    /// The matrices that give one side's skin the statistics of the other's, if requested. They are
    /// applied to the colours along the boundary too.
    fn matched_along(
        &self,
        source: &Texture,
        base: &Texture,
        [of_source, of_base]: [&mut SideColors; 2],
    ) -> Result<[Recolor; 2], ToneError> {
        let none = || Recolor { matrix: None, gains: Vec::new() };
        if !self.options.match_skin {
            return Ok([none(), none()]);
        }
        let skin_of = |what, side: &SideColors, all: Vec<Rgb>| {
            let model = SkinModel::new(&seeds(side), &all)
                .map_err(|reason| ToneError::Skin { what, reason })?;
            Ok::<_, ToneError>(only_skin(&model, &all))
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

    /// The model of a base's skin; `None` if a mask is given.
    fn base_model(
        &self,
        side: &SideColors,
        base: &Texture,
    ) -> Result<Option<SkinModel>, ToneError> {
        if self.skin.is_some() {
            return Ok(None);
        }
        let model = SkinModel::new(&seeds(side), &self.base_colors(base))
            .map_err(|reason| ToneError::Skin { what: "base", reason })?;
        Ok(Some(model))
    }

    /// The gains at every point, from their logarithms along the boundary.
    ///
    /// - `is_skin`: for points too far from the boundary or not connected to it, whether they take
    ///   on the boundary's overall gain.
    /// - `share`: factor on the logarithms.
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

    /// For each point, whether the connected part of the region that it belongs to shows enough
    /// skin in the source ([`SKIN_SHARE`]); all false without a skin model.
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
                    let uv = domain.centroid(piece, mesh);
                    let [rgb @ .., alpha] = sampler.rgba_as(uv, Encoding::Srgb);
                    let area = surface.area(face) * domain.pieces().share(piece);
                    if alpha >= 0.5 {
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

    /// The source's colours at the centroids of all pieces of the region.
    fn source_colors(&self, source: &Texture) -> Vec<Rgb> {
        let domain = &self.domain;
        let mesh = domain.pair().from(domain.direction());
        let pieces = domain.pieces().all();
        colors(source, pieces.len(), |index| {
            let piece = pieces[index];
            self.touched[piece.to as usize].then(|| domain.centroid(piece, mesh))
        })
    }

    /// The base's colours at the centroids of all triangles outside the region.
    fn base_colors(&self, base: &Texture) -> Vec<Rgb> {
        let mesh = self.domain.mesh();
        colors(base, self.touched.len(), |face| {
            (!self.touched[face]).then(|| centroid(wide(mesh.uv_triangle(face))))
        })
    }
}

impl BlendDomain {
    /// The centroid of a piece in the layout of the mesh that is read.
    pub(super) fn centroid(&self, piece: FacePiece, read: &Mesh) -> [f64; 2] {
        let corners = wide(read.uv_triangle(piece.from as usize));
        centroid(match self.pieces().part(piece) {
            None => corners,
            Some(part) => part.from.map(|weights| mixed(&corners, weights)),
        })
    }
}

/// The colours at given UV coordinates, without those that are `None` or transparent.
fn colors(
    texture: &Texture,
    count: usize,
    uv: impl Fn(usize) -> Option<[f64; 2]> + Sync,
) -> Vec<Rgb> {
    let sampler = Sampler::new(texture);
    let found = map_indices(count, |index| {
        let [r, g, b, alpha] = sampler.rgba_as(uv(index)?, Encoding::Srgb);
        (alpha >= 0.5).then_some([r, g, b])
    });
    found.into_iter().flatten().collect()
}

/// The centroid of a UV triangle.
pub(super) fn centroid(corners: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0)
}

/// Fraction of skin above which a connected part counts as skin: ears are redder than the face, and
/// eyes have no skin. The value's origin is not recorded.
const SKIN_SHARE: f64 = 0.2;

/// The colours along a boundary, as seeds of a skin model.
fn seeds(side: &SideColors) -> Vec<Rgb> {
    let with_color = side.iter().filter(|&&(_, area)| area > 0.0);
    with_color.map(|(color, _)| color.map(|value| value as f32)).collect()
}

/// The colours that a model classifies as skin.
fn only_skin(model: &SkinModel, colors: &[Rgb]) -> Vec<Rgb> {
    colors.iter().filter(|&&rgb| model.weight(rgb) > 0.5).copied().collect()
}
