//! Recognising a mesh and its layout.

use super::{Edition, KnownLayout, KnownMesh, MESHES};
use crate::connectivity::{Fingerprint, Welded};
use crate::mesh::Mesh;

/// How sure a recognition is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum Certainty {
    /// The connectivity is the same: it is the mesh, whatever its pose, shape and order.
    Connectivity,
    /// The counts are the same, and the table has no fingerprint that could be compared.
    CountsOnly,
    /// The counts are the same but the connectivity is not: it is another mesh, or an edited one,
    /// and correspondences made for the original do not fit.
    OtherConnectivity,
}

/// A mesh that looks like one in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MeshMatch {
    /// The entry.
    #[cfg_attr(feature = "serde", serde(serialize_with = "name_of_mesh"))]
    pub mesh: &'static KnownMesh,
    /// Which of its editions.
    #[cfg_attr(feature = "serde", serde(serialize_with = "name_of_edition"))]
    pub edition: &'static Edition,
    /// How sure this is.
    pub certainty: Certainty,
}

/// A layout that looks like one in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LayoutMatch {
    /// The mesh that the layout is published for.
    #[cfg_attr(feature = "serde", serde(serialize_with = "name_of_mesh"))]
    pub mesh: &'static KnownMesh,
    /// The layout.
    #[cfg_attr(feature = "serde", serde(serialize_with = "name_of_layout"))]
    pub layout: &'static KnownLayout,
    /// How sure this is.
    pub certainty: Certainty,
}

/// What a mesh and its layout look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Recognition {
    /// The known mesh with the same connectivity, or else with the same counts.
    pub mesh: Option<MeshMatch>,
    /// The known layout with the same UV connectivity, or else with the same counts on a mesh that
    /// looks like its own.
    pub layout: Option<LayoutMatch>,
    /// The fingerprint of the surface.
    pub surface_fingerprint: Fingerprint,
    /// The fingerprint of the UV faces.
    pub layout_fingerprint: Fingerprint,
}

/// Reports name entries instead of repeating them.
#[cfg(feature = "serde")]
macro_rules! name_only {
    ($function:ident, $entry:ty) => {
        fn $function<S: serde::Serializer>(
            entry: &&'static $entry,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            serializer.serialize_str(entry.name)
        }
    };
}
#[cfg(feature = "serde")]
name_only!(name_of_mesh, KnownMesh);
#[cfg(feature = "serde")]
name_only!(name_of_edition, Edition);
#[cfg(feature = "serde")]
name_only!(name_of_layout, KnownLayout);

impl Recognition {
    /// The match of the mesh, if it is one: its connectivity does not contradict it.
    pub fn likely_mesh(&self) -> Option<&MeshMatch> {
        self.mesh.as_ref().filter(|found| found.certainty != Certainty::OtherConnectivity)
    }

    /// The match of the layout, if it is one: its connectivity does not contradict it.
    pub fn likely_layout(&self) -> Option<&LayoutMatch> {
        self.layout.as_ref().filter(|found| found.certainty != Certainty::OtherConnectivity)
    }
}

/// Looks a mesh and its layout up in [`MESHES`].
///
/// Positions and the order of vertices, UV coordinates and faces do not matter, nor does it matter
/// whether vertices are split at UV seams. Triangulating a mesh that is published in quads leaves
/// only its counts to go by. Layouts with the same seams and another arrangement of islands are not
/// told apart.
pub fn recognise(mesh: &Mesh) -> Recognition {
    let welded = Welded::new(mesh);
    let [surface_fingerprint, layout_fingerprint] = welded.fingerprints(mesh);
    let counts = Counts::of(mesh, &welded);
    let found = find_mesh(&counts, surface_fingerprint);
    let layout = find_layout(&counts, layout_fingerprint, found.as_ref());
    Recognition { mesh: found, layout, surface_fingerprint, layout_fingerprint }
}

/// The counts of a mesh: as they are, and as they are without what exporters split and what no face
/// uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Counts {
    vertices: [usize; 2],
    uv_coordinates: [usize; 2],
    triangles: usize,
    polygons: usize,
}

impl Counts {
    fn of(mesh: &Mesh, welded: &Welded) -> Self {
        Self {
            vertices: [mesh.positions().len(), welded.used_points()],
            uv_coordinates: [mesh.uv().len(), welded.uv_count()],
            triangles: mesh.faces().len(),
            polygons: mesh.polygon_count(),
        }
    }

    /// Whether all counts of an edition that are known are the mesh's.
    fn are_of(&self, edition: &Edition) -> bool {
        let has_polygons = match (edition.triangles, edition.polygons) {
            (Some(triangles), _) => triangles == self.triangles,
            // Triangulating quads gives at least as many triangles as there are polygons.
            (None, Some(polygons)) => polygons <= self.polygons,
            (None, None) => true,
        };
        has_polygons && self.vertices.contains(&edition.vertices)
    }

    fn are_of_layout(&self, layout: &KnownLayout) -> bool {
        self.uv_coordinates.contains(&layout.uv_coordinates)
            && layout.triangles.is_none_or(|triangles| triangles == self.triangles)
    }

    /// Whether a fingerprint of polygons as published says anything about this mesh.
    fn are_comparable(&self, polygons: Option<usize>) -> bool {
        polygons.is_none_or(|polygons| polygons == self.polygons)
    }
}

fn certainty(known: Option<Fingerprint>, is_comparable: bool) -> Certainty {
    if known.is_some() && is_comparable {
        // Fingerprints that agree have been found before counts are looked at.
        Certainty::OtherConnectivity
    } else {
        Certainty::CountsOnly
    }
}

fn find_mesh(counts: &Counts, fingerprint: Fingerprint) -> Option<MeshMatch> {
    let all = || MESHES.iter().flat_map(|mesh| mesh.editions.iter().map(move |it| (mesh, it)));
    let same = all().find(|(_, edition)| edition.fingerprint == Some(fingerprint));
    if let Some((mesh, edition)) = same {
        return Some(MeshMatch { mesh, edition, certainty: Certainty::Connectivity });
    }
    let (mesh, edition) = all().find(|(_, edition)| counts.are_of(edition))?;
    let is_comparable = counts.are_comparable(edition.polygons.or(edition.triangles));
    Some(MeshMatch { mesh, edition, certainty: certainty(edition.fingerprint, is_comparable) })
}

fn find_layout(
    counts: &Counts,
    fingerprint: Fingerprint,
    found: Option<&MeshMatch>,
) -> Option<LayoutMatch> {
    let all = || MESHES.iter().flat_map(|mesh| mesh.layouts.iter().map(move |it| (mesh, it)));
    let same = all().find(|(_, layout)| layout.fingerprint == Some(fingerprint));
    if let Some((mesh, layout)) = same {
        return Some(LayoutMatch { mesh, layout, certainty: Certainty::Connectivity });
    }
    // Counts of UV coordinates say something only about a mesh that looks right.
    let MeshMatch { mesh, edition, .. } = found?;
    let layout = mesh.layouts.iter().find(|layout| counts.are_of_layout(layout))?;
    let is_comparable = counts.are_comparable(edition.polygons.or(edition.triangles));
    Some(LayoutMatch { mesh, layout, certainty: certainty(layout.fingerprint, is_comparable) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of triangles with as many vertices and UV coordinates as given, the rest of them
    /// unused.
    fn strip(vertices: usize, uv: usize, triangles: usize) -> Mesh {
        let positions = (0..vertices).map(|k| [k as f32, (k % 2) as f32, 0.0]).collect();
        let coordinates = (0..uv).map(|k| [k as f32 / uv as f32, (k % 2) as f32]).collect();
        let last = vertices.min(uv) as u32 - 2;
        let faces: Vec<[u32; 3]> =
            (0..triangles as u32).map(|k| k % last).map(|k| [k, k + 1, k + 2]).collect();
        Mesh::from_triangles(positions, coordinates, &faces, &faces).unwrap()
    }

    #[test]
    fn equal_counts_with_other_connectivity_are_not_it() {
        let found = recognise(&strip(5_023, 5_118, 9_976));
        let mesh = found.mesh.unwrap();
        assert_eq!((mesh.mesh.name, mesh.certainty), ("FLAME", Certainty::OtherConnectivity));
        assert_eq!(found.layout.unwrap().certainty, Certainty::OtherConnectivity);
        assert_eq!((found.likely_mesh(), found.likely_layout()), (None, None));
    }

    #[test]
    fn without_a_fingerprint_counts_decide() {
        let found = recognise(&strip(468, 468, 898));
        let mesh = found.mesh.unwrap();
        assert_eq!((mesh.mesh.name, mesh.certainty), ("MediaPipe face", Certainty::CountsOnly));
        assert_eq!(found.layout.unwrap().certainty, Certainty::CountsOnly);
        // One triangle less, or UV coordinates of somebody else's.
        assert_eq!(recognise(&strip(468, 468, 897)).mesh, None);
        assert_eq!(recognise(&strip(468, 400, 898)).layout, None);
        // Editions have names.
        let found = recognise(&strip(5_023, 5_118, 10_006)).mesh.unwrap();
        assert_eq!(found.mesh.title(found.edition), "FLAME, mouth closed");
        let found = recognise(&strip(5_143, 5_200, 10_144)).mesh.unwrap();
        assert_eq!(found.edition.name, "with VHAP's teeth");
    }

    #[test]
    fn quads_that_were_split_leave_the_counts() {
        let found = recognise(&strip(19_158, 21_334, 36_972)).mesh.unwrap();
        assert_eq!((found.mesh.name, found.certainty), ("MakeHuman", Certainty::CountsOnly));
    }

    #[test]
    fn an_unknown_mesh_has_no_name() {
        let found = recognise(&strip(4_321, 5_118, 9_976));
        assert_eq!((found.mesh, found.layout), (None, None));
    }
}
