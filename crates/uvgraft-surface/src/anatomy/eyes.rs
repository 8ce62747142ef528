//! Eyeballs: pairs of components that are spheres, or caps of spheres, of equal size.

use glam::DVec3;
use nalgebra::{Matrix4, Vector4};

use super::points::Points;

/// A fitted sphere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

/// Two spheres that may be eyes.
#[derive(Debug, Clone, Copy)]
pub(super) struct EyePair {
    pub spheres: [Sphere; 2],
}

/// Least-squares fit of a sphere, accumulated point by point.
///
/// `|p|² = 2 c·p + k` is linear in the centre `c` and in `k = r² - |c|²` (Coope 1993), so
/// one 4×4 system of normal equations replaces an iterative fit.
#[derive(Clone)]
pub(super) struct SphereFit {
    origin: DVec3,
    matrix: Matrix4<f64>,
    right: Vector4<f64>,
    pub count: u32,
}

impl SphereFit {
    /// - `origin`: a point near the sphere, to keep rounding errors small.
    pub fn new(origin: DVec3) -> Self {
        Self { origin, matrix: Matrix4::zeros(), right: Vector4::zeros(), count: 0 }
    }

    pub fn add(&mut self, point: DVec3) {
        let offset = point - self.origin;
        let row = Vector4::from((2.0 * offset).extend(1.0).to_array());
        self.matrix += row * row.transpose();
        self.right += row * offset.length_squared();
        self.count += 1;
    }

    /// `None` where the points lie in a plane.
    pub fn sphere(&self) -> Option<Sphere> {
        let found = self.matrix.lu().solve(&self.right)?;
        let center = DVec3::new(found[0], found[1], found[2]);
        let radius = (found[3] + center.length_squared()).sqrt();
        (radius.is_finite() && radius > 0.0)
            .then_some(Sphere { center: center + self.origin, radius })
    }
}

/// A component that is a sphere, or a cap of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub sphere: Sphere,
    pub component: u32,
    /// Number of points.
    pub count: u32,
}

/// Up to 8 pairs of components that may be eyes, most plausible first.
pub(super) fn pairs(points: &Points) -> Vec<EyePair> {
    let balls = balls(points);
    let mut pairs = Vec::new();
    for (index, a) in balls.iter().enumerate() {
        for b in &balls[index + 1..] {
            let spheres = [a.sphere, b.sphere];
            let radius = 0.5 * (spheres[0].radius + spheres[1].radius);
            // Relative to the radius, as the size of the mesh is unknown.
            let ratio = spheres[0].center.distance(spheres[1].center) / radius;
            let unlike = (spheres[0].radius - spheres[1].radius).abs() / radius;
            let counts = f64::from(a.count.min(b.count)) / f64::from(a.count.max(b.count));
            if unlike < 0.12 && counts > 0.6 && (2.0..9.0).contains(&ratio) {
                // Real eyes are five radii apart, larger ones less. Outer shells (corneas) come
                // first.
                let cost = unlike * 5.0 + (1.0 - counts) + (ratio / 4.5).ln().abs();
                pairs.push((cost, EyePair { spheres }));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs.truncate(8);
    pairs.into_iter().map(|(_, pair)| pair).collect()
}

/// Components that are spheres, with their numbers of points; the 64 with the most points.
pub(super) fn balls(points: &Points) -> Vec<Ball> {
    const MAX: usize = 64;
    let mut fits: Vec<Option<SphereFit>> = vec![None; points.component_count];
    for (&position, &component) in points.positions.iter().zip(&points.component) {
        fits[component as usize].get_or_insert_with(|| SphereFit::new(position)).add(position);
    }
    let diagonal = points.diagonal();
    let spheres: Vec<Option<Sphere>> = fits
        .iter()
        .map(|fit| fit.as_ref().filter(|fit| fit.count >= 12)?.sphere())
        .map(|sphere| sphere.filter(|sphere| (0.002..0.2).contains(&(sphere.radius / diagonal))))
        .collect();
    // Sums of squared relative deviations, and of outward directions: short if points are all
    // around.
    let mut deviation = vec![(0.0, DVec3::ZERO); points.component_count];
    for (&position, &component) in points.positions.iter().zip(&points.component) {
        if let Some(sphere) = spheres[component as usize] {
            let offset = position - sphere.center;
            let relative = offset.length() / sphere.radius;
            let (squares, sum) = &mut deviation[component as usize];
            *squares += (relative - 1.0).powi(2);
            *sum += offset / sphere.radius;
        }
    }
    let mut found: Vec<(f64, Ball)> = Vec::new();
    for (component, ((sphere, (squares, sum)), fit)) in
        (0..).zip(spheres.into_iter().zip(deviation).zip(&fits))
    {
        let (Some(sphere), Some(fit)) = (sphere, fit) else { continue };
        let count = f64::from(fit.count);
        let (error, lopsided) = ((squares / count).sqrt(), sum.length() / count);
        // A cap of less than 50 degrees is too flat for a reliable centre.
        if error < 0.08 && lopsided < 0.85 {
            found.push((error, Ball { sphere, component, count: fit.count }));
        }
    }
    found.sort_by(|a, b| b.1.count.cmp(&a.1.count).then(a.0.total_cmp(&b.0)));
    found.truncate(MAX);
    found.into_iter().map(|(_, ball)| ball).collect()
}
