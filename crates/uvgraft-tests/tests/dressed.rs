//! Heads and bodies with hair, glasses, hats and clothes: their faces, and pairs with a plain head.

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use uvgraft::correspond::surface::{SurfaceError, SurfaceReport};
use uvgraft::correspond::{By, FindOptions, Method, MethodFailure, find};
use uvgraft::{Anatomy, AnatomyError, Area, HeadFrame, Mesh, Pair};
use uvgraft_figure::Figure;
use uvgraft_tests::dressed::{Extra, dressed};
use uvgraft_tests::real;
use uvgraft_tests::remeshed::Remeshed;
use uvgraft_tests::synthetic::posed;

/// Sets of extras that are worn together.
const OUTFITS: [&[Extra]; 5] = [
    &[Extra::Cap, Extra::PonyTail, Extra::Locks],
    &[Extra::Cards, Extra::Glasses, Extra::Beard, Extra::Clothes],
    &[Extra::LongHair, Extra::Hat, Extra::Earrings],
    &[Extra::Buns, Extra::Lenses, Extra::Collar],
    &[Extra::Headscarf, Extra::Glasses, Extra::Horns],
];

/// The component with most faces: the skin, without eyeballs, ears and hair.
fn skin_of(mesh: &Mesh) -> Mesh {
    let mut number = HashMap::new();
    let points: Vec<usize> = mesh
        .positions()
        .iter()
        .map(|position| {
            let next = number.len();
            *number.entry(position.map(f32::to_bits)).or_insert(next)
        })
        .collect();
    // The least point of each component, by repeated passes.
    let mut least: Vec<usize> = (0..number.len()).collect();
    loop {
        let mut is_settled = true;
        for face in mesh.faces() {
            let corners = face.map(|vertex| points[vertex as usize]);
            let low = corners.map(|point| least[point]).into_iter().min().expect("three corners");
            for point in
                corners.into_iter().filter(|&point| least[point] != low).collect::<Vec<_>>()
            {
                least[point] = low;
                is_settled = false;
            }
        }
        if is_settled {
            break;
        }
    }
    let component = |vertex: u32| least[points[vertex as usize]];
    let mut counts: HashMap<usize, usize> = HashMap::new();
    mesh.faces().iter().for_each(|face| *counts.entry(component(face[0])).or_default() += 1);
    let (&largest, _) = counts.iter().max_by_key(|(_, count)| **count).expect("faces");
    only(mesh, |vertex| component(vertex) == largest)
}

/// The faces whose corners are all wanted.
fn only(mesh: &Mesh, is_wanted: impl Fn(u32) -> bool) -> Mesh {
    let kept = |all: &[[u32; 3]]| -> Vec<[u32; 3]> {
        let all = all.iter().zip(mesh.faces());
        all.filter(|(_, face)| face.iter().all(|&at| is_wanted(at))).map(|(it, _)| *it).collect()
    };
    let (faces, uv_faces) = (kept(mesh.faces()), kept(mesh.uv_faces()));
    Mesh::from_triangles(mesh.positions().to_vec(), mesh.uv().to_vec(), &faces, &uv_faces)
        .expect("faces of a sound mesh")
}

/// The faces between two heights, in distances between the eyes.
fn between(mesh: &Mesh, frame: &HeadFrame, heights: std::ops::Range<f64>) -> Mesh {
    let height = |vertex: u32| frame.local(mesh.positions()[vertex as usize].map(f64::from))[1];
    only(mesh, |vertex| heights.contains(&height(vertex)))
}

/// Fails unless the face of `worn` is that of `truth`.
fn assert_same_head(name: &str, truth: &HeadFrame, worn: &Mesh) {
    let found = Anatomy::find(worn).unwrap_or_else(|error| panic!("{name}: {error}"));
    let found = found.frame();
    let apart = DVec3::from(found.origin).distance(DVec3::from(truth.origin)) / truth.unit;
    let least = (0..3).map(|axis| DVec3::from(found.axes[axis]).dot(DVec3::from(truth.axes[axis])));
    let least = least.fold(1.0, f64::min);
    let size = found.unit / truth.unit;
    // A fifth of the way from eye to eye, 14 degrees: errors that alignment corrects.
    assert!(
        apart < 0.2 && least > 0.97 && (0.9..1.1).contains(&size),
        "{name}: {apart:.2} apart, cosine {least:.3}, {size:.2} times as large"
    );
}

fn heads() -> Vec<(&'static str, Mesh)> {
    let figure = Figure::new();
    let skin = skin_of(&figure.head);
    let frame = *Anatomy::find(&figure.body).expect("a face").frame();
    let bust = between(&figure.body, &frame, -7.0..9.0);
    let mut heads =
        vec![("skin", skin), ("head", figure.head), ("bust", bust), ("body", figure.body)];
    if let Some(folder) = real::folder() {
        for (name, without_eyes, file) in [
            ("FLAME", "FLAME without eyes", "flame_head_template.obj"),
            ("SMPL-X", "SMPL-X without eyes", "smplx_addon.obj"),
            ("HiFi3D++", "", "hifi3d_head.obj"),
        ] {
            let mesh = uvgraft_io::obj::read(folder.join(file)).expect("a sound mesh");
            if !without_eyes.is_empty() {
                heads.push((without_eyes, skin_of(&mesh)));
            }
            heads.push((name, mesh));
        }
    }
    heads
}

#[test]
fn faces_are_found_whatever_is_worn() {
    for (name, mesh) in heads() {
        let truth = *Anatomy::find(&mesh).expect("a face").frame();
        // Without eyeballs, a face is detected by its profile alone.
        let single = if name == "skin" { &Extra::ALL[..] } else { &[Extra::SideSwept] };
        for outfit in single.chunks(1).chain(OUTFITS) {
            assert_same_head(&format!("{name}, {outfit:?}"), &truth, &dressed(&mesh, outfit));
        }
    }
}

#[test]
fn faces_are_found_however_a_mesh_is_turned() {
    let skin = skin_of(&Figure::new().head);
    let z_up = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let turned = DMat3::from_rotation_y(2.2) * DMat3::from_rotation_x(-0.5);
    let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    for (name, scale, turn) in [
        ("centimetres", 100.0, DMat3::IDENTITY),
        ("Z up", 1.0, z_up),
        ("turned", 30.0, turned),
        ("upside down", 1.0, DMat3::from_rotation_z(std::f64::consts::PI)),
        ("mirrored", 1.0, mirrored),
    ] {
        let place = |at: [f64; 3]| (turn * DVec3::from(at) * scale + DVec3::ONE).to_array();
        for outfit in OUTFITS {
            let worn = posed(&dressed(&skin, outfit), turn.determinant() < 0.0, place);
            let plain = posed(&skin, turn.determinant() < 0.0, place);
            let truth = *Anatomy::find(&plain).expect("a face").frame();
            assert_same_head(&format!("{name}, {outfit:?}"), &truth, &worn);
        }
    }
}

fn registered(source: &Mesh, target: &Mesh) -> (Pair, SurfaceReport) {
    let mut options = FindOptions::default();
    options.by = By::Surface;
    let found = find(source.clone(), target.clone(), &options).expect("heads are found");
    let Method::Surface(report) = found.method else { panic!("not by surface") };
    (found.pair, report)
}

/// Skin of the figure's head, without eyes and hair, and another head of other triangles elsewhere, in
/// centimetres.
fn coarse() -> [Mesh; 2] {
    let skin = skin_of(&Figure::new().head);
    let [source, target] =
        [5, 6].map(|seed| Remeshed::new(&skin).decimated(&skin, 0.7, seed).mesh(&skin));
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.2);
    let place =
        |at: [f64; 3]| (turn * (DVec3::from(at) * DVec3::new(1.05, 0.97, 1.03)) * 100.0).to_array();
    [source, posed(&target, false, place)]
}

/// Fails unless a dressed target is registered as the plain one is.
fn check_pairs(name: &str, source: &Mesh, plain: &Mesh, outfits: &[&[Extra]]) {
    const FACE: [Area; 5] = [Area::Cheeks, Area::Forehead, Area::Nose, Area::Lips, Area::Jaw];
    let unit = Anatomy::find(source).expect("a face").frame().unit;
    let head = Anatomy::find(plain).expect("a face");
    let (truth_pair, truth) = registered(source, plain);
    for outfit in outfits {
        let (pair, report) = registered(source, &dressed(plain, outfit));
        let is_face = |vertex: &usize| FACE.iter().any(|&area| head.area(area)[*vertex] > 0.5);
        let at = |report: &SurfaceReport, vertex: usize| {
            glam::Vec3::from(report.registered[vertex]).as_dvec3()
        };
        let mut errors: Vec<f64> = (0..plain.positions().len())
            .filter(is_face)
            .map(|vertex| at(&truth, vertex).distance(at(&report, vertex)) / unit)
            .collect();
        errors.sort_unstable_by(f64::total_cmp);
        let [median, p95] = [errors.len() / 2, errors.len() * 95 / 100].map(|at| errors[at]);
        let faces = plain.faces().len() as u32;
        let linked = |pair: &Pair, wanted: &dyn Fn(u32) -> bool| {
            let mut linked: Vec<u32> = pair.pieces().map(|piece| piece.target).collect();
            linked.dedup();
            linked.into_iter().filter(|&face| wanted(face)).count()
        };
        let before = linked(&truth_pair, &|_| true);
        let [skin, worn] =
            [linked(&pair, &|face| face < faces), linked(&pair, &|face| face >= faces)];
        let text = format!(
            "{name}, {outfit:?}: {median:.3} and {p95:.3} distances between the eyes; {skin} of \
             {before} triangles of the skin and {worn} over it linked, {} left out",
            report.worn
        );
        // A hundredth is 0.6 mm.
        assert!(median < 0.01 && p95 < 0.05, "{text}");
        assert!(skin as f64 > 0.97 * before as f64, "{text}");
        // Where the skull is open below the hair, strands lie over nothing.
        assert!(50 * worn < before && report.worn > 0, "{text}");
    }
}

#[test]
fn dressed_heads_are_registered_as_plain_ones() {
    let [source, target] = coarse();
    check_pairs("skin", &source, &target, &OUTFITS);
    if let Some(folder) = real::folder() {
        let mesh = |name: &str| uvgraft_io::obj::read(folder.join(name)).expect("a sound mesh");
        let flame = mesh("flame_head_template.obj");
        let body = skin_of(&mesh("smplx_addon.obj"));
        let frame = *Anatomy::find(&body).expect("a face").frame();
        check_pairs("SMPL-X", &flame, &between(&body, &frame, -7.0..9.0), &OUTFITS[1..2]);
    }
}

/// Landmarks that lay the target on the source after it was turned around an axis of its head.
fn turned(source: &Mesh, target: &Mesh, axis: usize, degrees: f64) -> FindOptions {
    let [there, here] = [source, target].map(|mesh| *Anatomy::find(mesh).expect("a face").frame());
    let local = |vertex: usize| DVec3::from(here.local(target.positions()[vertex].map(f64::from)));
    // About the axis of the neck, or through the base of the nose.
    let center = if axis == 1 { DVec3::new(0.0, 0.0, -1.1) } else { DVec3::new(0.0, -0.6, 0.0) };
    let turn = DMat3::from_axis_angle(DVec3::AXES[axis], degrees.to_radians());
    let mut options = FindOptions::default();
    options.by = By::Surface;
    let used: Vec<usize> = target.faces().iter().step_by(97).map(|face| face[0] as usize).collect();
    options.surface.places = used
        .into_iter()
        .map(|vertex| {
            let place = there.world((turn * (local(vertex) - center) + center).to_array());
            [place.map(|value| value as f32), target.positions()[vertex]]
        })
        .collect();
    options
}

#[test]
fn what_was_laid_wrongly_on_a_face_is_refused() {
    let [source, target] = coarse();
    let mut reported = 0;
    for (axis, degrees) in [(0, 60.0), (0, 180.0), (2, 90.0)] {
        let error = find(source.clone(), target.clone(), &turned(&source, &target, axis, degrees));
        let error = error.expect_err("a head that is turned");
        let MethodFailure::Surface(error) = &error.0[0] else { panic!("{error}") };
        // A face that looks the other way may have nothing on it at all.
        match error {
            SurfaceError::Turned { most, .. } => reported += usize::from(*most == 20.0),
            SurfaceError::Nothing => {}
            error => panic!("axis {axis}, {degrees}°: {error}"),
        }
    }
    assert!(reported > 0);
    // What is turned by half fits, so that it is linked, and told.
    for (axis, degrees) in [(1, 0.0), (1, 25.0), (1, 180.0), (2, 180.0)] {
        let found = find(source.clone(), target.clone(), &turned(&source, &target, axis, degrees));
        let found = found.expect("surfaces that fit");
        let report = found.method.registered().expect("a registration");
        let reported = report.heads_turned.expect("two heads");
        assert!((reported - degrees).abs() < 15.0, "axis {axis}, {degrees}°: {reported}");
        assert_eq!(
            report.warning().is_some(),
            degrees > 90.0,
            "axis {axis}, {degrees}°: {reported}"
        );
    }
}

#[test]
fn clothes_without_a_head_are_refused() {
    let figure = Figure::new();
    let frame = *Anatomy::find(&figure.body).expect("a face").frame();
    let headless = between(&figure.body, &frame, -99.0..-3.5);
    let error = Anatomy::find(&headless).expect_err("a body without a head");
    assert!(
        matches!(error, AnatomyError::NoFace { .. } | AnatomyError::NoSymmetry { .. }),
        "{error}"
    );
}
