//! From growth to what is skin.

use super::grow::{Growth, divided, parts};
use super::layout::{BodyLayout, Detail};
use super::steps::Steps;
use crate::easing::smoothstep;
use crate::layout_grid::{GridColors, NONE};
use crate::skin::{Deviation, SkinError, SkinModel};
use crate::threads::{for_each_chunk, map_indices};

/// Skin reaches over steps of so many ΔE in all.
const REACH: f32 = 1.5;
/// Steps of more than this, in ΔE from a texel to the next, cut parts apart.
const CUT: f32 = 0.35;
/// What is smaller, as a share of all texels, is a fleck: skin where skin encloses it.
const FLECK: f32 = 0.0012;
/// The same for what has about skin's hue, as moles, nipples and hair on arms have.
const ALIKE_FLECK: f32 = 0.006;
/// The least part that is looked at by itself.
const LEAST_PART: f32 = 0.002;
/// A part is near skin if this share of its edge is,
const TOUCH: f32 = 0.06;
/// at most so many texels from it,
const ACROSS: usize = 56;
/// or touches it within so many where all skin is close to edges,
const WIDTH: usize = 6;
/// and one with it if colours on both sides differ by less than this on the whole, in ΔE.
const ALIKE: f32 = 2.5;
/// The same beside hands and feet.
const ALIKE_ENDS: f32 = 9.0;
/// A part is seamless with skin if colours differ by less than this where it touches it,
const SEAMLESS: f32 = 0.2;
/// at so many texels within [`WIDTH`] of its edge for one of that.
const LONG_TOUCH: f32 = 3.0;
/// Tones that differ by less in hue and light are one.
const SAME: (f32, f32) = (0.3, 0.03);
/// How much farther in hue than hands other parts of the body may be.
const MORE_HUE: f32 = 1.7;
/// So much of a part's lightness, as a logarithm, counts as one standard deviation of hue.
const LIGHT: f32 = 12.0;
/// Colours that models of skin and medians are made of, at most.
const MOST_COLORS: usize = 3000;

/// Which texels are skin.
pub(super) struct Decision<'a> {
    body: &'a BodyLayout,
    steps: &'a Steps,
    known: &'a [f32],
    deviation: Vec<Deviation>,
    is_end: Vec<bool>,
    /// Where skin may be.
    is_open: Vec<bool>,
    growth: Growth,
    is_skin: Vec<bool>,
}

/// How colours on both sides of an edge differ.
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

    /// Whether it is less than `most` ΔE on the whole, or there are less than `least` places to tell.
    fn is_within(&self, most: f32, least: f32) -> bool {
        let squares = self.sum.map(|sum| (sum / self.count.max(1.0)).powi(2));
        self.count < least || squares.iter().sum::<f32>() < most * most
    }
}

/// How a part differs from skin, by the medians of its texels.
struct Likeness {
    hue: f32,
    light: f32,
}

/// How a part is joined to skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joint {
    /// An edge of colour is between them.
    Cut,
    /// There is none, as far as can be told.
    Open,
    /// Both are one colour along much of its edge.
    Seamless,
}

/// How far parts may be from skin.
#[derive(Debug, Clone, Copy)]
struct Likely {
    hue: f32,
    /// Hue and light together.
    both: f32,
    light: f32,
}

impl Likely {
    fn has(&self, found: &Likeness) -> bool {
        let light = found.light.abs();
        found.hue < self.hue && light < self.light && found.hue + LIGHT * light < self.both
    }
}

impl<'a> Decision<'a> {
    /// # Errors
    /// [`SkinError`] if neither the face nor the neck is of one colour.
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
        let is_plain = |&&texel: &&u32| {
            let Deviation { hue, light, .. } = decision.deviation[texel as usize];
            hue < 2.0 && light.abs() < 0.4
        };
        let mut seeds: Vec<u32> = body.face.iter().filter(is_plain).copied().collect();
        if 2 * seeds.len() <= body.face.len() {
            // A blank head, or none.
            seeds = body.neck.iter().chain(&body.hands).filter(is_plain).copied().collect();
        }
        decision.grow(&seeds);
        decision.add_area(&body.neck, Likely { hue: 1.2, both: 2.2, light: 0.16 });
        // The neck's own tone, where the face's leads there, is what hands and feet have.
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

    /// Compares colours with a model of skin; the nearest of several counts.
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
        let step = part.len().div_ceil(MOST_COLORS).max(1);
        let median = |value: fn(&Deviation) -> f32| {
            let texels = part.iter().step_by(step);
            let mut values: Vec<f32> =
                texels.map(|&texel| value(&self.deviation[texel as usize])).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f32::total_cmp).1
        };
        Likeness {
            hue: median(|deviation| deviation.hue),
            light: median(|deviation| deviation.light),
        }
    }

    /// Whether an edge of colour cuts a part off from skin.
    ///
    /// Of all ways to skin across edges as a whole: single ones cross where shadows make both sides alike. Hands and feet
    /// are redder than what they are at.
    fn joint(&self, part: &[u32]) -> Joint {
        let grid = &self.body.grid;
        // One more than a texel's number, 0 for none: what is not written is no memory yet.
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
        // Skin may be no wider than what is close to its edge.
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

    /// What looks like skin and growth has not reached, largest parts first.
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
        found.retain(|part| part.len() >= self.share(LEAST_PART));
        found.sort_by_key(|part| std::cmp::Reverse(part.len()));
        found
    }

    /// How far parts of the body may be from skin's hue: somewhat farther than hands are, where those are known.
    fn most_hue(&self) -> f32 {
        let hands = self.body.hands.iter().filter(|&&texel| self.growth.has(texel));
        let hands: Vec<u32> = hands.copied().collect();
        if hands.len() < self.share(LEAST_PART) {
            return f32::INFINITY;
        }
        self.likeness(&hands).hue + MORE_HUE
    }

    /// Hands and feet behind sleeves and trousers.
    fn add_ends(&mut self) {
        // Trousers may reach over feet.
        for (area, both) in [(&self.body.hands, f32::INFINITY), (&self.body.feet, 2.2)] {
            let hue = self.most_hue().min(2.2);
            self.add_area(area, Likely { hue, both, light: 0.35 });
        }
    }

    /// Parts of an area that are skin by their colour and not cut off from skin that they touch.
    fn add_area(&mut self, area: &[u32], most: Likely) {
        let mut is_within = vec![false; self.known.len()];
        area.iter().for_each(|&texel| is_within[texel as usize] = true);
        for part in self.candidates(area.iter().copied(), |at| is_within[at]) {
            if most.has(&self.likeness(&part)) && self.joint(&part) != Joint::Cut {
                self.grow(&part);
            }
        }
    }

    /// Arms and legs between cloth; a belly too, if its colour is skin's own.
    fn add_parts(&mut self) {
        let bits = &self.body.bits;
        let is_two_sided = |part: &Vec<u32>| {
            let left = part.iter().filter(|&&texel| bits[texel as usize].is_left()).count();
            (0.1..0.9).contains(&(left as f32 / part.len() as f32))
        };
        let found = self.candidates(self.texels(), |at| !bits[at].is_detail());
        let (two_sided, one_sided): (Vec<_>, Vec<_>) = found.into_iter().partition(is_two_sided);
        // Legs come in two parts, trousers and shirts in one.
        let most_hue = self.most_hue();
        let of_limbs = Likely { hue: most_hue.min(1.9), both: 1.9, light: 0.16 };
        let of_trunk = Likely { hue: most_hue.min(0.8), both: 1.5, light: 0.06 };
        // A leg may be paler than hands all over, and is one colour with what it is at.
        let if_seamless = Likely { both: 3.0, ..of_limbs };
        for part in one_sided {
            let likeness = self.likeness(&part);
            let is_skin = if_seamless.has(&likeness)
                && match self.joint(&part) {
                    Joint::Cut => false,
                    Joint::Open => of_limbs.has(&likeness),
                    Joint::Seamless => true,
                };
            if is_skin {
                self.grow(&part);
            }
        }
        for part in two_sided {
            if of_trunk.has(&self.likeness(&part)) && self.joint(&part) != Joint::Cut {
                self.grow(&part);
            }
        }
    }

    /// Gives what is close to edges, and what is small, to skin or not, whichever is nearer over steps.
    fn divide(&mut self) {
        let Self { body, steps, known, .. } = *self;
        let is_free =
            |at: usize| body.bits[at].is_covered() && known[at] >= 0.5 && !steps.barrier.narrow[at];
        let mut side = map_indices(known.len(), |at| {
            (is_free(at) && self.growth.has_core(steps, at as u32)).then_some(true)
        });
        let is_other = |texel: u32| is_free(texel as usize) && !self.growth.has(texel);
        for part in parts(body, steps, CUT, self.texels(), is_other) {
            if part.len() >= self.share(LEAST_PART) {
                part.into_iter().for_each(|texel| side[texel as usize] = Some(false));
            }
        }
        divided(body, steps, &mut side);
        self.is_skin = map_indices(side.len(), |at| side[at].unwrap_or(false) && self.is_open[at]);
    }

    /// Moles and the like: what skin encloses.
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
            if part.len() <= most || (hue < 4.0 && light < 0.15) {
                part.into_iter().for_each(|texel| self.is_skin[texel as usize] = true);
            }
        }
    }

    /// How far texels are skin, soft at edges, 0 to 255.
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

/// How far a texel of the head takes part: lips half, eyes, brows and hair not.
fn share_of_skin(detail: &Detail, deviation: &Deviation) -> f32 {
    let Deviation { hue, pale, light } = *deviation;
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

/// Colours of some texels, where they are known.
fn some_colors(texels: &[u32], colors: &GridColors) -> Vec<[f32; 3]> {
    let is_known = |&&texel: &&u32| colors.known[texel as usize] >= 0.5;
    let step = texels.len().div_ceil(MOST_COLORS).max(1);
    let some = texels.iter().step_by(step).filter(is_known);
    some.map(|&texel| colors.rgb[texel as usize]).collect()
}
