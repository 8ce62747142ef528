//! Decides which texels are skin.
//!
//! Growth from the face gives the skin that is certain. Then the neck, hands, feet and other
//! candidate parts are accepted or rejected as a whole, by the median of their colours and
//! by the contrast along their edge with known skin; single texels would be too noisy for
//! either. Last, texels near edges are divided, and small holes are filled.
//!
//! Limits here and in `barrier` and `steps` were halved and doubled, one at a time, on six bodies:
//! SMPL-X with a brown shirt, a beige one, long sleeves and, a real texture, no clothes; the figure
//! in a pink shirt, and in beige clothes. "Flat" means that neither the share of skin that is found
//! nor that of cloth taken for skin changed by 0.3 % on any of them. Where they are cited, 88.8 %
//! of the skin in the beige shirt is found, and 89.9 % of that in the pink one.

use uvgraft_surface::easing::smoothstep;
use uvgraft_surface::statistics::median;
use uvgraft_surface::threads::{for_each_chunk, map_indices};

use super::grow::{Growth, divided, parts};
use super::layout::{BodyLayout, Detail};
use super::steps::Steps;
use crate::layout_grid::{GridColors, NONE};
use crate::skin::{Deviation, SkinError, SkinModel};

/// Growth of skin may cross colour steps of this total, in ΔE. Flat from 0.15 to 3; at 12, 91 % of
/// the beige clothes are skin.
const REACH: f32 = 1.5;
/// Steps of more than this separate parts, in ΔE per texel. Flat from 0.175 to 0.7.
const CUT: f32 = 0.35;
/// Largest fleck, as a fraction of the covered texels; flecks enclosed by skin are skin. Flat from
/// half to twice as many.
const FLECK: f32 = 0.0012;
/// The same for flecks of nearly skin's hue, such as moles, nipples and hair on arms. At 0.012,
/// 2.3 % of the pink shirt becomes skin; flat down to 0.003.
const ALIKE_FLECK: f32 = 0.006;
/// Smallest part that is judged by itself, as a fraction of the covered texels. Flat from 0.001 to
/// 0.004.
const MIN_PART: f32 = 0.002;
/// Least number of contrasts with skin per edge texel of a part; fewer do not count as an edge.
/// Flat down to 0.03; at 0.12, 94 % of the skin in the beige shirt is found, and no less of any
/// other.
const TOUCH: f32 = 0.06;
/// Largest distance across which contrasts are measured, in texels. At 14 and 28, 99.6 % of the
/// skin in the beige shirt is found, and no less of any other; flat up to 112.
const ACROSS: usize = 56;
/// The same where all nearby skin lies within the wide barrier. Flat from 3 to 12.
const WIDTH: usize = 6;
/// A part may be skin if the mean contrast is less than this, in ΔE. Flat from 1.25 to 5; at 0.5,
/// 3 % of the skin in the pink shirt is lost, at 10 nearly all of that in the beige one is found.
const ALIKE: f32 = 2.5;
/// The same next to hands and feet, which are redder than the skin they adjoin. Flat from 4.5 to
/// 18.
const ALIKE_ENDS: f32 = 9.0;
/// A part is seamless with skin if the mean contrast within [`WIDTH`] texels is less than this, in
/// ΔE. Flat from 0.1 to 0.4.
const SEAMLESS: f32 = 0.2;
/// Least number of such contrasts per edge texel of a seamless part. Flat from 1.5 to 6.
const LONG_TOUCH: f32 = 3.0;
/// Tones that differ by less in hue and lightness are the same. Origin not recorded.
const SAME: (f32, f32) = (0.3, 0.03);
/// How much more other parts of the body may deviate in hue than the hands do. Flat from 0.85 to
/// 3.4.
const MORE_HUE: f32 = 1.7;
/// Weight of a deviation in log lightness relative to one in hue, when the two are added. At 6,
/// 91 % of the beige clothes are skin; flat up to 24.
const LIGHT: f32 = 12.0;
/// Limit of the colours that skin models and medians are computed from.
const MAX_COLORS: usize = 3000;

/// Which texels are skin.
pub(super) struct Decision<'a> {
    body: &'a BodyLayout,
    steps: &'a Steps,
    known: &'a [f32],
    deviation: Vec<Deviation>,
    is_end: Vec<bool>,
    /// Texels that may be skin.
    is_open: Vec<bool>,
    growth: Growth,
    is_skin: Vec<bool>,
}

/// The mean colour difference across an edge.
#[derive(Debug, Clone, Copy, Default)]
struct Contrast {
    sum: [f32; 4],
    count: f32,
}

impl Contrast {
    fn add(&mut self, difference: [f32; 4]) {
        self.sum = [0, 1, 2, 3].map(|k| self.sum[k] + difference[k]);
        self.count += 1.0;
    }

    /// Whether the mean is less than `most` ΔE, or there are fewer than `least` samples to tell.
    fn is_within(&self, most: f32, least: f32) -> bool {
        let squares = self.sum.map(|sum| (sum / self.count.max(1.0)).powi(2));
        self.count < least || squares.iter().sum::<f32>() < most * most
    }
}

/// Median deviation of a part's texels from skin.
struct Likeness {
    hue: f32,
    light: f32,
}

/// The contact between a part and skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joint {
    /// A colour edge separates them.
    Cut,
    /// No colour edge was detected.
    Open,
    /// Both have the same colour along much of the part's edge.
    Seamless,
}

/// Limits of a part's deviation from skin.
#[derive(Debug, Clone, Copy)]
struct Limits {
    hue: f32,
    /// Hue and weighted lightness together.
    both: f32,
    light: f32,
}

impl Limits {
    fn allow(&self, found: &Likeness) -> bool {
        let light = found.light.abs();
        found.hue < self.hue && light < self.light && found.hue + LIGHT * light < self.both
    }
}

impl<'a> Decision<'a> {
    /// Segments the skin: grows it from the face, adds the neck, then hands and feet, then other
    /// parts that growth did not reach.
    ///
    /// - `skin`: the model of skin, if known; else it is estimated from the face, or from the neck.
    ///
    /// # Errors
    /// [`SkinError`] if neither the face nor the neck has a uniform colour.
    pub fn new(
        body: &'a BodyLayout,
        colors: &'a GridColors,
        steps: &'a Steps,
        skin: Option<&SkinModel>,
    ) -> Result<Self, SkinError> {
        let skin_of = |area: &[u32]| SkinModel::new(&some_colors(area, colors), &[]);
        let of_face = match skin {
            Some(skin) => *skin,
            None => skin_of(&body.face).or_else(|error| skin_of(&body.neck).map_err(|_| error))?,
        };
        let texels = colors.rgb.len();
        let mut is_end = vec![false; texels];
        body.hands.iter().chain(&body.feet).for_each(|&texel| is_end[texel as usize] = true);
        let mut decision = Self {
            body,
            steps,
            known: &colors.known,
            deviation: Vec::new(),
            is_end,
            is_open: Vec::new(),
            growth: Growth::new(texels, REACH),
            is_skin: vec![false; texels],
        };
        decision.compare(colors, &of_face);
        // A fringe and glasses lie in the face's areas too; growth from them would follow hair and
        // cloth of their colour.
        let is_plain = |&&texel: &&u32| {
            let Deviation { hue, light, .. } = decision.deviation[texel as usize];
            hue < 2.0 && light.abs() < 0.4
        };
        let mut seeds: Vec<u32> = body.face.iter().filter(is_plain).copied().collect();
        if 2 * seeds.len() <= body.face.len() {
            // The head is blank, or missing.
            seeds = body.neck.iter().chain(&body.hands).filter(is_plain).copied().collect();
        }
        decision.grow(&seeds);
        // Where the chin's shadow ends in an edge, growth stops short of the neck.
        // Twice these limits take 91 % of the beige clothes for skin, half of them change nothing.
        decision.add_area(&body.neck, Limits { hue: 1.2, both: 2.2, light: 0.16 });
        // Hands and feet have the tone of the neck, so add its own where growth reached it.
        let neck = body.neck.iter().filter(|&&texel| decision.growth.has(texel));
        if let Ok(of_neck) = skin_of(&neck.copied().collect::<Vec<_>>()) {
            let Deviation { hue, light, .. } = of_face.deviation(of_neck.color());
            if hue > SAME.0 || light.abs() > SAME.1 {
                decision.compare(colors, &of_neck);
            }
        }
        decision.add_ends();
        decision.add_parts();
        decision.divide();
        decision.fill();
        Ok(decision)
    }

    fn texels(&self) -> std::ops::Range<u32> {
        0..self.known.len() as u32
    }

    fn share(&self, share: f32) -> usize {
        (share * self.body.covered as f32) as usize
    }

    /// Compares colours with a model of skin. With several models, the nearest one is kept.
    fn compare(&mut self, colors: &GridColors, model: &SkinModel) {
        let deviations = model.deviations();
        let far = |deviation: &Deviation| deviation.hue + 5.0 * deviation.light.abs();
        let none = Deviation { hue: f32::INFINITY, pale: f32::INFINITY, light: 0.0 };
        self.deviation.resize(colors.rgb.len(), none);
        let (bits, width) = (&self.body.bits, self.body.grid.size().width as usize);
        for_each_chunk(&mut self.deviation, width, |y, row| {
            for (x, deviation) in row.iter_mut().enumerate() {
                let texel = y * width + x;
                if bits[texel].is_covered() {
                    let new = deviations(colors.rgb[texel]);
                    if far(&new) <= far(deviation) {
                        *deviation = new;
                    }
                }
            }
        });
        self.is_open = map_indices(self.known.len(), |texel| {
            let Deviation { hue, light, .. } = self.deviation[texel];
            self.body.bits[texel].is_outer()
                && self.known[texel] >= 0.5
                && hue < 6.0
                && (-1.5..0.8).contains(&light)
        });
    }

    fn grow(&mut self, seeds: &[u32]) {
        self.growth.add(self.body, self.steps, seeds, &self.is_open);
    }

    fn likeness(&self, part: &[u32]) -> Likeness {
        let step = part.len().div_ceil(MAX_COLORS).max(1);
        let median = |value: fn(&Deviation) -> f32| {
            let texels = part.iter().step_by(step);
            let values = texels.map(|&texel| value(&self.deviation[texel as usize]));
            median(values).unwrap_or_default()
        };
        Likeness {
            hue: median(|deviation| deviation.hue),
            light: median(|deviation| deviation.light),
        }
    }

    /// Whether a colour edge separates a part from skin.
    ///
    /// Dilates the part breadth-first until it meets skin, and averages the colour differences
    /// between each skin texel met and the edge texel it was reached from. A mean, since single
    /// paths may cross where a shadow makes both sides alike. Contrasts with hands and feet are
    /// averaged separately, as these are redder than the skin they adjoin.
    fn joint(&self, part: &[u32]) -> Joint {
        let grid = &self.body.grid;
        // Texel index + 1, 0 for none: zeroed pages take no memory until they are written.
        let mut origin = vec![0; self.known.len()];
        part.iter().for_each(|&texel| origin[texel as usize] = texel + 1);
        let is_edge = |texel: u32| grid.neighbours(texel).any(|near| origin[near as usize] == 0);
        let mut edge: Vec<u32> = part.iter().copied().filter(|&texel| is_edge(texel)).collect();
        let (least, long) = (TOUCH * edge.len() as f32, LONG_TOUCH * edge.len() as f32);
        let (mut contrasts, mut of_touch) = ([Contrast::default(); 2], Contrast::default());
        for step in 0..ACROSS {
            let mut next = Vec::new();
            for texel in edge {
                let from = origin[texel as usize];
                for near in grid.neighbours(texel) {
                    let at = near as usize;
                    if origin[at] != 0 || !self.body.bits[at].is_covered() {
                        continue;
                    }
                    origin[at] = from;
                    let is_skin = self.growth.has(near);
                    let difference = self.steps.difference(from - 1, near);
                    if is_skin && step < WIDTH {
                        of_touch.add(difference);
                    }
                    if is_skin && !self.steps.barrier.wide[at] {
                        contrasts[usize::from(self.is_end[at])].add(difference);
                    } else {
                        next.push(near);
                    }
                }
            }
            edge = next;
        }
        let [of_others, of_ends] = contrasts;
        // Skin may be too narrow to extend beyond the wide barrier.
        let is_open = if of_others.count + of_ends.count < least {
            of_touch.is_within(ALIKE, least)
        } else {
            of_others.is_within(ALIKE, least) && of_ends.is_within(ALIKE_ENDS, least)
        };
        if !is_open {
            Joint::Cut
        } else if of_touch.count >= long.max(1.0) && of_touch.is_within(SEAMLESS, 0.0) {
            Joint::Seamless
        } else {
            Joint::Open
        }
    }

    /// Parts that look like skin but were not reached by growth, largest first.
    fn candidates(
        &self,
        from: impl Iterator<Item = u32>,
        is_place: impl Fn(usize) -> bool,
    ) -> Vec<Vec<u32>> {
        let is_like = |texel: u32| {
            let at = texel as usize;
            self.is_open[at]
                && self.deviation[at].hue < 3.0
                && !self.growth.has(texel)
                && is_place(at)
        };
        let mut found = parts(self.body, self.steps, CUT, from, is_like);
        found.retain(|part| part.len() >= self.share(MIN_PART));
        // What is accepted first is skin that later parts are compared with.
        found.sort_by_key(|part| std::cmp::Reverse(part.len()));
        found
    }

    /// Limit of a part's deviation in hue: somewhat above that of the hands, if those were found.
    fn most_hue(&self) -> f32 {
        let hands = self.body.hands.iter().filter(|&&texel| self.growth.has(texel));
        let hands: Vec<u32> = hands.copied().collect();
        if hands.len() < self.share(MIN_PART) {
            return f32::INFINITY;
        }
        self.likeness(&hands).hue + MORE_HUE
    }

    /// Adds hands and feet, which sleeves and trousers separate from the face.
    fn add_ends(&mut self) {
        // Trousers may cover the feet, so their limits are stricter.
        // With half of these limits only 67 % of the skin in the pink shirt is found, with twice
        // these 91 % of the beige clothes are skin.
        for (area, both) in [(&self.body.hands, f32::INFINITY), (&self.body.feet, 2.2)] {
            let hue = self.most_hue().min(2.2);
            self.add_area(area, Limits { hue, both, light: 0.35 });
        }
    }

    /// Adds the parts of an area that have skin's colour and no edge towards the skin they touch.
    fn add_area(&mut self, area: &[u32], most: Limits) {
        let mut is_within = vec![false; self.known.len()];
        area.iter().for_each(|&texel| is_within[texel as usize] = true);
        for part in self.candidates(area.iter().copied(), |at| is_within[at]) {
            if most.allow(&self.likeness(&part)) && self.joint(&part) != Joint::Cut {
                self.grow(&part);
            }
        }
    }

    /// Adds arms and legs between clothes; a belly too, if its colour is very close to skin's.
    fn add_parts(&mut self) {
        let bits = &self.body.bits;
        let is_two_sided = |part: &Vec<u32>| {
            let left = part.iter().filter(|&&texel| bits[texel as usize].is_left()).count();
            (0.1..0.9).contains(&(left as f32 / part.len() as f32))
        };
        let found = self.candidates(self.texels(), |at| !bits[at].is_detail());
        let (two_sided, one_sided): (Vec<_>, Vec<_>) = found.into_iter().partition(is_two_sided);
        // Legs are two parts, one on each side of the body; trousers and shirts extend over both
        // sides.
        let most_hue = self.most_hue();
        // Flat halved; doubled, 92 % of the skin in the pink shirt is found, and nothing else
        // changes.
        let of_limbs = Limits { hue: most_hue.min(1.9), both: 1.9, light: 0.16 };
        // Flat halved; doubled, 91 % of the beige clothes are skin.
        let of_trunk = Limits { hue: most_hue.min(0.8), both: 1.5, light: 0.06 };
        // A leg may be paler than the hands overall, but is seamless with the skin it adjoins.
        let if_seamless = Limits { both: 3.0, ..of_limbs };
        for part in one_sided {
            let likeness = self.likeness(&part);
            let is_skin = if_seamless.allow(&likeness)
                && match self.joint(&part) {
                    Joint::Cut => false,
                    Joint::Open => of_limbs.allow(&likeness),
                    Joint::Seamless => true,
                };
            if is_skin {
                self.grow(&part);
            }
        }
        for part in two_sided {
            if of_trunk.allow(&self.likeness(&part)) && self.joint(&part) != Joint::Cut {
                self.grow(&part);
            }
        }
    }

    /// Assigns texels close to edges, and small parts, to skin or non-skin, whichever has the
    /// least path cost.
    fn divide(&mut self) {
        let Self { body, steps, known, .. } = *self;
        let is_free =
            |at: usize| body.bits[at].is_covered() && known[at] >= 0.5 && !steps.barrier.narrow[at];
        let mut side = map_indices(known.len(), |at| {
            // Within the barrier growth may have crossed the very edge it marks: decided anew.
            (is_free(at) && self.growth.has_core(steps, at as u32)).then_some(true)
        });
        let is_other = |texel: u32| is_free(texel as usize) && !self.growth.has(texel);
        for part in parts(body, steps, CUT, self.texels(), is_other) {
            if part.len() >= self.share(MIN_PART) {
                part.into_iter().for_each(|texel| side[texel as usize] = Some(false));
            }
        }
        divided(body, steps, &mut side);
        self.is_skin = map_indices(side.len(), |at| side[at].unwrap_or(false) && self.is_open[at]);
    }

    /// Fills small holes in the skin, such as moles.
    fn fill(&mut self) {
        let body = self.body;
        let is_hole =
            |at: usize| body.bits[at].is_covered() && !self.is_skin[at] && self.known[at] >= 0.5;
        let holes: Vec<bool> = map_indices(self.known.len(), is_hole);
        let [most, alike] = [FLECK, ALIKE_FLECK].map(|share| self.share(share));
        for part in super::super::geodesic::parts(&body.grid, &holes) {
            if part.len() > alike {
                continue;
            }
            let Likeness { hue, light } = self.likeness(&part);
            // Larger flecks only where they are not lighter: moles, nipples and hairs are darker
            // than skin.
            if part.len() <= most || (hue < 4.0 && light < 0.15) {
                part.into_iter().for_each(|texel| self.is_skin[texel as usize] = true);
            }
        }
    }

    /// The skin mask, soft at edges, 0 to 255.
    pub fn levels(&self) -> Vec<u8> {
        let grid = &self.body.grid;
        let width = grid.size().width as usize;
        let mut levels = vec![0; self.known.len()];
        for_each_chunk(&mut levels, width, |y, row| {
            for (x, level) in row.iter_mut().enumerate() {
                let texel = y * width + x;
                if !self.body.bits[texel].is_covered() {
                    continue;
                }
                let skin = |at: usize| f32::from(u8::from(self.is_skin[at]));
                let at = |near: u32| skin(if near == NONE { texel } else { near as usize });
                let around = grid.beside(texel as u32).map(at).into_iter().sum::<f32>();
                // Half from the neighbours, or edges would be staircases of texels.
                let soft = 0.5 * skin(texel) + 0.125 * around;
                *level = (soft * self.known[texel] * 255.0 + 0.5) as u8;
            }
        });
        for (texel, detail) in &self.body.details {
            let level = &mut levels[*texel as usize];
            let share = share_of_skin(detail, &self.deviation[*texel as usize]);
            *level = (f32::from(*level) * share + 0.5) as u8;
        }
        levels
    }
}

/// The skin weight of a texel of the head: half on lips, 0 on eyes, brows and hair.
fn share_of_skin(detail: &Detail, deviation: &Deviation) -> f32 {
    let Deviation { hue, pale, light } = *deviation;
    // The limits are those of `Finder::weights` in `find`, with lightness relative to all skin.
    let [lips, sockets] = [detail.lips, detail.sockets].map(|area| smoothstep(0.1, 0.5, area));
    let dark = |from: f32, to: f32| smoothstep(from, to, -light);
    let white = smoothstep(3.0, 5.0, pale) * smoothstep(-0.7, -0.3, light);
    let hair = smoothstep(1.5, 3.0, hue).max(smoothstep(0.12, 0.3, light.abs()));
    let none = smoothstep(0.3, 0.7, detail.eyes)
        .max(smoothstep(0.3, 0.7, detail.mouth))
        .max(lips * white.max(dark(0.9, 1.3)))
        .max(sockets * white.max(dark(0.5, 0.9)))
        .max(smoothstep(0.1, 0.4, detail.brows) * dark(0.1, 0.3))
        .max(smoothstep(0.2, 0.6, detail.scalp) * hair);
    let lip = lips * smoothstep(1.5, 3.0, hue).max(dark(0.12, 0.3));
    (1.0 - none) * (1.0 - 0.5 * lip)
}

/// The known colours of some texels, evenly subsampled.
fn some_colors(texels: &[u32], colors: &GridColors) -> Vec<[f32; 3]> {
    let is_known = |&&texel: &&u32| colors.known[texel as usize] >= 0.5;
    let step = texels.len().div_ceil(MAX_COLORS).max(1);
    let some = texels.iter().step_by(step).filter(is_known);
    some.map(|&texel| colors.rgb[texel as usize]).collect()
}
