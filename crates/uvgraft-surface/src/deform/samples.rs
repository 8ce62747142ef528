//! Where the source's deformation is read for each triangle of the target.

use crate::piece::{Extent, Piece, Weights};

/// A part of a target triangle, represented by its centroid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Face of the source.
    pub source: u32,
    /// The part's share of the target triangle's area.
    pub share: f64,
    /// The centroid in the target triangle.
    pub at: Weights,
    /// The centroid in the source face.
    pub from: Weights,
}

/// The samples of all target triangles.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    /// `triangles + 1` offsets into `samples`.
    first: Vec<usize>,
    samples: Vec<Sample>,
}

impl Samples {
    /// - `faces`: how many the target has.
    pub fn new(faces: usize, pieces: impl Iterator<Item = Piece>) -> Self {
        let mut found: Vec<(u32, Sample)> =
            pieces.map(|piece| (piece.target, sample(&piece))).collect();
        found.sort_by_key(|&(face, _)| face);
        let mut first = vec![0; faces + 1];
        for &(face, _) in &found {
            first[face as usize + 1] += 1;
        }
        for face in 0..faces {
            first[face + 1] += first[face];
        }
        Self { first, samples: found.into_iter().map(|(_, sample)| sample).collect() }
    }

    /// The samples of a triangle.
    pub fn of(&self, triangle: u32) -> &[Sample] {
        let triangle = triangle as usize;
        &self.samples[self.first[triangle]..self.first[triangle + 1]]
    }

    /// All of them, in ascending order of their triangles.
    pub fn all(&self) -> &[Sample] {
        &self.samples
    }

    /// The share of a triangle that its samples cover, counting overlaps once for each.
    pub fn covered(&self, triangle: u32) -> f64 {
        self.of(triangle).iter().map(|sample| sample.share).sum()
    }
}

fn sample(piece: &Piece) -> Sample {
    const CENTER: Weights = [1.0 / 3.0; 3];
    let (share, at, from) = match &piece.extent {
        Extent::Whole(_) => (1.0, CENTER, CENTER),
        Extent::Part { target, source } => (area(target), mean(target), mean(source)),
    };
    Sample { source: piece.source, share, at, from }
}

fn mean(corners: &[Weights; 3]) -> Weights {
    [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0)
}

/// The area of a part, as a share of its triangle's.
fn area(corners: &[Weights; 3]) -> f64 {
    let [a, b, c] = corners.map(|weights| [weights[1], weights[2]]);
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}
