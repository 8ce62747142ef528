//! Linear blend skinning.

use glam::{Mat3, Quat, Vec3};
use uvgraft::threads;

use super::{RigError, Rigid, Skeleton};

/// Joints that a vertex may follow in a file: a glTF attribute holds four, and many
/// readers support only one attribute.
pub const MAX_INFLUENCES: usize = 4;

/// Skinning weights: any number of joints for each vertex, with weights that sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Skin {
    /// Offsets of the vertices' influences, and the end of the last one's.
    starts: Vec<u32>,
    influences: Vec<(u16, f32)>,
}

/// The effect of dropping small influences.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pruning {
    /// Number of vertices that lost an influence.
    pub vertices: usize,
    /// Maximum over the vertices of the total weight lost, out of 1.
    pub most: f32,
    /// Mean of the total weight lost over all vertices.
    pub mean: f32,
}

/// Vertices in a unit of work; results don't depend on it.
const CHUNK: usize = 1024;

impl Skin {
    /// Builds normalised weights: they are divided by their sum, zeros are dropped, and each vertex
    /// has its weights in descending order.
    ///
    /// - `influences`: for each vertex, its joints and weights.
    /// - `joints`: number of joints.
    ///
    /// # Errors
    /// [`RigError::Weights`] if weights are negative, not finite, sum to zero or refer
    /// to a joint that does not exist.
    pub fn new<I>(influences: I, joints: usize) -> Result<Self, RigError>
    where
        I: IntoIterator<Item: IntoIterator<Item = (usize, f32)>>,
    {
        let mut skin = Self { starts: vec![0], influences: Vec::new() };
        let mut own = Vec::new();
        for (vertex, given) in influences.into_iter().enumerate() {
            own.clear();
            for (joint, weight) in given {
                let wrong = |problem| Err(RigError::Weights { vertex, problem });
                if joint >= joints || joint > usize::from(u16::MAX) {
                    return wrong("has a weight for a joint that does not exist");
                }
                if !(weight.is_finite() && weight >= 0.0) {
                    return wrong("has a negative, NaN or infinite weight");
                }
                if weight > 0.0 {
                    own.push((joint as u16, weight));
                }
            }
            let sum: f32 = own.iter().map(|&(_, weight)| weight).sum();
            if !(sum.is_finite() && sum > 0.0) {
                return Err(RigError::Weights { vertex, problem: "has no weights" });
            }
            own.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            skin.influences.extend(own.iter().map(|&(joint, weight)| (joint, weight / sum)));
            skin.starts.push(skin.influences.len() as u32);
        }
        Ok(skin)
    }

    /// Number of vertices.
    pub const fn vertices(&self) -> usize {
        self.starts.len() - 1
    }

    /// The joints that a vertex follows and their weights, largest first.
    pub fn of(&self, vertex: usize) -> &[(u16, f32)] {
        &self.influences[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Keeps the `most` largest weights of each vertex and renormalises them to sum to 1.
    pub fn pruned(&self, most: usize) -> (Self, Pruning) {
        let most = most.max(1);
        let mut pruned = Self { starts: vec![0], influences: Vec::new() };
        let (mut pruning, mut total) = (Pruning::default(), 0.0_f64);
        for vertex in 0..self.vertices() {
            let (kept, gone) = self.of(vertex).split_at(most.min(self.of(vertex).len()));
            let sum: f32 = kept.iter().map(|&(_, weight)| weight).sum();
            let lost: f32 = gone.iter().map(|&(_, weight)| weight).sum();
            if gone.is_empty() {
                pruned.influences.extend_from_slice(kept);
            } else {
                pruned.influences.extend(kept.iter().map(|&(joint, weight)| (joint, weight / sum)));
                pruning.vertices += 1;
            }
            pruning.most = pruning.most.max(lost);
            total += f64::from(lost);
            pruned.starts.push(pruned.influences.len() as u32);
        }
        pruning.mean = (total / self.vertices().max(1) as f64) as f32;
        (pruned, pruning)
    }

    /// For each vertex, the total weight of a joint and all those below it.
    ///
    /// # Panics
    /// If the weights name joints that the skeleton does not have.
    pub fn weights_below(&self, skeleton: &Skeleton, top: usize) -> Vec<f32> {
        let mut is_below: Vec<bool> = Vec::with_capacity(skeleton.joints().len());
        for (index, joint) in skeleton.joints().iter().enumerate() {
            is_below.push(index == top || joint.parent.is_some_and(|parent| is_below[parent]));
        }
        let below = |&&(joint, _): &&(u16, f32)| is_below[usize::from(joint)];
        let weight = |vertex| self.of(vertex).iter().filter(below).map(|(_, weight)| weight).sum();
        (0..self.vertices()).map(weight).collect()
    }

    /// The weights of a selection of vertices, unchanged.
    pub fn of_vertices(&self, vertices: &[u32]) -> Self {
        let mut some = Self { starts: vec![0], influences: Vec::new() };
        for &vertex in vertices {
            some.influences.extend_from_slice(self.of(vertex as usize));
            some.starts.push(some.influences.len() as u32);
        }
        some
    }

    /// These weights, followed by those of further vertices.
    pub(crate) fn followed_by(&self, further: &Self) -> Self {
        let mut both = self.clone();
        let first = both.influences.len() as u32;
        both.influences.extend_from_slice(&further.influences);
        both.starts.extend(further.starts[1..].iter().map(|start| first + start));
        both
    }

    /// Skins positions: `x' = Σ w_j (R_j x + t_j)`.
    ///
    /// - `positions`: at rest, one for each vertex.
    /// - `motions`: one for each joint, from [`Skeleton::motions`](super::Skeleton::motions).
    ///
    /// # Panics
    /// If there are not as many positions as vertices, or fewer motions than joints.
    pub fn pose(&self, positions: &[[f32; 3]], motions: &[Rigid]) -> Vec<[f32; 3]> {
        assert_eq!(positions.len(), self.vertices(), "a position for each vertex");
        let matrices = matrices(motions);
        let mut posed = vec![[0.0; 3]; positions.len()];
        threads::for_each_chunk(&mut posed, CHUNK, |chunk, posed| {
            for (offset, posed) in posed.iter_mut().enumerate() {
                let vertex = chunk * CHUNK + offset;
                let (turn, shift) = self.blend(vertex, &matrices);
                *posed = (turn * Vec3::from(positions[vertex]) + shift).into();
            }
        });
        posed
    }

    /// The blended rotation matrix of each vertex; not orthogonal where its joints' rotations differ.
    pub fn turns(&self, motions: &[Rigid]) -> Vec<Mat3> {
        let matrices = matrices(motions);
        (0..self.vertices()).map(|vertex| self.blend(vertex, &matrices).0).collect()
    }

    fn blend(&self, vertex: usize, matrices: &[(Mat3, Vec3)]) -> (Mat3, Vec3) {
        let (mut turn, mut shift) = (Mat3::ZERO, Vec3::ZERO);
        for &(joint, weight) in self.of(vertex) {
            let (matrix, translation) = matrices[usize::from(joint)];
            turn += matrix * weight;
            shift += translation * weight;
        }
        (turn, shift)
    }
}

fn matrices(motions: &[Rigid]) -> Vec<(Mat3, Vec3)> {
    let matrix = |motion: &Rigid| {
        (Mat3::from_quat(Quat::from_array(motion.rotation)), Vec3::from(motion.translation))
    };
    motions.iter().map(matrix).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_between_two_joints_moves_half_as_far() {
        let skin =
            Skin::new([vec![(0, 1.0)], vec![(0, 2.0), (1, 2.0)], vec![(1, 0.5)]], 2).unwrap();
        let stay = Rigid { rotation: [0.0, 0.0, 0.0, 1.0], translation: [0.0; 3] };
        let rise = Rigid { translation: [0.0, 2.0, 0.0], ..stay };
        let posed = skin.pose(&[[1.0, 0.0, 0.0]; 3], &[stay, rise]);
        assert_eq!(posed, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 0.0]]);
    }

    #[test]
    fn pruning_keeps_the_largest_and_reports_the_loss() {
        let many = vec![(0, 0.1), (1, 0.3), (2, 0.2), (3, 0.4)];
        let skin = Skin::new([many, vec![(2, 1.0)]], 4).unwrap();
        let (pruned, pruning) = skin.pruned(2);
        assert_eq!(pruned.of(0).iter().map(|&(joint, _)| joint).collect::<Vec<_>>(), [3, 1]);
        assert!((pruned.of(0)[0].1 - 4.0 / 7.0).abs() < 1e-6);
        assert_eq!(pruned.of(1), [(2, 1.0)]);
        assert_eq!(pruning.vertices, 1);
        assert!((pruning.most - 0.3).abs() < 1e-6 && (pruning.mean - 0.15).abs() < 1e-6);
        assert_eq!(skin.pruned(4), (skin, Pruning::default()));
    }

    #[test]
    fn invalid_weights_are_refused() {
        for (bad, part) in [
            (vec![], "has no weights"),
            (vec![(0, 0.0)], "has no weights"),
            (vec![(0, f32::NAN)], "NaN or infinite"),
            (vec![(0, -1.0), (1, 2.0)], "negative"),
            (vec![(2, 1.0)], "does not exist"),
        ] {
            let error = Skin::new([vec![(0, 1.0)], bad], 2).unwrap_err().to_string();
            assert!(error.starts_with("vertex 1") && error.contains(part), "{error}");
        }
    }
}
