//! Measures how faces look on bodies, and renders them:
//! `cargo run --release -p uvgraft-tests --example looks -- --sheet looks.png`
//!
//! With `UVGRAFT_DATA`, real meshes, faces and bodies are included. `--faces` and `--bodies` select
//! by substrings of the names, separated by semicolons; `--textures FOLDER` writes the painted
//! textures. The sheet shows each face on each body: pasted, in the body's tone, and with the body
//! in the face's tone.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the table is the output")]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use uvgraft::{Channels, Encoding, Mesh, MeshPart, Size, Texels, Texture, Tone};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_render::{Shading, View, render};
use uvgraft_tests::looks::measure::{self, Bench, Figures};
use uvgraft_tests::looks::subjects::{BODY, Outcome, subjects, transfer};
use uvgraft_tests::looks::{BodyFrame, Label, Labels};

const CELL: Size = Size::new(200, 220);

struct Arguments {
    sheet: Option<PathBuf>,
    textures: Option<PathBuf>,
    faces: Vec<String>,
    bodies: Vec<String>,
}

fn main() -> ExitCode {
    let Some(arguments) = Arguments::parse() else {
        eprintln!(
            "usage: looks [--sheet OUT.png] [--textures FOLDER] [--faces NAMES] [--bodies NAMES]"
        );
        return ExitCode::from(2);
    };
    let (pairs, frame, mut faces, mut bodies) = subjects();
    faces.retain(|face| chosen(&face.name, &arguments.faces));
    bodies.retain(|body| chosen(&body.name, &arguments.bodies));
    if let Some(folder) = &arguments.textures {
        for subject in faces.iter().chain(&bodies) {
            let name = subject.name.replace([' ', ','], "-");
            write(&subject.texture, &folder.join(format!("{name}.png")));
            if let Some(truth) = &subject.truth {
                write(&colored(truth), &folder.join(format!("{name}-truth.png")));
            }
        }
    }
    let benches: Vec<Bench> =
        pairs.iter().map(|pair| Bench::new(Arc::clone(pair), &frame, BODY)).collect();
    println!("{:<28} {:<14} {:<6} {}", "face", "body", "tone", Figures::HEAD);
    let mut cells = Vec::new();
    for face in &faces {
        let bench = &benches[face.pair];
        let transferred = face.truth.as_ref().map(|truth| bench.transfer(truth));
        if let Some(truth) = &face.truth {
            let found = uvgraft::Labels::new(pairs[face.pair].source(), &face.texture);
            match found {
                Ok(found) => {
                    let agreement = measure::agreement(&measure::labels_like(truth, &found), truth);
                    println!("{:<28} labels: {agreement:?}", face.name);
                }
                Err(error) => println!("{:<28} labels: {error}", face.name),
            }
        }
        let mut row = Vec::new();
        for body in &bodies {
            for (tone, name) in [(Tone::Base, "base"), (Tone::Source, "source")] {
                let Outcome { paste, result, figures } =
                    transfer(&pairs[face.pair], bench, face, transferred.as_ref(), body, tone);
                println!("{:<28} {:<14} {name:<6} {figures}", face.name, body.name);
                if arguments.sheet.is_some() {
                    if tone == Tone::Base {
                        row.push(view(pairs[face.pair].target(), &frame, &paste));
                    }
                    row.push(view(pairs[face.pair].target(), &frame, &result));
                }
            }
        }
        cells.push(row);
    }
    if let Some(path) = &arguments.sheet {
        write(&sheet(&cells), path);
    }
    ExitCode::SUCCESS
}

impl Arguments {
    fn parse() -> Option<Self> {
        let mut found = Self { sheet: None, textures: None, faces: vec![], bodies: vec![] };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let value = arguments.next()?;
            let names = || value.split(';').map(str::to_owned).collect();
            match argument.as_str() {
                "--sheet" => found.sheet = Some(value.into()),
                "--textures" => found.textures = Some(value.into()),
                "--faces" => found.faces = names(),
                "--bodies" => found.bodies = names(),
                _ => return None,
            }
        }
        Some(found)
    }
}

fn chosen(name: &str, wanted: &[String]) -> bool {
    wanted.is_empty() || wanted.iter().any(|part| name.contains(part.as_str()))
}

/// Head and chest from the front.
fn view(mesh: &Mesh, frame: &BodyFrame, texture: &Texture) -> Texture {
    let origin = frame.head.origin;
    let view = View {
        azimuth: 14.0,
        elevation: 2.0,
        target: [origin[0], origin[1] - 0.14, origin[2] - 0.06],
        height: 0.58,
        floor: false,
    };
    let shading = |part: &MeshPart| Shading::named(&part.material).unwrap_or_default();
    render(mesh, texture, shading, &view, CELL)
}

fn sheet(rows: &[Vec<Texture>]) -> Texture {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let size = Size::new(columns * CELL.width, rows.len() as u32 * CELL.height);
    let mut values = vec![0; size.texels() * 3];
    for (row, cells) in rows.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            for y in 0..CELL.height as usize {
                for x in 0..CELL.width as usize {
                    let to = (row * CELL.height as usize + y) * size.width as usize
                        + column * CELL.width as usize
                        + x;
                    for k in 0..3 {
                        let value = cell.get(x as u32, y as u32, k) * 255.0;
                        values[to * 3 + k] = value.round() as u8;
                    }
                }
            }
        }
    }
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).expect("some cells")
}

/// Labels as false colours.
fn colored(truth: &Labels) -> Texture {
    let color = |label: Label| match label {
        Label::Other => [0, 0, 0],
        Label::Skin => [230, 180, 150],
        Label::Hair => [110, 70, 30],
        Label::Brow => [160, 120, 0],
        Label::Lip => [220, 60, 90],
        Label::Eye => [255, 255, 255],
        Label::Mouth => [120, 0, 0],
        Label::Cloth => [60, 110, 220],
    };
    let values = truth.of_texels.iter().flat_map(|&label| color(label)).collect();
    Texture::new(truth.size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
        .expect("as many values as texels")
}

fn write(texture: &Texture, path: &Path) {
    let image = Image::from(texture.clone());
    // 8-bit PNG files lose nothing.
    let _ = image::write(&image, path, &WriteOptions::default()).expect("a folder to write to");
}
