//! Lids that meet and lips that close, as on the source.

use glam::{DVec3, Vec3};
use uvgraft::Mesh;
use uvgraft::deform::{Condition, DeformationTransfer};

use super::super::FaceError;
use super::super::features::{Face, Opening};
use super::parts::Parts;

/// Lids of which less than this share of the gap is left are closed.
const SHUT: f32 = 0.2;
/// Lips that part by less than this, in distances between the eyes, are closed: 0.5 mm.
const TOUCHING: f32 = 0.008;
/// Lips of which less than this share of the opening of the jaw is left are closed.
const SEALED: f32 = 0.15;
/// Skin stays this far from an eyeball's centre at least, in radii, unless it is nearer at rest.
const LID: f64 = 1.04;

/// What touches in an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactKind {
    /// The lids of the left eye.
    LeftLids,
    /// The lids of the right eye.
    RightLids,
    /// The lips; for `mouthClose` with `jawOpen`.
    Lips,
}

/// A contact that was corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Name of the expression.
    pub expression: String,
    /// What touches.
    pub kind: ContactKind,
    /// The largest gap or overlap (negative) along the opening after the transfer, in the target's
    /// unit.
    pub before: f32,
    /// The same after the correction.
    pub after: f32,
}

/// The lids and lips of both heads.
pub(super) struct Contacts<'a> {
    source: Option<Face>,
    target: Face,
    rest: &'a [[f32; 3]],
    deform: &'a DeformationTransfer,
    parts: &'a Parts,
    source_rest: &'a [[f32; 3]],
}

impl<'a> Contacts<'a> {
    /// - `parts`: with the target's eyeballs.
    pub fn new(
        source: &'a Mesh,
        target: &'a Mesh,
        deform: &'a DeformationTransfer,
        parts: &'a Parts,
    ) -> Result<Self, FaceError> {
        Ok(Self {
            source: Face::find(source).ok(),
            target: Face::find(target)?,
            rest: target.positions(),
            deform,
            parts,
            source_rest: source.positions(),
        })
    }

    /// Corrects the offsets of all expressions.
    ///
    /// - `from`: the source's offsets in an expression.
    pub fn close(
        &self,
        names: &[&str],
        from: impl Fn(usize) -> Vec<[f32; 3]>,
        offsets: &mut [Vec<[f32; 3]>],
    ) -> Vec<Contact> {
        let jaw = names.iter().position(|&name| name == "jawOpen");
        let mut contacts = Vec::new();
        // The jaw first, because lips that it parts are closed relative to it.
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by_key(|&index| Some(index) != jaw);
        for index in order {
            let source = from(index);
            let mut note = |kind, [before, after]: [f32; 2]| {
                let expression = names[index].to_owned();
                contacts.push(Contact { expression, kind, before, after });
            };
            for (side, kind) in
                [ContactKind::LeftLids, ContactKind::RightLids].into_iter().enumerate()
            {
                if self.shuts(names[index], side, &source) {
                    note(kind, self.shut(side, &mut offsets[index]));
                }
            }
            self.clear_eyes(&mut offsets[index]);
            let opened = jaw.filter(|_| names[index] == "mouthClose");
            let wide = opened.map(|jaw| (from(jaw), offsets[jaw].clone()));
            if let Some(gaps) = self.seal(&source, wide.as_ref(), &mut offsets[index]) {
                note(ContactKind::Lips, gaps);
            }
        }
        contacts
    }

    fn up(face: &Face) -> Vec3 {
        Vec3::from(face.frame.axes[1].map(|value| value as f32))
    }

    /// Whether an expression closes the lids of one eye.
    fn shuts(&self, name: &str, side: usize, source: &[[f32; 3]]) -> bool {
        let named = ["eyeBlinkLeft", "eyeBlinkRight"][side] == name;
        let seen = self.source.as_ref().is_some_and(|face| {
            let up = Self::up(face);
            let lids = &face.eyes[side].lids;
            let gap =
                |values: &[[f32; 3]]| lids.iter().map(|lid| part(lid, values).dot(up)).sum::<f32>();
            let rest = gap(self.source_rest);
            rest + gap(source) < SHUT * rest
        });
        named || seen
    }

    /// Closes lids; returns the largest gap before and after.
    fn shut(&self, side: usize, offsets: &mut [[f32; 3]]) -> [f32; 2] {
        const ROUNDS: usize = 3;
        let axes = [1, 2].map(|k| Vec3::from(self.target.frame.axes[k].map(|value| value as f32)));
        let lids = &self.target.eyes[side].lids;
        let gap = |lid: &Opening, offsets: &[[f32; 3]]| part(lid, self.rest) + part(lid, offsets);
        let largest =
            |offsets: &[[f32; 3]]| largest(lids.iter().map(|lid| gap(lid, offsets).dot(axes[0])));
        let before = largest(offsets);
        for _ in 0..ROUNDS {
            let conditions: Vec<Condition> = lids
                .iter()
                .flat_map(|lid| {
                    let gap = gap(lid, offsets);
                    axes.map(|axis| condition(lid, axis, -gap.dot(axis)))
                })
                .collect();
            self.correct(&conditions, offsets);
            self.clear_eyes(offsets);
        }
        [before, largest(offsets)]
    }

    /// Keeps skin out of the eyeballs, where it does not lie in them at rest.
    fn clear_eyes(&self, offsets: &mut [[f32; 3]]) {
        for eye in &self.parts.eyes {
            for (vertex, offset) in offsets.iter_mut().enumerate() {
                if *offset == [0.0; 3] || eye.vertices.binary_search(&(vertex as u32)).is_ok() {
                    continue;
                }
                let rest = Vec3::from(self.rest[vertex]).as_dvec3() - eye.center;
                let least = rest.length().min(LID * eye.radius);
                let moved = rest + Vec3::from(*offset).as_dvec3();
                let far = moved.length();
                if rest.length() > 2.0 * eye.radius || far >= least || far <= 0.0 {
                    continue;
                }
                let cleared: DVec3 = moved * (least / far);
                *offset = (cleared - rest).as_vec3().to_array();
            }
        }
    }

    /// Closes lips where the source's stay closed, and keeps them from overlapping; returns the largest
    /// gap before and after, if any had to be corrected.
    ///
    /// - `wide`: the offsets of the source and of the target that are added, of the jaw.
    fn seal(
        &self,
        source: &[[f32; 3]],
        wide: Option<&(Vec<[f32; 3]>, Vec<[f32; 3]>)>,
        offsets: &mut [[f32; 3]],
    ) -> Option<[f32; 2]> {
        const ROUNDS: usize = 2;
        let face = &self.target;
        let up = Self::up(face);
        let unit = face.frame.unit as f32;
        let opens = |lips: &Opening, offsets: &[[f32; 3]]| {
            let jaw = wide.map_or(0.0, |(_, jaw)| part(lips, jaw).dot(up));
            part(lips, offsets).dot(up) + jaw
        };
        if face.lips.iter().all(|lips| part(lips, offsets) == Vec3::ZERO) {
            return None;
        }
        let parted = self.parted(source, wide);
        let wanted = |lips: &Opening, offsets: &[[f32; 3]]| {
            let found = opens(lips, offsets);
            // Without a source to compare with, lips may part, but not overlap.
            let is_shut = parted.map_or(wide.is_some(), |parted| !parted);
            if is_shut { Some(0.0) } else { (found < 0.0).then_some(0.0) }
        };
        let misses = |offsets: &[[f32; 3]]| {
            largest(
                face.lips
                    .iter()
                    .filter_map(|lips| Some(opens(lips, offsets) - wanted(lips, offsets)?)),
            )
        };
        let before = misses(offsets);
        if before.abs() < 1e-4 * unit {
            return None;
        }
        for _ in 0..ROUNDS {
            let conditions: Vec<Condition> = face
                .lips
                .iter()
                .filter_map(|lips| {
                    let change = wanted(lips, offsets)? - opens(lips, offsets);
                    Some(condition(lips, up, change))
                })
                .collect();
            self.correct(&conditions, offsets);
        }
        Some([before, misses(offsets)])
    }

    /// Whether the source's lips part; `None` if they could not be found.
    fn parted(
        &self,
        source: &[[f32; 3]],
        wide: Option<&(Vec<[f32; 3]>, Vec<[f32; 3]>)>,
    ) -> Option<bool> {
        let face = self.source.as_ref()?;
        let up = Self::up(face);
        let most = |offsets: &[[f32; 3]], jaw: Option<&Vec<[f32; 3]>>| {
            let opens = |lips: &Opening| {
                part(lips, offsets).dot(up) + jaw.map_or(0.0, |jaw| part(lips, jaw).dot(up))
            };
            face.lips.iter().map(opens).fold(0.0, f32::max)
        };
        let limit = match wide {
            Some((jaw, _)) => SEALED * most(jaw, None),
            None => TOUCHING * face.frame.unit as f32,
        };
        Some(most(source, wide.map(|(jaw, _)| jaw)) > limit)
    }

    fn correct(&self, conditions: &[Condition], offsets: &mut [[f32; 3]]) {
        for (offset, change) in offsets.iter_mut().zip(self.deform.correction(conditions)) {
            (0..3).for_each(|k| offset[k] += change[k]);
        }
    }
}

/// The upper side of an opening relative to the lower one.
fn part(opening: &Opening, values: &[[f32; 3]]) -> Vec3 {
    opening.upper.of(values) - opening.lower.of(values)
}

/// That an opening changes by some amount along an axis.
fn condition(opening: &Opening, axis: Vec3, value: f32) -> Condition {
    let side = |spot: &super::super::surface::Spot, sign: f32| {
        let entry = move |&(vertex, share): &(u32, f32)| (vertex, (axis * sign * share).to_array());
        spot.parts().iter().map(entry).collect::<Vec<_>>()
    };
    let row = [side(&opening.upper, 1.0), side(&opening.lower, -1.0)].concat();
    Condition { row, value }
}

/// The value with the largest magnitude; 0 if there is none.
fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(0.0, |most: f32, value| if value.abs() > most.abs() { value } else { most })
}
