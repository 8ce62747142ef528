//! Landmarks: the same places of two surfaces, as lists of vertices or as painted dots.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::Context;
use uvgraft::Mesh;
use uvgraft::correspond::surface::SurfaceOptions;
use uvgraft::dots;
use uvgraft_image::{self as image, Format};
use uvgraft_io::vertex_map;

use crate::failure::{OrBadInput, bad_input};

/// Reads the landmarks in two files, source first: two lists of vertices or two images.
pub(super) fn read(
    paths: [&Path; 2],
    meshes: [&Mesh; 2],
    options: &mut SurfaceOptions,
) -> anyhow::Result<()> {
    match paths.map(is_image) {
        [true, true] => options.places = painted(paths, meshes)?,
        [false, false] => options.landmarks = listed(paths)?,
        [source_is_image, _] => {
            let (image, list) = if source_is_image { (0, 1) } else { (1, 0) };
            return Err(bad_input(format!(
                "landmarks must be two images or two lists of vertices, but {} is an image and {} is \
                 not",
                paths[image].display(),
                paths[list].display()
            )));
        }
    }
    Ok(())
}

/// Whether a file is an image by its content. One that cannot be read is refused where it is read.
fn is_image(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(512).read_to_end(&mut start));
    read.is_ok() && Format::detect(&start).is_some()
}

fn painted(paths: [&Path; 2], meshes: [&Mesh; 2]) -> anyhow::Result<Vec<[[f32; 3]; 2]>> {
    let image = |path: &Path| -> anyhow::Result<_> {
        let texture = image::read(path).or_bad_input()?.texture;
        let found = dots::find(&texture).with_context(|| path.display().to_string());
        Ok((found.or_bad_input()?, texture.size()))
    };
    let [(source, source_size), (target, target_size)] = [image(paths[0])?, image(paths[1])?];
    let both = || format!("{} and {}", paths[0].display(), paths[1].display());
    let pairs = dots::matched(&source, &target).with_context(both).or_bad_input()?;
    let places = |side: usize, size| {
        let dots = pairs.iter().map(|pair| pair[side]);
        let named = || paths[side].display().to_string();
        dots::places(dots, size, meshes[side]).with_context(named).or_bad_input()
    };
    let (source, target) = (places(0, source_size)?, places(1, target_size)?);
    Ok(source.into_iter().zip(target).map(|(source, target)| [source, target]).collect())
}

fn listed([source, target]: [&Path; 2]) -> anyhow::Result<Vec<[u32; 2]>> {
    let (source_ids, target_ids) = (vertices(source)?, vertices(target)?);
    if source_ids.len() != target_ids.len() {
        return Err(bad_input(format!(
            "{}: must have as many landmarks as {}, {}, got {}",
            target.display(),
            source.display(),
            source_ids.len(),
            target_ids.len()
        )));
    }
    Ok(source_ids.into_iter().zip(target_ids).map(|(from, to)| [from, to]).collect())
}

fn vertices(path: &Path) -> anyhow::Result<Vec<u32>> {
    let ids = vertex_map::read(path).or_bad_input()?;
    let id = |(index, &id): (usize, &i64)| {
        u32::try_from(id).map_err(|_| {
            bad_input(format!(
                "{}: landmark {index} must be a vertex index, got {id}",
                path.display()
            ))
        })
    };
    ids.iter().enumerate().map(id).collect()
}
