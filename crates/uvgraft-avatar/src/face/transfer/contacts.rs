//! Lids that meet and lips that close, as on the source.

use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::deform::{DeformationTransfer, Handles, Row};

use super::super::FaceError;
use super::super::features::{Face, Opening};
use super::super::surface::Spot;
use super::eyelids::Eyelids;
use super::parts::Parts;

/// Lids of which less than this share of the gap is left are closed.
const SHUT: f32 = 0.2;
/// Lips that part by less than this, in distances between the eyes, are closed: 0.5 mm.
const TOUCHING: f32 = 0.008;
/// Lips of which less than this share of the jaw's opening is left are closed.
const SEALED: f32 = 0.15;

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
    /// The largest deviation along the opening after the transfer, in the target's unit: a gap, or an
    /// overlap (negative) larger than the source's.
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
    eyelids: Vec<Eyelids<'a>>,
    source_rest: &'a [[f32; 3]],
    /// For each eye, the heights of the upper margins of its lids, followed by those of the lower ones.
    lids: [Handles; 2],
    lips: Handles,
}

/// The offsets of the source's and of the target's vertices where the jaw is open.
type Opened = (Vec<[f32; 3]>, Vec<[f32; 3]>);

/// The lips in an expression, along the up axis, relative to rest.
struct Lips {
    /// The range in which each opening of the target should be; `None` where they part.
    wanted: Vec<Option<[f32; 2]>>,
    /// How the jaw opens them, for an expression that closes them again.
    jaw: Vec<f32>,
}

impl<'a> Contacts<'a> {
    /// - `parts`: with the target's eyeballs.
    pub fn new(
        source: &'a Mesh,
        target: &'a Mesh,
        deform: &'a DeformationTransfer,
        parts: &Parts,
    ) -> Result<Self, FaceError> {
        let face = Face::find(target)?;
        let up = Self::up(&face);
        let lids = [0, 1].map(|side| {
            let lids = &face.eyes[side].lids;
            let upper = lids.iter().map(|lid| row(&lid.upper, up));
            let lower = lids.iter().map(|lid| row(&lid.lower, up));
            deform.handles(&upper.chain(lower).collect::<Vec<Row>>())
        });
        let lips: Vec<Row> = face
            .lips
            .iter()
            .map(|lips| [row(&lips.upper, up), row(&lips.lower, -up)].concat())
            .collect();
        Ok(Self {
            source: Face::find(source).ok(),
            lips: deform.handles(&lips),
            lids,
            eyelids: Eyelids::find(target, &face, parts),
            target: face,
            rest: target.positions(),
            deform,
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
                    note(kind, self.shut(side, &source, &mut offsets[index]));
                }
            }
            self.eyelids.iter().for_each(|lids| lids.settle(&mut offsets[index]));
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
        let seen = self.source_gap(side, source).is_some_and(|[rest, gap]| gap < SHUT * rest);
        named || seen
    }

    /// The mean gap between the source's lids at rest and in an expression.
    fn source_gap(&self, side: usize, source: &[[f32; 3]]) -> Option<[f32; 2]> {
        let face = self.source.as_ref()?;
        let up = Self::up(face);
        let lids = &face.eyes[side].lids;
        let gap = |values: &[[f32; 3]]| {
            lids.iter().map(|lid| part(lid, values).dot(up)).sum::<f32>() / lids.len() as f32
        };
        let rest = gap(self.source_rest);
        Some([rest, rest + gap(source)])
    }

    /// Closes lids, the upper one onto the lower one; returns the largest gap before and after. Lids may
    /// overlap as far as the source's do, whose margins lie behind each other.
    fn shut(&self, side: usize, source: &[[f32; 3]], offsets: &mut [[f32; 3]]) -> [f32; 2] {
        const ROUNDS: usize = 3;
        let up = Self::up(&self.target);
        let scale = self.deform.alignment().scale as f32;
        let overlap = self.source_gap(side, source).map_or(0.0, |[_, gap]| scale * gap.min(0.0));
        let lids = &self.target.eyes[side].lids;
        let miss = |lid: &Opening, offsets: &[[f32; 3]]| {
            let gap = (part(lid, self.rest) + part(lid, offsets)).dot(up);
            gap - gap.clamp(overlap, 0.0)
        };
        let largest = |offsets: &[[f32; 3]]| largest(lids.iter().map(|lid| miss(lid, offsets)));
        let before = largest(offsets);
        for _ in 0..ROUNDS {
            let upper = lids.iter().map(|lid| Some(-miss(lid, offsets)));
            let changes: Vec<_> = upper.chain(lids.iter().map(|_| Some(0.0))).collect();
            self.correct(&self.lids[side], &changes, offsets);
            self.eyelids.iter().for_each(|lids| lids.clear(offsets));
        }
        [before, largest(offsets)]
    }

    /// Closes lips where the source's stay closed; returns the largest deviation before and after, if any
    /// had to be corrected.
    ///
    /// - `wide`: the offsets of the source and of the target that are added, of the jaw.
    fn seal(
        &self,
        source: &[[f32; 3]],
        wide: Option<&Opened>,
        offsets: &mut [[f32; 3]],
    ) -> Option<[f32; 2]> {
        const ROUNDS: usize = 2;
        /// Lips that miss their place by less, in distances between the eyes, are left: 0.1 mm.
        const CLOSE: f32 = 1.5e-3;
        let face = &self.target;
        let up = Self::up(face);
        let unit = face.frame.unit as f32;
        let moves = |lips: &Opening| {
            let longest = lips.upper.of(offsets).length().max(lips.lower.of(offsets).length());
            longest > TOUCHING * unit
        };
        if !face.lips.iter().any(moves) {
            return None;
        }
        let Lips { wanted, jaw } = self.lips(source, wide);
        let misses = |offsets: &[[f32; 3]]| -> Vec<Option<f32>> {
            let openings = face.lips.iter().zip(&jaw);
            let found = openings.map(|(lips, jaw)| part(lips, offsets).dot(up) + jaw);
            let miss = |(wanted, found): (&Option<[f32; 2]>, f32)| {
                let [least, most] = (*wanted)?;
                Some(found - found.clamp(least, most))
            };
            wanted.iter().zip(found).map(miss).collect()
        };
        let worst = |offsets: &[[f32; 3]]| largest(misses(offsets).into_iter().flatten());
        let before = worst(offsets);
        if before.abs() < CLOSE * unit {
            return None;
        }
        for _ in 0..ROUNDS {
            let changes: Vec<_> =
                misses(offsets).into_iter().map(|miss| miss.map(|miss| -miss)).collect();
            self.correct(&self.lips, &changes, offsets);
        }
        Some([before, worst(offsets)])
    }

    /// How far the lips should part: no farther than the source's if those stay closed, and not overlap
    /// more, as rolled lips do behind the line where they touch at rest. Without a source to compare
    /// with, lips close if they were opened by the jaw before.
    fn lips(&self, source: &[[f32; 3]], wide: Option<&Opened>) -> Lips {
        let scale = self.deform.alignment().scale as f32;
        let openings = |face: &Face, offsets: &[[f32; 3]]| -> Vec<f32> {
            let up = Self::up(face);
            face.lips.iter().map(|lips| part(lips, offsets).dot(up)).collect()
        };
        let columns = self.target.lips.len();
        let jaw = wide.map_or_else(|| vec![0.0; columns], |(_, jaw)| openings(&self.target, jaw));
        let Some(face) = &self.source else {
            return Lips { wanted: vec![wide.map(|_| [0.0; 2]); columns], jaw };
        };
        let mut from = openings(face, source);
        let mut limit = TOUCHING * face.frame.unit as f32;
        if let Some((jaw, _)) = wide {
            let opened = openings(face, jaw);
            limit = limit.max(SEALED * opened.iter().copied().fold(0.0, f32::max));
            from.iter_mut().zip(opened).for_each(|(from, opened)| *from += opened);
        }
        // Both run from one corner to the other, though some places may lack an opening.
        let wanted = |column: usize| {
            let found = from[column * from.len() / columns];
            let touching = TOUCHING * face.frame.unit as f32;
            (found < limit).then(|| [found.min(0.0), found.clamp(0.0, touching)].map(|d| scale * d))
        };
        Lips { wanted: (0..columns).map(wanted).collect(), jaw }
    }

    fn correct(&self, handles: &Handles, changes: &[Option<f32>], offsets: &mut [[f32; 3]]) {
        let correction = self.deform.correction(handles, changes);
        for (offset, change) in offsets.iter_mut().zip(correction) {
            (0..3).for_each(|k| offset[k] += change[k]);
        }
    }
}

/// The upper side of an opening relative to the lower one.
fn part(opening: &Opening, values: &[[f32; 3]]) -> Vec3 {
    opening.upper.of(values) - opening.lower.of(values)
}

/// The height of a spot along an axis.
fn row(spot: &Spot, axis: Vec3) -> Row {
    spot.parts().iter().map(|&(vertex, share)| (vertex, (axis * share).to_array())).collect()
}

/// The value with the largest magnitude; 0 if there is none.
fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(0.0, |most: f32, value| if value.abs() > most.abs() { value } else { most })
}
