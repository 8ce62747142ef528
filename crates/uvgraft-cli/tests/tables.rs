//! Meshes linked by tables that others publish, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::fmt::Write as _;

use crate::bench::Bench;
use serde_json::Value;
use uvgraft::correspond::table::UvLocator;
use uvgraft::{Mesh, Pair};
use uvgraft_io::arrays::{NamedArrays, NumericArray, save_npz};
use uvgraft_io::{obj, pair_file};

/// A bent sheet of `n * n` quads of two triangles, with its layout scaled and moved.
fn sheet(n: u32, scale: f32, shift: f32) -> Mesh {
    let count = n + 1;
    let plane: Vec<[f32; 2]> = (0..count * count)
        .map(|k| [k % count, k / count].map(|at| 0.1 + 0.8 * at as f32 / n as f32))
        .collect();
    let positions = plane.iter().map(|&[u, v]| [u, 1.0 - v, 0.05 * (3.0 * u).sin()]).collect();
    let uv = plane.iter().map(|uv| uv.map(|value| shift + scale * value)).collect();
    let faces: Vec<[u32; 3]> = (0..n * n)
        .map(|k| k / n * count + k % n)
        .flat_map(|k| [[k, k + 1, k + count + 1], [k, k + count + 1, k + count]])
        .collect();
    Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
}

/// The source's layout is the plane; the target's is half as large, from 0.05.
fn source() -> Mesh {
    sheet(4, 1.0, 0.0)
}

fn target() -> Mesh {
    sheet(9, 0.5, 0.05)
}

/// Where a place of the target's layout is in the source's.
fn in_source(uv: [f64; 2]) -> [f64; 2] {
    uv.map(|value| (value - 0.05) / 0.5)
}

/// The face of the source and the weights for each vertex of the target.
fn points() -> Vec<(u32, [f64; 3])> {
    let (source, target) = (source(), target());
    let locator = UvLocator::new(&source);
    let at = |uv: &[f32; 2]| {
        let found = locator.locate(in_source(uv.map(f64::from)), 1e-3).unwrap();
        (found.face, found.weights)
    };
    target.uv().iter().map(at).collect()
}

/// The same as elements of a matrix.
fn elements() -> Vec<(i64, i64, f64)> {
    let faces = source().faces().to_vec();
    let row = |(row, (face, weights)): (usize, (u32, [f64; 3]))| {
        let columns = faces[face as usize];
        (0..3).map(move |k| (row as i64, i64::from(columns[k]), weights[k]))
    };
    points().into_iter().enumerate().flat_map(row).filter(|element| element.2 != 0.0).collect()
}

fn bench() -> Bench {
    let bench = Bench::new();
    obj::save(&source(), bench.path("coarse.obj")).unwrap();
    obj::save(&target(), bench.path("fine.obj")).unwrap();
    bench
}

fn ints(shape: &[usize], values: &[i64]) -> NumericArray {
    NumericArray::new_i64(shape.to_vec(), values.to_vec()).unwrap()
}

fn floats(shape: &[usize], values: &[f64]) -> NumericArray {
    NumericArray::new_f64(shape.to_vec(), values.to_vec()).unwrap()
}

fn save(bench: &Bench, name: &str, arrays: &[(&str, NumericArray)]) {
    let mut named = NamedArrays::new();
    for (name, array) in arrays {
        named.insert(*name, array.clone());
    }
    save_npz(&named, bench.path(name)).unwrap();
}

fn save_points(bench: &Bench, name: &str, change: impl Fn(&mut [(i64, [f64; 3])])) {
    let mut points: Vec<(i64, [f64; 3])> =
        points().into_iter().map(|(face, weights)| (i64::from(face), weights)).collect();
    change(&mut points);
    let faces: Vec<i64> = points.iter().map(|point| point.0).collect();
    let weights: Vec<f64> = points.iter().flat_map(|point| point.1).collect();
    let arrays = [("face_ids", ints(&[100], &faces)), ("bary_coords", floats(&[100, 3], &weights))];
    save(bench, name, &arrays);
}

/// Instructions of a pickle, protocol 2, for an array of one axis.
fn pickled(dtype: &str, bytes: &[u8]) -> Vec<u8> {
    let length = (bytes.len() as u32).to_le_bytes();
    let count = (bytes.len() as u32 / 8).to_le_bytes();
    let mut out = b"cnumpy.core.numeric\n_frombuffer\n(T".to_vec();
    out.extend([&length[..], bytes, b"cnumpy\ndtype\nU\x02", dtype.as_bytes()].concat());
    out.extend([&b"\x85RJ"[..], &count, b"\x85U\x01CtR"].concat());
    out
}

fn pickled_ints(values: &[i64]) -> Vec<u8> {
    pickled("i8", &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
}

fn pickled_floats(values: &[f64]) -> Vec<u8> {
    pickled("f8", &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
}

/// A pickled SciPy matrix of a shape and a class, under the key `matrix` of a dict.
fn pickled_matrix(class: &str, [rows, columns]: [i32; 2], arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut out = format!("c{class}\n)").into_bytes();
    out.extend(b"\x81}(U\x06_shape");
    out.extend([&b"J"[..], &rows.to_le_bytes(), b"J", &columns.to_le_bytes(), b"\x86"].concat());
    for (name, value) in arrays {
        out.extend([&b"U"[..], &[name.len() as u8], name.as_bytes(), value].concat());
    }
    [&b"\x80\x02}U\x06matrix"[..], &out, b"ubs."].concat()
}

/// Ascending offsets of `count` groups in sorted keys.
fn offsets(keys: &[i64], count: i64) -> Vec<i64> {
    (0..=count).map(|at| keys.iter().filter(|&&key| key < at).count() as i64).collect()
}

/// The matrix as SciPy pickles it in each format, with as many columns for normals.
fn pickles() -> [(&'static str, Vec<u8>); 3] {
    let rows = elements();
    let mut columns = rows.clone();
    columns.sort_by_key(|element| (element.1, element.0));
    let shape = [100, 50];
    let part = |elements: &[(i64, i64, f64)], k: usize| {
        pickled_ints(&elements.iter().map(|at| [at.0, at.1][k]).collect::<Vec<_>>())
    };
    let data = |elements: &[(i64, i64, f64)]| {
        pickled_floats(&elements.iter().map(|element| element.2).collect::<Vec<_>>())
    };
    let by_row =
        pickled_ints(&offsets(&rows.iter().map(|element| element.0).collect::<Vec<_>>(), 100));
    let by_column =
        pickled_ints(&offsets(&columns.iter().map(|element| element.1).collect::<Vec<_>>(), 50));
    let csr = [("indptr", by_row), ("indices", part(&rows, 1)), ("data", data(&rows))];
    let csc = [("indptr", by_column), ("indices", part(&columns, 0)), ("data", data(&columns))];
    let coo = [("row", part(&rows, 0)), ("col", part(&rows, 1)), ("data", data(&rows))];
    [
        ("csr.pkl", pickled_matrix("scipy.sparse.csr\ncsr_matrix", shape, &csr)),
        ("csc.pkl", pickled_matrix("scipy.sparse.csc\ncsc_matrix", shape, &csc)),
        ("coo.pkl", pickled_matrix("scipy.sparse._coo\ncoo_matrix", shape, &coo)),
    ]
}

/// The grid of the reference for the target's layout, 64 texels wide and high.
fn grid() -> [(&'static str, NumericArray); 2] {
    let mut uv = Vec::new();
    let mut faces = Vec::new();
    for k in 0..64 * 64 {
        let place = in_source([k % 64, k / 64].map(|at| (f64::from(at) + 0.5) / 64.0));
        let is_inside = place.iter().all(|value| (0.1..0.9).contains(value));
        uv.extend(place.map(|value| if is_inside { 2.0 * value - 1.0 } else { 0.0 }));
        faces.push(if is_inside { 3 } else { -1 });
    }
    [("uv_grid", floats(&[1, 64, 64, 2], &uv)), ("pix_to_face", ints(&[64, 64], &faces))]
}

fn pair(bench: &Bench) -> Pair {
    let file = pair_file::read(bench.path("new.uvpair")).unwrap();
    std::sync::Arc::unwrap_or_clone(file.pair)
}

/// Every piece of the pair puts places of the target's layout where they are in the source's, and
/// together they cover this share of it.
fn covered(pair: &Pair, wanted: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let mut total = 0.0;
    for piece in pair.pieces() {
        let [target, source] = piece.uv(pair.target(), pair.source());
        for (at, found) in target.iter().zip(&source) {
            let wanted = wanted(*at);
            assert!((0..2).all(|k| (wanted[k] - found[k]).abs() < 4e-3), "{wanted:?} {found:?}");
        }
        let [a, b, c] = target;
        total += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }
    let faces = pair.target().faces().len();
    let area = |face: usize| {
        let [a, b, c] = pair.target().uv_triangle(face).map(|uv| uv.map(f64::from));
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    (total / (0..faces).map(area).sum::<f64>()).abs()
}

#[test]
fn every_format_links_the_meshes_exactly() {
    let bench = bench();
    let mut names = Vec::new();
    for (name, bytes) in pickles() {
        bench.write(name, bytes);
        names.push(name);
    }
    save_points(&bench, "points.npz", |_| {});
    let mut rows = String::from("{'descr': '<f8', 'fortran_order': False, 'shape': (100, 4), }");
    while (rows.len() + 11) % 64 != 0 {
        rows.push(' ');
    }
    let mut npy = b"\x93NUMPY\x01\0".to_vec();
    npy.extend((rows.len() as u16 + 1).to_le_bytes());
    npy.extend(rows.bytes().chain(*b"\n"));
    for (face, weights) in points() {
        let row = [f64::from(face), weights[0], weights[1], weights[2]];
        npy.extend(row.iter().flat_map(|value| value.to_le_bytes()));
    }
    bench.write("points.npy", npy);
    save(&bench, "grid.npz", &grid());
    names.extend(["points.npz", "points.npy", "grid.npz"]);
    for name in names {
        for by in ["", " --by table"] {
            let report = bench.succeed(&format!(
                "pair coarse.obj fine.obj --table {name}{by} -o new.uvpair --json"
            ));
            let report: Value = serde_json::from_str(&report).unwrap();
            let table = &report["linked_by"]["table"];
            assert_eq!((&table["rows"], &table["vertices"]), (&"target".into(), &100.into()));
            assert_eq!(table["is_vertex_map"], false, "{name}");
            let share = covered(&pair(&bench), in_source);
            assert!((share - 1.0).abs() < 5e-3, "{name}: {share}");
        }
        // The table's mesh may be the source as well.
        bench.succeed(&format!("pair fine.obj coarse.obj --table {name} -o new.uvpair"));
        let share = covered(&pair(&bench), |uv| uv.map(|value| 0.05 + 0.5 * value));
        assert!((share - 1.0).abs() < 5e-3, "{name}: {share}");
    }
}

#[test]
fn rows_without_a_point_leave_their_faces_unlinked() {
    let bench = bench();
    save_points(&bench, "holes.npz", |points| points[44].0 = -1);
    let report = bench.succeed("pair coarse.obj fine.obj --table holes.npz -o new.uvpair");
    let first = report.lines().next().unwrap();
    let wanted = "linked by the table: 99 of the target's 100 vertices at points of the source; 96.3 % \
                  of the target's area; 6 triangles not linked because corners have no row";
    assert_eq!(first, wanted);
    let pair = pair(&bench);
    assert!((covered(&pair, in_source) - 156.0 / 162.0).abs() < 5e-3);
    let faces = pair.target().faces();
    assert!(pair.pieces().all(|piece| !faces[piece.target as usize].contains(&44)));
}

/// The coarse sheet with its vertices in reverse order, and another layout.
fn reversed() -> Mesh {
    let sheet = sheet(4, 0.5, 0.05);
    let positions = sheet.positions().iter().rev().copied().collect();
    let faces: Vec<[u32; 3]> =
        sheet.faces().iter().map(|face| face.map(|vertex| 24 - vertex)).collect();
    Mesh::from_triangles(positions, sheet.uv().to_vec(), &faces, sheet.uv_faces()).unwrap()
}

#[test]
fn a_table_of_vertices_is_a_vertex_map() {
    let bench = bench();
    obj::save(&reversed(), bench.path("reversed.obj")).unwrap();
    let ids: Vec<i64> = (0..25).rev().collect();
    let corners: Vec<i64> = ids.iter().flat_map(|&id| [id; 3]).collect();
    let weights: Vec<f64> = (0..25).flat_map(|_| [1.0, 0.0, 0.0]).collect();
    let arrays = [("closest_faces", ints(&[25, 3], &corners)), ("bc", floats(&[25, 3], &weights))];
    save(&bench, "map.npz", &arrays);
    let with_table = "pair coarse.obj reversed.obj --table map.npz --note x -o new.uvpair";
    let report = bench.succeed(with_table);
    assert!(report.starts_with("linked by the table: 25 of the target's 25 vertices at vertices"));
    let by_table = bench.bytes("new.uvpair");
    let text = ids.iter().fold(String::new(), |mut text, id| {
        let _ = writeln!(text, "{id}");
        text
    });
    bench.write("map.txt", text);
    bench.succeed("pair coarse.obj reversed.obj --vertex-map map.txt --note x -o new.uvpair");
    assert_eq!(bench.bytes("new.uvpair"), by_table);
}

/// The texels of a layout with the vertices of a mesh, as TF_FLAME's `texture_data_*.npy` has them.
fn texels(mesh: &Mesh) -> Vec<(&'static str, NumericArray)> {
    const SIDE: usize = 128;
    let locator = UvLocator::new(mesh);
    let (mut ids, mut vertices, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    let coordinate = |at: usize| at as f64 + 0.5;
    for k in 0..SIDE * SIDE {
        let uv = [k % SIDE, k / SIDE].map(|at| coordinate(at) / SIDE as f64);
        if let Some(found) = locator.locate(uv, 0.0) {
            ids.push(k as i64);
            vertices.extend(mesh.faces()[found.face as usize].map(i64::from));
            weights.extend(found.weights);
        }
    }
    let (count, all) = (ids.len(), SIDE * SIDE);
    let x: Vec<f64> = (0..all).map(|k| coordinate(k % SIDE)).collect();
    let y: Vec<f64> = (0..all).map(|k| coordinate(k / SIDE)).collect();
    vec![
        ("x_coords", floats(&[all], &x)),
        ("y_coords", floats(&[all], &y)),
        ("valid_pixel_ids", ints(&[count], &ids)),
        ("valid_pixel_3d_faces", ints(&[count, 3], &vertices)),
        ("valid_pixel_b_coords", floats(&[count, 3], &weights)),
    ]
}

#[test]
fn texels_of_a_layout_link_the_meshes_that_have_it() {
    let bench = bench();
    let reversed = reversed();
    obj::save(&reversed, bench.path("reversed.obj")).unwrap();
    // The layout of the coarse sheet with the vertices of the reversed one.
    let faces: Vec<[u32; 3]> =
        source().faces().iter().map(|face| face.map(|vertex| 24 - vertex)).collect();
    let positions = reversed.positions().to_vec();
    let layout =
        Mesh::from_triangles(positions, source().uv().to_vec(), &faces, source().uv_faces());
    save(&bench, "texture_data.npz", &texels(&layout.unwrap()));
    for (meshes, wanted) in
        [("coarse.obj reversed.obj", [0.5, 0.05]), ("reversed.obj coarse.obj", [2.0, -0.1])]
    {
        let report =
            bench.succeed(&format!("pair {meshes} --table texture_data.npz -o new.uvpair"));
        assert!(report.contains("25 vertices at vertices of the"), "{report}");
        let [scale, shift] = wanted;
        let share = covered(&pair(&bench), |uv| uv.map(|value| (value - shift) / scale));
        assert!((share - 1.0).abs() < 1e-5, "{share}");
    }
    bench.refuse(
        "pair fine.obj reversed.obj --table texture_data.npz -o new.uvpair",
        &[
            "texture_data.npz: the file has a UV layout with 25 coordinates",
            "16 % of the source's layout and 36 % of the target's",
        ],
    );
}

#[test]
fn tables_of_other_meshes_name_all_counts() {
    let bench = bench();
    let [(csr, bytes), ..] = pickles();
    bench.write(csr, bytes);
    save_points(&bench, "points.npz", |_| {});
    obj::save(&sheet(5, 1.0, 0.0), bench.path("other.obj")).unwrap();
    bench.refuse(
        "pair coarse.obj other.obj --table csr.pkl -o new.uvpair",
        &[
            "csr.pkl: the table is a matrix of 100 x 50; it must have a row for each vertex of one mesh",
            "the source mesh has 25 vertices and the target mesh 36",
        ],
    );
    bench.refuse(
        "pair coarse.obj other.obj --table points.npz -o new.uvpair",
        &["points.npz: the table is a list of 100 faces and weights", "target mesh 36"],
    );
    // The right number of rows, with faces of another mesh.
    bench.refuse(
        "pair source.obj fine.obj --table points.npz -o new.uvpair --by table",
        &["points.npz", "none of the faces lies on the other mesh"],
    );
}

#[test]
fn hostile_tables_are_refused() {
    let bench = bench();
    let [(_, csr), ..] = pickles();
    bench.write("cut.pkl", &csr[..csr.len() / 2]);
    bench.write("code.pkl", b"\x80\x02cos\nsystem\nU\x04echo\x85R.");
    bench.write("empty.npz", b"");
    bench.write("text.npz", b"face 1 0.5 0.5");
    let matrix = |shape, rows: &[i64], columns: &[i64], data: &[f64]| {
        let arrays = [
            ("row", pickled_ints(rows)),
            ("col", pickled_ints(columns)),
            ("data", pickled_floats(data)),
        ];
        pickled_matrix("scipy.sparse.coo\ncoo_matrix", shape, &arrays)
    };
    bench.write("beyond.pkl", matrix([100, 25], &[0], &[25], &[1.0]));
    bench.write("negative.pkl", matrix([100, -25], &[0], &[0], &[1.0]));
    bench.write("huge.pkl", matrix([i32::MAX, i32::MAX], &[0], &[0], &[1.0]));
    bench.write("nan.pkl", matrix([100, 25], &[0], &[3], &[f64::NAN]));
    bench.write("none.pkl", matrix([100, 25], &[], &[], &[]));
    bench.write("heavy.pkl", matrix([100, 25], &[0, 1], &[3, 4], &[2.0, -1.0]));
    save_points(&bench, "face.npz", |points| points[7].0 = 32);
    save_points(&bench, "minus.npz", |points| points[7].0 = -5);
    save_points(&bench, "weights.npz", |points| points[7].1 = [0.5, 0.75, 0.0]);
    save_points(&bench, "nan.npz", |points| points[7].1 = [0.5, f64::NAN, 0.5]);
    save(
        &bench,
        "floats.npz",
        &[
            ("face_ids", floats(&[100], &[0.5; 100])),
            ("bary_coords", floats(&[100, 3], &[0.25; 300])),
        ],
    );
    let header = |shape: &str| {
        let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = (text.len() as u16).to_le_bytes();
        [&b"\x93NUMPY\x01\0"[..], &length, text.as_bytes()].concat()
    };
    bench.write("claims.npy", header("(4611686018427387904, 4)"));
    bench.write("short.npy", header("(100, 4)"));
    for (name, wanted) in [
        ("cut.pkl", "cut"),
        ("code.pkl", "the pickle imports os.system"),
        ("empty.npz", "an empty file"),
        ("text.npz", "got a file that starts with"),
        ("beyond.pkl", "a sparse matrix of 100 x 25 has a value at 0, 25"),
        ("negative.pkl", "the shape of a sparse matrix must have two dimensions"),
        ("huge.pkl", "at most 4194304 rows and columns"),
        ("nan.pkl", "the matrix must be finite, got NaN in row 0, column 3"),
        ("none.pkl", "none of the 100 vertices of the table has a point"),
        ("heavy.pkl", "none of the 100 vertices of the table has a point"),
        ("face.npz", "the face of vertex 7 must be from 0 to 31, or -1 for none; got 32"),
        ("minus.npz", "`face_ids` must be at least 0, or -1 for none, got -5 in row 7"),
        ("weights.npz", "the weights of vertex 7 must be finite, not negative and add up to 1"),
        ("nan.npz", "`bary_coords` must hold finite weights, got [0.5, NaN, 0.5] in row 7"),
        ("floats.npz", "`face_ids` must hold integers, got floats"),
        ("claims.npy", "claims.npy"),
        ("short.npy", "short.npy"),
        ("missing.npz", "No such file"),
    ] {
        let args = format!("pair coarse.obj fine.obj --table {name} -o new.uvpair");
        bench.refuse(&args, &[name, wanted]);
    }
}

#[test]
fn options_that_contradict_each_other_are_refused() {
    let bench = bench();
    save_points(&bench, "points.npz", |_| {});
    let pair = "pair coarse.obj fine.obj -o new.uvpair";
    bench.refuse(&format!("{pair} --by table"), &["--by table needs --table"]);
    bench.refuse(
        &format!("{pair} --by faces --table points.npz"),
        &["--table is used only with --by table or auto"],
    );
    bench.refuse(
        &format!("{pair} --table points.npz --vertex-map ids.npy"),
        &["--table <FILE>", "cannot be used with", "--vertex-map"],
    );
    bench.refuse(
        &format!("{pair} --table points.npz --registered out.obj"),
        &["a table registers nothing"],
    );
    bench.refuse(
        "pair coarse.obj fine.obj --table points.npz -o points.npz",
        &["points.npz", "is also an input"],
    );
}
