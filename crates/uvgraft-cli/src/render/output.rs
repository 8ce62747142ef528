//! Output files: one, or one for each frame.

use std::path::{Path, PathBuf};

use anyhow::Context;
use uvgraft::Texture;
use uvgraft_assembly::render::Rendering;
use uvgraft_assembly::{Input, RenderRequest};
use uvgraft_files::output::write_atomically;
use uvgraft_image::animation::{AnimationError, write_gif, write_webp};
use uvgraft_image::{self as image, Format, Image, WriteOptions};
use uvgraft_pipeline::Outputs;
use uvgraft_render::Background;

use crate::failure::bad_input;
use crate::{outcome, progress};

/// Memory limit for frames that are held together.
const MAX_BYTES: usize = 1 << 30;

/// Output files, checked to be writable.
pub(super) struct Output {
    paths: Vec<PathBuf>,
    kind: OutputFormat,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum OutputFormat {
    /// A file for each frame.
    Images,
    /// All frames in one file, at a frame rate.
    Gif(f32),
    WebP(f32),
}

impl Output {
    /// - `frames`: number of pictures.
    pub(super) fn new(path: &Path, request: &RenderRequest, frames: usize) -> anyhow::Result<Self> {
        let (name, size) = (path.display(), request.frame_size());
        let is_gif = is_gif(path);
        let format = Format::from_path(path);
        let transparent = request.background() == Background::Transparent;
        let moving = request.rate();
        const MAX_GIF_FPS: f32 = 50.0;
        let kind = match (moving, format) {
            (Some(fps), None) if is_gif && fps > MAX_GIF_FPS => {
                return Err(bad_input(format!(
                    "{name}: GIF supports at most {MAX_GIF_FPS} frames per second, got {fps}; \
                     write a .webp, or use a lower --fps"
                )));
            }
            (fps, None) if is_gif => OutputFormat::Gif(fps.unwrap_or(1.0)),
            (_, None) => {
                let known = Format::extension_list();
                return Err(bad_input(format!("{name}: extension must be .gif or one of {known}")));
            }
            (_, Some(Format::Jpeg)) if transparent => {
                return Err(bad_input(format!(
                    "{name}: JPEG does not support transparency; use .png or .webp, or another \
                     --background"
                )));
            }
            (Some(fps), Some(Format::WebP)) => OutputFormat::WebP(fps),
            (_, Some(_)) => OutputFormat::Images,
        };
        let bytes =
            frames.saturating_mul(size.texels()).saturating_mul(if transparent { 4 } else { 3 });
        if kind != OutputFormat::Images && bytes > MAX_BYTES {
            return Err(bad_input(format!(
                "{name}: {frames} frames of {size} do not fit into one file; use a smaller --size \
                 or a lower --fps, or write .png files"
            )));
        }
        let paths = match (moving, kind) {
            (Some(_), OutputFormat::Images) => {
                (0..frames).map(|frame| numbered(path, frame, frames)).collect()
            }
            _ => vec![path.to_path_buf()],
        };
        let mut outputs = Outputs::new(request.inputs().filter_map(Input::path));
        for path in &paths {
            outputs.check(path)?;
        }
        Ok(Self { paths, kind })
    }

    /// Draws all frames and writes them.
    pub(super) fn write(&self, rendering: &Rendering) -> anyhow::Result<()> {
        let bar = progress::bar(rendering.frames() as u64, "{bar:32} {pos}/{len} {eta:>4}");
        let pictures = rendering.pictures().inspect(|_| bar.inc(1));
        if self.kind == OutputFormat::Images {
            for (picture, path) in pictures.zip(&self.paths) {
                let options = WriteOptions::default().compress(true);
                let _ = image::write(&Image::from(picture?), path, &options)?;
                outcome::wrote(path);
            }
        } else {
            let frames = pictures.collect::<Result<Vec<Texture>, _>>()?;
            let path = &self.paths[0];
            write_atomically::<AnimationError>(path, |out| match self.kind {
                OutputFormat::Gif(fps) => write_gif(&frames, fps, out),
                OutputFormat::WebP(fps) => write_webp(&frames, fps, out),
                OutputFormat::Images => Ok(()),
            })
            .with_context(|| format!("cannot write {}", path.display()))?;
            outcome::wrote(path);
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// Whether a file is a GIF, which has no partial opacity, by its extension.
pub(super) fn is_gif(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gif"))
}

/// `me_007.png` for the eighth frame of `me.png`.
fn numbered(path: &Path, frame: usize, frames: usize) -> PathBuf {
    let digits = (frames - 1).to_string().len().max(3);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{frame:0digits$}.{extension}"))
}
