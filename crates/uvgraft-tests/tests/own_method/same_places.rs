//! Triangles at the same three positions: a method for meshes of one shape with different vertex
//! indices.

use std::collections::HashMap;

use uvgraft::{Mesh, Pair, PairError, Piece};

/// The positions of a triangle's corners.
type Places = [[u32; 3]; 3];

/// Links each target triangle to the first source triangle with corners at the same positions.
pub fn pair(source: Mesh, target: Mesh) -> Result<Pair, PairError> {
    let mut known: HashMap<Places, u32> = HashMap::new();
    for face in 0..source.faces().len() {
        let mut key = places(&source, face);
        key.sort_unstable();
        known.entry(key).or_insert(face as u32);
    }
    let linked = |face: usize| {
        let corners = places(&target, face);
        let mut key = corners;
        key.sort_unstable();
        let of_source = *known.get(&key)?;
        let others = places(&source, of_source as usize);
        let [a, b, c] = corners.map(|place| others.iter().position(|other| *other == place));
        Some(Piece::whole(face as u32, of_source, [a? as u8, b? as u8, c? as u8]))
    };
    let pieces: Vec<Piece> = (0..target.faces().len()).filter_map(linked).collect();
    Pair::from_pieces(source, target, pieces)
}

fn places(mesh: &Mesh, face: usize) -> Places {
    mesh.faces()[face].map(|vertex| mesh.positions()[vertex as usize].map(f32::to_bits))
}
