//! Room for the eyeballs in MakeHuman's layout, where an iris would be eight texels wide in a texture
//! of 2048.
//!
//! MakeHuman's skins leave the islands of its helper eyes empty, since its people wear other ones. So
//! these are moved to a free corner and enlarged, the fronts with the irises most.

use glam::Vec2;
use uvgraft::Mesh;

use crate::islands::{Island, islands};

/// Side of the box of a front, and of a back.
const SIDES: [f32; 2] = [0.1, 0.035];

/// Upper left corners of the boxes of each eye's front and back, with the origin at the top left. The
/// eyes lie beside each other, so that nothing takes them for one.
const PLACES: [(&str, [Vec2; 2]); 2] = [
    ("left_eye", [Vec2::new(0.775, 0.02), Vec2::new(0.775, 0.127)]),
    ("right_eye", [Vec2::new(0.885, 0.02), Vec2::new(0.885, 0.127)]),
];

/// The layout of a body with more room for the islands of its eyes.
///
/// - `mesh`: in MakeHuman's layout, with the parts of `PLACES`.
pub(crate) fn with_room(mesh: &Mesh) -> Vec<[f32; 2]> {
    let mut uv: Vec<Vec2> = mesh.uv().iter().map(|&place| place.into()).collect();
    let islands = islands(mesh);
    for (name, places) in PLACES {
        let parts = mesh.parts().iter().filter(|part| part.group == name);
        let polygons = parts.flat_map(|part| part.polygons.clone());
        let is_of_eye = faces_of(mesh, polygons);
        let mut of_eye: Vec<&Island> =
            islands.iter().filter(|island| is_of_eye[island.faces[0] as usize]).collect();
        of_eye.sort_by(|a, b| forward(mesh, b).total_cmp(&forward(mesh, a)));
        for ((island, corner), side) in of_eye.into_iter().zip(places).zip(SIDES) {
            let [low, high] = island.bounds(&uv);
            let widest = (high - low).max_element().max(f32::MIN_POSITIVE);
            island.place(&mut uv, corner, side / widest);
        }
    }
    uv.into_iter().map(Vec2::into).collect()
}

/// For each triangle whether it is of one of the polygons.
fn faces_of(mesh: &Mesh, polygons: impl Iterator<Item = u32>) -> Vec<bool> {
    let mut is_of_them = vec![false; mesh.faces().len()];
    polygons.for_each(|polygon| is_of_them[mesh.polygon(polygon as usize)].fill(true));
    is_of_them
}

/// How far in front an island is: the mean of its corners.
fn forward(mesh: &Mesh, island: &Island) -> f32 {
    let corners = island.faces.iter().flat_map(|&face| mesh.faces()[face as usize]);
    let sum: f32 = corners.map(|vertex| mesh.positions()[vertex as usize][2]).sum();
    sum / (3 * island.faces.len()) as f32
}

#[cfg(test)]
mod tests {
    use uvgraft::mesh::MeshPart;

    use super::*;

    #[test]
    fn fronts_of_eyes_are_enlarged_and_skin_stays() {
        // A triangle of skin, and for each eye a back and a front.
        let (mut places, mut uv, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for (index, depth) in [0.0_f32, -1.0, 1.0, -1.0, 1.0].into_iter().enumerate() {
            let first = uv.len() as u32;
            for [u, v] in [[0.0, 0.0], [0.01, 0.0], [0.0, 0.02]] {
                places.push([u, v, depth]);
                uv.push([0.1 * index as f32 + u, 0.5 + v]);
            }
            faces.push([first, first + 1, first + 2]);
        }
        let part = |group: &str, polygons| MeshPart {
            group: group.to_owned(),
            polygons,
            ..MeshPart::default()
        };
        let parts = vec![part("skin", 0..1), part("left_eye", 1..3), part("right_eye", 3..5)];
        let mesh = Mesh::from_triangles(places, uv.clone(), &faces, &faces).unwrap();
        let mesh = mesh.with_parts(parts);
        let moved = with_room(&mesh);
        assert_eq!(moved[..3], uv[..3]);
        let close = |[u, v]: [f32; 2], at: Vec2| Vec2::new(u, v).distance(at) < 1e-6;
        let [(_, left), (_, right)] = PLACES;
        assert!(close(moved[3], left[1]) && close(moved[6], left[0]));
        assert!(close(moved[9], right[1]) && close(moved[12], right[0]));
        assert!(close(moved[8], left[0] + Vec2::new(0.0, SIDES[0])));
        assert!(moved.iter().flatten().all(|value| (0.0..=1.0).contains(value)));
    }
}
