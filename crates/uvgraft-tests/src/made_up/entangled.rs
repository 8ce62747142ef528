//! Expression components that are random mixtures of known movements.

use fastrand::Rng;
use glam::Vec3;
use uvgraft::Mesh;
use uvgraft::anatomy::Anatomy;

use super::Truth;

/// How known movements are mixed into components.
#[derive(Debug, Clone)]
pub struct Entanglement {
    /// Seed of the mixture.
    pub seed: u64,
    /// Number of components.
    pub components: usize,
    /// Standard deviation of each component's noise at each vertex, in the mesh's unit.
    pub noise: f32,
    /// Movements whose names start with one of these are left out.
    pub without: Vec<&'static str>,
}

impl Default for Entanglement {
    /// A hundred components, which span all movements, with a hundredth of a millimetre of noise.
    fn default() -> Self {
        Self { seed: 1, components: 100, noise: 1e-5, without: Vec::new() }
    }
}

impl Entanglement {
    /// The components: a random rotation of the movements, padded with smooth bumps to the full
    /// number.
    pub(super) fn components(
        &self,
        mesh: &Mesh,
        anatomy: &Anatomy,
        truths: &[Truth],
    ) -> Vec<Vec<[f32; 3]>> {
        let mut rng = Rng::with_seed(self.seed);
        let left_out = |name: &str| self.without.iter().any(|start| name.starts_with(start));
        let known = truths.iter().filter(|truth| !left_out(truth.name));
        let mut basis: Vec<Vec<[f32; 3]>> = known.map(|truth| truth.offsets.clone()).collect();
        while basis.len() < self.components {
            basis.push(bumps(mesh, anatomy, &mut rng));
        }
        let rotation = rotation(self.components, basis.len(), &mut rng);
        let mut mixed = Vec::with_capacity(self.components);
        for row in &rotation {
            let mut component = vec![[0.0_f32; 3]; mesh.positions().len()];
            for (part, offsets) in row.iter().zip(&basis) {
                for (value, offset) in
                    component.as_flattened_mut().iter_mut().zip(offsets.as_flattened())
                {
                    *value += *part as f32 * offset;
                }
            }
            for value in component.as_flattened_mut() {
                *value += self.noise * normal(&mut rng) as f32;
            }
            mixed.push(component);
        }
        mixed
    }
}

/// A few random bumps of about a millimetre on the head.
fn bumps(mesh: &Mesh, anatomy: &Anatomy, rng: &mut Rng) -> Vec<[f32; 3]> {
    let frame = anatomy.frame();
    let unit = frame.unit as f32;
    let spots: Vec<(Vec3, f32, Vec3)> = (0..6)
        .map(|_| {
            let place = [rng.f64() * 2.0 - 1.0, rng.f64() * 2.5 - 1.5, rng.f64() - 0.3];
            let place = Vec3::from(frame.world(place).map(|value| value as f32));
            let by = Vec3::from(std::array::from_fn(|_| normal(rng) as f32)) * 0.015 * unit;
            (place, (0.25 + 0.35 * rng.f32()) * unit, by)
        })
        .collect();
    let at = |p: &[f32; 3]| {
        let near = |&(place, width, by): &(Vec3, f32, Vec3)| {
            by * (-Vec3::from(*p).distance_squared(place) / (2.0 * width * width)).exp()
        };
        spots.iter().map(near).sum::<Vec3>().into()
    };
    mesh.positions().iter().map(at).collect()
}

/// Random orthonormal rows by Gram-Schmidt; with fewer rows than columns, part of a rotation.
fn rotation(rows: usize, columns: usize, rng: &mut Rng) -> Vec<Vec<f64>> {
    let mut done: Vec<Vec<f64>> = Vec::with_capacity(rows);
    for _ in 0..rows {
        let mut row: Vec<f64> = (0..columns).map(|_| normal(rng)).collect();
        for other in &done {
            let part: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
            row.iter_mut().zip(other).for_each(|(value, other)| *value -= part * other);
        }
        let length = row.iter().map(|value| value * value).sum::<f64>().sqrt();
        row.iter_mut().for_each(|value| *value /= length);
        done.push(row);
    }
    done
}

/// A normally distributed number (Box-Muller).
fn normal(rng: &mut Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.f64()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.f64()).cos()
}
