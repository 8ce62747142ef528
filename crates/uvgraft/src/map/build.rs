//! Building a map: patches first, then runs, block of rows by block.

use super::coverage::{Layout, Span, Sweep, corners_px};
use super::gutter::{Border, Winners};
use super::rows::{Block, Draft, Rows};
use super::surroundings::{Surroundings, merge};
use super::{Affine, MapStats, Patch, Precedence, Run, SamplingMap};
use crate::pair::{Direction, Oriented};
use crate::texture::Size;
use crate::threads::{extend_indices, join, map_indices_with};

/// In place of the patch of a face that has none.
const UNLINKED: u32 = u32::MAX;

/// - `gutter_px`: how many texels beyond the islands are filled.
/// - `precedence`: of the layout that is filled.
pub(super) fn build(
    oriented: &Oriented<'_>,
    direction: Direction,
    size: Size,
    gutter_px: u32,
    precedence: impl FnOnce() -> Precedence + Send,
) -> SamplingMap {
    let to = oriented.to;
    let (precedence, (layout, (patch_of_face, mut patches))) =
        join(precedence, || (Layout::new(to, size), linked_patches(oriented, size)));
    let patch = |face: u32| patch_of_face[face as usize];
    let is_linked = |face| patch(face) != UNLINKED;
    let lost = precedence.lost_edges(&layout);
    let border = Border::new(to, precedence.islands(), &lost, size, gutter_px, is_linked);

    let gutter_patches = patches.len() as u32;
    let mut beside = Vec::new();
    extend_indices(&mut beside, border.patches(), |index| {
        let of_face = |face: u32| &patches[patch(face) as usize];
        let (face, affine) = border.patch(index, |face| &of_face(face).src_uv_from_tgt_px);
        Patch { src_uv_from_tgt_px: affine, jacobian: of_face(face).jacobian, face }
    });
    patches.append(&mut beside);

    let plan = Plan { layout, precedence, border, patch_of_face, gutter_patches };
    let blocks = plan.layout.blocks.count();
    let new_worker = || Worker::new(size.width);
    let mut parts =
        map_indices_with(blocks, new_worker, |worker, block| worker.build(&plan, block, None));
    // Who lost texels to whom is known by now, and decides about a few texels around them.
    let mut clashes: Vec<(u32, u32)> =
        parts.iter_mut().flat_map(|part| std::mem::take(&mut part.clashes)).collect();
    clashes.sort_unstable();
    clashes.dedup();
    if !clashes.is_empty() {
        let winners = plan.border.winners(clashes);
        let concerned = winners.concerned();
        let again = map_indices_with(concerned.len(), new_worker, |worker, index| {
            worker.build(&plan, concerned[index], Some(&winners))
        });
        for (block, part) in concerned.into_iter().zip(again) {
            parts[block] = part;
        }
    }

    let mut stats = MapStats { linked: 0, gutter: 0, covered: 0, overlapping: 0 };
    for part in &parts {
        stats.linked += part.stats.linked;
        stats.gutter += part.stats.gutter;
        stats.covered += part.stats.covered;
        stats.overlapping += part.stats.overlapping;
    }
    let runs = Rows::new(parts.into_iter().map(|part| part.runs).collect());
    SamplingMap { size, direction, runs, patches, gutter_patches, stats }
}

/// The patch of each face, and the patches in the order of their faces.
fn linked_patches(oriented: &Oriented<'_>, size: Size) -> (Vec<u32>, Vec<Patch>) {
    let (to, from) = (oriented.to, oriented.from);
    let mut patch_of_face = vec![UNLINKED; to.faces().len()];
    let mut patches = Vec::with_capacity(to.faces().len());
    for (face, counterpart) in oriented.from_face.iter().enumerate() {
        let Some(counterpart) = counterpart else { continue };
        // A source triangle without area is a line or a point, and still has a colour: its
        // texels take that rather than stay a hole. Only the target's area is divided by.
        let source = from.uv_triangle(counterpart.face as usize);
        let src_uv = counterpart.corners.map(|corner| source[corner as usize].map(f64::from));
        if let Some(affine) = Affine::from_triangles(corners_px(to, face, size), src_uv) {
            patch_of_face[face] = patches.len() as u32;
            let jacobian = affine.jacobian;
            patches.push(Patch { src_uv_from_tgt_px: affine, jacobian, face: face as u32 });
        }
    }
    (patch_of_face, patches)
}

/// What all blocks depend on.
struct Plan<'a> {
    layout: Layout<'a>,
    precedence: Precedence,
    border: Border,
    patch_of_face: Vec<u32>,
    gutter_patches: u32,
}

/// The runs of a block, and what was found on the way.
struct Part {
    runs: Block<Run>,
    stats: MapStats,
    clashes: Vec<(u32, u32)>,
}

/// Buffers, kept from block to block.
struct Worker {
    sweep: Sweep,
    around: Surroundings,
    runs: Draft<Run>,
    /// Of the row that is worked on: what linked triangles own.
    owned: Vec<Run>,
}

impl Worker {
    fn new(width: u32) -> Self {
        Self {
            sweep: Sweep::new(width),
            around: Surroundings::new(width),
            runs: Draft::new(),
            owned: Vec::new(),
        }
    }

    fn build(&mut self, plan: &Plan<'_>, block: usize, winners: Option<&Winners>) -> Part {
        let Self { sweep, around, runs, owned } = self;
        let patch = |face: u32| plan.patch_of_face[face as usize];
        if winners.is_some() {
            sweep.cover_all(&plan.layout, &plan.precedence, block);
        } else {
            sweep.cover(&plan.layout, &plan.precedence, block, |face| patch(face) != UNLINKED);
        }
        around.enter(&plan.border, block, |row| sweep.covered(row));
        let mut stats =
            MapStats { linked: 0, gutter: 0, covered: 0, overlapping: sweep.overlapping };
        runs.clear();
        for (row, index) in plan.layout.blocks.rows(block).zip(0..) {
            let spans = sweep.spans.row(index);
            around.beside(&plan.border, block, row);
            if let Some(winners) = winners {
                let islands = plan.precedence.islands();
                around.steal(&plan.border, winners, islands, block, row, spans);
            }
            stats.covered +=
                sweep.covered(index).iter().map(|word| word.count_ones()).sum::<u32>() as usize;
            owned.clear();
            for span in spans.iter().filter(|span| patch(span.face) != UNLINKED) {
                push_without(owned, *span, patch(span.face), &around.stolen);
            }
            stats.linked += texels(owned);
            stats.gutter += texels(&around.runs);
            for run in &mut around.runs {
                run.patch += plan.gutter_patches;
            }
            merge(owned, &around.runs, |run| runs.items.push(run));
            runs.end_row();
        }
        Part { runs: runs.block(), stats, clashes: std::mem::take(&mut sweep.clashes) }
    }
}

fn texels(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.len as usize).sum()
}

/// Adds a run for the texels of a span that are not in `holes` (sorted).
fn push_without(runs: &mut Vec<Run>, span: Span, patch: u32, holes: &[u32]) {
    let mut x = span.start;
    let first = holes.partition_point(|&hole| hole < span.start);
    for &hole in holes[first..].iter().take_while(|&&hole| hole < span.end) {
        if x < hole {
            runs.push(Run { x, len: hole - x, patch });
        }
        x = hole + 1;
    }
    if x < span.end {
        runs.push(Run { x, len: span.end - x, patch });
    }
}
