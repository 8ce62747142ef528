//! Measures how faces look on bodies, and draws them:
//! `cargo run --release -p uvgraft-tests --example looks -- --sheet looks.png`
//!
//! With `UVGRAFT_DATA` real meshes, faces and bodies are there too. `--faces` and `--bodies` choose by parts of
//! names, separated by commas; `--textures FOLDER` writes what was painted.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "the table is the output")]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use uvgraft::{
    BlendOptions, Channels, Encoding, Graft, Mesh, Pair, Size, Sizes, Texels, Texture, Tone,
};
use uvgraft_avatar::Figure;
use uvgraft_avatar::render::{View, render};
use uvgraft_io::image::{self, Image, WriteOptions};
use uvgraft_tests::looks::measure::{self, Bench, Case, Figures};
use uvgraft_tests::looks::{
    BodyFrame, BodyLook, FaceLook, HeadFrame, Label, Labels, Layout, frame,
};
use uvgraft_tests::real;

const FACE: Size = Size::square(512);
const BODY: Size = Size::square(1024);
const CELL: Size = Size::new(200, 220);

struct Arguments {
    sheet: Option<PathBuf>,
    textures: Option<PathBuf>,
    faces: Vec<String>,
    bodies: Vec<String>,
}

/// A face, or a body, with what it truly shows where that is known.
struct Subject {
    name: String,
    texture: Texture,
    truth: Option<Labels>,
    /// Of faces: which pair carries them.
    pair: usize,
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
        let carried = face.truth.as_ref().map(|truth| bench.carry(truth));
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
                let (result, figures) =
                    transfer(&pairs[face.pair], bench, face, carried.as_ref(), body, tone);
                println!("{:<28} {:<14} {name:<6} {figures}", face.name, body.name);
                if arguments.sheet.is_some() {
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
            let names = || value.split(',').map(str::to_owned).collect();
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

/// Pairs, landmarks, faces and bodies: real ones where there are some.
fn subjects() -> (Vec<Arc<Pair>>, BodyFrame, Vec<Subject>, Vec<Subject>) {
    let folder = real::folder();
    let (mut pairs, frame, head) = match real::flame_to_smplx() {
        Some(pair) => (vec![pair], BodyFrame::SMPLX, HeadFrame::FLAME),
        None => (vec![frame::figure_pair(&Figure::new())], BodyFrame::FIGURE, HeadFrame::FIGURE),
    };
    let (mut faces, mut bodies) = (Vec::new(), Vec::new());
    if let Some(folder) = &folder {
        pairs.push(hifi3d_pair(folder));
        for (name, file, pair) in [
            ("captured", "flame_face_texture.png", 0),
            ("mean", "flame_mean_texture.jpg", 0),
            ("hifi3d", "hifi3d_face_texture.png", 1),
        ] {
            faces.push(Subject { pair, ..subject(name, read(&folder.join(file))) });
        }
        for (name, file) in [("medium, real", "body_medium.jpg"), ("light, real", "body_light.jpg")]
        {
            let texture = read(&folder.join(file));
            let smaller =
                texture.resized(BODY, uvgraft::Filter::Lanczos3, uvgraft::Averaging::Encoded);
            bodies.push(subject(name, smaller.expect("memory for a texture")));
        }
    }
    let layout = Layout::new(pairs[0].source(), FACE);
    for look in FaceLook::all() {
        let painted = look.paint(pairs[0].source(), &head, &layout);
        let truth = Some(painted.truth);
        faces.push(Subject { truth, ..subject(look.name, painted.texture) });
    }
    let layout = Layout::new(pairs[0].target(), BODY);
    for look in BodyLook::all() {
        let painted = look.paint(pairs[0].target(), &frame, &layout);
        let truth = Some(painted.truth);
        bodies.push(Subject { truth, ..subject(look.name, painted.texture) });
    }
    (pairs, frame, faces, bodies)
}

fn subject(name: &str, texture: Texture) -> Subject {
    Subject { name: name.to_owned(), texture, truth: None, pair: 0 }
}

/// FLAME with HiFi3D's layout: the same triangles in the same order, other UVs.
fn hifi3d_pair(folder: &Path) -> Arc<Pair> {
    let mesh = |name: &str| uvgraft_io::obj::read(&folder.join(name)).expect("a sound mesh");
    let ids = uvgraft_io::vertex_map::read(&folder.join("smplx_flame_vertex_ids.npy"));
    let pair = Pair::by_vertex_map(
        mesh("flame_hifi3d_uv.obj"),
        mesh("smplx_addon.obj"),
        &ids.expect("a sound vertex map"),
    );
    Arc::new(pair.expect("a head that is part of the body"))
}

/// The transfer as users get it, and what it is like.
fn transfer(
    pair: &Arc<Pair>,
    bench: &Bench,
    face: &Subject,
    carried: Option<&Labels>,
    body: &Subject,
    tone: Tone,
) -> (Texture, Figures) {
    let sizes = Sizes { from: face.texture.size(), to: BODY };
    let plain = Graft::builder(Arc::clone(pair), sizes).build().expect("sound sizes");
    let paste = plain.apply(&face.texture, &body.texture).expect("textures of these sizes");
    let options = BlendOptions::default().feather(0.01).membrane().tone(tone);
    let graft = Graft::builder(Arc::clone(pair), sizes).blend(options).build().expect("a region");
    let toning = graft.toning(&face.texture, &body.texture, body.texture.format());
    let toning = toning.unwrap_or_else(|error| {
        eprintln!("{} on {}: {error}", face.name, body.name);
        None
    });
    let overlay =
        graft.overlay(&face.texture, body.texture.format()).expect("a texture of that size");
    let overlay = match &toning {
        Some(toning) => overlay.toned(toning).expect("found for it"),
        None => overlay,
    };
    let result = overlay.lay(0, body.texture.clone()).expect("a base of that size");
    let narrowed = toning.as_ref().and_then(|toning| toning.narrowed());
    let blend = narrowed.or(graft.blend()).expect("a blend");
    let region = blend.cut().expect("a mesh of that size");
    let figures = bench.measure(&Case {
        face: carried,
        body: body.truth.as_ref(),
        base: &body.texture,
        paste: &paste,
        result: &result,
        region: &region,
    });
    (result, figures)
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
    render(mesh, texture, &view, CELL)
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

/// Labels as colours.
fn colored(truth: &Labels) -> Texture {
    let color = |label: Label| match label {
        Label::Other => [0, 0, 0],
        Label::Skin => [230, 180, 150],
        Label::Hair => [110, 70, 30],
        Label::BrowLip => [220, 60, 90],
        Label::Eye => [255, 255, 255],
        Label::Mouth => [120, 0, 0],
        Label::Cloth => [60, 110, 220],
    };
    let values = truth.of_texels.iter().flat_map(|&label| color(label)).collect();
    Texture::new(truth.size, Channels::Rgb, Encoding::Srgb, Texels::U8(values))
        .expect("as many values as texels")
}

fn read(path: &Path) -> Texture {
    image::read(path).expect("a sound image").texture
}

fn write(texture: &Texture, path: &Path) {
    let image = Image::from(texture.clone());
    // Nothing is lost in 8-bit PNG files.
    let _ = image::write(&image, path, &WriteOptions::default()).expect("a folder to write to");
}
