//! Output files: one, or one for each frame.

use std::path::{Path, PathBuf};

use uvgraft::Texture;
use uvgraft_assembly::render::Rendering;
use uvgraft_assembly::{Input, RenderRequest};
use uvgraft_files::output::write_atomically;
use uvgraft_image::animation::Animation;
use uvgraft_image::{self as image, Format, Image, WriteOptions};
use uvgraft_pipeline::Outputs;
use uvgraft_render::Background;

use crate::failure::bad_input;
use crate::files::OrCannotWrite;
use crate::{outcome, progress};

/// Memory limit for frames that are held together.
const MAX_BYTES: usize = 1 << 30;

/// Output files, checked to be writable.
pub(super) struct Output {
    paths: Vec<PathBuf>,
    /// How all frames are written to one file, and at which rate; `None` for a file for each.
    animation: Option<(&'static Animation, f32)>,
}

impl Output {
    /// - `frames`: number of pictures.
    pub(super) fn new(path: &Path, request: &RenderRequest, frames: usize) -> anyhow::Result<Self> {
        let (name, size) = (path.display(), request.frame_size());
        let transparent = request.background() == Background::Transparent;
        let moving = request.rate();
        let animation = match (moving, Animation::from_path(path), Format::from_path(path)) {
            (Some(fps), Some(Animation { name: kind, max_fps: Some(max), .. }), _)
                if fps > *max =>
            {
                return Err(bad_input(format!(
                    "{name}: {kind} supports at most {max} frames per second, got {fps}; write a \
                     .webp, or use a lower --fps"
                )));
            }
            (fps, Some(animation), None) => Some((animation, fps.unwrap_or(1.0))),
            (_, None, None) => {
                let known = Format::extension_list();
                return Err(bad_input(format!("{name}: extension must be .gif or one of {known}")));
            }
            (_, _, Some(format)) if transparent && !format.codec().has_alpha => {
                return Err(bad_input(format!(
                    "{name}: {format} does not support transparency; use .png or .webp, or another \
                     --background"
                )));
            }
            (Some(fps), Some(animation), Some(_)) => Some((animation, fps)),
            (_, _, Some(_)) => None,
        };
        let bytes =
            frames.saturating_mul(size.texels()).saturating_mul(if transparent { 4 } else { 3 });
        if animation.is_some() && bytes > MAX_BYTES {
            return Err(bad_input(format!(
                "{name}: {frames} frames of {size} do not fit into one file; use a smaller --size \
                 or a lower --fps, or write .png files"
            )));
        }
        let paths = match (moving, animation) {
            (Some(_), None) => (0..frames).map(|frame| numbered(path, frame, frames)).collect(),
            _ => vec![path.to_path_buf()],
        };
        let mut outputs = Outputs::new(request.inputs().filter_map(Input::path));
        for path in &paths {
            outputs.check(path)?;
        }
        Ok(Self { paths, animation })
    }

    /// Draws all frames and writes them.
    pub(super) fn write(&self, rendering: &Rendering) -> anyhow::Result<()> {
        let bar = progress::bar(rendering.frames() as u64, "{bar:32} {pos}/{len} {eta:>4}");
        let pictures = rendering.pictures().inspect(|_| bar.inc(1));
        if let Some((animation, fps)) = self.animation {
            let frames = pictures.collect::<Result<Vec<Texture>, _>>()?;
            let path = &self.paths[0];
            write_atomically(path, |out| (animation.write)(&frames, fps, out))
                .or_cannot_write(path)?;
            outcome::wrote(path);
        } else {
            for (picture, path) in pictures.zip(&self.paths) {
                let options = WriteOptions::default().compress(true);
                let _ = image::write(&Image::from(picture?), path, &options)?;
                outcome::wrote(path);
            }
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// `me_007.png` for the eighth frame of `me.png`.
fn numbered(path: &Path, frame: usize, frames: usize) -> PathBuf {
    let digits = (frames - 1).to_string().len().max(3);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{frame:0digits$}.{extension}"))
}
