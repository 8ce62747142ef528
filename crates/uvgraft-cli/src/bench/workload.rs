//! The workload for one direction and size: textures, files, and the stages that use them.

use std::ffi::OsString;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::Parser;
use uvgraft::{
    Direction, Filter, Graft, GraftError, MapOptions, Pair, SamplingMap, Size, Sizes, Texture,
};
use uvgraft_files::output::TemporaryFolder;
use uvgraft_image::{self as image, Format, Image, WriteOptions};
use uvgraft_io::pair_file;

use super::measure::time;
use super::painting::detailed;
use super::stage::{InputImage, Measured, Stage, StageKind, Variant};
use crate::files::OrCannotWrite;
use crate::transfer;

/// Bytes of an 8-bit RGB texel.
pub(super) const TEXEL: usize = 3;

/// Textures and files for one direction and size.
pub(super) struct Workload<'a> {
    pub(super) direction: Direction,
    /// Size of the source texture.
    pub(super) from: Size,
    /// Size of the result.
    pub(super) to: Size,
    pair_path: &'a Path,
    pair: &'a Arc<Pair>,
    pub(super) source: Texture,
    pub(super) base: Texture,
    source_png: Vec<u8>,
    base_png: Vec<u8>,
    /// Texels of the result covered by the map.
    pub(super) filled: usize,
    /// Texels of the source that are read.
    pub(super) read: usize,
    folder: TemporaryFolder,
}

impl<'a> Workload<'a> {
    pub(super) fn new(
        pair_path: &'a Path,
        pair: &'a Arc<Pair>,
        direction: Direction,
        from: Size,
        to: Size,
    ) -> anyhow::Result<Self> {
        let (source, base) = (detailed(from, 1)?, detailed(to, 2)?);
        let (source_png, base_png) = (png(&source)?, png(&base)?);
        let folder = TemporaryFolder::create().context("cannot create a temporary folder")?;
        let filled = map(pair, direction, to, MapOptions::default()).stats();
        // The texels read are the linked texels of the other layout: its map counts them.
        let read = map(pair, direction.opposite(), from, MapOptions::with_gutter(0)).stats();
        let workload = Self {
            filled: filled.linked + filled.gutter,
            read: read.linked,
            direction,
            from,
            to,
            pair_path,
            pair,
            source,
            base,
            source_png,
            base_png,
            folder,
        };
        for (part, bytes) in
            [(InputImage::Source, &workload.source_png), (InputImage::Base, &workload.base_png)]
        {
            let path = workload.file(part);
            std::fs::write(&path, bytes).or_cannot_write(&path)?;
        }
        Ok(workload)
    }

    fn file(&self, part: InputImage) -> PathBuf {
        self.folder.path().join(match part {
            InputImage::Source => "source.png",
            InputImage::Base => "base.png",
        })
    }

    /// The stages of a kind: one, or one for each filter or input image.
    pub(super) fn stages(
        &self,
        kind: StageKind,
        filters: &[Filter],
    ) -> anyhow::Result<Vec<Stage<'_>>> {
        let filters = filters.iter().copied();
        match kind {
            StageKind::ReadPair => Ok(vec![self.read_pair()]),
            StageKind::Map => Ok(vec![self.build_map()]),
            // The widest filter needs the widest padding.
            StageKind::Padding => {
                Ok(filters.last().map(|filter| self.prepare_padding(filter)).into_iter().collect())
            }
            StageKind::Decode => Ok(vec![
                self.decode(InputImage::Source, &self.source_png, self.from),
                self.decode(InputImage::Base, &self.base_png, self.to),
            ]),
            StageKind::Resample => filters.map(|filter| self.resample(filter)).collect(),
            StageKind::Apply => filters.map(|filter| self.apply(filter)).collect(),
            StageKind::Encode => Ok(vec![self.encode()?]),
            StageKind::File => filters.map(|filter| self.file_to_file(filter)).collect(),
        }
    }

    fn read_pair(&self) -> Stage<'_> {
        let work = || {
            let (pair, seconds) = time(|| pair_file::read(self.pair_path));
            pair.map(|_| seconds).map_err(Into::into)
        };
        stage(Measured::Stage(StageKind::ReadPair), None, None, None, work)
    }

    fn build_map(&self) -> Stage<'_> {
        let work = || Ok(time(|| map(self.pair, self.direction, self.to, MapOptions::default())).1);
        stage(Measured::Stage(StageKind::Map), None, self.filled, None, work)
    }

    /// Preparing a graft also builds its map, so the time of a map is subtracted.
    fn prepare_padding(&self, filter: Filter) -> Stage<'_> {
        let work = move || {
            let (_, map) = time(|| map(self.pair, self.direction, self.to, MapOptions::default()));
            let (graft, both) = time(|| self.graft(filter));
            graft.map(|_| (both - map).max(0.0)).map_err(Into::into)
        };
        stage(Measured::Stage(StageKind::Padding), None, self.from.texels(), None, work)
    }

    fn decode(&self, part: InputImage, png: &'a [u8], size: Size) -> Stage<'a> {
        let work = move || {
            let (image, seconds) = time(|| image::decode(png));
            image.map(|_| seconds).map_err(Into::into)
        };
        let moved = png.len() + size.texels() * TEXEL;
        let variant = Some(Variant::Image(part));
        stage(Measured::Stage(StageKind::Decode), variant, size.texels(), moved, work)
    }

    fn resample(&self, filter: Filter) -> anyhow::Result<Stage<'_>> {
        let graft = self.graft(filter)?;
        let mut base = Some(self.base.clone());
        let work = move || {
            // The copy of the source is made and touched before the timing, and freed afterwards;
            // the result becomes the base of the next run.
            let (source, below) = (self.source.clone(), base.take().context("a base")?);
            let (blended, seconds) = time(|| {
                let overlay = graft.overlay(source, below.format())?;
                let result = overlay.lay(0, below)?;
                Ok::<_, GraftError>((overlay, result))
            });
            base = Some(blended?.1);
            Ok(seconds)
        };
        let moved = (self.read + self.filled) * TEXEL;
        let variant = Some(Variant::Filter(filter));
        Ok(stage(Measured::Stage(StageKind::Resample), variant, self.filled, moved, work))
    }

    /// What a user of the library calls, who keeps the source.
    fn apply(&self, filter: Filter) -> anyhow::Result<Stage<'_>> {
        let graft = self.graft(filter)?;
        let mut base = Some(self.base.clone());
        let work = move || {
            let below = base.take().context("a base")?;
            let (blended, seconds) = time(|| graft.apply(&self.source, below));
            base = Some(blended?);
            Ok(seconds)
        };
        let moved = (2 * self.from.texels() + self.read + self.filled) * TEXEL;
        let variant = Some(Variant::Filter(filter));
        Ok(stage(Measured::Stage(StageKind::Apply), variant, self.filled, moved, work))
    }

    fn encode(&self) -> anyhow::Result<Stage<'_>> {
        let graft = self.graft(Filter::default())?;
        let result = Image::from(graft.apply(self.source.clone(), self.base.clone())?);
        let mut bytes = encoded(&result, Vec::new())?;
        let moved = bytes.len() + self.to.texels() * TEXEL;
        let work = move || {
            let buffer = std::mem::take(&mut bytes);
            let (out, seconds) = time(|| encoded(&result, buffer));
            bytes = out?;
            Ok(seconds)
        };
        Ok(stage(Measured::Stage(StageKind::Encode), None, self.to.texels(), moved, work))
    }

    /// Runs the command itself, to measure exactly what users get but for what it would tell of these textures.
    fn file_to_file(&self, filter: Filter) -> anyhow::Result<Stage<'_>> {
        #[derive(Parser)]
        #[command(no_binary_name = true)]
        struct Command {
            #[command(flatten)]
            args: transfer::Args,
        }
        let output = self.folder.path().join("result.png");
        let mut words: Vec<OsString> =
            vec![self.pair_path.into(), self.file(InputImage::Source).into()];
        words.extend(["--onto".into(), self.file(InputImage::Base).into()]);
        words.extend(["--filter".into(), filter.to_string().into()]);
        words.extend(["--output".into(), output.clone().into()]);
        if self.direction == Direction::Reverse {
            words.push("--reverse".into());
        }
        let command = Command::try_parse_from(words)?;
        let run = move || {
            let (done, seconds) = time(|| transfer::run_silently(&command.args));
            done?;
            anyhow::Ok(seconds)
        };
        run()?;
        let result = std::fs::metadata(&output)?.len() as usize;
        let moved = self.source_png.len() + self.base_png.len() + result;
        let variant = Some(Variant::Filter(filter));
        Ok(stage(Measured::Stage(StageKind::File), variant, self.to.texels(), moved, run))
    }

    pub(super) fn graft(&self, filter: Filter) -> Result<Graft, GraftError> {
        Graft::builder(Arc::clone(self.pair), Sizes { from: self.from, to: self.to })
            .direction(self.direction)
            .filter(filter)
            .build()
    }
}

fn map(pair: &Pair, direction: Direction, size: Size, options: MapOptions) -> SamplingMap {
    SamplingMap::new(pair, direction, size, &options)
}

fn png(texture: &Texture) -> anyhow::Result<Vec<u8>> {
    encoded(&Image::from(texture.clone()), Vec::new())
}

/// Encodes into a buffer that is reused.
fn encoded(image: &Image, mut buffer: Vec<u8>) -> anyhow::Result<Vec<u8>> {
    buffer.clear();
    let mut out = Cursor::new(buffer);
    // PNG can store an 8-bit RGB texture without loss.
    let _ = image::encode(image, Format::PNG, &WriteOptions::default(), &mut out)?;
    Ok(out.into_inner())
}

pub(super) fn stage<'a>(
    measured: Measured,
    variant: Option<Variant>,
    texels: impl Into<Option<usize>>,
    moved_bytes: impl Into<Option<usize>>,
    work: impl FnMut() -> anyhow::Result<f64> + 'a,
) -> Stage<'a> {
    let (texels, moved_bytes) = (texels.into(), moved_bytes.into());
    Stage { measured, variant, texels, moved_bytes, work: Box::new(work) }
}
