//! Tables from grids of source positions: for each texel of the target's layout, the UV coordinate in
//! the source's.
//!
//! A grid is the most that a precomputed sampling map holds. Within a target triangle it is affine
//! where the meshes share their triangles, and nearly so elsewhere, so each triangle's map is fitted
//! to the texels it owns and evaluated at its corners. That recovers the vertices of the source to
//! far less than a texel, where reading the texel nearest to a corner would be half a texel off, and
//! beyond the seam half of the time.

use super::locator::{UvLocator, clamped};
use super::{SNAP, SurfacePoint, TableError, VertexTable};
use crate::mesh::Mesh;
use crate::piece::mixed;
use crate::raster::{ScanTriangle, corners_px};
use crate::size::Size;
use crate::statistics::median;
use crate::threads::map_indices;

/// A corner this close to a source vertex in UV space is that vertex: 0.04 texels at 4096², less than
/// single-precision positions and a fit's extrapolation resolve.
const SNAP_UV: f64 = 1e-5;

/// Residual of a fit, in steps from one texel to the next, beyond which a triangle's texels do not
/// belong together: it lies across a seam of the source.
const MOST_RESIDUAL: f64 = 0.5;

/// A fitted step from texel to texel may be this many times the median of all triangles. Three texels
/// on both sides of a seam are fitted exactly, but with a step across half of the texture.
const MOST_STRETCH: f64 = 16.0;

/// Corners may be this many steps outside of all source triangles.
const REACH: f64 = 1.5;

/// What the triangles of the target mesh and their texels gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TexelCounts {
    /// Triangles with a fitted map.
    pub fitted: usize,
    /// Triangles with fewer than three texels that have a position, or with all of them in a line.
    pub too_few_texels: usize,
    /// Triangles whose texels lie on both sides of a seam of the source.
    pub across_seams: usize,
    /// Texels in several target triangles, which cannot tell whose position they have: unused.
    pub overlapping_texels: usize,
}

/// The affine map of one triangle from target texels to source UV coordinates.
#[derive(Debug, Clone, Copy)]
struct Fit {
    centre_px: [f64; 2],
    centre_uv: [f64; 2],
    /// Columns: the change of `(u, v)` from one texel to the next along x and along y.
    steps: [[f64; 2]; 2],
    /// Length of the longer step.
    step: f64,
    /// The largest distance of a sample from the fit, in UV units.
    residual: f64,
    texels: u32,
}

/// A corner's place on the source, as one triangle sees it.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    point: SurfacePoint,
    uv: [f64; 2],
    step: f64,
    texels: u32,
}

impl VertexTable {
    /// A table of the target's vertices on the source mesh, from the source position of each texel of
    /// the target's layout.
    ///
    /// Needs no positions of either mesh. Vertices whose triangles all have too few texels, lie across
    /// a seam of the source or outside its triangles, or overlap others have no point.
    ///
    /// - `size`: size of the grid.
    /// - `source_uv`: `[height * width]` UV coordinates in the source's layout at the centres of the
    ///   target's texels, row by row, origin at the top left; NaN for none.
    ///
    /// # Errors
    /// [`TableError::Length`] if there are not as many positions as texels, [`TableError::Nothing`] if
    /// no vertex has a point.
    pub fn from_texels(
        source: &Mesh,
        target: &Mesh,
        size: Size,
        source_uv: &[[f32; 2]],
    ) -> Result<(Self, TexelCounts), TableError> {
        if source_uv.len() != size.texels() {
            let (found, wanted) = (source_uv.len(), size.texels());
            return Err(TableError::Length {
                what: "positions, one for each texel",
                found,
                wanted,
            });
        }
        let mut counts = TexelCounts::default();
        let claims = claims(target, size);
        counts.overlapping_texels = claims.iter().filter(|&&claims| claims > 1).count();
        let faces = target.faces().len();
        let mut fits = map_indices(faces, |face| {
            let usable = |texel: usize| claims[texel] == 1;
            fit(&samples(target, face, size, source_uv, usable))
        });
        let steps = fits.iter().flatten().map(|fit| fit.step);
        let limit = MOST_STRETCH * median(steps).unwrap_or(0.0);
        for fit in &mut fits {
            match fit {
                None => counts.too_few_texels += 1,
                Some(found)
                    if found.residual > MOST_RESIDUAL * found.step || found.step > limit =>
                {
                    counts.across_seams += 1;
                    *fit = None;
                }
                Some(_) => counts.fitted += 1,
            }
        }
        let locator = UvLocator::new(source);
        let candidates = map_indices(faces, |face| match &fits[face] {
            Some(fit) => candidates(fit, corners_px(target, face, size), source, &locator),
            None => [None; 3],
        });
        let points = chosen(target, &candidates);
        Ok((Self::new(points, source.positions().len())?, counts))
    }
}

/// The number of triangles that own each texel.
fn claims(mesh: &Mesh, size: Size) -> Vec<u8> {
    let mut claims = vec![0_u8; size.texels()];
    for face in 0..mesh.faces().len() {
        for texel in texels(mesh, face, size) {
            claims[texel] = claims[texel].saturating_add(1);
        }
    }
    claims
}

/// The texels whose centres lie in a triangle.
fn texels(mesh: &Mesh, face: usize, size: Size) -> impl Iterator<Item = usize> {
    let scan = ScanTriangle::new(corners_px(mesh, face, size), size);
    let width = size.width as usize;
    scan.into_iter().flat_map(move |scan| {
        let spans: Vec<_> = scan.spans(&scan.rows()).collect();
        spans
            .into_iter()
            .flat_map(move |(row, span)| span.map(move |x| row as usize * width + x as usize))
    })
}

/// The centres of a triangle's usable texels, in texels, with their source positions.
fn samples(
    mesh: &Mesh,
    face: usize,
    size: Size,
    source_uv: &[[f32; 2]],
    usable: impl Fn(usize) -> bool,
) -> Vec<[[f64; 2]; 2]> {
    let sample = |texel: usize| {
        let [x, y] = [texel % size.width as usize, texel / size.width as usize];
        let uv = source_uv[texel].map(f64::from);
        let is_known = uv.iter().all(|value| value.is_finite());
        is_known.then_some([[x as f64 + 0.5, y as f64 + 0.5], uv])
    };
    texels(mesh, face, size).filter(|&texel| usable(texel)).filter_map(sample).collect()
}

/// The least-squares affine map of some samples; `None` if they don't determine one.
fn fit(samples: &[[[f64; 2]; 2]]) -> Option<Fit> {
    if samples.len() < 3 {
        return None;
    }
    let count = samples.len() as f64;
    let mean = |part: usize| {
        [0, 1].map(|axis| samples.iter().map(|sample| sample[part][axis]).sum::<f64>() / count)
    };
    let (centre_px, centre_uv) = (mean(0), mean(1));
    // Sums of products of distances from the centre: among texels, and of texels with positions.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let mut with_uv = [[0.0; 2]; 2];
    for &[px, uv] in samples {
        let [x, y] = [px[0] - centre_px[0], px[1] - centre_px[1]];
        xx += x * x;
        xy += x * y;
        yy += y * y;
        for axis in 0..2 {
            with_uv[0][axis] += x * (uv[axis] - centre_uv[axis]);
            with_uv[1][axis] += y * (uv[axis] - centre_uv[axis]);
        }
    }
    // On a lattice the determinant of texels that are not in a line is at least 1/3.
    let determinant = xx * yy - xy * xy;
    if determinant < 0.1 {
        return None;
    }
    let [by_x, by_y] = with_uv;
    let steps = [
        [0, 1].map(|axis| (yy * by_x[axis] - xy * by_y[axis]) / determinant),
        [0, 1].map(|axis| (xx * by_y[axis] - xy * by_x[axis]) / determinant),
    ];
    let step = steps.iter().map(|step| step[0].hypot(step[1])).fold(0.0, f64::max);
    let mut fit = Fit { centre_px, centre_uv, steps, step, residual: 0.0, texels: 0 };
    let off = |&[px, uv]: &[[f64; 2]; 2]| distance(fit.at(px), uv);
    fit.residual = samples.iter().map(off).fold(0.0, f64::max);
    fit.texels = samples.len() as u32;
    // A constant position is no place for a triangle.
    (step > 0.0 && step.is_finite()).then_some(fit)
}

impl Fit {
    fn at(&self, px: [f64; 2]) -> [f64; 2] {
        let [x, y] = [px[0] - self.centre_px[0], px[1] - self.centre_px[1]];
        [0, 1].map(|axis| self.centre_uv[axis] + x * self.steps[0][axis] + y * self.steps[1][axis])
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Where a triangle's corners lie on the source.
fn candidates(
    fit: &Fit,
    corners_px: [[f64; 2]; 3],
    source: &Mesh,
    locator: &UvLocator,
) -> [Option<Candidate>; 3] {
    let corners = corners_px.map(|corner| fit.at(corner));
    let middle = mixed(&corners, [1.0 / 3.0; 3]);
    corners.map(|uv| {
        let point = located(uv, middle, REACH * fit.step, source, locator)?;
        Some(Candidate { point, uv, step: fit.step, texels: fit.texels })
    })
}

/// The source point at a corner of a triangle.
///
/// - `middle`: the middle of the triangle, which decides on which side of an edge the corner is: source
///   islands may touch, and corners of equal triangles lie on their edges.
fn located(
    uv: [f64; 2],
    middle: [f64; 2],
    reach: f64,
    source: &Mesh,
    locator: &UvLocator,
) -> Option<SurfacePoint> {
    const INWARDS: f64 = 1e-3;
    // The triangle just inside, unless it is so small that the corner is well outside of it.
    const MOST_OUTSIDE: f64 = -0.02;
    let within = [0, 1].map(|axis| uv[axis] + (middle[axis] - uv[axis]) * INWARDS);
    let inner = locator.locate(within, 0.0).and_then(|inner| {
        let weights = locator.weights(inner.face, uv)?;
        let is_near = weights.iter().all(|&weight| weight > MOST_OUTSIDE);
        is_near.then(|| (inner.face, clamped(weights)))
    });
    let nearest = || locator.locate(uv, reach).map(|found| (found.face, found.weights));
    let (face, weights) = inner.or_else(nearest)?;
    let point = SurfacePoint { vertices: source.faces()[face as usize], weights };
    let corners = locator.corners(face);
    let near = (0..3).find(|&k| weights[k] >= 1.0 - SNAP || distance(corners[k], uv) < SNAP_UV);
    Some(near.map_or(point, |corner| point.at_corner(corner)))
}

/// For each vertex, the place that most texels support.
fn chosen(target: &Mesh, candidates: &[[Option<Candidate>; 3]]) -> Vec<Option<SurfacePoint>> {
    let mut seen: Vec<(u32, Candidate)> = Vec::new();
    for (corners, candidates) in target.faces().iter().zip(candidates) {
        let known = corners.iter().zip(candidates);
        seen.extend(known.filter_map(|(&vertex, candidate)| Some((vertex, (*candidate)?))));
    }
    // Stable, so that ties are decided by the order of faces.
    seen.sort_by_key(|&(vertex, _)| vertex);
    let mut points = vec![None; target.positions().len()];
    for group in seen.chunk_by(|a, b| a.0 == b.0) {
        points[group[0].0 as usize] = Some(best(group));
    }
    points
}

/// The candidate that agrees with most texels; among those that agree, vertices come first.
fn best(group: &[(u32, Candidate)]) -> SurfacePoint {
    // A fan of thousands is compared with its largest triangles only.
    const MOST_COMPARED: usize = 64;
    let mut candidates: Vec<&Candidate> = group.iter().map(|(_, candidate)| candidate).collect();
    candidates.sort_by_key(|candidate| std::cmp::Reverse(candidate.texels));
    candidates.truncate(MOST_COMPARED);
    let agrees = |a: &Candidate, b: &Candidate| {
        distance(a.uv, b.uv) < MOST_RESIDUAL * a.step.min(b.step)
            || a.point.difference(&b.point) < 0.1
    };
    let support = |candidate: &&Candidate| -> u64 {
        let others = candidates.iter().filter(|other| agrees(candidate, other));
        others.map(|other| u64::from(other.texels)).sum()
    };
    // The first of several with the same key, which has most texels.
    let key = |candidate: &&Candidate| (support(candidate), candidate.point.vertex().is_some());
    let first = candidates
        .iter()
        .copied()
        .reduce(|best, other| if key(&other) > key(&best) { other } else { best });
    first.map_or(group[0].1.point, |candidate| candidate.point)
}

#[cfg(test)]
mod tests;
