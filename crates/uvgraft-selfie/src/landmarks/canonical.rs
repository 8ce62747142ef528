//! The average face whose vertices are the landmarks.

use crate::face_networks::CanonicalMesh;

/// The canonical face of MediaPipe, and which landmarks mirror each other.
#[derive(Debug, Clone, PartialEq)]
pub struct CanonicalFace {
    /// 468 positions in centimetres: x towards the face's left (right in a picture), y up, z forwards.
    pub positions: Vec<[f64; 3]>,
    /// 468 texture coordinates in `0.0..=1.0`, with the origin at the top left.
    pub uvs: Vec<[f32; 2]>,
    /// 898 triangles, counter-clockwise seen from outside. Eyes and mouth are closed.
    pub triangles: Vec<[u32; 3]>,
    /// For each landmark its partner on the other side of the face; itself on the line of symmetry.
    pub mirror_partners: Vec<usize>,
}

impl CanonicalFace {
    /// From what was read.
    pub fn new(mesh: &CanonicalMesh) -> Self {
        let positions: Vec<[f64; 3]> =
            mesh.positions.iter().map(|position| position.map(f64::from)).collect();
        let mirror_partners =
            positions.iter().map(|&position| mirror_partner(&positions, position)).collect();
        let (uvs, triangles) = (mesh.uvs.clone(), mesh.triangles.clone());
        Self { positions, uvs, triangles, mirror_partners }
    }
}

/// The vertex that is nearest to a mirrored position.
fn mirror_partner(positions: &[[f64; 3]], [x, y, z]: [f64; 3]) -> usize {
    let distance =
        |other: &[f64; 3]| (other[0] + x).powi(2) + (other[1] - y).powi(2) + (other[2] - z).powi(2);
    let distances = positions.iter().map(distance).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirror_partners_mirror_each_other() {
        let positions = vec![[0.0, 1.0, 0.0], [-2.0, 0.0, 1.0], [1.9, 0.1, 1.0], [-1.0, 0.0, 3.0]];
        let found: Vec<_> =
            positions.iter().map(|&position| mirror_partner(&positions, position)).collect();
        assert_eq!(found[..3], [0, 2, 1]);
    }
}
