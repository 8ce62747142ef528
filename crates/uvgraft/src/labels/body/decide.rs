//! From growth to what is skin.

use crate::layout_grid::{GridColors, NONE};
use crate::skin::{Deviation, SkinError, SkinModel};
use crate::threads::{for_each_chunk, map_indices};

use super::super::evidence::ramp;
use super::grow::{Growth, divided, parts};
use super::layout::{BodyLayout, Detail};
use super::steps::Steps;

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
/// A part touches skin if this share of its edge does.
const TOUCH: f32 = 0.06;
/// Tones that differ by less in hue and light are one.
const SAME: (f32, f32) = (0.3, 0.03);
/// How much farther in hue than hands other parts of the body may be.
const MORE_HUE: f32 = 0.6;
/// How many texels wide a step is.
const WIDTH: usize = 4;
/// Colours that models of skin and medians are made of, at most.
const MOST_COLORS: usize = 3000;

/// Which texels are skin.
pub(super) struct Decision<'a> {
    body: &'a BodyLayout,
    steps: &'a Steps,
    known: &'a [f32],
    deviation: Vec<Deviation>,
    /// Where skin may be.
    is_open: Vec<bool>,
    growth: Growth,
    is_skin: Vec<bool>,
}

/// How a part differs from skin, by the medians of its texels.
struct Likeness {
    hue: f32,
    light: f32,
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
        let mut decision = Self {
            body,
            steps,
            known: &colors.known,
            deviation: Vec::new(),
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
        let old = std::mem::take(&mut self.deviation);
        let far = |deviation: &Deviation| deviation.hue + 5.0 * deviation.light.abs();
        self.deviation = map_indices(colors.rgb.len(), |texel| {
            if !self.body.bits[texel].is_covered() {
                return Deviation { hue: f32::INFINITY, pale: f32::INFINITY, light: 0.0 };
            }
            let new = deviations(colors.rgb[texel]);
            match old.get(texel) {
                Some(old) if far(old) < far(&new) => *old,
                _ => new,
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
        self.growth.add(&self.body.grid, self.steps, seeds.iter().copied(), &self.is_open);
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

    /// Which share of a part's edge is beside skin.
    fn touch(&self, part: &[u32]) -> f32 {
        let grid = &self.body.grid;
        let mut within = vec![false; self.known.len()];
        part.iter().for_each(|&texel| within[texel as usize] = true);
        let is_edge = |texel: u32| grid.neighbours(texel).any(|near| !within[near as usize]);
        let edge: Vec<u32> = part.iter().copied().filter(|&texel| is_edge(texel)).collect();
        let touching = edge.iter().filter(|&&texel| self.is_near_skin(texel)).count();
        touching as f32 / edge.len().max(1) as f32
    }

    fn is_near_skin(&self, texel: u32) -> bool {
        let (mut around, mut first) = (vec![texel], 0);
        for _ in 0..WIDTH {
            let end = around.len();
            for index in first..end {
                for near in self.body.grid.neighbours(around[index]) {
                    if self.growth.has(near) {
                        return true;
                    }
                    if !around.contains(&near) {
                        around.push(near);
                    }
                }
            }
            first = end;
        }
        false
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
        let mut found = parts(&self.body.grid, self.steps, CUT, from, is_like);
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
        for area in [&self.body.hands, &self.body.feet] {
            let most_hue = self.most_hue().min(2.2);
            let mut is_end = vec![false; self.known.len()];
            area.iter().for_each(|&texel| is_end[texel as usize] = true);
            for part in self.candidates(area.iter().copied(), |at| is_end[at]) {
                let Likeness { hue, light } = self.likeness(&part);
                if hue < most_hue && light.abs() < 0.35 && self.touch(&part) < TOUCH {
                    self.grow(&part);
                }
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
        for (parts, most) in [(one_sided, (1.6_f32, 0.16)), (two_sided, (0.8, 0.06))] {
            for part in parts {
                let Likeness { hue, light } = self.likeness(&part);
                if hue < most.0.min(most_hue) && light.abs() < most.1 && self.touch(&part) < TOUCH {
                    self.grow(&part);
                }
            }
        }
    }

    /// Gives what is close to edges, and what is small, to skin or not, whichever is nearer over steps.
    fn divide(&mut self) {
        let Self { body, steps, known, .. } = *self;
        let is_free =
            |at: usize| body.bits[at].is_covered() && known[at] >= 0.5 && !steps.barrier[at];
        let mut side = map_indices(known.len(), |at| {
            (is_free(at) && self.growth.has(at as u32)).then_some(true)
        });
        let is_other = |texel: u32| is_free(texel as usize) && !self.growth.has(texel);
        for part in parts(&body.grid, steps, CUT, self.texels(), is_other) {
            if part.len() >= self.share(LEAST_PART) {
                part.into_iter().for_each(|texel| side[texel as usize] = Some(false));
            }
        }
        divided(&body.grid, steps, &mut side);
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
    let [lips, sockets] = [detail.lips, detail.sockets].map(|area| ramp(0.1, 0.5, area));
    let dark = |from: f32, to: f32| ramp(from, to, -light);
    let white = ramp(3.0, 5.0, pale) * ramp(-0.7, -0.3, light);
    let hair = ramp(1.5, 3.0, hue).max(ramp(0.12, 0.3, light.abs()));
    let none = ramp(0.3, 0.7, detail.eyes)
        .max(ramp(0.3, 0.7, detail.mouth))
        .max(lips * white.max(dark(0.9, 1.3)))
        .max(sockets * white.max(dark(0.5, 0.9)))
        .max(ramp(0.1, 0.4, detail.brows) * dark(0.1, 0.3))
        .max(ramp(0.2, 0.6, detail.scalp) * hair);
    let lip = lips * ramp(1.5, 3.0, hue).max(dark(0.12, 0.3));
    (1.0 - none) * (1.0 - 0.5 * lip)
}

/// Colours of some texels, where they are known.
fn some_colors(texels: &[u32], colors: &GridColors) -> Vec<[f32; 3]> {
    let is_known = |&&texel: &&u32| colors.known[texel as usize] >= 0.5;
    let step = texels.len().div_ceil(MOST_COLORS).max(1);
    let some = texels.iter().step_by(step).filter(is_known);
    some.map(|&texel| colors.rgb[texel as usize]).collect()
}
