//! Makes what the documents' pictures of pairs are drawn from; `scripts/pair-pictures.sh` calls it:
//! `cargo run --release -p uvgraft-tests --example pair_pictures -- meshes FOLDER`
//! `cargo run --release -p uvgraft-tests --example pair_pictures -- half IN.png OUT.jpg`
//!
//! The first writes meshes of the figure's head that correspond in one way each, the second halves
//! a picture's size.

use std::collections::HashMap;
use std::path::Path;
use std::process::ExitCode;

use uvgraft::{Averaging, Filter, Mesh, Size};
use uvgraft_figure::Figure;
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_io::obj;
use uvgraft_tests::remeshed::Remeshed;
use uvgraft_tests::synthetic::posed;

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[expect(clippy::print_stderr, reason = "the only output there is")]
fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments[..] {
        ["meshes", folder] => meshes(Path::new(folder)),
        ["half", from, to] => half(Path::new(from), Path::new(to)),
        _ => {
            eprintln!("usage: pair_pictures meshes FOLDER | half IN.png OUT.jpg");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn meshes(folder: &Path) -> Outcome {
    let figure = Figure::new();
    let head = &figure.head;
    // Broader below, flatter, with other triangles.
    let other = posed(head, false, |[x, y, z]| {
        [x * (1.06 - 0.3 * (y - 1.6)), 1.04 * y, 0.96 * z].map(|coordinate| 10.0 * coordinate)
    });
    let other = Remeshed::new(head).turned().decimated(head, 0.5, 1).mesh(&other);
    for (name, mesh) in [
        ("head.obj", head),
        ("body.obj", &figure.body),
        ("head_unrolled.obj", &unrolled(head)),
        ("other_head.obj", &unrolled(&other)),
        ("head_in_tiles.obj", &eyes_in_another_tile(head)),
    ] {
        obj::save(mesh, folder.join(name))?;
    }
    Ok(())
}

/// The mesh in the layout of a cylinder around it, with its seam at the back. Hair and ears, the largest
/// of its connected parts after the skin, lie over it, so they get strips of their own.
fn unrolled(mesh: &Mesh) -> Mesh {
    const TURN: f64 = std::f64::consts::TAU;
    let range = |axis: usize| {
        let values = mesh.positions().iter().map(|position| f64::from(position[axis]));
        let [low, high] =
            [values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max)];
        (0.5 * (low + high), high - low)
    };
    let ranges = [0, 1, 2].map(range);
    let ranks = part_ranks(mesh);
    let place = |vertex: u32| {
        let position = mesh.positions()[vertex as usize];
        let [x, y, z] = [0, 1, 2].map(|k| (f64::from(position[k]) - ranges[k].0) / ranges[k].1);
        let down = 0.5 - y;
        let v = match ranks[vertex as usize] {
            1 => 0.02 + 0.28 * down,
            2 | 3 => 0.12 + 0.22 * down,
            _ => 0.29 + 0.7 * down,
        };
        (x.atan2(z), v)
    };
    let (mut uv, mut known) = (Vec::new(), HashMap::new());
    let mut corner = |vertex: u32, (turned, v): (f64, f64)| {
        *known.entry((vertex, turned.to_bits())).or_insert_with(|| {
            uv.push([(0.5 + 0.86 * turned / TURN) as f32, v as f32]);
            uv.len() as u32 - 1
        })
    };
    let uv_faces: Vec<[u32; 3]> = mesh
        .faces()
        .iter()
        .map(|&vertices| {
            let places = vertices.map(place);
            let turns = places.map(|(turned, _)| turned);
            let spread = turns.into_iter().fold(f64::MIN, f64::max)
                - turns.into_iter().fold(f64::MAX, f64::min);
            let is_across = spread > 0.5 * TURN;
            [0, 1, 2].map(|k| {
                let (turned, v) = places[k];
                let turned = if is_across && turned < 0.0 { turned + TURN } else { turned };
                corner(vertices[k], (turned, v))
            })
        })
        .collect();
    Mesh::from_triangles(mesh.positions().to_vec(), uv, mesh.faces(), &uv_faces)
        .expect("the faces of a sound mesh")
}

/// For each vertex, how many connected parts have more vertices than its own.
fn part_ranks(mesh: &Mesh) -> Vec<usize> {
    let mut part: Vec<usize> = (0..mesh.positions().len()).collect();
    // Smaller numbers spread until nothing changes.
    loop {
        let mut is_settled = true;
        for vertices in mesh.faces() {
            let vertices = vertices.map(|vertex| vertex as usize);
            let least =
                vertices.into_iter().map(|vertex| part[vertex]).fold(usize::MAX, usize::min);
            for vertex in vertices {
                is_settled &= part[vertex] == least;
                part[vertex] = least;
            }
        }
        if is_settled {
            break;
        }
    }
    let mut counts: HashMap<usize, usize> = HashMap::new();
    part.iter().for_each(|&part| *counts.entry(part).or_default() += 1);
    let mut by_size: Vec<(usize, usize)> = counts.into_iter().map(|(part, n)| (n, part)).collect();
    by_size.sort_unstable_by(|one, other| other.cmp(one));
    let rank = |part: usize| by_size.iter().position(|&(_, other)| other == part).unwrap_or(0);
    part.into_iter().map(rank).collect()
}

/// The mesh with the islands of its eyes in tile 1003.
fn eyes_in_another_tile(mesh: &Mesh) -> Mesh {
    let is_eye = |point: &[f32; 2]| point[1] > 0.642 && (0.37..0.55).contains(&point[0]);
    let move_eye = |&[u, v]: &[f32; 2]| {
        if is_eye(&[u, v]) { [2.0 + (u - 0.37) * 2.7, (v - 0.642) * 2.7] } else { [u, v] }
    };
    let uv = mesh.uv().iter().map(move_eye).collect();
    Mesh::from_triangles(mesh.positions().to_vec(), uv, mesh.faces(), mesh.uv_faces())
        .expect("the faces of a sound mesh")
}

fn half(from: &Path, to: &Path) -> Outcome {
    const QUALITY: u8 = 88;
    let texture = image::read(from)?.texture;
    let size = Size::new(texture.size().width / 2, texture.size().height / 2);
    let texture = texture.resized(size, Filter::CatmullRom, Averaging::Light)?;
    // JPEG is lossy anyway.
    let _ =
        image::write(&Image::from(texture), to, &WriteOptions::default().jpeg_quality(QUALITY))?;
    Ok(())
}
