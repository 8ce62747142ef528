//! Corresponding triangles from connectivity alone: one mesh inside another, however both are
//! numbered.
//!
//! Half-edges whose surroundings occur once in each mesh seed the match, and growth over shared
//! edges extends and verifies it. Components that look alike from several sides, such as eyeballs,
//! are matched afterwards, and positions choose among the possible ways. Growth leaves out what
//! contradicts, so meshes that were edited in places match elsewhere.

mod growth;
mod net;
mod one_side;
mod poked;
mod signature;

use std::cell::Cell;

use glam::DVec3;

use self::growth::{Grown, Match, Work};
use self::net::{NONE, Net, merged_triangles, polygons};
use self::one_side::one_side;
use self::signature::Candidates;
use super::similarity::Similarity;
use super::vertex_map::link_faces;
use crate::disjoint::DisjointSets;
use crate::mesh::Mesh;
use crate::piece::Piece;
use crate::statistics::median;
use crate::surface::Surface;

/// Least share of the smaller mesh's polygons that must be found in the other. Origin not recorded.
const ENOUGH: f64 = 0.6;

/// Why connectivity does not link two meshes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TopologyError {
    /// Too little of the smaller mesh is connected as somewhere in the other.
    #[error(
        "the connectivity of one mesh must be found in the other; {matched} of {of} polygons are \
         connected alike"
    )]
    Different {
        /// Polygons of the smaller mesh that were found.
        matched: usize,
        /// Polygons of the smaller mesh.
        of: usize,
    },
    /// Both meshes look alike from everywhere, so that the search ended at its limit.
    #[error(
        "there are too many ways to lay one mesh over the other: {matched} of {of} polygons were found \
         within {steps} steps, the most for meshes of this size"
    )]
    TooManyWays {
        /// Polygons of the smaller mesh that were found.
        matched: usize,
        /// Polygons of the smaller mesh.
        of: usize,
        /// The limit.
        steps: u64,
    },
}

/// What matching by connectivity found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TopologyReport {
    /// Polygons of the smaller mesh with a counterpart. Polygons of several triangles count once,
    /// triangles that make up a quad of the other mesh too.
    pub matched: usize,
    /// Polygons of the smaller mesh.
    pub of: usize,
    /// Connected components of the smaller mesh of which nothing was matched.
    pub components_left_out: usize,
    /// Components that fit in several ways, of which positions chose one.
    pub chosen_by_position: usize,
    /// Polygons that have an added centre vertex in one of the meshes, and are linked in parts.
    pub with_added_centre: usize,
    /// Whether the windings of the meshes are opposite.
    pub is_mirrored: bool,
}

/// Links the triangles of two meshes by connectivity.
pub(super) fn pieces(
    source: &mut Mesh,
    target: &mut Mesh,
) -> Result<(Vec<Piece>, TopologyReport), TopologyError> {
    let surfaces = [&*source, &*target].map(Surface::new);
    let smaller = usize::from(target.faces().len() < source.faces().len());
    let views = views([&*source, &*target], &surfaces);
    let mut best: Option<Embedding> = None;
    for rings in &views {
        let [inner, outer] = [smaller, 1 - smaller].map(|side| &rings[side]);
        let positions = [smaller, 1 - smaller].map(|side| surfaces[side].positions());
        let found = embed(inner, outer, positions);
        let share = found.report.share();
        if best.as_ref().is_none_or(|best| share > best.report.share()) {
            best = Some(found);
        }
        if share > 0.95 {
            break;
        }
    }
    let nothing = TopologyError::Different { matched: 0, of: source.polygon_count() };
    let Embedding { outer_of_inner, mut report, ended_at } = best.ok_or(nothing)?;
    let TopologyReport { matched, of, .. } = report;
    if report.share() < ENOUGH {
        return Err(match ended_at {
            Some(steps) => TopologyError::TooManyWays { matched, of, steps },
            None => TopologyError::Different { matched, of },
        });
    }
    let point_of_vertex = [&*source, &*target].map(|mesh| {
        let surface = &surfaces[usize::from(std::ptr::eq(mesh, target))];
        points_of_vertices(mesh, surface)
    });
    let mut has_partner = vec![false; surfaces[1 - smaller].positions().len()];
    for &point in outer_of_inner.iter().filter(|&&point| point != NONE) {
        has_partner[point as usize] = true;
    }
    // Both meshes' vertices as points of the larger one.
    let common = |side: usize, vertex: u32| match point_of_vertex[side][vertex as usize] {
        NONE => NONE,
        point if side == smaller => outer_of_inner[point as usize],
        point if has_partner[point as usize] => point,
        _ => NONE,
    };
    let common = &common;
    let points = [0, 1].map(|side| move |vertex: u32| common(side, vertex));
    let mut found = link_faces(source, target, points[0], points[1]);
    let (in_target, target_count) = poked::pieces(target, source, points[1], points[0]);
    let (in_source, source_count) = poked::pieces(source, target, points[0], points[1]);
    report.with_added_centre = target_count + source_count;
    if report.with_added_centre > 0 {
        found.extend(in_target);
        found.extend(in_source.into_iter().map(Piece::swapped));
        found.sort_by_key(|piece| piece.target);
    }
    if found.is_empty() {
        Err(TopologyError::Different { matched, of })
    } else {
        Ok((found, report))
    }
}

impl TopologyReport {
    fn share(&self) -> f64 {
        self.matched as f64 / self.of.max(1) as f64
    }
}

/// The surface point of each vertex, or [`NONE`] for vertices without a face.
fn points_of_vertices(mesh: &Mesh, surface: &Surface) -> Vec<u32> {
    let mut points = vec![NONE; mesh.positions().len()];
    let corners = mesh.faces().as_flattened().iter().zip(surface.triangles().as_flattened());
    for (&vertex, &point) in corners {
        points[vertex as usize] = point;
    }
    points
}

/// The ways to look at both meshes, in the order in which they are tried: as their polygons are;
/// if one is triangulated where the other may have quads, with triangles joined to quads; and if one
/// has polygons with an added centre, without it.
fn views(meshes: [&Mesh; 2], surfaces: &[Surface; 2]) -> Vec<[Vec<Vec<u32>>; 2]> {
    let plain = [0, 1]
        .map(|side| one_side(polygons(meshes[side], &surfaces[side]), surfaces[side].positions()));
    let is_triangles = |rings: &[Vec<u32>]| rings.iter().all(|ring| ring.len() == 3);
    let quads = |side: usize| {
        if is_triangles(&plain[side]) {
            one_side(
                merged_triangles(&plain[side], surfaces[side].positions()),
                surfaces[side].positions(),
            )
        } else {
            plain[side].clone()
        }
    };
    let joined = [0, 1].map(quads);
    let whole = [0, 1].map(|side| poked::without_centres(&plain[side]));
    let mut views = vec![plain];
    if joined != views[0] {
        views.push(joined.clone());
    }
    // Triangles of the other mesh may be halves of quads, or what polygons without a centre are.
    let [source, target] = whole;
    let [joined_source, joined_target] = joined;
    if let Some(source) = source {
        views.push([source, joined_target]);
    }
    if let Some(target) = target {
        views.push([joined_source, target]);
    }
    views
}

/// One net found in another.
struct Embedding {
    /// The outer point of each inner point, or [`NONE`].
    outer_of_inner: Vec<u32>,
    report: TopologyReport,
    /// The limit at which a search ended.
    ended_at: Option<u64>,
}

/// Finds the inner net in the outer one, seen from the front and from behind, and takes what fits
/// better.
fn embed(inner: &[Vec<u32>], outer: &[Vec<u32>], positions: [&[DVec3]; 2]) -> Embedding {
    let inner = Net::new(inner, positions[0].len());
    let outer = Net::new(outer, positions[1].len());
    let direct = Search::new(&inner, &outer, positions).run();
    let flipped = outer.flipped();
    let mirrored = Search::new(&inner, &flipped, positions).run();
    // A symmetric mesh fits both ways. Windings usually agree, so only positions that clearly fit
    // better speak for the mirror image.
    let is_mirrored = match (mirrored.matched.rings(), direct.matched.rings()) {
        (mirrored, direct) if mirrored as f64 > 1.2 * direct as f64 => true,
        (mirrored, direct) if direct as f64 > 1.2 * mirrored as f64 => false,
        _ => mirrored.misfit < 0.5 * direct.misfit,
    };
    let ended_at = (direct.is_ended || mirrored.is_ended).then(|| most_steps([&inner, &outer]));
    let chosen = if is_mirrored { mirrored } else { direct };
    let report = TopologyReport {
        matched: chosen.matched.rings(),
        of: inner.rings(),
        components_left_out: chosen.components_left_out,
        chosen_by_position: chosen.chosen_by_position,
        with_added_centre: 0,
        is_mirrored,
    };
    Embedding { outer_of_inner: chosen.matched.target_of, report, ended_at }
}

/// The search for one net in another with the same winding.
struct Search<'a> {
    nets: [&'a Net; 2],
    positions: [&'a [DVec3]; 2],
    candidates: Candidates,
    matched: Match,
    work: Work,
}

/// So many ways to match a component are too many to grow all: spheres that artists make have up to 256.
const MANY_WAYS: usize = 256;

/// How many steps a search may take.
fn most_steps(nets: [&Net; 2]) -> u64 {
    /// Heads are found in bodies and in themselves in up to 3 for each polygon. A sphere of 128 by 64 quads,
    /// which has to be grown in 256 ways, takes 256.
    const PER_RING: usize = 256;
    const LEAST: usize = 1 << 19;
    (LEAST + PER_RING * (nets[0].rings() + nets[1].rings())) as u64
}

/// What a search found.
struct Found {
    matched: Match,
    components_left_out: usize,
    chosen_by_position: usize,
    /// The median distance of matched points after alignment, relative to the size of the mesh;
    /// infinite if nothing can be aligned.
    misfit: f64,
    /// Whether the search ended at its limit.
    is_ended: bool,
}

impl<'a> Search<'a> {
    fn new(inner: &'a Net, outer: &'a Net, positions: [&'a [DVec3]; 2]) -> Self {
        Self {
            nets: [inner, outer],
            positions,
            candidates: Candidates::new(inner, outer),
            matched: Match::new(inner, outer),
            work: Work::new(most_steps([inner, outer])),
        }
    }

    fn run(mut self) -> Found {
        self.grow_from_unique();
        let components = components(self.nets[0]);
        let mut aligned = self.alignment(&self.matched.ring_points(self.nets[0]));
        let mut components_left_out = 0;
        let mut chosen_by_position = 0;
        for rings in &components {
            if rings.iter().any(|&ring| self.matched.ring[ring as usize] != NONE) {
                continue;
            }
            match self.grow_by_position(rings, aligned) {
                Some(ways) => {
                    chosen_by_position += usize::from(ways > 1);
                    // What was matched first leads the rest.
                    if aligned.is_none() {
                        aligned = self.alignment(&self.matched.ring_points(self.nets[0]));
                    }
                }
                None => components_left_out += 1,
            }
        }
        let misfit = aligned.map_or(f64::INFINITY, |aligned| {
            self.misfit(&self.matched.ring_points(self.nets[0]), &aligned)
        });
        let is_ended = self.work.is_done();
        Found { matched: self.matched, components_left_out, chosen_by_position, misfit, is_ended }
    }

    /// Grows from half-edges with a unique counterpart, the best of the first few first, so that a
    /// chance resemblance doesn't come before the true match.
    fn grow_from_unique(&mut self) {
        const FIRST_TRIES: usize = 12;
        let seeds = self.candidates.unique();
        let spread = (seeds.len() / FIRST_TRIES).max(1);
        let mut best: Option<(usize, [u32; 2])> = None;
        for &seed in seeds.iter().step_by(spread) {
            let grown = self.matched.grow(self.nets, seed, &mut self.work);
            let Some(grown) = grown else { continue };
            let size = grown.rings.len();
            self.matched.undo(&grown);
            if best.is_none_or(|(most, _)| size > most) {
                best = Some((size, seed));
            }
            // Two large matches cannot both be wrong, and there is nothing larger than all.
            if size * 2 > self.nets[0].rings() {
                break;
            }
        }
        let first = best.map(|(_, seed)| seed);
        for seed in first.into_iter().chain(seeds) {
            let ring = self.nets[0].ring_of[seed[0] as usize];
            if self.matched.ring[ring as usize] == NONE
                && let Some(grown) = self.matched.grow(self.nets, seed, &mut self.work)
                && !is_plausible(&grown)
            {
                self.matched.undo(&grown);
            }
        }
    }

    /// Matches a component that has no unique half-edge: every possible way is grown, and the one
    /// whose points lie closest after alignment is kept. Returns how many ways there were; `None`
    /// if there is none, if positions don't tell them apart, or at the end of the work.
    fn grow_by_position(&mut self, rings: &[u32], aligned: Option<Similarity>) -> Option<usize> {
        /// How much farther off the second best must be. Origin not recorded.
        const CLEARLY: f64 = 1.05;
        let halves = rings.iter().flat_map(|&ring| self.nets[0].halves(ring));
        let looked_at = Cell::new(0);
        let is_free = |half: u32| {
            looked_at.set(looked_at.get() + 1);
            !self.matched.is_taken[self.nets[1].ring_of[half as usize] as usize]
        };
        let found = self.candidates.rarest(halves, is_free);
        // Looking at a half-edge is a small part of matching two polygons.
        self.work.take(looked_at.get() / 64);
        let (half, others) = found?;
        let count = others.len();
        let others = self.nearest_first(half, &others, aligned);
        if count > MANY_WAYS && self.grow_in_place(half, &others, rings.len(), aligned) {
            return Some(count);
        }
        let mut ways: Vec<(f64, u32)> = Vec::new();
        for other in others {
            let grown = self.matched.grow(self.nets, [half, other], &mut self.work);
            let Some(grown) = grown else { continue };
            if grown.rings.len() * 10 >= rings.len() * 9 {
                let transform = aligned.or_else(|| self.alignment(&grown.points));
                let misfit =
                    transform.map_or(f64::INFINITY, |found| self.misfit(&grown.points, &found));
                self.work.take(grown.points.len());
                ways.push((misfit, other));
            }
            self.matched.undo(&grown);
        }
        if self.work.is_done() {
            return None;
        }
        ways.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (best, other) = *ways.first()?;
        let is_tied = ways.get(1).is_some_and(|(second, _)| *second <= best * CLEARLY);
        if is_tied {
            return None;
        }
        self.matched.grow(self.nets, [half, other], &mut self.work)?;
        Some(ways.len())
    }

    /// The counterparts of a half-edge, those that lie closest to where alignment puts it, or to where it
    /// is, first. Of many only these.
    fn nearest_first(
        &mut self,
        half: u32,
        others: &[u32],
        aligned: Option<Similarity>,
    ) -> Vec<u32> {
        /// More ways than any sphere that an artist makes has.
        const MOST_WAYS: usize = 4096;
        /// The same where it is known where they belong: thousands of hair cards may be alike.
        const MOST_ALIGNED: usize = 64;
        let mut sorted: Vec<(f64, u32)> =
            others.iter().map(|&other| (self.apart(half, other, aligned), other)).collect();
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if sorted.len() > MANY_WAYS {
            sorted.truncate(if aligned.is_some() { MOST_ALIGNED } else { MOST_WAYS });
        }
        // Comparing two places is a small part of matching two polygons.
        self.work.take(others.len() / 16);
        sorted.into_iter().map(|(_, other)| other).collect()
    }

    /// How far a target half-edge is from where alignment puts a source half-edge, or from where it is:
    /// the sum of the squared distances of their ends.
    fn apart(&self, half: u32, other: u32, aligned: Option<Similarity>) -> f64 {
        let ends = |side: usize, half: u32| {
            let net = self.nets[side];
            [half, net.next(half)]
                .map(|half| self.positions[side][net.points[half as usize] as usize])
        };
        let [from, to] = ends(0, half).map(|at| aligned.map_or(at, |aligned| aligned.apply(at)));
        let [other_from, other_to] = ends(1, other);
        from.distance_squared(other_from) + to.distance_squared(other_to)
    }

    /// Matches a component to where it is, if a half-edge's first counterpart does so and no other is as
    /// near: no other way can be better.
    fn grow_in_place(
        &mut self,
        half: u32,
        others: &[u32],
        rings: usize,
        aligned: Option<Similarity>,
    ) -> bool {
        /// Rounding of positions, relative to the size of a component.
        const EXACT: f64 = 1e-6;
        let &[first, second, ..] = others else { return false };
        let Some(grown) = self.matched.grow(self.nets, [half, first], &mut self.work) else {
            return false;
        };
        let pairs = self.pairs(&grown.points);
        let extent = pairs.iter().map(|pair| pair[1].distance(pairs[0][1])).fold(0.0, f64::max);
        let place = |at: DVec3| aligned.map_or(at, |aligned| aligned.apply(at));
        let is_there = |&[from, to]: &[DVec3; 2]| place(from).distance(to) <= EXACT * extent;
        let is_apart = self.apart(half, second, aligned).sqrt() > 4.0 * EXACT * extent;
        let is_whole = grown.rings.len() * 10 >= rings * 9;
        let is_in_place = is_apart && is_whole && pairs.iter().all(is_there);
        if !is_in_place {
            self.matched.undo(&grown);
        }
        is_in_place
    }

    /// The transform from inner to outer positions that fits the matched ones of `points`.
    fn alignment(&self, points: &[u32]) -> Option<Similarity> {
        Similarity::robust(&self.pairs(points), true)
    }

    /// How far matched points are from each other after alignment, relative to the size of the
    /// part: their mean offset and the median deviation from it. Apart, so that a part that lies a
    /// little elsewhere in the other mesh is not less sensitive to being turned.
    fn misfit(&self, points: &[u32], aligned: &Similarity) -> f64 {
        let pairs = self.pairs(points);
        let extent = pairs.iter().map(|pair| pair[1].distance(pairs[0][1])).fold(0.0, f64::max);
        let offsets: Vec<DVec3> =
            pairs.iter().map(|&[from, to]| to - aligned.apply(from)).collect();
        let mean = offsets.iter().sum::<DVec3>() / offsets.len().max(1) as f64;
        let deviation = median(offsets.iter().map(|offset| offset.distance(mean))).unwrap_or(0.0);
        (mean.length() + deviation) / extent.max(f64::MIN_POSITIVE)
    }

    fn pairs(&self, points: &[u32]) -> Vec<[DVec3; 2]> {
        let of = |&point: &u32| {
            let other = self.matched.target_of[point as usize];
            [self.positions[0][point as usize], self.positions[1][other as usize]]
        };
        points.iter().map(of).collect()
    }
}

/// Whether a growth is more than a chance resemblance: a whole region without many contradictions.
fn is_plausible(grown: &Grown) -> bool {
    const SMALLEST: usize = 12;
    grown.rings.len() >= SMALLEST.max(3 * grown.contradictions)
        || (grown.contradictions == 0 && grown.rings.len() >= 4)
}

/// The rings of each connected component, ascending, the largest component first.
fn components(net: &Net) -> Vec<Vec<u32>> {
    let mut sets = DisjointSets::new(net.rings() as u32);
    for (half, &twin) in net.twin.iter().enumerate() {
        if twin != NONE {
            sets.join(net.ring_of[half], net.ring_of[twin as usize]);
        }
    }
    let mut of_root: std::collections::BTreeMap<u32, Vec<u32>> = std::collections::BTreeMap::new();
    for ring in 0..net.rings() as u32 {
        of_root.entry(sets.root(ring)).or_default().push(ring);
    }
    let mut found: Vec<Vec<u32>> = of_root.into_values().collect();
    found.sort_by_key(|rings| std::cmp::Reverse(rings.len()));
    found
}
