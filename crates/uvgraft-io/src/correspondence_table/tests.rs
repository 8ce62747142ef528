use std::io::Cursor;

use uvgraft::Size;
use uvgraft::correspond::table::VertexTable;

use super::*;
use crate::arrays::write_npz;
use crate::numpy::write_header;

fn floats(shape: &[usize], values: &[f64]) -> NumericArray {
    NumericArray::new_f64(shape.to_vec(), values.to_vec()).unwrap()
}

fn integers(shape: &[usize], values: &[i64]) -> NumericArray {
    NumericArray::new_i64(shape.to_vec(), values.to_vec()).unwrap()
}

fn npz(arrays: &[(&str, NumericArray)]) -> Vec<u8> {
    let mut named = NamedArrays::new();
    for (name, array) in arrays {
        named.insert(*name, array.clone());
    }
    let mut bytes = Cursor::new(Vec::new());
    write_npz(&named, &mut bytes).unwrap();
    bytes.into_inner()
}

fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_header("<f4", shape, &mut bytes).unwrap();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn error(bytes: &[u8]) -> String {
    parse(bytes).unwrap_err().to_string()
}

#[test]
fn points_by_any_of_their_names() {
    let weights = floats(&[2, 3], &[0.5, 0.25, 0.25, 0.0, 0.0, 1.0]);
    let wanted = CorrespondenceFile::Points {
        faces: vec![4, -1],
        weights: vec![[0.5, 0.25, 0.25], [0.0, 0.0, 1.0]],
    };
    for (faces_name, weights_name) in
        [("face_ids", "bary_coords"), ("lmk_face_idx", "lmk_b_coords"), ("triangle_id", "bcs")]
    {
        let faces = integers(&[2, 1], &[4, -1]);
        let bytes = npz(&[(weights_name, weights.clone()), (faces_name, faces)]);
        assert_eq!(parse(&bytes).unwrap(), wanted, "{faces_name}");
    }
    let rows = npy(&[3, 4], &[4.0, 0.5, 0.25, 0.25, -1.0, 0.0, 0.0, 1.0, f32::NAN, 0.0, 0.0, 0.0]);
    let CorrespondenceFile::Points { faces, weights } = parse(&rows).unwrap() else { panic!() };
    assert_eq!((&faces[..], weights[0]), (&[4, -1, -1][..], [0.5, 0.25, 0.25]));
    // As in SMPL-X's flip correspondences.
    let corners = integers(&[2, 3], &[7, 8, 9, 9, 8, 7]);
    let weights = floats(&[2, 3], &[0.5, 0.25, 0.25, 0.0, 0.0, 1.0]);
    let bytes = npz(&[("closest_faces", corners), ("bc", weights)]);
    let CorrespondenceFile::Corners { vertices, weights } = parse(&bytes).unwrap() else {
        panic!()
    };
    let table = VertexTable::from_corners(&vertices, &weights, 10).unwrap();
    assert_eq!(table.points()[1].unwrap().vertex(), Some(7));
}

#[test]
fn points_that_are_not_are_named() {
    let weights = || ("bc", floats(&[2, 3], &[0.5, 0.25, 0.25, 0.0, 0.0, f64::NAN]));
    let faces = |values: &[i64]| ("face_ids", integers(&[values.len()], values));
    for (arrays, wanted) in [
        (
            vec![faces(&[1, 2, 3]), weights()],
            "`bc` must have shape (3, 3) like `face_ids`, got [2, 3]",
        ),
        (
            vec![faces(&[1, 2]), weights()],
            "`bc` must hold finite weights, got [0.0, 0.0, NaN] in row 1",
        ),
        (
            vec![faces(&[1, -2]), weights()],
            "`face_ids` must be at least 0, or -1 for none, got -2 in row 1",
        ),
        (
            vec![("fid", floats(&[2], &[0.5, 1.0])), weights()],
            "`fid` must hold integers, got floats",
        ),
        (
            vec![("fid", integers(&[1, 2], &[1, 1])), weights()],
            "`fid` must have shape (n) with a face",
        ),
        (vec![faces(&[1, 2])], "must have a matrix (`mtx`, `matrix` or scipy.sparse.save_npz)"),
        (vec![("f", integers(&[1], &[1])), weights()], "the file has `f`, `bc`"),
        (vec![("matrix", integers(&[1], &[1]))], "`matrix` must be a matrix of two axes, got [1]"),
    ] {
        let found = error(&npz(&arrays));
        assert!(found.contains(wanted), "{found}\nnot {wanted}");
    }
    assert!(parse(&npz(&[faces(&[1, -1]), weights()])).is_ok());
    let rows = error(&npy(&[1, 4], &[0.5, 0.5, 0.25, 0.25]));
    assert!(rows.starts_with("the array must have a face, an integer from 0"), "{rows}");
    assert!(error(&npy(&[1, 4], &[1.0, 0.5, f32::NAN, 0.25])).contains("finite weights"));
    assert!(error(&npy(&[3], &[0.5; 3])).contains("must have shape (n, 4)"));
    assert!(error(b"text").contains("got a file that starts with `text`"));
    assert!(error(b"").contains("an empty file"));
    let program = b"\x80\x02cos\nsystem\nU\x04echo\x85R.";
    assert!(error(program).starts_with("refused: the pickle imports os.system"));
}

#[test]
fn grids_of_both_kinds() {
    let nan = f32::NAN;
    let bytes = npy(&[1, 3, 2], &[0.25, 0.75, nan, nan, 1.5, 0.5]);
    let CorrespondenceFile::Grid(grid) = parse(&bytes).unwrap() else { panic!() };
    assert_eq!((grid.size, grid.count(), grid.uv[0]), (Size::new(3, 1), 1, [0.25, 0.75]));
    // The reference's: 0 where there is no face, which is the middle of the source otherwise.
    let uv_grid = floats(&[1, 1, 3, 2], &[-1.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
    let pix_to_face = integers(&[1, 3], &[5, -1, 0]);
    let bytes = npz(&[("uv_grid", uv_grid.clone()), ("pix_to_face", pix_to_face)]);
    let CorrespondenceFile::Grid(grid) = parse(&bytes).unwrap() else { panic!() };
    assert_eq!((grid.size, grid.count()), (Size::new(3, 1), 2));
    assert_eq!((grid.uv[0], grid.uv[2]), ([0.0, 0.75], [0.5, 0.5]));

    let only = error(&npz(&[("uv_grid", uv_grid.clone())]));
    assert_eq!(only, "no array `pix_to_face`; the file has `uv_grid`");
    let other = error(&npz(&[("uv_grid", uv_grid), ("pix_to_face", integers(&[4], &[0; 4]))]));
    assert_eq!(other, "`pix_to_face` must have shape (1, 3) like `uv_grid`, got [4]");
    let flat = error(&npz(&[("uv_grid", floats(&[3, 3], &[0.0; 9]))]));
    assert_eq!(
        flat,
        "`uv_grid` must have shape (height, width, 2) or (1, height, width, 2), got [3, 3]"
    );
    assert!(error(&npy(&[0, 3, 2], &[])).contains("from 1 to 65536 texels on each side, got 3×0"));
}

/// A sheet of squares on which texels are found, without the file's UV coordinates. Every fifth vertex
/// of a row is cut, so that its sides are apart.
fn layout(side: u32, squares: u32) -> (TexelLayout, Vec<[[f32; 2]; 3]>) {
    let mut made = TexelLayout {
        size: Size::square(side),
        centres_px: Vec::new(),
        vertices: Vec::new(),
        weights: Vec::new(),
        uv: None,
    };
    let mut corners_of_faces = Vec::new();
    let step = f64::from(side) / (f64::from(squares) + 2.0);
    for y in 0..squares {
        for x in 0..squares {
            let at = |k: u32, l: u32| (y + l) * (squares + 1) + x + k;
            let shift = f64::from(x / 5) * 1.37;
            let px = |k: u32, l: u32| {
                [f64::from(x + k) * step + shift + 0.31, f64::from(y + l) * step * 1.1 + 0.17]
            };
            for corners in [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]] {
                let vertices = corners.map(|[k, l]| at(k, l));
                let corners = corners.map(|[k, l]| px(k, l));
                corners_of_faces.push(corners.map(|corner| corner.map(|value| value as f32)));
                let scan = uvgraft::raster::ScanTriangle::new(corners, made.size).unwrap();
                for (row, span) in scan.spans(&scan.rows()) {
                    for column in span {
                        let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                        let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
                            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
                        };
                        let [a, b, c] = corners;
                        let whole = area(a, b, c);
                        let weights = [area(centre, b, c), area(a, centre, c), area(a, b, centre)];
                        made.centres_px.push(centre.map(|value| value as f32));
                        made.vertices.push(vertices);
                        made.weights.push(weights.map(|weight| weight / whole));
                    }
                }
            }
        }
    }
    (made, corners_of_faces)
}

#[test]
fn corners_follow_from_texels() {
    for (side, squares, least) in [(120, 12, 288), (48, 12, 280)] {
        let (layout, mut wanted) = layout(side, squares);
        let made = layout_mesh(&layout).unwrap();
        assert!(!made.is_exact && made.mesh.faces().len() >= least, "{}", made.left_out);
        assert!(made.left_out <= 288 - least);
        let scale = side as f32;
        let place = |triangle: [[f32; 2]; 3]| triangle.map(|uv| uv.map(|value| value * scale));
        let mut worst = 0.0_f32;
        for face in 0..made.mesh.faces().len() {
            let found = place(made.mesh.uv_triangle(face));
            let off = |wanted: &[[f32; 2]; 3]| {
                let corners = wanted.as_flattened().iter().zip(found.as_flattened());
                corners.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
            };
            let nearest = wanted.iter().enumerate().min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
            let (at, off) = nearest.map(|(at, corners)| (at, off(corners))).unwrap();
            worst = worst.max(off);
            wanted.swap_remove(at);
        }
        assert!(worst < 0.01, "{side}: {worst}");
        // Vertices on the cuts have two UV coordinates.
        let cuts = made.mesh.uv().len() as i64 - 13 * 13;
        assert_eq!(cuts, 2 * 13, "{side}");
    }
}

#[test]
fn layouts_are_checked() {
    let texels = |changed: (&'static str, NumericArray)| {
        let mut arrays = vec![
            ("x_coords", floats(&[4], &[0.5, 1.5, 0.5, 1.5])),
            ("y_coords", floats(&[4], &[0.5, 0.5, 1.5, 1.5])),
            ("valid_pixel_ids", integers(&[2], &[0, 3])),
            ("valid_pixel_3d_faces", integers(&[2, 3], &[0, 1, 2, 0, 1, 2])),
            ("valid_pixel_b_coords", floats(&[2, 3], &[0.5, 0.5, 0.0, 0.25, 0.25, 0.5])),
        ];
        arrays.retain(|(name, _)| *name != changed.0);
        arrays.push(changed);
        npz(&arrays)
    };
    let sound = parse(&texels(("img_size", integers(&[], &[4])))).unwrap();
    let CorrespondenceFile::Layout(layout) = sound else { panic!() };
    assert_eq!((layout.size, layout.centres_px[1]), (Size::square(4), [1.5, 1.5]));
    // Two texels are not enough for a triangle.
    assert_eq!(layout_mesh(&layout), Err(uvgraft::MeshError::NoFaces));
    let indices = parse(&texels(("x_coords", floats(&[4], &[0.0, 1.0, 0.0, 1.0])))).unwrap();
    let CorrespondenceFile::Layout(layout) = indices else { panic!() };
    assert_eq!(layout.centres_px[1], [1.0, 1.5]);
    for (changed, wanted) in [
        (
            ("x_coords", floats(&[3], &[0.5; 3])),
            "`y_coords` must have as many values as `x_coords`, 3, got 4",
        ),
        (
            ("x_coords", floats(&[4], &[f64::NAN; 4])),
            "`x_coords` must be texel positions from 0 to 65535, got NaN",
        ),
        (
            ("valid_pixel_ids", integers(&[2], &[0, 4])),
            "`valid_pixel_ids` must be indices into `x_coords`, below 4, got 4",
        ),
        (
            ("valid_pixel_ids", integers(&[1], &[0])),
            "`valid_pixel_3d_faces` must have shape (1, 3), a row for each",
        ),
        (
            ("valid_pixel_3d_faces", integers(&[2, 3], &[0, 1, 2, 0, 1, 1 << 40])),
            "`valid_pixel_3d_faces` must be vertices",
        ),
        (
            ("valid_pixel_b_coords", floats(&[2, 3], &[0.5; 6])),
            "`valid_pixel_b_coords` must be barycentric weights",
        ),
        (("valid_pixel_b_coords", floats(&[6], &[0.5; 6])), "must have shape (n, 3), got [6]"),
        (("img_size", integers(&[], &[1])), "`img_size` must be one length of at least 2"),
    ] {
        let found = error(&texels(changed));
        assert!(found.contains(wanted), "{found}\nnot {wanted}");
    }
    assert!(
        error(&npz(&[("valid_pixel_ids", integers(&[1], &[0]))])).contains("no array `x_coords`")
    );
}
