//! Carrying one texture after the other, or several at once, with what they share.

use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use uvgraft::{
    Direction, Fit, FitOptions, MapOptions, Overlay, Pair, SamplingMap, Size, TexelFormat, Texture,
    Transfer, TransferError, TransferOptions,
};
use uvgraft_io::image::{
    BandReader, BandWriter, EncodeError, Format, TextureSpec, WriteError, WriteOptions, Written,
};

use super::Args;
use super::base::{Base, bytes_of, meant_format};
use super::pipeline::{self, Ahead};
use super::plan::Job;
use crate::failure::{OrBadInput, bad_input};
use crate::fitting::{self, FitSummary};

/// Carries textures, keeping what they share.
pub(super) struct Carrier<'a> {
    args: &'a Args,
    pair: &'a Pair,
    base: &'a Base,
    carriages: Mutex<HashMap<Size, Arc<OnceLock<Arc<Carriage>>>>>,
}

/// How carrying a texture went.
pub(super) struct Outcome {
    /// How its fit went, if it was fitted.
    pub(super) result: anyhow::Result<Option<FitSummary>>,
    /// What the user should know.
    pub(super) warnings: Vec<String>,
}

impl<'a> Carrier<'a> {
    pub(super) fn new(args: &'a Args, pair: &'a Pair, base: &'a Base) -> Self {
        Self { args, pair, base, carriages: Mutex::default() }
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
        let format = meant_format(source.spec().format(), self.args);
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
                let carriage = self.carriage(size);
                wanted.store(carriage.source_rows_end(), Ordering::Relaxed);
                carriage
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
            let (texture, failure) = texture?;
            // Decoding may have gone further than is read, before that was known: damage there is
            // none of this texture's, whichever was faster.
            if let Some((row, error)) = failure
                && row < carriage.source_rows_end()
            {
                return Err(bad_input(error));
            }
            let texture = texture.with_encoding(format.encoding);
            let (overlay, fit) = carriage.overlay(texture, base)?;
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

    /// The carriage for sources of `size`, made at the first of them while the others wait.
    fn carriage(&self, size: Size) -> Arc<Carriage> {
        let place = {
            let mut carriages = self.carriages.lock().unwrap_or_else(PoisonError::into_inner);
            carriages.entry(size).or_default().clone()
        };
        place.get_or_init(|| Arc::new(self.make_carriage(size))).clone()
    }

    fn make_carriage(&self, size: Size) -> Carriage {
        let Self { args, pair, base, .. } = *self;
        let target = base.size();
        let direction = self.direction();
        let options = TransferOptions {
            filter: args.filter(),
            map: MapOptions { gutter_px: args.gutter, prefer: args.prefer.into() },
            linear_light: args.linear_light,
        };
        if args.fit {
            let fit = FitOptions { max_steps: args.fit_steps, ..FitOptions::default() };
            Carriage::Fitted(Box::new(Fit::new(pair, direction, size, target, &options, fit)))
        } else {
            Carriage::Sampled(Box::new(Transfer::new(pair, direction, size, target, &options)))
        }
    }

    /// Which texels are covered, the same for sources of every size.
    pub(super) fn mask(&self, target: Size) -> Texture {
        let carriages = self.carriages.lock().unwrap_or_else(PoisonError::into_inner);
        match carriages.values().find_map(|carriage| carriage.get()) {
            Some(carriage) => carriage.transfer().map().mask(),
            None => {
                let options = MapOptions { gutter_px: 0, prefer: self.args.prefer.into() };
                SamplingMap::new(self.pair, self.direction(), target, &options).mask()
            }
        }
    }

    fn direction(&self) -> Direction {
        if self.args.reverse { Direction::Reverse } else { Direction::Forward }
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
enum Carriage {
    Sampled(Box<Transfer>),
    Fitted(Box<Fit>),
}

impl Carriage {
    fn transfer(&self) -> &Transfer {
        match self {
            Self::Sampled(transfer) => transfer,
            Self::Fitted(fit) => fit.transfer(),
        }
    }

    /// The row of a source after the last that counts.
    fn source_rows_end(&self) -> u32 {
        match self {
            Self::Sampled(transfer) => transfer.source_rows().end,
            Self::Fitted(fit) => fit.transfer().source_size().height,
        }
    }

    fn overlay(
        &self,
        source: Texture,
        base: TexelFormat,
    ) -> Result<(Overlay<'_>, Option<FitSummary>), TransferError> {
        match self {
            Self::Sampled(transfer) => Ok((transfer.overlay(source, base)?, None)),
            Self::Fitted(fit) => {
                fitting::overlay(fit, source, base).map(|(overlay, how)| (overlay, Some(how)))
            }
        }
    }
}
