//! From growth to what is skin.

use crate::layout_grid::{GridColors, NONE};
use crate::skin::{Deviation, SkinError, SkinModel};
use crate::threads::map_indices;

use super::super::evidence::ramp;
use super::grow::{divided, grown, parts, widened};
use super::steps::{GAP, Steps};
use super::{BodyLayout, MOST_COLORS, skin_of};

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
/// How many texels wide a step is.
const WIDTH: usize = 4;

/// Which texels are skin.
pub(super) struct Decision<'a> {
    body: &'a BodyLayout,
    steps: &'a Steps,
    known: &'a [f32],
    deviation: Vec<Deviation>,
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
    ) -> Result<Self, SkinError> {
        let areas = &body.areas;
        let of_face = skin_of(&areas.face, colors)
            .or_else(|error| skin_of(&areas.neck, colors).map_err(|_| error))?;
        let mut decision = Self {
            body,
            steps,
            known: &colors.known,
            deviation: deviations(body, colors, &[of_face]),
            is_skin: Vec::new(),
        };
        let start = |&texel: &u32| {
            let at = texel as usize;
            let Deviation { hue, light, .. } = decision.deviation[at];
            areas.face[at] >= 0.5 && decision.is_open(texel) && hue < 2.0 && light.abs() < 0.4
        };
        let seeds = decision.texels().filter(start);
        decision.is_skin = decision.grown(seeds);
        // The neck's own tone, where the face's leads there, is what hands and feet have.
        let on_neck: Vec<f32> = (0..areas.neck.len())
            .map(|texel| if decision.is_skin[texel] { areas.neck[texel] } else { 0.0 })
            .collect();
        if let Ok(of_neck) = skin_of(&on_neck, colors) {
            decision.deviation = deviations(body, colors, &[of_face, of_neck]);
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

    /// Whether skin may grow over a texel.
    fn is_open(&self, texel: u32) -> bool {
        let texel = texel as usize;
        let Deviation { hue, light, .. } = self.deviation[texel];
        self.body.grid.faces()[texel] != NONE
            && self.known[texel] >= 0.5
            && self.body.areas.eyes[texel] < 0.5
            && self.body.areas.mouth[texel] < 0.5
            && hue < 6.0
            && light > -1.5
            && light < 0.8
    }

    /// What seeds reach without passing gaps in edges, and up to those edges.
    fn grown(&self, seeds: impl Iterator<Item = u32>) -> Vec<bool> {
        let Self { body, steps, .. } = *self;
        let is_free = |texel: u32| self.is_open(texel) && !steps.barrier[texel as usize];
        let found = grown(&body.grid, steps, seeds.filter(|&texel| is_free(texel)), REACH, is_free);
        let close = widened(&body.grid, &found, GAP + WIDTH);
        let found = self.texels().filter(|&texel| found[texel as usize]);
        grown(&body.grid, steps, found, REACH, |texel| close[texel as usize] && self.is_open(texel))
    }

    fn likeness(&self, part: &[u32]) -> Likeness {
        let step = part.len().div_ceil(MOST_COLORS).max(1);
        let median = |value: &dyn Fn(&Deviation) -> f32| {
            let texels = part.iter().step_by(step);
            let mut values: Vec<f32> =
                texels.map(|&texel| value(&self.deviation[texel as usize])).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f32::total_cmp).1
        };
        Likeness {
            hue: median(&|deviation| deviation.hue),
            light: median(&|deviation| deviation.light),
        }
    }

    /// Which share of a part's edge is beside skin.
    fn touch(&self, part: &[u32]) -> f32 {
        let grid = &self.body.grid;
        let mut within = vec![false; self.known.len()];
        part.iter().for_each(|&texel| within[texel as usize] = true);
        let near_skin = &widened(grid, &self.is_skin, WIDTH);
        let (mut edge, mut touching) = (0, 0);
        for &texel in part {
            if grid.neighbours(texel).any(|near| !within[near as usize]) {
                edge += 1;
                touching += usize::from(near_skin[texel as usize]);
            }
        }
        touching as f32 / edge.max(1) as f32
    }

    fn accept(&mut self, part: &[u32]) {
        let found = self.grown(part.iter().copied());
        for (is_skin, found) in self.is_skin.iter_mut().zip(found) {
            *is_skin |= found;
        }
    }

    /// Hands and feet behind sleeves and trousers.
    fn add_ends(&mut self) {
        let areas = &self.body.areas;
        for area in [&areas.hands, &areas.feet] {
            let is_end = |texel: u32| {
                area[texel as usize] >= 0.5
                    && !self.is_skin[texel as usize]
                    && self.is_open(texel)
                    && self.deviation[texel as usize].hue < 3.0
            };
            let mut found = parts(&self.body.grid, self.steps, CUT, is_end);
            found.retain(|part| part.len() >= self.share(LEAST_PART));
            found.sort_by_key(|part| std::cmp::Reverse(part.len()));
            for part in found {
                let Likeness { hue, light } = self.likeness(&part);
                if hue < 2.2 && light.abs() < 0.35 && self.touch(&part) < TOUCH {
                    self.accept(&part);
                }
            }
        }
    }

    /// Arms and legs between cloth; a belly too, if its colour is skin's own.
    fn add_parts(&mut self) {
        let is_open = |texel: u32| {
            !self.is_skin[texel as usize]
                && self.is_open(texel)
                && self.deviation[texel as usize].hue < 3.0
                && !self.body.is_detail(texel as usize)
        };
        let mut found = parts(&self.body.grid, self.steps, CUT, is_open);
        found.retain(|part| part.len() >= self.share(LEAST_PART));
        let two_sided = |part: &[u32]| {
            let left = part.iter().filter(|&&texel| self.body.leftness[texel as usize] > 0.0);
            let left = left.count() as f32 / part.len() as f32;
            (0.1..0.9).contains(&left)
        };
        let mut found: Vec<_> = found.into_iter().map(|part| (two_sided(&part), part)).collect();
        found.sort_by_key(|(two_sided, part)| (*two_sided, std::cmp::Reverse(part.len())));
        for (two_sided, part) in found {
            let Likeness { hue, light } = self.likeness(&part);
            let (most_hue, most_light) = if two_sided { (0.8, 0.06) } else { (1.6, 0.16) };
            if hue < most_hue && light.abs() < most_light && self.touch(&part) < TOUCH {
                self.accept(&part);
            }
        }
    }

    /// Gives what is close to edges, and what is small, to skin or not, whichever is nearer over steps.
    fn divide(&mut self) {
        let Self { body, steps, known, .. } = *self;
        let is_free = |texel: u32| {
            let at = texel as usize;
            body.grid.faces()[at] != NONE && known[at] >= 0.5 && !steps.barrier[at]
        };
        let mut side = vec![None; known.len()];
        for texel in self.texels().filter(|&texel| is_free(texel)) {
            if self.is_skin[texel as usize] {
                side[texel as usize] = Some(true);
            }
        }
        let is_other = |texel: u32| is_free(texel) && !self.is_skin[texel as usize];
        for part in parts(&body.grid, steps, CUT, is_other) {
            if part.len() >= self.share(LEAST_PART) {
                part.into_iter().for_each(|texel| side[texel as usize] = Some(false));
            }
        }
        divided(&body.grid, steps, &mut side);
        for (texel, side) in side.into_iter().enumerate() {
            self.is_skin[texel] = side.unwrap_or(false) && self.is_open(texel as u32);
        }
    }

    /// Moles and the like: what skin encloses.
    fn fill(&mut self) {
        let body = self.body;
        let is_open = |texel: u32| {
            let at = texel as usize;
            body.grid.faces()[at] != NONE && !self.is_skin[at] && self.known[at] >= 0.5
        };
        let all: Vec<bool> = self.texels().map(is_open).collect();
        let largest = self.share(ALIKE_FLECK);
        for part in super::super::geodesic::parts(&body.grid, &all) {
            if part.len() > largest {
                continue;
            }
            let Likeness { hue, light } = self.likeness(&part);
            let is_alike = hue < 4.0 && light < 0.15;
            if is_alike || part.len() <= self.share(FLECK) {
                part.into_iter().for_each(|texel| self.is_skin[texel as usize] = true);
            }
        }
    }

    /// How far texels are skin, soft at edges.
    pub fn weights(&self) -> Vec<f32> {
        let grid = &self.body.grid;
        let hard: Vec<f32> = self.is_skin.iter().map(|&is| f32::from(u8::from(is))).collect();
        map_indices(hard.len(), |texel| {
            if grid.faces()[texel] == NONE {
                return 0.0;
            }
            let beside = grid.beside(texel as u32);
            let at = |near: u32| if near == NONE { hard[texel] } else { hard[near as usize] };
            let around = beside.map(at).into_iter().sum::<f32>();
            let soft = 0.5 * hard[texel] + 0.125 * around;
            soft * self.known[texel] * self.detail(texel)
        })
    }

    /// How far a texel of the head takes part: lips half, eyes, brows and hair not.
    fn detail(&self, texel: usize) -> f32 {
        if !self.body.is_detail(texel) {
            return 1.0;
        }
        let areas = &self.body.areas;
        let Deviation { hue, pale, light } = self.deviation[texel];
        let at = |area: &[f32], from: f32, to: f32| ramp(from, to, area[texel]);
        let (lips, sockets) = (at(&areas.lips, 0.1, 0.5), at(&areas.sockets, 0.1, 0.5));
        let dark = |from: f32, to: f32| ramp(from, to, -light);
        let white = ramp(3.0, 5.0, pale) * ramp(-0.7, -0.3, light);
        let none = at(&areas.eyes, 0.3, 0.7)
            .max(at(&areas.mouth, 0.3, 0.7))
            .max(lips * white.max(dark(0.9, 1.3)))
            .max(sockets * white.max(dark(0.5, 0.9)))
            .max(at(&areas.brows, 0.1, 0.4) * dark(0.1, 0.3))
            .max(
                at(&areas.scalp, 0.2, 0.6) * ramp(1.5, 3.0, hue).max(ramp(0.12, 0.3, light.abs())),
            );
        let lip = lips * ramp(1.5, 3.0, hue).max(dark(0.12, 0.3));
        (1.0 - none) * (1.0 - 0.5 * lip)
    }
}

/// How texels differ from the nearest of some models of skin.
fn deviations(body: &BodyLayout, colors: &GridColors, models: &[SkinModel]) -> Vec<Deviation> {
    map_indices(colors.rgb.len(), |texel| {
        let mut best = Deviation { hue: f32::INFINITY, pale: f32::INFINITY, light: 0.0 };
        if body.grid.faces()[texel] == NONE {
            return best;
        }
        let far = |deviation: &Deviation| deviation.hue + 5.0 * deviation.light.abs();
        for deviation in models.iter().map(|model| model.deviation(colors.rgb[texel])) {
            if far(&deviation) < far(&best) {
                best = deviation;
            }
        }
        best
    })
}
