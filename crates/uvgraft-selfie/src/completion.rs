//! What photographs do not show of a head: the mirror image of what they do, then colours that
//! spread smoothly over the surface, and hair where hair grows.

use glam::DVec3;
use uvgraft::Area;
use uvgraft::easing::smoothstep;
use uvgraft::statistics::median_color;
use uvgraft::surface_field::Smoothness;
use uvgraft::surface_index::SurfacePoint;
use uvgraft::threads::map_indices;
use uvgraft_avatar::paint::texel::blend;

use crate::head::Head;
use crate::layout_texels::LayoutTexels;
use crate::mirror::Mirror;
use crate::raster::{Squares, sample};

/// Smoothness of colours that spread over the surface, in eye distances. Origin not recorded.
const SPREAD: Smoothness = Smoothness { bending: 0.02, membrane: 0.5 };

/// Texels at the edge of what is known are not quite skin. Origin not recorded.
const CERTAIN: f32 = 0.8;

/// The inside of the mouth, which photographs show by chance.
const MOUTH: [f32; 3] = [0.34, 0.13, 0.12];

/// A head's layout, prepared for completing textures.
pub(crate) struct Completion<'a> {
    head: &'a Head,
    texels: &'a LayoutTexels,
}

impl<'a> Completion<'a> {
    pub fn new(head: &'a Head, texels: &'a LayoutTexels) -> Self {
        Self { head, texels }
    }

    /// Completes colours.
    ///
    /// - `colors`: `[texels]`, sRGB, 1.0 for white.
    /// - `known`: `[texels]`, 0 to 1.
    /// - `scalp`: the colour of the scalp, hair or skin, if it is seen.
    pub fn complete(
        &self,
        colors: Vec<[f32; 3]>,
        known: &[f32],
        scalp: Option<[f32; 3]>,
    ) -> Vec<[f32; 3]> {
        let size = self.texels.size();
        let Some(tones) = self.tones(&colors, known) else { return colors };
        let lips = self.lips(&colors, known);
        let between_lips = self.between_lips(known);
        let mirror = Mirror::new(self.head);
        let rims = self.rims(&colors, known, &tones);
        let feathered = self.feathered(known);
        let packed = map_indices(size.texels(), |texel| {
            let (color, rim) = (colors[texel], rims.at(texel));
            let [r, g, b] = std::array::from_fn(|k| color[k] - rim[k]);
            [r, g, b, feathered[texel]]
        });
        drop(feathered);
        drop(colors);
        let on_scalp = self.head.anatomy.area(Area::Scalp);
        let on_lips = self.head.anatomy.area(Area::Lips);
        let in_mouth = self.head.anatomy.area(Area::MouthInterior);
        map_indices(size.texels(), |texel| {
            let [r, g, b, known] = packed[texel];
            let Some(place) = self.texels.place(texel) else { return [0.0; 3] };
            let corners = self.head.mesh.faces()[place.face as usize];
            let of = |tones: &[[f64; 3]]| self.tone(tones, &place);
            let tone = of(&tones);
            let within = |area: &[f32]| -> f32 {
                (0..3).map(|c| place.weights[c] as f32 * area[corners[c] as usize]).sum()
            };
            let [share, mouth, lip] = [on_scalp, in_mouth, on_lips].map(within);
            // From the least certain to the most: tone, lips, mouth, hair, the mirror image,
            // photographs.
            let mut filled = match &lips {
                Some(lips) => {
                    let lips = of(lips).map(|value| value * (1.0 - between_lips[texel]));
                    blend(tone, lips, smoothstep(0.3, 0.7, lip))
                }
                None => tone,
            };
            filled = blend(filled, MOUTH, smoothstep(0.02, 0.6, mouth));
            if let Some(hair) = scalp {
                let share = smoothstep(0.15, 0.85, share) * (1.0 - mouth);
                filled = std::array::from_fn(|k| filled[k] + (hair[k] - filled[k]) * share);
            }
            if known < 1.0
                && let Some(uv) = mirror.uv(self.texels, texel)
            {
                let [mr, mg, mb, known] = sample(size, &packed, uv);
                let share = smoothstep(0.3, 0.9, known);
                filled = blend(filled, [mr, mg, mb], share);
            }
            blend(filled, [r, g, b], known)
        })
    }

    /// The colour of a place of the surface by those of the vertices.
    fn tone(&self, tones: &[[f64; 3]], place: &SurfacePoint) -> [f32; 3] {
        let corners = self.head.mesh.faces()[place.face as usize];
        let corner = |c: usize, k: usize| place.weights[c] * tones[corners[c] as usize][k];
        std::array::from_fn(|k| (0..3).map(|c| corner(c, k)).sum::<f64>() as f32)
    }

    /// By how much what is known must change near its rim so that its tone, though not its detail,
    /// becomes that of what is filled: shade beside hair and at the sides of a face would end there.
    fn rims(&self, colors: &[[f32; 3]], known: &[f32], tones: &[[f64; 3]]) -> Squares<3> {
        /// Tones are those of squares with this share of the texture's side, and change over some.
        const SQUARES: u32 = 128;
        const AROUND: usize = 1;
        const RIM: usize = 3;
        // The difference from the tone, and how far it is known; beside islands there is no rim.
        let squares = Squares::new(self.texels.size(), SQUARES, |texel| {
            let Some(place) = self.texels.place(texel) else { return [0.0, 0.0, 0.0, 0.0, 1.0] };
            let (tone, known) = (self.tone(tones, &place), known[texel]);
            let [r, g, b] = std::array::from_fn(|k| (colors[texel][k] - tone[k]) * known);
            [r, g, b, known, known]
        });
        let tones = squares.blurred(AROUND);
        let interior = squares.blurred(RIM);
        tones.map(|square| {
            let ([r, g, b, known, _], [.., interior]) =
                (tones.values()[square], interior.values()[square]);
            let share = (1.0 - smoothstep(0.5, 0.95, interior)) / known.max(1e-3);
            [r, g, b].map(|difference| difference * share)
        })
    }

    /// What is known, fading towards what is not over some millimetres: what is filled never has
    /// quite the tone of what it adjoins.
    fn feathered(&self, known: &[f32]) -> Vec<f32> {
        const SQUARES: u32 = 512;
        const RADIUS: usize = 5;
        let areas = [Area::Lips, Area::MouthInterior, Area::EyeSockets, Area::Eyes]
            .map(|area| self.head.anatomy.area(area));
        let is_narrow = |face: u32| {
            let corners = self.head.mesh.faces()[face as usize];
            areas.iter().any(|area| corners.iter().any(|&vertex| area[vertex as usize] > 0.3))
        };
        // Beside islands there is nothing to fade towards, and lips and lids are narrow.
        let around =
            Squares::new(self.texels.size(), SQUARES, |texel| match self.texels.face(texel) {
                Some(face) if !is_narrow(face) => [known[texel]],
                _ => [1.0],
            });
        let around = around.blurred(RADIUS);
        map_indices(known.len(), |texel| known[texel] * smoothstep(0.5, 0.95, around.at(texel)[0]))
    }

    /// `[texels]`: how much darker lips are where they touch, which no photograph of a smile shows:
    /// in the middle of what is not known of them.
    fn between_lips(&self, known: &[f32]) -> Vec<f32> {
        /// Radius of the neighbourhood in squares of which the texture's side has so many.
        const SQUARES: u32 = 512;
        const RADIUS: usize = 9;
        /// Share of the lips' colour that is taken away. Origin not recorded.
        const DARKER: f32 = 0.45;
        let around = Squares::new(self.texels.size(), SQUARES, |texel| [known[texel]]);
        let around = around.blurred(RADIUS);
        map_indices(known.len(), |texel| DARKER * (1.0 - smoothstep(0.0, 0.3, around.at(texel)[0])))
    }

    /// `[vertices]`: the colour of skin at each, from texels that are known, spread over the rest.
    fn tones(&self, colors: &[[f32; 3]], known: &[f32]) -> Option<Vec<[f64; 3]>> {
        let plain = self.plain_skin(colors, known)?;
        self.spread(plain, colors, known, |_| 1.0)
    }

    /// The same of lips; `None` if hardly anything of them is known.
    fn lips(&self, colors: &[[f32; 3]], known: &[f32]) -> Option<Vec<[f64; 3]>> {
        let plain = self.median_of(&[Area::Lips], colors, known)?;
        let on_lips = self.head.anatomy.area(Area::Lips);
        let plain = DVec3::from(plain.map(f64::from));
        self.spread(plain, colors, known, |vertex| f64::from(on_lips[vertex] > 0.6))
    }

    /// `[vertices]`: colours that are known, spread over the rest, where they become `plain` in time.
    ///
    /// - `weight`: how far what is known at a vertex counts, 0 to 1.
    fn spread(
        &self,
        plain: DVec3,
        colors: &[[f32; 3]],
        known: &[f32],
        weight: impl Fn(usize) -> f64,
    ) -> Option<Vec<[f64; 3]>> {
        /// Weights of what is known and of plain skin elsewhere, beside the field's smoothness.
        /// Origin not recorded.
        const KNOWN: f64 = 10.0;
        const PLAIN: f64 = 0.3;
        let vertices = self.head.mesh.positions().len();
        let (mut sums, mut weights) = (vec![DVec3::ZERO; vertices], vec![0.0; vertices]);
        let mut counts = vec![0.0; vertices];
        for (texel, (color, &known)) in colors.iter().zip(known).enumerate() {
            let Some(place) = self.texels.place(texel) else { continue };
            let corners = self.head.mesh.faces()[place.face as usize];
            let is_known = f64::from(u8::from(known > CERTAIN));
            let color = DVec3::from(color.map(f64::from)) - plain;
            for k in 0..3 {
                let (at, share) = (corners[k] as usize, place.weights[k].max(0.0));
                counts[at] += share;
                weights[at] += share * is_known;
                sums[at] += color * (share * is_known);
            }
        }
        let areas = self.head.field.areas();
        let at: Vec<(f64, [f64; 3])> = (0..vertices)
            .map(|vertex| {
                let share = weights[vertex] / f64::max(counts[vertex], 1e-9);
                let known = KNOWN * share * share * weight(vertex);
                let color = sums[vertex] / f64::max(weights[vertex], 1e-9);
                let weight = known + PLAIN;
                (weight * areas[vertex], (color * (known / weight)).to_array())
            })
            .collect();
        let unit = self.head.unit();
        let smoothness =
            Smoothness { bending: SPREAD.bending * unit, membrane: SPREAD.membrane * unit };
        let spread = self.head.field.solve(smoothness, &at, &[])?;
        Some(spread.into_iter().map(|color| (DVec3::from(color) + plain).to_array()).collect())
    }

    /// The median colour of the cheeks and the nose, or of all that is known if they are not.
    fn plain_skin(&self, colors: &[[f32; 3]], known: &[f32]) -> Option<DVec3> {
        let plain = self.median_of(&[Area::Cheeks, Area::Nose], colors, known);
        let color = plain.or_else(|| {
            let certain = (0..known.len()).filter(|&texel| known[texel] > CERTAIN);
            median_color(certain.map(|texel| colors[texel]))
        })?;
        Some(DVec3::from(color.map(f64::from)))
    }

    /// The median colour of what is known of some areas; `None` of too little.
    fn median_of(&self, areas: &[Area], colors: &[[f32; 3]], known: &[f32]) -> Option<[f32; 3]> {
        const FEWEST: usize = 200;
        let is_within = |face: u32| {
            let corners = self.head.mesh.faces()[face as usize];
            areas.iter().any(|&area| {
                let weights = self.head.anatomy.area(area);
                corners.iter().all(|&vertex| weights[vertex as usize] > 0.6)
            })
        };
        let certain = (0..known.len()).filter(|&texel| known[texel] > CERTAIN);
        let texels: Vec<usize> =
            certain.filter(|&texel| self.texels.face(texel).is_some_and(is_within)).collect();
        if texels.len() < FEWEST {
            return None;
        }
        median_color(texels.into_iter().map(|texel| colors[texel]))
    }
}
