//! Building a map: patches first, then runs, in blocks of rows.

use uvgraft_surface::pair::{Direction, Oriented};
use uvgraft_surface::piece::wide;
use uvgraft_surface::threads::{extend_indices, join, map_indices, map_indices_with};

use super::coverage::{LayoutTriangles, Span, Sweep};
use super::cut::{FacePatch, FacePatches};
use super::gutter::{Border, Winners};
use super::gutter_rows::{GutterRows, merge};
use super::rows::{Block, Draft, RowLists};
use super::{Affine, MapStats, Patch, Precedence, Run, SamplingMap, has_area, sides};
use crate::texture::Size;

/// Builds a map in parallel over blocks of rows.
///
/// Overlaps take two passes. The first assigns texels to islands and collects which island lost
/// texels to which. Only then is it known where an island's fringe displaces its losers, so the
/// second pass rebuilds the blocks that such fringes reach.
///
/// - `gutter_px`: width of the gutter around islands, in texels.
/// - `precedence`: of the islands of the target layout.
pub(super) fn build(
    oriented: &Oriented<'_>,
    direction: Direction,
    size: Size,
    gutter_px: u32,
    precedence: impl FnOnce() -> Precedence + Send,
) -> SamplingMap {
    let to = oriented.to;
    let (precedence, (layout, (face_patches, mut patches))) = join(precedence, || {
        let layout = LayoutTriangles::new(to, size);
        let patches = linked_patches(oriented, &layout);
        (layout, patches)
    });
    let lost = layout.lost_edges(&precedence);
    let border = Border::new(to, precedence.islands(), &lost, size, gutter_px, &face_patches);

    let gutter_patches = patches.len() as u32;
    let mut of_gutter = Vec::new();
    extend_indices(&mut of_gutter, border.patches(), |index| {
        let (patch, zone) = border.patch(index);
        let beside = &patches[patch as usize];
        Patch { src_uv_from_tgt_px: zone(&beside.src_uv_from_tgt_px), ..beside.clone() }
    });
    patches.append(&mut of_gutter);

    let inputs = BlockInputs { layout, precedence, border, face_patches, gutter_patches };
    let blocks = inputs.layout.blocks.count();
    let new_worker = || Worker::new(size.width);
    let mut parts =
        map_indices_with(blocks, new_worker, |worker, block| worker.build(&inputs, block, None));
    // Which islands lost texels to which is known only now, and affects a few texels
    // around the overlaps.
    let mut clashes: Vec<(u32, u32)> =
        parts.iter_mut().flat_map(|part| std::mem::take(&mut part.clashes)).collect();
    clashes.sort_unstable();
    clashes.dedup();
    if !clashes.is_empty() {
        let is_hidden = inputs.hidden_islands(&patches, &parts);
        clashes.retain(|&(_, loser)| is_hidden[loser as usize]);
    }
    if !clashes.is_empty() {
        let winners = inputs.border.winners(clashes);
        let affected = winners.affected();
        let again = map_indices_with(affected.len(), new_worker, |worker, index| {
            worker.build(&inputs, affected[index], Some(&winners))
        });
        for (block, part) in affected.into_iter().zip(again) {
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
    let runs = RowLists::new(parts.into_iter().map(|part| part.runs).collect());
    SamplingMap { size, direction, runs, patches, gutter_patches, stats }
}

/// The patches of all pieces, in the order of their target faces, and the patches of each face.
fn linked_patches(oriented: &Oriented<'_>, layout: &LayoutTriangles) -> (FacePatches, Vec<Patch>) {
    let Oriented { from, to, pieces } = oriented;
    let all = pieces.all();
    // Only the target's area is divided by. A source triangle without area is a line or a point, which
    // still has a colour: its texels take that colour instead of staying a hole.
    let has_area =
        map_indices(all.len(), |index| has_area(layout.corners_px(all[index].to as usize)));
    let numbers: Vec<u32> =
        (0..).zip(&has_area).filter(|(_, has_area)| **has_area).map(|(number, _)| number).collect();
    let mut face_patches = FacePatches::none(to.faces().len());
    for (&number, patch) in numbers.iter().zip(0..) {
        let piece = all[number as usize];
        let corners_px = layout.corners_px(piece.to as usize);
        match pieces.part(piece) {
            None => face_patches.add_whole(piece.to, patch, corners_px, layout.size),
            Some(part) => face_patches.add_part(piece.to, patch, part.to, corners_px, layout.size),
        }
    }
    let mut patches = Vec::new();
    extend_indices(&mut patches, numbers.len(), |patch| {
        let number = numbers[patch];
        let piece = all[number as usize];
        let source = wide(from.uv_triangle(piece.from as usize));
        let corners_px = layout.corners_px(piece.to as usize);
        let affine = Affine::from_triangles(corners_px, pieces.at_corners(piece, source))
            .expect("triangles without area were left out");
        Patch {
            jacobian: affine.jacobian,
            src_uv_from_tgt_px: affine,
            face: piece.to,
            piece: number,
            is_part: pieces.part(piece).is_some(),
        }
    });
    (face_patches, patches)
}

/// What all blocks of rows are built from.
struct BlockInputs {
    layout: LayoutTriangles,
    precedence: Precedence,
    border: Border,
    face_patches: FacePatches,
    /// Index of the first patch of the gutter.
    gutter_patches: u32,
}

/// An island that owns at most this share of its linked area lies beneath others: two eyes that share
/// a disc of 16 texels, a texel apart, keep 12 % of the one beneath. Islands that merely touch others, or
/// have others within them, keep more than half.
const HIDDEN_SHARE: f64 = 0.25;

impl BlockInputs {
    /// Whether each island lies beneath others, so that what is left of it at their edges is not worth
    /// showing. Of all others, no fringe takes a texel.
    ///
    /// - `parts`: all blocks, without fringes.
    fn hidden_islands(&self, patches: &[Patch], parts: &[BuiltBlock]) -> Vec<bool> {
        let islands = self.precedence.of_faces();
        let mut area = vec![0.0; self.precedence.islands().count()];
        for (face, &island) in islands.iter().enumerate() {
            if self.face_patches.is_linked(face as u32) {
                area[island as usize] += sides(self.layout.corners_px(face)).1.abs() / 2.0;
            }
        }
        let mut owned = vec![0; area.len()];
        for run in parts.iter().flat_map(|part| part.runs.items()) {
            if run.patch < self.gutter_patches {
                let face = patches[run.patch as usize].face;
                owned[islands[face as usize] as usize] += run.len as usize;
            }
        }
        owned.iter().zip(area).map(|(&owned, area)| owned as f64 <= HIDDEN_SHARE * area).collect()
    }
}

/// The runs of a block, its texel counts, and pairs of islands that share texels.
struct BuiltBlock {
    runs: Block<Run>,
    stats: MapStats,
    clashes: Vec<(u32, u32)>,
}

/// Buffers, reused from block to block.
struct Worker {
    sweep: Sweep,
    around: GutterRows,
    runs: Draft<Run>,
    /// Runs of the current row that linked triangles own.
    owned: Vec<Run>,
    /// Spans of the current row that the parts of a face cover.
    claims: Vec<Span>,
}

impl Worker {
    fn new(width: u32) -> Self {
        Self {
            sweep: Sweep::new(width),
            around: GutterRows::new(width),
            runs: Draft::new(),
            owned: Vec::new(),
            claims: Vec::new(),
        }
    }

    /// Builds the runs of one block: texel owners of each row, less those stolen by fringes,
    /// merged with the gutter.
    ///
    /// - `winners`: on the second pass, the edges of islands that won overlaps.
    fn build(
        &mut self,
        inputs: &BlockInputs,
        block: usize,
        winners: Option<&Winners>,
    ) -> BuiltBlock {
        let Self { sweep, around, runs, owned, claims } = self;
        if winners.is_some() {
            sweep.cover_all(&inputs.layout, &inputs.precedence, block);
        } else {
            sweep.cover(&inputs.layout, &inputs.precedence, block, |face| {
                inputs.face_patches.is_linked(face)
            });
        }
        around.begin_block(&inputs.border, block, |row| sweep.covered(row));
        let mut stats =
            MapStats { linked: 0, gutter: 0, covered: 0, overlapping: sweep.overlapping };
        runs.clear();
        for (row, index) in inputs.layout.blocks.rows(block).zip(0..) {
            let spans = sweep.spans.row(index);
            around.find_gutter(&inputs.border, block, row);
            if let Some(winners) = winners {
                let islands = inputs.precedence.islands();
                around.steal(&inputs.border, winners, islands, block, row, spans);
            }
            stats.covered +=
                sweep.covered(index).iter().map(|word| word.count_ones()).sum::<u32>() as usize;
            owned.clear();
            for span in spans {
                match inputs.face_patches.of(span.face) {
                    FacePatch::None => {}
                    FacePatch::One(patch) => push_without(owned, *span, patch, &around.stolen),
                    FacePatch::Cut(face) => face.split(row, *span, claims, |span, patch| {
                        push_without(owned, span, patch, &around.stolen);
                    }),
                }
            }
            stats.linked += texels(owned);
            stats.gutter += texels(&around.runs);
            for run in &mut around.runs {
                run.patch += inputs.gutter_patches;
            }
            merge(owned, &around.runs, |run| runs.items.push(run));
            runs.end_row();
        }
        BuiltBlock { runs: runs.block(), stats, clashes: sweep.take_clashes() }
    }
}

fn texels(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.len as usize).sum()
}

/// Adds runs for the texels of a span that are not in `holes`, which must be sorted.
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
