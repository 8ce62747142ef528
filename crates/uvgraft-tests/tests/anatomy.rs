//! Landmarks and areas of the synthetic figure and of real heads and bodies.

use uvgraft::mesh_report::{MeshReport, Subject, Unit};
use uvgraft::{Anatomy, Area, Landmark, Mesh};
use uvgraft_figure::Figure;
use uvgraft_tests::real;

/// Landmarks read off front and side views, in the head's coordinates.
type Seen = [(Landmark, [f64; 3])];

/// Allows for reading positions off a picture, and for the flat curvature around a rounded chin's
/// foremost point.
const TOLERANCE: f64 = 0.17;

fn check(name: &str, mesh: &Mesh, seen: &Seen) -> Anatomy {
    let found = Anatomy::find(mesh).unwrap_or_else(|error| panic!("{name}: {error}"));
    for &(landmark, wanted) in seen {
        let at = found.point(landmark).unwrap_or_else(|| panic!("{name} has no {landmark:?}"));
        let at = found.frame().local(at);
        let distance = (0..3).map(|k| (at[k] - wanted[k]).powi(2)).sum::<f64>().sqrt();
        assert!(distance < TOLERANCE, "{name}: {landmark:?} is at {at:?}, not at {wanted:?}");
    }
    for area in [Area::Cheeks, Area::Forehead, Area::Lips, Area::Eyes, Area::Scalp, Area::Neck] {
        assert!(total(&found, area) > 5.0, "{name} has no {area:?}");
    }
    let sides = [1.0, -1.0].map(|side| {
        let values = mesh.positions().iter().zip(found.area(Area::Cheeks));
        let on_side = values
            .filter(|(position, _)| found.frame().local(position.map(f64::from))[0] * side > 0.0);
        on_side.map(|(_, &value)| f64::from(value)).sum::<f64>()
    });
    assert!((sides[0] / sides[1] - 1.0).abs() < 0.25, "{name}: cheeks of {sides:?} vertices");
    found
}

fn total(anatomy: &Anatomy, area: Area) -> f32 {
    anatomy.area(area).iter().sum()
}

#[test]
fn the_figure() {
    let figure = Figure::new();
    let seen = [
        (Landmark::LeftEye, [0.5, 0.0, 0.0]),
        (Landmark::RightEye, [-0.5, 0.0, 0.0]),
        (Landmark::NoseTip, [0.0, -0.55, 0.67]),
        (Landmark::Mouth, [0.0, -1.1, 0.43]),
        (Landmark::Chin, [0.0, -1.5, 0.4]),
        (Landmark::LeftEar, [1.33, -0.06, -1.36]),
        (Landmark::RightEar, [-1.33, -0.06, -1.36]),
    ];
    let head = check("head", &figure.head, &seen);
    let body = check("body", &figure.body, &seen);
    for area in [Area::Hands, Area::Feet, Area::Chest] {
        assert!(total(&head, area) == 0.0, "a head has no {area:?}");
        assert!(total(&body, area) > 100.0, "a body has {area:?}");
    }
    // The head is part of the body, under other vertex indices.
    for area in [Area::Cheeks, Area::Nose, Area::Lips, Area::Brows, Area::Eyes] {
        let pairs = figure.vertex_map.iter().enumerate();
        let differences = pairs.map(|(vertex, &other)| {
            (head.area(area)[vertex] - body.area(area)[other as usize]).abs()
        });
        let mean = differences.sum::<f32>() / figure.vertex_map.len() as f32;
        assert!(mean < 0.005, "{area:?} differs by {mean}");
    }
}

#[test]
fn real_heads_and_bodies() {
    let Some(folder) = real::folder() else { return };
    let mesh = |name: &str| uvgraft_io::obj::read(folder.join(name)).expect("a sound mesh");
    let seen = [
        (Landmark::NoseTip, [0.0, -0.55, 0.77]),
        (Landmark::Mouth, [0.0, -1.13, 0.4]),
        (Landmark::Chin, [0.0, -1.66, 0.36]),
        (Landmark::LeftMouthCorner, [0.39, -1.15, 0.26]),
        (Landmark::LeftEar, [1.47, -0.15, -1.43]),
        (Landmark::BrowCenter, [0.0, 0.35, 0.45]),
    ];
    check("FLAME", &mesh("flame_head_template.obj"), &seen);
    check("FLAME in HiFi3D++ layout", &mesh("flame_hifi3d_uv.obj"), &seen[..1]);
    check("HiFi3D++", &mesh("hifi3d_head.obj"), &seen);
    let body = check("SMPL-X", &mesh("smplx_addon.obj"), &seen);
    for area in [Area::Hands, Area::Feet, Area::Chest] {
        assert!(total(&body, area) > 100.0, "SMPL-X has {area:?}");
    }
}

#[test]
fn bodies_are_reported_from_heads_by_shape() {
    let figure = Figure::new();
    let body = &figure.body;
    let anatomy = Anatomy::find(body).unwrap();
    let is_end = |vertex: u32| {
        let weight = |area| anatomy.area(area)[vertex as usize];
        weight(Area::Hands) > 0.0 || weight(Area::Feet) > 0.0
    };
    let kept: Vec<usize> = (0..body.faces().len())
        .filter(|&face| !body.faces()[face].iter().any(|&vertex| is_end(vertex)))
        .collect();
    assert!(kept.len() < body.faces().len());
    let only = |faces: &[[u32; 3]]| kept.iter().map(|&face| faces[face]).collect::<Vec<_>>();
    let (positions, uv) = (body.positions().to_vec(), body.uv().to_vec());
    let (faces, uv_faces) = (only(body.faces()), only(body.uv_faces()));
    let cut = Mesh::from_triangles(positions, uv, &faces, &uv_faces);
    let cut = cut.unwrap();
    for (mesh, subject) in
        [(&figure.head, Subject::Head), (body, Subject::Body), (&cut, Subject::Body)]
    {
        let found = MeshReport::new(mesh);
        assert_eq!((found.subject, &found.units[..]), (Some(subject), &[Unit::Metre][..]));
    }
}
