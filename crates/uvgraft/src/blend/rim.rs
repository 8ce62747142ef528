//! The boundary of a region: a robust colour ratio between its two sides.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::ops::Range;

use glam::DVec3;
use uvgraft_surface::piece::{mixed, wide};
use uvgraft_surface::statistics::{median, median_color};
use uvgraft_surface::surface::Surface;
use uvgraft_surface::threads::map_indices;

use super::selection::BlendDomain;
use super::tone::gain_between;
use crate::color::Encoding;
use crate::sampler::Sampler;
use crate::texture::Texture;

/// The boundary points of a region, and where colours are sampled around them.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    /// Corners of the region's triangles at signed distances of 0 or less, in ascending index
    /// order.
    pub points: Vec<u32>,
    /// For each point, the neighbours along the boundary (itself included) with their weights.
    along: Vec<Vec<(u32, f64)>>,
    /// For each point, the triangles around it, as indices into `samples`, with their weights.
    around: Vec<Vec<(u32, f64)>>,
    /// The sampled triangles.
    samples: Vec<Samples>,
    /// Sample positions inside the region, in the source's layout.
    inside_uv: Vec<[f64; 2]>,
    /// Sample positions outside the region, in the target's layout.
    outside_uv: Vec<[f64; 2]>,
}

/// The sample positions of a triangle, as ranges of `inside_uv` and `outside_uv`.
#[derive(Debug, Clone)]
struct Samples {
    /// Surface area that each sample stands for.
    area: f64,
    inside: Range<u32>,
    outside: Range<u32>,
}

/// The colour difference between the two sides of a boundary.
#[derive(Debug, Clone)]
pub(super) struct Difference {
    /// For each boundary point, the logarithms of the gains that map one side to the other.
    pub log_gains: Vec<[f64; 3]>,
    /// The logarithms for the boundary as a whole.
    pub overall: [f64; 3],
}

/// For each sampled triangle, its mean colour on one side of the boundary, as stored sRGB values
/// with 1.0 for full intensity, and the area that this stands for.
pub(super) type SideColors = Vec<([f64; 3], f64)>;

/// Upper limit, in mean boundary-edge lengths, of the radius in which colours are sampled around a
/// boundary point: about 1900 triangles.
const MAX_ACROSS: f64 = 16.0;

/// How many edges are followed along the boundary, for all of its points together, and how many
/// triangles are looked at around them. For 1,300 points around FLAME's face in SMPL-X, 41,000 points are
/// found along edges, and 75,000 triangles, each of which is looked at about three times. With a wide feather
/// in a mesh of five million triangles, 2,600 points around a neck would look at 15 million.
const MOST_ALONG: usize = 1 << 23;
const MOST_AROUND: usize = 1 << 24;

/// A point may follow, or look at, as many in any case.
const LEAST: usize = 64;

/// Sub-triangles along each edge of a triangle: colours are sampled at their centroids.
const GRID: u32 = 4;

impl Rim {
    /// Finds the boundary points and the samples around them.
    ///
    /// Colours are averaged over the triangles around each point, weighted by
    /// `exp(-(d / across)²)`, and log gains along the boundary, weighted by
    /// `exp(-(d / window)² / 2)` with a window of twice the reach.
    ///
    /// - `touched`: which triangles are in the region, wholly or in part.
    /// - `inside`: signed distance of each point from the boundary.
    /// - `reach`: radius in which colours are sampled, in the mesh's unit; raised to 1.2 mean
    ///   boundary edges if it is less.
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
        // In the order of the points: a hash map's own order differs from run to run.
        let lengths = points.iter().filter_map(|point| edges.get(point)).flatten();
        let count = lengths.clone().count();
        let total: f64 = lengths.map(|&(_, length)| length).sum();
        let mean_edge = if count > 0 { total / count as f64 } else { surface.mean_edge() };
        let reach = reach.max(1.2 * mean_edge);
        let along = map_indices(points.len(), |index| {
            let window = 2.0 * reach;
            let near = within(&edges, points[index], 3.0 * window, share(MOST_ALONG, points.len()));
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
            samples: Vec::new(),
            inside_uv: Vec::new(),
            outside_uv: Vec::new(),
            points,
        };
        // With a wide feather on a fine mesh each point would otherwise sample most of the mesh.
        let across = reach.min(MAX_ACROSS * mean_edge);
        let mut known = HashMap::new();
        let mut nearby = Nearby::new(domain.surface(), share(MOST_AROUND, rim.points.len()));
        for index in 0..rim.points.len() {
            let point = rim.points[index];
            let around = nearby
                .triangles(point, across)
                .into_iter()
                .map(|(triangle, distance)| {
                    let samples = *known.entry(triangle).or_insert_with(|| {
                        rim.sample(domain, touched, inside, triangle);
                        rim.samples.len() as u32 - 1
                    });
                    (samples, (-(distance / across).powi(2)).exp())
                })
                .collect();
            rim.around.push(around);
        }
        rim
    }

    /// Adds the sample positions of a triangle.
    fn sample(&mut self, domain: &BlendDomain, touched: &[bool], inside: &[f64], triangle: u32) {
        let face = triangle as usize;
        let levels = domain.surface().triangles()[face].map(|point| inside[point as usize]);
        let target_uv = wide(domain.mesh().uv_triangle(face));
        let starts = [self.inside_uv.len() as u32, self.outside_uv.len() as u32];
        for weights in grid() {
            let level: f64 = levels.iter().zip(weights).map(|(level, weight)| level * weight).sum();
            let source_uv = if touched[face] { domain.source_uv(face, weights) } else { None };
            match source_uv {
                // Whole triangles have no corner outside, but all three may lie on the boundary.
                Some(uv) if level >= 0.0 || levels.iter().all(|&level| level >= 0.0) => {
                    self.inside_uv.push(uv);
                }
                _ => self.outside_uv.push(mixed(&target_uv, weights)),
            }
        }
        self.samples.push(Samples {
            area: domain.surface().area(triangle) / f64::from(GRID * GRID),
            inside: starts[0]..self.inside_uv.len() as u32,
            outside: starts[1]..self.outside_uv.len() as u32,
        });
    }

    /// The source's colours around the boundary, as stored sRGB values.
    ///
    /// - `weigh`: weight of a UV coordinate, 0 to 1.
    pub fn source(&self, texture: &Texture, weigh: impl Fn([f64; 2]) -> f32 + Sync) -> SideColors {
        let range = |samples: &Samples| samples.inside.clone();
        self.side(texture, &self.inside_uv, range, |uv, _| weigh(uv))
    }

    /// The base's colours around the boundary, as stored sRGB values.
    ///
    /// - `weigh`: weight of a colour, 0 to 1.
    pub fn base(&self, texture: &Texture, weigh: impl Fn([f32; 3]) -> f32 + Sync) -> SideColors {
        let range = |samples: &Samples| samples.outside.clone();
        self.side(texture, &self.outside_uv, range, |_, rgb| weigh(rgb))
    }

    fn side(
        &self,
        texture: &Texture,
        uv: &[[f64; 2]],
        range: impl Fn(&Samples) -> Range<u32> + Sync,
        weigh: impl Fn([f64; 2], [f32; 3]) -> f32 + Sync,
    ) -> SideColors {
        let sampler = Sampler::new(texture);
        map_indices(self.samples.len(), |index| {
            let set = &self.samples[index];
            let range = range(set);
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for &uv in &uv[range.start as usize..range.end as usize] {
                let [rgb @ .., alpha] = sampler.rgba_as(uv, Encoding::Srgb);
                // Nearly transparent texels carry no reliable colour.
                if alpha >= 0.5 && rgb.iter().all(|value| value.is_finite()) {
                    let weight = f64::from(weigh(uv, rgb));
                    for (sum, value) in sum.iter_mut().zip(rgb) {
                        *sum += weight * f64::from(value);
                    }
                    total += weight;
                }
            }
            if total > 0.0 { (sum.map(|sum| sum / total), total * set.area) } else { (sum, 0.0) }
        })
    }

    /// The gains that map one side's colours to the other's along the boundary; `None` if
    /// either side has no colours.
    ///
    /// The log gain `x` at each point maps the mean colours around it. Its weight is
    /// `w · exp(-(|x - m| / 1.5 s)² / 2)`, with `w` from `weigh`, the boundary's median `m`
    /// and `s` 1.4826 times the median deviation from it: a brow, hair or a collar would
    /// otherwise set the tone of the skin next to it. The weighted log gains are then averaged
    /// along the boundary by [`typical`].
    ///
    /// - `weigh`: how far a colour of the first side, and one of the second, is of the kind
    ///   that decides (such as skin), 0 to 1; `None` if all colours are, so that none is an
    ///   outlier for being unlike most.
    /// - `aim`: from a colour of the first side and one of the second, the colour that the first is
    ///   mapped to.
    pub fn difference(
        &self,
        [from, to]: [&SideColors; 2],
        weigh: Option<[&dyn Fn([f32; 3]) -> f32; 2]>,
        aim: impl Fn([f32; 3], [f32; 3]) -> [f32; 3],
    ) -> Option<Difference> {
        let mean = |around: &[(u32, f64)], side: &SideColors| {
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for &(index, weight) in around {
                let (color, area) = side[index as usize];
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
        let trust: Vec<f64> = colors
            .iter()
            .map(|colors| {
                colors.map_or(0.0, |[from, to]| {
                    weigh.map_or(1.0, |weigh| f64::from(weigh[0](from).min(weigh[1](to))))
                })
            })
            .collect();
        // If few points qualify, the kind of colour does not matter and all points count alike.
        let has_trusted = trust.iter().filter(|&&trust| trust > 0.5).count() * 4 >= trust.len();
        let trust = if has_trusted { trust } else { vec![1.0; trust.len()] };
        let trusted = measured.iter().zip(&trust).filter(|(_, trust)| **trust > 0.5);
        let overall = median_color(trusted.filter_map(|(measured, _)| *measured))?;
        let far = measured.iter().flatten().map(|&d| dist(d, overall));
        // 1.4826 median deviations are one standard deviation of a normal distribution.
        let spread = (1.4826 * median(far).unwrap_or(0.0)).max(MIN_SPREAD);
        // Outlier weights: brows, hair and collars are unlike the rest.
        let likeness: Vec<f64> = measured
            .iter()
            .zip(&trust)
            .map(|(measured, trust)| {
                measured.map_or(0.0, |d| match weigh {
                    Some(_) => trust * (-0.5 * (dist(d, overall) / (1.5 * spread)).powi(2)).exp(),
                    None => 1.0,
                })
            })
            .collect();
        let log_gains =
            self.along.iter().map(|along| typical(along, &measured, &likeness, overall)).collect();
        Some(Difference { log_gains, overall })
    }
}

/// Lower limit of the spread of log gains: gains that differ by less than 3 % are alike. Origin not
/// recorded.
const MIN_SPREAD: f64 = 0.03;

/// Robust mean of the log gains along the boundary: iteratively reweighted least squares with
/// Cauchy weights `1 / (1 + (d / s)²)`, where `s` is 1.4826 times the median distance from the last
/// mean. Outliers would drag a plain mean along.
fn typical(
    along: &[(u32, f64)],
    measured: &[Option<[f64; 3]>],
    likeness: &[f64],
    overall: [f64; 3],
) -> [f64; 3] {
    /// Weight of the boundary's overall log gain, which decides where all neighbours are outliers.
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
        let far = near.iter().map(|&(value, _)| dist(value, center));
        let spread = (1.4826 * median(far).unwrap_or(0.0)).max(MIN_SPREAD);
        center = mean(&|value| 1.0 / (1.0 + (dist(value, center) / spread).powi(2)));
    }
    center
}

/// The Euclidean distance.
fn dist(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from(a).distance(b.into())
}

/// For each boundary point, its neighbours along boundary edges with the lengths of those edges.
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

/// What each of some points may do of what all may together.
fn share(most: usize, points: usize) -> usize {
    (most / points.max(1)).max(LEAST)
}

/// The points within a distance along edges, the start included, with their distances (Dijkstra): the
/// nearest, if more than `most` edges would have to be followed.
fn within(
    edges: &HashMap<u32, Vec<(u32, f64)>>,
    from: u32,
    limit: f64,
    most: usize,
) -> Vec<(u32, f64)> {
    let mut left = most;
    let mut settled = Vec::new();
    let mut found = HashMap::from([(from, 0.0)]);
    let mut queue = BinaryHeap::from([Reverse((0_u64, from))]);
    while let Some(Reverse((bits, point))) = queue.pop() {
        let distance = f64::from_bits(bits);
        if distance > found[&point] {
            continue;
        }
        settled.push((point, distance));
        let beside = edges.get(&point).map_or(&[][..], Vec::as_slice);
        if beside.len() > left {
            break;
        }
        left -= beside.len();
        for &(other, length) in beside {
            let further = distance + length;
            if further <= limit && found.get(&other).is_none_or(|&known| further < known) {
                found.insert(other, further);
                queue.push(Reverse((further.to_bits(), other)));
            }
        }
    }
    settled
}

/// Finds the triangles near points; what is known is kept from search to search.
struct Nearby<'a> {
    surface: &'a Surface,
    /// How many triangles each search may look at.
    most: usize,
    centroids: Vec<DVec3>,
    /// How many all searches looked at.
    looked_at: usize,
    /// The number of the current search, counted from 1.
    search: u32,
    /// For each triangle, and each point, the last search that came to it.
    triangles: Vec<u32>,
    points: Vec<u32>,
}

impl<'a> Nearby<'a> {
    fn new(surface: &'a Surface, most: usize) -> Self {
        let count = surface.triangles().len();
        let centroid = |triangle: u32| {
            let [a, b, c] = surface.corners(triangle);
            (a + b + c) / 3.0
        };
        Self {
            surface,
            most,
            centroids: (0..count as u32).map(centroid).collect(),
            looked_at: 0,
            search: 0,
            triangles: vec![0; count],
            points: vec![0; surface.positions().len()],
        }
    }

    /// The triangles whose centroid is within `reach` of a point, with their distances, found through
    /// neighbours that are within reach too. Triangles at the point itself are always included.
    fn triangles(&mut self, point: u32, reach: f64) -> Vec<(u32, f64)> {
        let surface = self.surface;
        self.search += 1;
        let center = surface.positions()[point as usize];
        let distance = |triangle: u32| self.centroids[triangle as usize].distance(center);
        let mut found: Vec<(u32, f64)> =
            surface.around(point).iter().map(|&triangle| (triangle, distance(triangle))).collect();
        // A triangle may have two of its corners at the point.
        found.dedup_by_key(|&mut (triangle, _)| triangle);
        found.iter().for_each(|&(triangle, _)| self.triangles[triangle as usize] = self.search);
        self.points[point as usize] = self.search;
        let (mut next, mut left) = (0, self.most);
        while let Some(&(triangle, _)) = found.get(next) {
            next += 1;
            for corner in surface.triangles()[triangle as usize] {
                // All triangles at a point are looked at when it is first reached.
                if std::mem::replace(&mut self.points[corner as usize], self.search) == self.search
                {
                    continue;
                }
                for &other in surface.around(corner) {
                    if left == 0 {
                        return found;
                    }
                    left -= 1;
                    self.looked_at += 1;
                    let far = distance(other);
                    let known = &mut self.triangles[other as usize];
                    if far <= reach && *known != self.search {
                        *known = self.search;
                        found.push((other, far));
                    }
                }
            }
        }
        found
    }
}

/// The centroids of a triangle's sub-triangles, as barycentric weights.
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
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::{Direction, Pair};

    use super::*;

    #[test]
    fn grid_points_are_centroids_of_sub_triangles() {
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

    /// The boundary of all but the outermost four rows.
    fn rim(domain: &BlendDomain, side: u32, reach: f64) -> Rim {
        let is_in = |k: &u32| [k % side, k / side].iter().all(|k| (4..side - 4).contains(k));
        let inside: Vec<u32> = (0..side * side).filter(is_in).collect();
        let region = domain.vertices(uvgraft_surface::pair::Side::Target, &inside).unwrap();
        let levels = domain.signed_distances(&region, 9.0);
        Rim::new(domain, &domain.touched(&region), &levels, reach)
    }

    /// Sums in hash-map order would differ in their last digits from run to run.
    #[test]
    fn rims_are_deterministic() {
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
    fn wide_feathers_do_not_sample_the_whole_mesh() {
        let pair = sheet(64);
        let domain = BlendDomain::new(pair, Direction::Forward);
        let wide = rim(&domain, 64, 1000.0);
        let most = wide.around.iter().map(Vec::len).max();
        // Of 7938 triangles.
        assert!(most < Some(2000), "{most:?}");
    }

    /// A point with thousands of triangles is looked at once in a search, and all searches together have
    /// a limit.
    #[test]
    fn points_with_many_triangles_are_looked_at_once() {
        const SIDES: u32 = 4000;
        let mut positions: Vec<[f32; 3]> = (0..SIDES)
            .map(|k| (k as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos())
            .map(|(x, y)| [x, y, 0.0])
            .collect();
        positions.push([0.0; 3]);
        let uv = positions.iter().map(|&[x, y, _]| [x, y].map(|k| 0.5 + 0.4 * k)).collect();
        let faces: Vec<[u32; 3]> = (0..SIDES).map(|k| [SIDES, k, (k + 1) % SIDES]).collect();
        let mesh = Mesh::from_triangles(positions, uv, &faces, &faces).unwrap();
        let surface = Surface::new(&mesh);
        let mut nearby = Nearby::new(&surface, usize::MAX);
        assert_eq!(nearby.triangles(0, 10.0).len(), SIDES as usize);
        assert!(nearby.looked_at <= 3 * SIDES as usize, "{}", nearby.looked_at);
        let mut nearby = Nearby::new(&surface, 100);
        (0..SIDES).for_each(|point| assert!(nearby.triangles(point, 10.0).len() <= 102));
        assert!(nearby.looked_at <= 100 * SIDES as usize);
        // Along edges likewise, the nearest first.
        let edges: HashMap<u32, Vec<(u32, f64)>> =
            (0..SIDES).map(|k| (k, vec![((k + 1) % SIDES, 1.0), (SIDES, 5.0)])).collect();
        let all = within(&edges, 0, 4.5, usize::MAX);
        assert_eq!(all.iter().map(|&(point, _)| point).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        assert_eq!(within(&edges, 0, 4.5, 5), all[..3]);
    }

    #[test]
    fn outliers_carry_no_weight() {
        let along: Vec<(u32, f64)> = (0..20).map(|other| (other, 1.0)).collect();
        let of =
            |other: u32| if other.is_multiple_of(3) { [1.5, 1.0, 2.0] } else { [0.2, 0.1, -0.1] };
        let measured: Vec<Option<[f64; 3]>> = (0..20).map(|other| Some(of(other))).collect();
        let found = typical(&along, &measured, &[1.0; 20], [0.2, 0.1, -0.1]);
        assert!(dist(found, [0.2, 0.1, -0.1]) < 0.02, "{found:?}");
        // If all neighbours are outliers, the overall log gain decides.
        let found = typical(&along, &measured, &[0.0; 20], [0.3; 3]);
        assert_eq!(found, [0.3; 3]);
    }
}
