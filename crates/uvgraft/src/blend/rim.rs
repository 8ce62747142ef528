//! The rim of a region: which colours meet there, told by what most of it says.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::ops::Range;

use glam::DVec3;

use super::selection::BlendDomain;
use super::tone::gain_between;
use crate::color::Encoding;
use crate::piece::{mixed, wide};
use crate::sampler::Sampler;
use crate::texture::Texture;
use crate::threads::map_indices;

/// The points that a region ends at, and where colours are measured beside them.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    /// The points: the last ones of the region's triangles, in the order of their numbers.
    pub points: Vec<u32>,
    /// For each, others along the rim, itself included, and how much they count.
    along: Vec<Vec<(u32, f64)>>,
    /// For each, the triangles around and how much they count.
    around: Vec<Vec<(u32, f64)>>,
    /// Where the triangles are looked at.
    places: Vec<Places>,
    inside_uv: Vec<[f64; 2]>,
    outside_uv: Vec<[f64; 2]>,
}

/// Which UV coordinates belong to a triangle.
#[derive(Debug, Clone)]
struct Places {
    /// Area that each of them stands for.
    area: f64,
    inside: Range<u32>,
    outside: Range<u32>,
}

/// How the colours on both sides of a rim differ.
#[derive(Debug, Clone)]
pub(super) struct Difference {
    /// For each point of the rim, the logarithms of the gains that take one side to the other.
    pub log_gains: Vec<[f64; 3]>,
    /// The logarithms for all of the rim together.
    pub overall: [f64; 3],
}

/// Colours of the triangles beside a rim: means and the areas that they stand for.
pub(super) type Side = Vec<([f64; 3], f64)>;

/// Beside a point of the rim colours are looked at no farther away than so many of the rim's edges:
/// some 1900 triangles.
const MOST_ACROSS: f64 = 16.0;

/// Sides of the grid of triangles in which each one is looked at.
const GRID: u32 = 4;

impl Rim {
    /// - `touched`: which triangles are in the region, wholly or in part.
    /// - `inside`: signed distance of each point from the rim.
    /// - `reach`: how far from the rim colours are looked at, at least, in the mesh's unit.
    pub fn new(domain: &BlendDomain, touched: &[bool], inside: &[f64], reach: f64) -> Self {
        let surface = domain.surface();
        let mut is_rim = vec![false; inside.len()];
        for (corners, _) in surface.triangles().iter().zip(touched).filter(|(_, touched)| **touched)
        {
            for &point in corners {
                is_rim[point as usize] |= inside[point as usize] <= 0.0;
            }
        }
        let points: Vec<u32> =
            (0u32..).zip(&is_rim).filter(|(_, is)| **is).map(|(p, _)| p).collect();
        let edges = rim_edges(domain, touched, &is_rim);
        // In the order of the points: a map's own order is another one each time.
        let lengths = points.iter().filter_map(|point| edges.get(point)).flatten();
        let count = lengths.clone().count();
        let total: f64 = lengths.map(|&(_, length)| length).sum();
        let mean_edge = if count > 0 { total / count as f64 } else { surface.mean_edge() };
        let reach = reach.max(1.2 * mean_edge);
        let along = map_indices(points.len(), |index| {
            let window = 2.0 * reach;
            let near = within(&edges, points[index], 3.0 * window);
            let mut weighted: Vec<(u32, f64)> = near
                .into_iter()
                .filter_map(|(point, distance)| {
                    let other = points.binary_search(&point).ok()? as u32;
                    Some((other, (-0.5 * (distance / window).powi(2)).exp()))
                })
                .collect();
            weighted.sort_unstable_by_key(|&(other, _)| other);
            weighted
        });

        let mut rim = Self {
            along,
            around: Vec::with_capacity(points.len()),
            places: Vec::new(),
            inside_uv: Vec::new(),
            outside_uv: Vec::new(),
            points,
        };
        // A wide feather on a fine mesh would have each point look at most triangles there are.
        let across = reach.min(MOST_ACROSS * mean_edge);
        let mut known = HashMap::new();
        for index in 0..rim.points.len() {
            let point = rim.points[index];
            let around = triangles_near(domain, point, across)
                .into_iter()
                .map(|(triangle, distance)| {
                    let places = *known.entry(triangle).or_insert_with(|| {
                        rim.look_at(domain, touched, inside, triangle);
                        rim.places.len() as u32 - 1
                    });
                    (places, (-(distance / across).powi(2)).exp())
                })
                .collect();
            rim.around.push(around);
        }
        rim
    }

    /// Adds the places of a triangle.
    fn look_at(&mut self, domain: &BlendDomain, touched: &[bool], inside: &[f64], triangle: u32) {
        let face = triangle as usize;
        let levels = domain.surface().triangles()[face].map(|point| inside[point as usize]);
        let target_uv = wide(domain.mesh().uv_triangle(face));
        let starts = [self.inside_uv.len() as u32, self.outside_uv.len() as u32];
        for weights in grid() {
            let level: f64 = levels.iter().zip(weights).map(|(level, weight)| level * weight).sum();
            let source_uv = if touched[face] { domain.source_uv(face, weights) } else { None };
            match source_uv {
                // Whole triangles have no corner outside, and all three may be on the rim.
                Some(uv) if level >= 0.0 || levels.iter().all(|&level| level >= 0.0) => {
                    self.inside_uv.push(uv);
                }
                _ => self.outside_uv.push(mixed(&target_uv, weights)),
            }
        }
        self.places.push(Places {
            area: domain.surface().area(triangle) / f64::from(GRID * GRID),
            inside: starts[0]..self.inside_uv.len() as u32,
            outside: starts[1]..self.outside_uv.len() as u32,
        });
    }

    /// The colours of a source beside the rim, sRGB values as stored.
    ///
    /// - `counts`: how much what is at a UV coordinate counts, from 0 to 1.
    pub fn source(&self, texture: &Texture, counts: impl Fn([f64; 2]) -> f32 + Sync) -> Side {
        let range = |places: &Places| places.inside.clone();
        self.side(texture, &self.inside_uv, range, |uv, _| counts(uv))
    }

    /// The colours of a base beside the rim, sRGB values as stored.
    ///
    /// - `counts`: how much a colour counts, from 0 to 1.
    pub fn base(&self, texture: &Texture, counts: impl Fn([f32; 3]) -> f32 + Sync) -> Side {
        let range = |places: &Places| places.outside.clone();
        self.side(texture, &self.outside_uv, range, |_, rgb| counts(rgb))
    }

    fn side(
        &self,
        texture: &Texture,
        uv: &[[f64; 2]],
        range: impl Fn(&Places) -> Range<u32> + Sync,
        counts: impl Fn([f64; 2], [f32; 3]) -> f32 + Sync,
    ) -> Side {
        let sampler = Sampler::new(texture);
        map_indices(self.places.len(), |index| {
            let places = &self.places[index];
            let range = range(places);
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for &uv in &uv[range.start as usize..range.end as usize] {
                let [rgb @ .., opacity] = sampler.rgba_as(uv, Encoding::Srgb);
                // What is hardly there has no colour that counts.
                if opacity >= 0.5 && rgb.iter().all(|value| value.is_finite()) {
                    let weight = f64::from(counts(uv, rgb));
                    for (sum, value) in sum.iter_mut().zip(rgb) {
                        *sum += weight * f64::from(value);
                    }
                    total += weight;
                }
            }
            if total > 0.0 { (sum.map(|sum| sum / total), total * places.area) } else { (sum, 0.0) }
        })
    }

    /// The gains that take one side to the other along the rim; none where one of them has no colours
    /// at all.
    ///
    /// - `counts`: how far a colour of the first side, and one of the second, is of the kind that
    ///   decides, from 0 to 1; nothing if all colours are of that kind, so that none is an outlier for being
    ///   unlike most.
    /// - `aim`: from a colour of the first side and one of the second, the one that the first is taken to.
    pub fn difference(
        &self,
        [from, to]: [&Side; 2],
        counts: Option<[&dyn Fn([f32; 3]) -> f32; 2]>,
        aim: impl Fn([f32; 3], [f32; 3]) -> [f32; 3],
    ) -> Option<Difference> {
        let mean = |around: &[(u32, f64)], side: &Side| {
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for &(place, weight) in around {
                let (color, area) = side[place as usize];
                let weight = weight * area;
                for (sum, value) in sum.iter_mut().zip(color) {
                    *sum += value * weight;
                }
                total += weight;
            }
            (total > 0.0).then(|| sum.map(|sum| (sum / total) as f32))
        };
        let colors: Vec<_> = self
            .around
            .iter()
            .map(|around| Some([mean(around, from)?, mean(around, to)?]))
            .collect();
        let measured: Vec<Option<[f64; 3]>> = colors
            .iter()
            .map(|colors| {
                let [from, to] = (*colors)?;
                let to = aim(from, to);
                Some([0, 1, 2].map(|k| f64::from(gain_between(from[k], to[k])).ln()))
            })
            .collect();
        let kind: Vec<f64> = colors
            .iter()
            .map(|colors| {
                colors.map_or(0.0, |[from, to]| {
                    counts.map_or(1.0, |counts| f64::from(counts[0](from).min(counts[1](to))))
                })
            })
            .collect();
        // Where hardly anything is of that kind, the kind is not what decides.
        let is_of_kind = kind.iter().filter(|&&kind| kind > 0.5).count() * 4 >= kind.len();
        let kind = if is_of_kind { kind } else { vec![1.0; kind.len()] };
        let of_kind = measured.iter().zip(&kind).filter(|(_, kind)| **kind > 0.5);
        let overall = median(of_kind.filter_map(|(measured, _)| measured.as_ref()))?;
        let far: Vec<f64> = measured.iter().flatten().map(|&d| apart(d, overall)).collect();
        let spread = (1.4826 * middle(far)).max(LEAST_SPREAD);
        // How much each is like the others: a brow, hair or a collar is not.
        let likeness: Vec<f64> = measured
            .iter()
            .zip(&kind)
            .map(|(measured, kind)| {
                measured.map_or(0.0, |d| match counts {
                    Some(_) => kind * (-0.5 * (apart(d, overall) / (1.5 * spread)).powi(2)).exp(),
                    None => 1.0,
                })
            })
            .collect();
        let log_gains =
            self.along.iter().map(|along| typical(along, &measured, &likeness, overall)).collect();
        Some(Difference { log_gains, overall })
    }
}

/// Differences closer than this are alike: 3 % of a value.
const LEAST_SPREAD: f64 = 0.03;

/// What most of the neighbours along the rim say: a mean in which those that are far from it count
/// little, found anew a few times (iteratively reweighted least squares with Cauchy's weights).
fn typical(
    along: &[(u32, f64)],
    measured: &[Option<[f64; 3]>],
    likeness: &[f64],
    overall: [f64; 3],
) -> [f64; 3] {
    /// So much counts the rim as a whole, which decides where no neighbour is like it.
    const PRIOR: f64 = 1e-3;
    let near: Vec<([f64; 3], f64)> = along
        .iter()
        .filter_map(|&(other, weight)| {
            let other = other as usize;
            Some((measured[other]?, weight * likeness[other]))
        })
        .collect();
    let mean = |weigh: &dyn Fn([f64; 3]) -> f64| {
        let (mut sum, mut total) = (overall.map(|value| value * PRIOR), PRIOR);
        for &(value, weight) in &near {
            let weight = weight * weigh(value);
            total += weight;
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += value * weight;
            }
        }
        sum.map(|sum| sum / total)
    };
    let mut center = mean(&|_| 1.0);
    for _ in 0..6 {
        let far = near.iter().map(|&(value, _)| apart(value, center)).collect();
        let spread = (1.4826 * middle(far)).max(LEAST_SPREAD);
        center = mean(&|value| 1.0 / (1.0 + (apart(value, center) / spread).powi(2)));
    }
    center
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from(a).distance(b.into())
}

/// The median of each component; none of nothing.
fn median<'a>(values: impl Iterator<Item = &'a [f64; 3]>) -> Option<[f64; 3]> {
    let values: Vec<&[f64; 3]> = values.collect();
    values.first()?;
    Some([0, 1, 2].map(|k| middle(values.iter().map(|value| value[k]).collect())))
}

fn middle(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(half, f64::total_cmp).1 }
}

/// For each point of a rim, the next ones along it and how far they are.
fn rim_edges(
    domain: &BlendDomain,
    touched: &[bool],
    is_rim: &[bool],
) -> HashMap<u32, Vec<(u32, f64)>> {
    let surface = domain.surface();
    let mut edges: HashMap<u32, Vec<(u32, f64)>> = HashMap::new();
    for (corners, _) in surface.triangles().iter().zip(touched).filter(|(_, touched)| **touched) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if a != b && is_rim[a as usize] && is_rim[b as usize] {
                let length = surface.length(a, b);
                edges.entry(a).or_default().push((b, length));
                edges.entry(b).or_default().push((a, length));
            }
        }
    }
    edges
}

/// The points along edges within a distance, the point itself included.
fn within(edges: &HashMap<u32, Vec<(u32, f64)>>, from: u32, limit: f64) -> HashMap<u32, f64> {
    let mut found = HashMap::from([(from, 0.0)]);
    let mut queue = BinaryHeap::from([Reverse((0_u64, from))]);
    while let Some(Reverse((bits, point))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > found[&point] {
            continue;
        }
        for &(other, length) in edges.get(&point).into_iter().flatten() {
            let further = distance + length;
            if further <= limit && found.get(&other).is_none_or(|&known| further < known) {
                found.insert(other, further);
                queue.push(Reverse((further.to_bits(), other)));
            }
        }
    }
    found
}

/// The triangles around a point whose middle is within a distance, over neighbours that are; those
/// at the point itself in any case.
fn triangles_near(domain: &BlendDomain, point: u32, reach: f64) -> Vec<(u32, f64)> {
    let surface = domain.surface();
    let center = surface.positions()[point as usize];
    let distance = |triangle: u32| {
        let [a, b, c] = surface.corners(triangle);
        ((a + b + c) / 3.0).distance(center)
    };
    let mut found: Vec<(u32, f64)> =
        surface.around(point).iter().map(|&triangle| (triangle, distance(triangle))).collect();
    // A triangle may have two corners at one point.
    found.dedup_by_key(|&mut (triangle, _)| triangle);
    let mut known: HashSet<u32> = found.iter().map(|&(triangle, _)| triangle).collect();
    let mut next = 0;
    while let Some(&(triangle, _)) = found.get(next) {
        next += 1;
        for &corner in &surface.triangles()[triangle as usize] {
            for &other in surface.around(corner) {
                let far = distance(other);
                if far <= reach && known.insert(other) {
                    found.push((other, far));
                }
            }
        }
    }
    found
}

/// The middles of the small triangles that a triangle is divided into, as weights of its corners.
fn grid() -> impl Iterator<Item = [f64; 3]> {
    let third = 1.0 / (3.0 * f64::from(GRID));
    (0..GRID).flat_map(move |row| {
        (0..2 * (GRID - row) - 1).map(move |k| {
            let (column, turned) = (k / 2, k % 2);
            let a = f64::from(3 * row + 1 + turned) * third;
            let b = f64::from(3 * column + 1 + turned) * third;
            [a, b, 1.0 - a - b]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blend::selection;
    use crate::mesh::Mesh;
    use crate::pair::{Direction, Pair};

    #[test]
    fn the_grid_is_the_middles_of_small_triangles() {
        let all: Vec<[f64; 3]> = grid().collect();
        assert_eq!(all.len(), (GRID * GRID) as usize);
        assert!(all.iter().flatten().all(|&weight| weight > 0.0));
        let mean = [0, 1, 2].map(|k| all.iter().map(|weights| weights[k]).sum::<f64>());
        for sum in mean {
            assert!((sum / all.len() as f64 - 1.0 / 3.0).abs() < 1e-12);
        }
    }

    /// A bumpy sheet of squares with sides of about 1, linked to itself.
    fn sheet(side: u32) -> Pair {
        let mut rng = fastrand::Rng::with_seed(5);
        let positions: Vec<[f32; 3]> = (0..side * side)
            .map(|k| [(k % side) as f32 + 0.4 * rng.f32(), (k / side) as f32, rng.f32()])
            .collect();
        let uv = positions.iter().map(|&[x, y, _]| [x, y].map(|k| k / side as f32)).collect();
        let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
        let faces: Vec<[u32; 3]> =
            squares.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect();
        let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
        let map: Vec<i64> = (0..i64::from(side * side)).collect();
        Pair::by_vertex_map(mesh.clone(), mesh, &map).unwrap()
    }

    /// The rim of all but the outermost four rows.
    fn rim(domain: &BlendDomain, side: u32, reach: f64) -> Rim {
        let is_in = |k: &u32| [k % side, k / side].iter().all(|k| (4..side - 4).contains(k));
        let inside: Vec<u32> = (0..side * side).filter(is_in).collect();
        let region = domain.vertices(selection::Side::Target, &inside).unwrap();
        let levels = domain.signed_distances(&region, 9.0);
        Rim::new(domain, &domain.touched(&region), &levels, reach)
    }

    /// Sums in the order of a hash map would differ in their last digits from one time to the next.
    #[test]
    fn a_rim_is_the_same_every_time() {
        let pair = sheet(24);
        let domain = BlendDomain::new(pair, Direction::Forward);
        let first = rim(&domain, 24, 0.0);
        assert_eq!(first.points.len(), 60);
        for _ in 0..20 {
            let again = rim(&domain, 24, 0.0);
            assert!(again.along == first.along && again.around == first.around);
        }
    }

    #[test]
    fn wide_feathers_do_not_make_every_point_look_at_everything() {
        let pair = sheet(64);
        let domain = BlendDomain::new(pair, Direction::Forward);
        let wide = rim(&domain, 64, 1000.0);
        let most = wide.around.iter().map(Vec::len).max();
        // Of 7938 triangles.
        assert!(most < Some(2000), "{most:?}");
    }

    #[test]
    fn outliers_do_not_count() {
        let along: Vec<(u32, f64)> = (0..20).map(|other| (other, 1.0)).collect();
        let of =
            |other: u32| if other.is_multiple_of(3) { [1.5, 1.0, 2.0] } else { [0.2, 0.1, -0.1] };
        let measured: Vec<Option<[f64; 3]>> = (0..20).map(|other| Some(of(other))).collect();
        let found = typical(&along, &measured, &[1.0; 20], [0.2, 0.1, -0.1]);
        assert!(apart(found, [0.2, 0.1, -0.1]) < 0.02, "{found:?}");
        // Where nobody near is like the rest, the rest decides.
        let found = typical(&along, &measured, &[0.0; 20], [0.3; 3]);
        assert_eq!(found, [0.3; 3]);
    }
}
