//! Transfers textures one by one, or several in parallel, with shared state.

use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use uvgraft::{Blend, FitSummary, Graft, Size, Sizes, TexelFormat, Texture, ToneCorrection};
use uvgraft_io::image::{
    BandReader, BandWriter, EncodeError, Format, TextureSpec, WriteError, Written,
};

use crate::base::{Base, bytes_of};
use crate::blending::{self, KnownTexels};
use crate::failure::{Blame, Failure, Result};
use crate::link::Link;
use crate::material::Values;
use crate::non_finite::without_non_finite;
use crate::observer::{Event, Observer};
use crate::plan::Job;
use crate::stream::{self, Ahead};
use crate::transfer::Transfer;

/// Transfers textures, with the state that they share.
pub(crate) struct TransferWorker<'a> {
    pub(crate) transfer: &'a Transfer,
    pub(crate) values: Values,
    pub(crate) link: &'a Link,
    pub(crate) base: &'a Base,
    pub(crate) blend: Option<&'a Arc<Blend>>,
    pub(crate) known: &'a KnownTexels,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) grafts: Grafts,
    /// The first texture to be transferred, and its analysis.
    pub(crate) first: (&'a Path, OnceLock<FirstTexture>),
}

/// The analysis of a texture.
pub(crate) struct FirstTexture {
    /// The blend restricted to what remains of the region.
    pub(crate) narrowed: Option<Arc<Blend>>,
    /// The mask of covered texels, if requested and anything is excluded.
    mask: Option<Texture>,
}

/// One cell for each texture size, and the first graft, whose parts the others share.
#[derive(Default)]
pub(crate) struct Grafts {
    by_size: Mutex<HashMap<Size, Arc<GraftCell>>>,
    first: OnceLock<Arc<Graft>>,
}

/// A graft once it is built, or the reason for failure.
type GraftCell = OnceLock<Result<Arc<Graft>>>;

/// The outcome of a texture.
pub(crate) struct Outcome {
    /// Summary of the fit, if the texture was fitted.
    pub(crate) result: Result<Option<FitSummary>>,
    /// Notes and warnings.
    pub(crate) log: Log,
}

/// Messages about a texture.
#[derive(Debug, Default)]
pub(crate) struct Log {
    pub(crate) notes: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

impl TransferWorker<'_> {
    /// Transfers a texture.
    ///
    /// - `alone`: whether no other texture is processed at the same time, so that decoding,
    ///   sampling and encoding should overlap.
    pub(crate) fn carry(&self, job: &Job, alone: bool) -> Outcome {
        let mut log = Log::default();
        let result = self.try_carry(job, alone, &mut log);
        Outcome { result, log }
    }

    /// Decodes the source while the graft is prepared, finds the tone, and streams the base through
    /// the overlay band by band.
    fn try_carry(&self, job: &Job, alone: bool, log: &mut Log) -> Result<Option<FitSummary>> {
        stream::check(self.observer)?;
        let source = BandReader::open(&job.source).or_input()?;
        let found = source.spec().format();
        let depth = self.values.depth(found.depth, &job.output);
        let format = self.values.reinterpret(TexelFormat { depth, ..found });
        log.warnings.extend(self.base.mismatch(source.icc(), &job.source));
        let (base, mut icc) = self.base.under(format, source.icc());
        let channels = format.channels.union(base.channels);
        // A profile is for greyscale or for RGB; readers reject images with the wrong kind.
        let owner = if self.base.is_image() { base } else { format };
        if channels.has_color() != owner.channels.has_color() && icc.take().is_some() {
            let warning = "ICC profile dropped: it is for greyscale, but the result is in colour";
            log.warnings.push(format!("{}: {warning}", job.output.display()));
        }
        if channels.has_alpha() && Format::from_path(&job.output) == Some(Format::Jpeg) {
            return Err(self.needs_alpha(&job.output));
        }

        let bands = self.base.bands(base)?;
        let (written, fit) = thread::scope(|scope| {
            let row_bytes = bytes_of(Size::new(self.base.size().width, 1), base) as usize;
            let rows = stream::rows_in_band(row_bytes);
            let (ahead, bands) = if alone {
                (Some(Ahead::start(scope, bands, rows, row_bytes)), None)
            } else {
                (None, Some(bands))
            };
            let size = source.spec().size;
            let wanted = AtomicU32::new(size.height);
            let read = || {
                let is_wanted = |row| row < wanted.load(Ordering::Relaxed);
                source.read_while(is_wanted).or_input()
            };
            let prepare = || {
                let graft = self.graft(size)?;
                wanted.store(self.source_rows_end(&graft), Ordering::Relaxed);
                Ok(graft)
            };
            let (graft, texture) = if alone {
                thread::scope(|scope| {
                    let reading = scope.spawn(read);
                    let graft = prepare();
                    let texture = reading.join();
                    (graft, texture.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                })
            } else {
                (prepare(), read())
            };
            let ((texture, failure), graft) = (texture?, graft?);
            // The decoder may have read further than needed, depending on timing; damage in rows
            // that are not needed must not matter.
            if let Some((row, error)) = failure
                && row < self.source_rows_end(&graft)
            {
                return Err(Failure::input(error));
            }
            let texture = texture.converted(found.channels, depth).with_encoding(format.encoding);
            let (texture, unknown) = without_non_finite(texture, &job.source);
            let lacks_texels = unknown.is_some();
            log.warnings.extend(unknown);
            let texture = self.known.complete(texture, self.values, &job.source)?;
            let toning = self.toning(&graft, &texture, base, &job.source, log)?;
            let (mut overlay, fit) = self.overlay(&graft, texture, base, &job.source)?;
            if let Some(toning) = &toning {
                overlay = if self.values.is_toned() {
                    overlay.with_tone(toning).or_work()?
                } else {
                    overlay.with_exclusion(toning).or_work()?
                };
                self.store_analysis(job, toning, &overlay);
            }
            if (self.known.adds_alpha() || lacks_texels) && !channels.has_alpha() {
                overlay = overlay.opaque();
            }
            let spec = TextureSpec::new(self.base.size(), overlay.format());
            let options = self.transfer.write;
            let written = match BandWriter::create(&job.output, spec, icc.as_deref(), &options) {
                Err(error) => Err(error),
                Ok(writer) => match (ahead, bands) {
                    (Some(ahead), _) => ahead.run(scope, &overlay, writer, self.observer)?,
                    (None, Some(bands)) => {
                        stream::run(bands, rows, &overlay, writer, self.observer)?
                    }
                    (None, None) => unreachable!("a base has rows"),
                },
            };
            Ok((written, fit))
        })?;
        log.warnings.extend(losses(written, &job.output)?);
        Ok(fit)
    }

    fn needs_alpha(&self, output: &Path) -> Failure {
        let hint = if self.base.is_clear_color() {
            "use an opaque base, such as --onto '#808080', or write"
        } else {
            "choose"
        };
        Failure::input(format!(
            "cannot write {}: the result has an alpha channel, which JPEG does not support; \
             {hint} PNG, WebP, TIFF or EXR",
            output.display()
        ))
    }

    /// Estimates the tone of a texture on its base, and what to exclude from the texture. If no
    /// tone can be estimated, this is a warning.
    fn toning(
        &self,
        graft: &Graft,
        texture: &Texture,
        base: TexelFormat,
        path: &Path,
        log: &mut Log,
    ) -> Result<Option<ToneCorrection>> {
        let Some(blend) = graft.blend().filter(|blend| blend.options().needs_labels()) else {
            return Ok(None);
        };
        if !self.values.is_toned() {
            // Other maps take labels from the albedo, if it has any.
            return Ok(if blend.has_labels() { graft.exclusion(texture) } else { None });
        }
        let toning = if blend.options().needs_colors() {
            let colors = self.base.colors()?;
            graft.toning(texture, &colors, base).unwrap_or_else(|why| {
                let warning = format!("{}: {why}; colours left unchanged", path.display());
                log.warnings.push(warning);
                graft.exclusion(texture)
            })
        } else {
            graft.exclusion(texture)
        };
        if let Some(toning) = &toning {
            let name = path.display();
            log.notes
                .extend(blending::exclusion_note(toning).map(|note| format!("{name}: {note}")));
            let warnings = toning.report().warnings().into_iter();
            log.warnings.extend(warnings.map(|warning| format!("{name}: {warning}")));
        }
        Ok(toning)
    }

    /// Stores the analysis of the first texture.
    fn store_analysis(&self, job: &Job, toning: &ToneCorrection, overlay: &uvgraft::Overlay) {
        let (first, found) = &self.first;
        if *first == job.source {
            let narrowed = toning.narrowed().cloned();
            let needs_mask = narrowed.is_some() && self.transfer.mask.is_some();
            let mask = needs_mask.then(|| overlay.mask());
            let _ = found.set(FirstTexture { narrowed, mask });
        }
    }

    /// The texture, sampled or fitted.
    fn overlay(
        &self,
        graft: &Graft,
        texture: Texture,
        base: TexelFormat,
        path: &Path,
    ) -> Result<(uvgraft::Overlay, Option<FitSummary>)> {
        let overlay = match &self.transfer.fit {
            None => graft.overlay(texture, base).map(|overlay| (overlay, None)),
            Some(options) => {
                let mut progress =
                    |progress| self.observer.event(Event::FitProgress { source: path, progress });
                let fitted = graft.fit(texture, base, options, &mut progress);
                fitted.map(|fitted| (fitted.overlay, Some(fitted.summary)))
            }
        };
        overlay.or_input().map_err(|failure| failure.context(path.display()))
    }

    /// One past the last row of a texture that is needed.
    fn source_rows_end(&self, graft: &Graft) -> u32 {
        if self.transfer.fit.is_some() {
            graft.sizes().from.height
        } else {
            graft.texture_rows().end
        }
    }

    /// The graft for textures of `size`, built once while other threads wait for it.
    fn graft(&self, size: Size) -> Result<Arc<Graft>> {
        let cell = {
            let mut grafts = self.grafts.by_size.lock().unwrap_or_else(PoisonError::into_inner);
            grafts.entry(size).or_default().clone()
        };
        cell.get_or_init(|| self.make_graft(size).map(Arc::new)).clone()
    }

    fn make_graft(&self, size: Size) -> Result<Graft> {
        if let Some(graft) = self.grafts.first.get() {
            return graft.with_texture_size(size).or_work();
        }
        let graft = self.build_graft(size)?;
        let _ = self.grafts.first.set(Arc::new(graft.clone()));
        Ok(graft)
    }

    fn build_graft(&self, from: Size) -> Result<Graft> {
        let Self { transfer, values, .. } = self;
        let sizes = Sizes { from, to: self.base.size() };
        let mut builder = self
            .link
            .builder(sizes)
            .direction(transfer.direction)
            .filter(transfer.filter(*values))
            .map_options(transfer.map)
            .overlap(transfer.overlap)
            .averaging(transfer.averaging)
            .content(values.content(transfer.normals));
        if let Some(blend) = self.blend {
            builder = builder.shared_blend(Arc::clone(blend));
        }
        builder.build().or_work()
    }

    /// The coverage mask without what is excluded from the first texture; the same for every
    /// texture size.
    pub(crate) fn mask(&self) -> Result<Texture> {
        if let Some(mask) = self.first.1.get().and_then(|found| found.mask.clone()) {
            return Ok(mask);
        }
        match self.grafts.first.get() {
            Some(graft) => Ok(graft.mask()),
            // No texture needed a graft, so any size does.
            None => Ok(self.build_graft(Size::square(1))?.mask()),
        }
    }
}

/// The losses of a written file as warnings, or its error, classified by fault.
pub(crate) fn losses(
    written: std::result::Result<Written, WriteError>,
    path: &Path,
) -> Result<Vec<String>> {
    let written = written.map_err(|error| match error {
        // Outputs were checked to be writable, so by now the disk is full or gone.
        WriteError::Encode { reason: EncodeError::Io(_), .. } => Failure::work(error),
        error => Failure::input(error),
    })?;
    let losses = written.losses.into_iter();
    Ok(losses.map(|loss| format!("{}: {loss}", path.display())).collect())
}
