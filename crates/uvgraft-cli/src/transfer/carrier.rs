//! Carrying one texture after the other, or several at once, with what they share.

use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use anyhow::Context;
use uvgraft::{
    BlendMap, Encoding, Fit, FitOptions, MapOptions, NormalFrames, NormalOptions, Overlay, Pair,
    SamplingMap, Size, TexelFormat, Texture, Toning, Transfer, TransferOptions,
};
use uvgraft_io::image::{
    BandReader, BandWriter, EncodeError, Format, TextureSpec, WriteError, WriteOptions, Written,
};

use super::base::{Base, bytes_of};
use super::pipeline::{self, Ahead};
use super::plan::Job;
use super::treatment::Treatment;
use super::{Args, direction};
use crate::blending::{Blending, Known};
use crate::failure::{OrBadInput, bad_input};
use crate::fitting::{self, FitSummary};

/// Carries textures, keeping what they share.
pub(super) struct Carrier<'a> {
    args: &'a Args,
    treatment: Treatment,
    pair: &'a Pair,
    base: &'a Base,
    blending: Option<&'a Blending<'a>>,
    known: &'a Known,
    carriages: Mutex<Carriages<'a>>,
}

/// One place for each size of sources.
type Carriages<'a> = HashMap<Size, Arc<OnceLock<anyhow::Result<Arc<Carriage<'a>>>>>>;

/// How carrying a texture went.
pub(super) struct Outcome {
    /// How its fit went, if it was fitted.
    pub(super) result: anyhow::Result<Option<FitSummary>>,
    /// What the user should know.
    pub(super) warnings: Vec<String>,
}

impl<'a> Carrier<'a> {
    pub(super) fn new(
        args: &'a Args,
        treatment: Treatment,
        pair: &'a Pair,
        base: &'a Base,
        blending: Option<&'a Blending<'a>>,
        known: &'a Known,
    ) -> Self {
        Self { args, treatment, pair, base, blending, known, carriages: Mutex::default() }
    }

    /// Carries a texture.
    ///
    /// - `alone`: whether no other is carried meanwhile, so that decoding, sampling and encoding are
    ///   to overlap.
    pub(super) fn carry(&self, job: &Job, alone: bool) -> Outcome {
        let mut warnings = Vec::new();
        let result = self.try_carry(job, alone, &mut warnings);
        Outcome { result, warnings }
    }

    fn try_carry(
        &self,
        job: &Job,
        alone: bool,
        warnings: &mut Vec<String>,
    ) -> anyhow::Result<Option<FitSummary>> {
        let source = BandReader::open(&job.source).or_bad_input()?;
        let found = source.spec().format();
        let depth = self.treatment.depth(found.depth, &job.output);
        let format = self.treatment.meant(TexelFormat { depth, ..found });
        warnings.extend(self.base.mismatch(source.icc(), &job.source));
        let (base, mut icc) = self.base.under(format, source.icc());
        let channels = format.channels.union(base.channels);
        // A profile is for grey or for RGB; readers refuse images that have the other one.
        let owner = if self.base.is_image() { base } else { format };
        if channels.has_color() != owner.channels.has_color() && icc.take().is_some() {
            let warning = "the ICC profile was dropped: it is for grey and the result has colours";
            warnings.push(format!("{}: {warning}", job.output.display()));
        }
        if channels.has_alpha() && Format::from_path(&job.output) == Some(Format::Jpeg) {
            return Err(self.needs_alpha(&job.output));
        }

        let bands = self.base.bands(base)?;
        let (written, fit) = thread::scope(|scope| {
            let row_bytes = bytes_of(Size::new(self.base.size().width, 1), base) as usize;
            let rows = pipeline::rows_in_band(row_bytes);
            let (ahead, bands) = if alone {
                (Some(Ahead::start(scope, bands, rows, row_bytes)), None)
            } else {
                (None, Some(bands))
            };
            let size = source.spec().size;
            let wanted = AtomicU32::new(size.height);
            let read = || {
                let is_wanted = |row| row < wanted.load(Ordering::Relaxed);
                source.read_while(is_wanted).or_bad_input()
            };
            let prepare = || {
                let carriage = self.carriage(size)?;
                wanted.store(carriage.source_rows_end(), Ordering::Relaxed);
                anyhow::Ok(carriage)
            };
            let (carriage, texture) = if alone {
                thread::scope(|scope| {
                    let reading = scope.spawn(read);
                    let carriage = prepare();
                    let texture = reading.join();
                    (carriage, texture.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                })
            } else {
                (prepare(), read())
            };
            let ((texture, failure), carriage) = (texture?, carriage?);
            // Decoding may have gone further than is read, before that was known: damage there is
            // none of this texture's, whichever was faster.
            if let Some((row, error)) = failure
                && row < carriage.source_rows_end()
            {
                return Err(bad_input(error));
            }
            let texture = texture.converted(found.channels, depth).with_encoding(format.encoding);
            let texture = self.known.complete(texture, self.treatment.values(), &job.source)?;
            let (toning, warning) = self.toning(&carriage, &texture, base)?;
            warnings.extend(warning.map(|why| format!("{}: {why}", job.source.display())));
            let (mut overlay, fit) =
                carriage.overlay(texture, base, toning.as_ref(), &job.source)?;
            if self.known.adds_opacity() && !channels.has_alpha() {
                overlay = overlay.opaque();
            }
            let spec = TextureSpec::new(self.base.size(), overlay.format());
            let options = self.write_options();
            let written = match BandWriter::create(&job.output, spec, icc.as_deref(), &options) {
                Err(error) => Err(error),
                Ok(writer) => match (ahead, bands) {
                    (Some(ahead), _) => ahead.run(scope, &overlay, writer)?,
                    (None, Some(bands)) => pipeline::run(bands, rows, &overlay, writer)?,
                    (None, None) => unreachable!("a base has rows"),
                },
            };
            anyhow::Ok((written, fit))
        })?;
        warnings.extend(losses(written, &job.output)?);
        Ok(fit)
    }

    pub(super) fn write_options(&self) -> WriteOptions {
        WriteOptions { compress: self.args.compress, jpeg_quality: self.args.quality }
    }

    fn needs_alpha(&self, output: &Path) -> anyhow::Error {
        let hint = if self.base.is_clear_color() {
            "lay it over a colour, such as --onto '#808080', or choose"
        } else {
            "choose"
        };
        bad_input(format!(
            "cannot write {}: the result has an alpha channel, which JPEG cannot hold; \
             {hint} PNG, WebP, TIFF or EXR",
            output.display()
        ))
    }

    /// The tone that a texture and the base are to have, or why there is none.
    fn toning(
        &self,
        carriage: &Carriage<'_>,
        texture: &Texture,
        base: TexelFormat,
    ) -> anyhow::Result<(Option<Toning>, Option<String>)> {
        let wants = self.treatment.is_toned() && self.args.blending.needs_colors();
        let Some(blending) = self.blending.filter(|_| wants && carriage.at.is_some()) else {
            return Ok((None, None));
        };
        let is_light = self.args.linear_light && base.encoding == Encoding::Srgb;
        let encoding = if is_light { Encoding::Linear } else { base.encoding };
        let colors = self.base.colors()?;
        Ok(match blending.blend().toning(texture, &colors, encoding) {
            Ok(toning) => (toning, None),
            Err(why) => (None, Some(format!("{why}; colours are left as they are"))),
        })
    }

    /// The carriage for sources of `size`, made at the first of them while the others wait.
    fn carriage(&self, size: Size) -> anyhow::Result<Arc<Carriage<'a>>> {
        let place = {
            let mut carriages = self.carriages.lock().unwrap_or_else(PoisonError::into_inner);
            carriages.entry(size).or_default().clone()
        };
        let made = place.get_or_init(|| self.make_carriage(size).map(Arc::new));
        made.as_ref().map(Arc::clone).map_err(|error| anyhow::anyhow!("{error:#}"))
    }

    fn make_carriage(&self, size: Size) -> anyhow::Result<Carriage<'a>> {
        let Self { args, treatment, pair, base, .. } = *self;
        let target = base.size();
        let direction = direction(args);
        let options = TransferOptions {
            filter: treatment.filter(args),
            map: MapOptions { gutter_px: args.gutter, prefer: args.prefer.into() },
            linear_light: args.linear_light,
            overlap: args.overlap.into(),
        };
        let how = if args.fit {
            let fit = FitOptions { max_steps: args.fit_steps, ..FitOptions::default() };
            How::Fitted(Box::new(Fit::new(pair, direction, size, target, &options, fit)))
        } else {
            let transfer = Box::new(Transfer::new(pair, direction, size, target, &options));
            match treatment.normals() {
                Some(options) => {
                    let frames = Box::new(NormalFrames::new(pair, direction));
                    How::Turned(transfer, frames, options)
                }
                None => How::Sampled(transfer),
            }
        };
        let at = self.blending.map(|blending| blending.on(how.transfer().map())).transpose()?;
        Ok(Carriage { how, at })
    }

    /// Which texels are covered, and how much, the same for sources of every size.
    pub(super) fn mask(&self, target: Size) -> anyhow::Result<Texture> {
        let carriages = self.carriages.lock().unwrap_or_else(PoisonError::into_inner);
        let known = carriages.values().find_map(|carriage| carriage.get()?.as_ref().ok());
        match (known, self.blending) {
            (Some(carriage), _) => {
                let map = carriage.how.transfer().map();
                Ok(carriage.at.as_ref().map_or_else(|| map.mask(), |at| at.weights(map)))
            }
            (None, blending) => {
                let options = MapOptions { gutter_px: 0, prefer: self.args.prefer.into() };
                let map = SamplingMap::new(self.pair, direction(self.args), target, &options);
                match blending {
                    Some(blending) => Ok(blending.on(&map)?.weights(&map)),
                    None => Ok(map.mask()),
                }
            }
        }
    }
}

/// What became of a file, as warnings; its errors sorted by whose fault they are.
pub(super) fn losses(
    written: Result<Written, WriteError>,
    path: &Path,
) -> anyhow::Result<Vec<String>> {
    let written = written.map_err(|error| match error {
        // The place was found to be writable before: now the disk is full, or gone.
        WriteError::Encode { reason: EncodeError::Io(_), .. } => anyhow::anyhow!("{error}"),
        error => bad_input(error),
    })?;
    let losses = written.losses.into_iter();
    Ok(losses.map(|loss| format!("{}: {loss}", path.display())).collect())
}

/// What textures of one size are carried by.
struct Carriage<'a> {
    how: How,
    /// The blend at the texels of its map.
    at: Option<BlendMap<'a>>,
}

enum How {
    Sampled(Box<Transfer>),
    Fitted(Box<Fit>),
    /// Normals, which are turned with the layout.
    Turned(Box<Transfer>, Box<NormalFrames>, NormalOptions),
}

impl How {
    fn transfer(&self) -> &Transfer {
        match self {
            Self::Sampled(transfer) | Self::Turned(transfer, ..) => transfer,
            Self::Fitted(fit) => fit.transfer(),
        }
    }
}

impl Carriage<'_> {
    /// The row of a source after the last that counts.
    fn source_rows_end(&self) -> u32 {
        match &self.how {
            // Colours are measured wherever the region is, which the map may not read.
            _ if self.at.is_some() => self.how.transfer().source_size().height,
            How::Sampled(transfer) | How::Turned(transfer, ..) => transfer.source_rows().end,
            How::Fitted(fit) => fit.transfer().source_size().height,
        }
    }

    fn overlay(
        &self,
        source: Texture,
        base: TexelFormat,
        toning: Option<&Toning>,
        path: &Path,
    ) -> anyhow::Result<(Overlay<'_>, Option<FitSummary>)> {
        let (overlay, fit) = match &self.how {
            How::Sampled(transfer) => (transfer.overlay(source, base)?, None),
            How::Turned(transfer, frames, options) => {
                let overlay = transfer.normal_overlay(source, base, frames, *options);
                (overlay.with_context(|| path.display().to_string()).or_bad_input()?, None)
            }
            How::Fitted(fit) => {
                let (overlay, how) = fitting::overlay(fit, source, base)?;
                (overlay, Some(how))
            }
        };
        Ok(match &self.at {
            Some(at) => (overlay.blended(at, toning), fit),
            None => (overlay, fit),
        })
    }
}
