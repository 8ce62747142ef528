//! Labels from the evidence.
//!
//! Cloth, hair and other occluders are connected regions: by colour alone, shadows and moles would
//! match too. Lips, eyes and brows follow from anatomy and colour.
//!
//! Limits here and in `evidence` were halved and doubled, one at a time, on nine painted faces and
//! a captured one in FLAME's layout (the bench of looks). Figures are the intersection over union
//! (IoU) of found and painted labels; "flat" means that none changed by 0.01.

use uvgraft_surface::easing::smoothstep;
use uvgraft_surface::statistics::median;
use uvgraft_surface::threads::map_indices;

use super::evidence::Evidence;
use super::geodesic::{flood, parts, widened};
use super::head::HeadLayout;
use super::{Label, LabelError, Labels};
use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::texture::Texture;

/// Non-skin regions with at most this many texels, of some 220,000, are moles. Flat from 7 to 140;
/// at 560, brows lose up to 0.02.
const MOLE: usize = 70;
/// Hanging hair reaches at most this many eye distances below the scalp. Flat from 0.6 to 2.4.
const HANGING: f32 = 1.2;
/// Cloth-like texels within this many texels of cloth are cloth too. Flat from 1 to 32.
const SCRAPS: usize = 8;
/// Cloth covering a smaller fraction of the neck is discarded. Flat from 0.002 to 0.04; at 0.16,
/// collars are discarded.
const MIN_CLOTH: f64 = 0.02;

impl Labels {
    /// Labels the texture of a head.
    ///
    /// # Errors
    /// [`LabelError::Skin`] if the cheeks have no uniform colour, or are missing.
    pub(crate) fn find(head: &HeadLayout, texture: &Texture) -> Result<Self, LabelError> {
        let colors = GridColors::new(texture, &head.grid);
        let evidence = Evidence::new(head, colors)?;
        let mut finder = Finder::new(head, evidence);
        finder.cross_beard();
        let cloth = finder.cloth();
        let hair = finder.hair(&cloth);
        let other = finder.other(&cloth, &hair);
        let weights = map_indices(cloth.len(), |texel| {
            finder.weights(texel, cloth[texel], hair[texel], other[texel])
        });
        Ok(Self { size: head.grid.size(), weights: softened(&head.grid, &weights) })
    }
}

/// The fraction of a texel's light that comes from hair, where skin and hair mix.
///
/// With lightnesses relative to skin, a texel with coverage `s` of skin has the lightness
/// `s + (1 - s) · dark`, of which `s` comes from skin.
///
/// - `light`: the logarithm of the texel's lightness relative to skin.
/// - `dark`: the lightness of hair relative to skin.
fn hair_share(light: f32, dark: f32) -> f32 {
    let ratio = light.exp();
    let of_skin = (ratio - dark) / (ratio * (1.0 - dark));
    1.0 - of_skin.clamp(0.0, 1.0)
}

/// Weights blurred with their neighbours on the surface, ignoring texels outside islands.
/// Eyes and teeth stay sharp: they are only a few texels wide, and a soft edge would tint
/// much of them with half the change of skin tone.
fn softened(grid: &LayoutGrid, weights: &[[f32; 8]]) -> Vec<[f32; 8]> {
    map_indices(weights.len(), |texel| {
        let own = &weights[texel];
        if own[Label::Eye as usize] + own[Label::Mouth as usize] > 0.9 {
            return *own;
        }
        let (mut sum, mut total) = (weights[texel].map(|weight| 4.0 * weight), 4.0);
        grid.each_neighbour(texel as u32, |near| {
            for (sum, weight) in sum.iter_mut().zip(weights[near as usize]) {
                *sum += weight;
            }
            total += 1.0;
        });
        sum.map(|sum| sum / total)
    })
}

/// How strongly a texel's colour rules out skin, 0 to 1.
fn is_not_skin(evidence: &Evidence, texel: usize) -> f32 {
    let Evidence { hue, pale, light, light_of_face, .. } = evidence;
    // Highlights are pale and lighter than their surroundings.
    let highlight = smoothstep(0.03, 0.15, light[texel]) * smoothstep(0.5, 2.0, pale[texel]);
    // Flat, but for brows, from 0.8 to 1.25 times these. Halved, 5.6 % of very light skin is lost,
    // not 0.3 %; doubled, a grey beard is skin (IoU of hair 0.96 -> 0.66).
    let hue = smoothstep(3.5, 6.0, hue[texel]) * smoothstep(-2.0, -1.3, light_of_face[texel]);
    let hue = hue * (1.0 - highlight);
    // Flat but for brows and hair, which change by up to 0.02 when it is halved or doubled.
    let dark = smoothstep(0.33, 0.75, -light[texel]);
    hue.max(dark)
}

struct Finder<'a> {
    head: &'a HeadLayout,
    evidence: Evidence,
    /// How strongly each texel's own colour rules out skin, 0 to 1.
    not_skin: Vec<f32>,
}

impl<'a> Finder<'a> {
    fn new(head: &'a HeadLayout, evidence: Evidence) -> Self {
        let not_skin = map_indices(evidence.hue.len(), |texel| is_not_skin(&evidence, texel));
        Self { head, evidence, not_skin }
    }

    fn texels(&self) -> std::ops::Range<u32> {
        0..self.evidence.hue.len() as u32
    }

    /// Adds seeds of skin beyond a full beard and on ears, if their colour matches: every path from
    /// the cheeks to them crosses a colour step, as beard and hair separate them.
    fn cross_beard(&mut self) {
        let grid = &self.head.grid;
        let areas = &self.head.areas;
        let Evidence { hue, light, light_of_face, step, .. } = &self.evidence;
        let is_alike = |texel: u32| {
            let texel = texel as usize;
            hue[texel] < 2.5 && light[texel].abs() < 0.45 && light_of_face[texel].abs() < 0.7
        };
        let is_open =
            map_indices(hue.len(), |texel| self.not_skin[texel] >= 0.5 && areas.lips[texel] < 0.3);
        let is_beard = |part: &&Vec<u32>| {
            let on_jaw = part.iter().filter(|&&texel| areas.jaw[texel as usize] >= 0.3).count();
            part.len() > 8 * MOLE && 5 * on_jaw > part.len()
        };
        let parts = parts(grid, &is_open);
        let beards = parts.iter().filter(is_beard).flatten();
        // Edges are soft: only some texels farther on are colours pure skin.
        let mut beard = vec![false; hue.len()];
        beards.for_each(|&texel| beard[texel as usize] = true);
        let beyond = self.widened(&beard, 4);
        let seeds: Vec<u32> = self
            .texels()
            .filter(|&texel| {
                let is_near = beyond[texel as usize] && !beard[texel as usize];
                (is_near || areas.ears[texel as usize] >= 0.5) && is_alike(texel)
            })
            .collect();
        // No beard cuts anything off: distances would hardly change.
        if seeds.iter().all(|&texel| step[texel as usize] < 1.0) {
            return;
        }
        let Evidence { steps, step, known, .. } = &mut self.evidence;
        steps.shorten(grid, step, seeds.into_iter(), |texel| {
            areas.eyes[texel as usize] < 0.5 && known[texel as usize] >= 0.5
        });
    }

    /// How much a texel at the neck looks like cloth or background, by its colour and by the
    /// colour step between it and the face.
    fn is_like_cloth(&self, texel: usize) -> f32 {
        let Evidence { hue, light, step, known, .. } = &self.evidence;
        if known[texel] < 0.5 {
            return 1.0;
        }
        let (hue, light, step) = (hue[texel], light[texel], step[texel]);
        let dark_enough = smoothstep(-2.2, -1.5, self.evidence.light_of_face[texel]);
        // Hue: halved, a white collar takes skin with it (IoU of cloth 0.90 -> 0.84); flat doubled.
        let other_color = (smoothstep(3.0, 5.0, hue) * dark_enough)
            .max(smoothstep(0.33, 0.6, light))
            .max(smoothstep(0.9, 1.4, -light));
        // Shadows are darker but keep skin's hue; skin-coloured cloth shows only by the step.
        let no_shadow = smoothstep(-0.45, -0.2, light).max(smoothstep(1.8, 3.0, hue));
        // The first step is flat halved and doubled. The second one: halved, collars take skin with
        // them (IoU 0.90 -> 0.82 of the white one); doubled, that of a grey capture is lost in part
        // (0.86 -> 0.74), though the others gain up to 0.05. With 1.25 and 1.5 times as much all
        // gain: the white one is at 0.94.
        (other_color * smoothstep(1.0, 2.5, step)).max(no_shadow * smoothstep(2.5, 4.0, step))
    }

    /// Cloth and background: cloth-like texels that are connected to the boundary at the neck.
    ///
    /// Hair that hangs down to the neck is removed, and what that disconnects from the boundary is
    /// dropped. Then nearby scraps are added, unless they are large: a quarter of the cloth or more
    /// is not a scrap but something else of that colour.
    fn cloth(&self) -> Vec<f32> {
        let head = self.head;
        let alike = map_indices(self.not_skin.len(), |texel| {
            if self.may_be_cloth(texel) { self.is_like_cloth(texel) } else { 0.0 }
        });
        let is_open = |texel: u32| alike[texel as usize] >= 0.5;
        let mut found = flood(&head.grid, head.rim.iter().copied(), is_open);
        let count = |of: &[bool]| of.iter().filter(|is| **is).count();
        let neck = head.areas.neck.iter().filter(|&&neck| neck >= 0.5).count();
        if count(&found) as f64 > MIN_CLOTH * neck as f64 {
            self.drop_hair(&mut found);
            let left = found;
            found = flood(&head.grid, head.rim.iter().copied(), |texel| left[texel as usize]);
        }
        if (count(&found) as f64) <= MIN_CLOTH * neck as f64 {
            return vec![0.0; alike.len()];
        }
        // Nearby scraps, cut off by a shadow or a strand of hair.
        let beside = self.widened(&found, SCRAPS);
        let scraps = flood(
            &head.grid,
            self.texels().filter(|&texel| beside[texel as usize] && !found[texel as usize]),
            |texel| is_open(texel) && !found[texel as usize],
        );
        if count(&scraps) < count(&found) / 4 {
            found.iter_mut().zip(scraps).for_each(|(found, scrap)| *found |= scrap);
        }
        // The edge is as soft as the evidence.
        let near = self.widened(&found, 2);
        (0..found.len()).map(|texel| if near[texel] { alike[texel] } else { 0.0 }).collect()
    }

    fn may_be_cloth(&self, texel: usize) -> bool {
        let areas = &self.head.areas;
        let face = areas.cheeks[texel]
            .max(areas.nose[texel])
            .max(areas.forehead[texel])
            .max(areas.lips[texel])
            .max(areas.eyes[texel])
            .max(areas.mouth[texel])
            .max(areas.sockets[texel]);
        self.head.grid.faces()[texel] != NONE && face < 0.2
    }

    /// Removes hair that hangs down to the neck from the cloth: texels near the scalp within 5
    /// ΔE of the hair on the crown, in geodesic colour distance.
    fn drop_hair(&self, found: &mut [bool]) {
        let areas = &self.head.areas;
        let Evidence { step, .. } = &self.evidence;
        let is_crown = |&texel: &u32| {
            let texel = texel as usize;
            areas.scalp[texel] >= 0.9 && areas.neck[texel] < 0.1 && self.not_skin[texel] >= 0.5
        };
        let seeds: Vec<u32> = self.texels().filter(is_crown).collect();
        if seeds.is_empty() {
            return;
        }
        let steps = &self.evidence.steps;
        // Paths keep off skin: through the face, cloth would be near the hair as well.
        let from_hair =
            steps.distances(&self.head.grid, seeds.into_iter(), |texel| step[texel as usize] > 0.5);
        for texel in 0..found.len() {
            // Half and twice as much change a white collar's IoU by 0.02, and nothing else.
            if found[texel] && from_hair[texel] < 5.0 && self.is_near_scalp(texel) {
                found[texel] = false;
            }
        }
    }

    fn is_near_scalp(&self, texel: usize) -> bool {
        self.head.areas.scalp[texel] > 0.02 || self.head.above_nape[texel] > -HANGING
    }

    /// Hair: non-skin texels that are connected to the scalp, and beards.
    fn hair(&self, cloth: &[f32]) -> Vec<f32> {
        let areas = &self.head.areas;
        let Evidence { hue, light, step, .. } = &self.evidence;
        let unlike = map_indices(cloth.len(), |texel| {
            let scalp = areas.scalp[texel];
            let colors = self.not_skin[texel];
            // On the scalp the thresholds are lower, since blond hair has nearly the colour of
            // skin.
            // The step is flat halved and doubled.
            let clearly = smoothstep(1.5, 3.0, hue[texel])
                .max(smoothstep(0.12, 0.3, light[texel].abs()))
                .max(smoothstep(1.5, 4.0, step[texel]));
            colors.max(scalp * clearly) * (1.0 - cloth[texel])
        });
        let is_face = |texel: usize| areas.eyes[texel] >= 0.5 || areas.mouth[texel] >= 0.5;
        let is_open = |texel: u32| unlike[texel as usize] >= 0.4 && !is_face(texel as usize);
        let crown = self.texels().filter(|&texel| areas.scalp[texel as usize] >= 0.5);
        let mut found = flood(&self.head.grid, crown, is_open);
        self.add_beard(&unlike, &mut found);
        let near = self.widened(&found, 2);
        let darkness = self.darkness_of_hair(&found);
        let share = |texel: usize| match darkness {
            // Hair as light as skin does not mix by light: there the evidence itself is the share.
            Some(dark) => hair_share(light[texel], dark) * (1.0 - cloth[texel]),
            None => unlike[texel],
        };
        map_indices(cloth.len(), |texel| if near[texel] { share(texel) } else { 0.0 })
    }

    /// The lightness of hair relative to skin; `None` for hair that is not clearly darker.
    fn darkness_of_hair(&self, found: &[bool]) -> Option<f32> {
        let is_hair = |texel: &usize| found[*texel] && self.head.areas.scalp[*texel] >= 0.5;
        let light = (0..found.len()).filter(is_hair).map(|texel| self.evidence.light[texel]);
        // Flat to -0.45 but for one face, which loses 0.013 of its hair. At -0.3, blond hair counts
        // as dark (IoU 0.98 -> 0.89); at -1.2, a fifth more of the captured face is hair.
        median(light).filter(|&light| light < -0.6).map(f32::exp)
    }

    /// Adds beards: regions on jaw, cheeks and neck that are darker or paler than skin and
    /// larger than four moles.
    fn add_beard(&self, unlike: &[f32], found: &mut [bool]) {
        let areas = &self.head.areas;
        let is_open = map_indices(unlike.len(), |texel| {
            let place = areas.jaw[texel].max(areas.neck[texel]).max(areas.cheeks[texel]);
            unlike[texel] >= 0.5
                && !found[texel]
                && place > 0.05
                && (self.evidence.light[texel] < -0.2 || self.evidence.pale[texel] > 3.0)
                && areas.lips[texel] < 0.3
        });
        for part in parts(&self.head.grid, &is_open) {
            if part.len() > 4 * MOLE {
                part.into_iter().for_each(|texel| found[texel as usize] = true);
            }
        }
    }

    /// Other non-skin regions in the face, such as glasses, larger than a mole.
    fn other(&self, cloth: &[f32], hair: &[f32]) -> Vec<f32> {
        let areas = &self.head.areas;
        let unlike = map_indices(cloth.len(), |texel| {
            let known = areas.ears[texel].max(areas.lips[texel]).max(areas.mouth[texel]);
            let rest = (1.0 - known) * (1.0 - hair[texel]) * (1.0 - cloth[texel]);
            self.not_skin[texel] * rest
        });
        let is_open: Vec<bool> = unlike.iter().map(|&unlike| unlike >= 0.5).collect();
        let mut found = vec![false; cloth.len()];
        for part in parts(&self.head.grid, &is_open) {
            if part.len() > MOLE {
                part.into_iter().for_each(|texel| found[texel as usize] = true);
            }
        }
        let near = self.widened(&found, 1);
        (0..cloth.len()).map(|texel| if near[texel] { unlike[texel] } else { 0.0 }).collect()
    }

    /// A texel's weights. Labels are applied in order of precedence, each to its share of what the
    /// earlier ones left; skin is the remainder.
    fn weights(&self, texel: usize, cloth: f32, hair: f32, other: f32) -> [f32; 8] {
        let areas = &self.head.areas;
        let Evidence { hue, pale, light, red, .. } = &self.evidence;
        let (hue, pale, light, red) = (hue[texel], pale[texel], light[texel], red[texel]);
        let mut weights = [0.0; 8];
        let mut rest = 1.0_f32;
        let mut add = |label: Label, share: f32| {
            let share = share.clamp(0.0, 1.0) * rest;
            weights[label as usize] += share;
            rest -= share;
        };
        add(Label::Cloth, cloth);
        add(Label::Eye, smoothstep(0.3, 0.7, areas.eyes[texel]));
        add(Label::Mouth, smoothstep(0.3, 0.7, areas.mouth[texel]));
        let (lips, sockets, brows) = (areas.lips[texel], areas.sockets[texel], areas.brows[texel]);
        // Teeth are paler than skin and hardly darker, or yellower where skin is as pale, or
        // lighter where colour doesn't help; never redder, as lips are. The gap between the lips
        // is black.
        let inner = smoothstep(0.3, 0.7, lips);
        let yellow = smoothstep(2.5, 4.0, hue) * smoothstep(3.0, 6.0, -red) * inner;
        let teeth = smoothstep(-0.5, -0.2, light) * smoothstep(3.5, 6.0, pale).max(yellow);
        let teeth = teeth.max(smoothstep(0.1, 0.2, light) * inner) * smoothstep(-5.0, -2.0, -red);
        add(Label::Mouth, smoothstep(0.1, 0.5, lips) * teeth.max(smoothstep(0.9, 1.3, -light)));
        add(
            Label::Lip,
            smoothstep(0.1, 0.5, lips)
                * smoothstep(1.5, 3.0, hue).max(smoothstep(0.12, 0.3, -light)),
        );
        let white = smoothstep(3.0, 5.0, pale) * smoothstep(-0.7, -0.3, light);
        add(Label::Eye, smoothstep(0.1, 0.5, sockets) * white.max(smoothstep(0.5, 0.9, -light)));
        add(Label::Brow, smoothstep(0.1, 0.4, brows) * smoothstep(0.1, 0.3, -light));
        add(Label::Hair, hair);
        add(Label::Other, other);
        weights[Label::Skin as usize] = rest;
        weights
    }

    /// Dilates a mask by a number of texels.
    fn widened(&self, found: &[bool], texels: usize) -> Vec<bool> {
        let of = self.texels().filter(|&texel| found[texel as usize]);
        let mut wide = vec![false; found.len()];
        for texel in widened(&self.head.grid, of, texels) {
            wide[texel as usize] = true;
        }
        wide
    }
}
