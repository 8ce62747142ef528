//! Carrying one texture after the other, or several at once, with what they share.

use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;

use uvgraft::{Blend, FitSummary, Graft, Pair, Size, Sizes, TexelFormat, Texture, Toning};
use uvgraft_io::image::{
    BandReader, BandWriter, EncodeError, Format, TextureSpec, WriteError, Written,
};

use crate::base::{Base, bytes_of};
use crate::blending::KnownTexels;
use crate::failure::{Blame, Failure, Result};
use crate::material::Values;
use crate::non_finite::without_non_finite;
use crate::observer::{Event, Observer};
use crate::plan::Job;
use crate::stream::{self, Ahead};
use crate::transfer::Transfer;

/// Carries textures, keeping what they share.
pub(crate) struct Carrier<'a> {
    pub(crate) transfer: &'a Transfer,
    pub(crate) values: Values,
    pub(crate) pair: &'a Arc<Pair>,
    pub(crate) base: &'a Base,
    pub(crate) blend: Option<&'a Arc<Blend>>,
    pub(crate) known: &'a KnownTexels,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) grafts: Grafts,
}

/// One place for each size of textures, and the first graft that was made, which others share parts with.
#[derive(Default)]
pub(crate) struct Grafts {
    by_size: Mutex<HashMap<Size, Arc<Place>>>,
    first: OnceLock<Arc<Graft>>,
}

/// Where a graft is once it is made, or why it was not.
type Place = OnceLock<Result<Arc<Graft>>>;

/// How carrying a texture went.
pub(crate) struct Outcome {
    /// How its fit went, if it was fitted.
    pub(crate) result: Result<Option<FitSummary>>,
    /// What the user should know.
    pub(crate) warnings: Vec<String>,
}

impl Carrier<'_> {
    /// Carries a texture.
    ///
    /// - `alone`: whether no other is carried meanwhile, so that decoding, sampling and encoding are
    ///   to overlap.
    pub(crate) fn carry(&self, job: &Job, alone: bool) -> Outcome {
        let mut warnings = Vec::new();
        let result = self.try_carry(job, alone, &mut warnings);
        Outcome { result, warnings }
    }

    fn try_carry(
        &self,
        job: &Job,
        alone: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Option<FitSummary>> {
        stream::check(self.observer)?;
        let source = BandReader::open(&job.source).or_input()?;
        let found = source.spec().format();
        let depth = self.values.depth(found.depth, &job.output);
        let format = self.values.meant(TexelFormat { depth, ..found });
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
            // Decoding may have gone further than is read, before that was known: damage there is
            // none of this texture's, whichever was faster.
            if let Some((row, error)) = failure
                && row < self.source_rows_end(&graft)
            {
                return Err(Failure::input(error));
            }
            let texture = texture.converted(found.channels, depth).with_encoding(format.encoding);
            let (texture, unknown) = without_non_finite(texture, &job.source);
            let lacks_texels = unknown.is_some();
            warnings.extend(unknown);
            let texture = self.known.complete(texture, self.values, &job.source)?;
            let toning = self.toning(&graft, &texture, base, &job.source, warnings)?;
            let (mut overlay, fit) = self.overlay(&graft, texture, base, &job.source)?;
            if let Some(toning) = &toning {
                overlay = overlay.toned(toning).or_work()?;
            }
            if (self.known.adds_opacity() || lacks_texels) && !channels.has_alpha() {
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
        warnings.extend(losses(written, &job.output)?);
        Ok(fit)
    }

    fn needs_alpha(&self, output: &Path) -> Failure {
        let hint = if self.base.is_clear_color() {
            "lay it over a colour, such as --onto '#808080', or choose"
        } else {
            "choose"
        };
        Failure::input(format!(
            "cannot write {}: the result has an alpha channel, which JPEG cannot hold; \
             {hint} PNG, WebP, TIFF or EXR",
            output.display()
        ))
    }

    /// The tone that a texture and the base are to have; why there is none is a warning.
    fn toning(
        &self,
        graft: &Graft,
        texture: &Texture,
        base: TexelFormat,
        path: &Path,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Toning>> {
        let wants = graft.blend().is_some_and(|blend| blend.options().needs_colors());
        if !(wants && self.values.is_toned()) {
            return Ok(None);
        }
        let colors = self.base.colors()?;
        Ok(graft.toning(texture, &colors, base).unwrap_or_else(|why| {
            warnings.push(format!("{}: {why}; colours are left as they are", path.display()));
            None
        }))
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

    /// The row of a texture after the last that counts.
    fn source_rows_end(&self, graft: &Graft) -> u32 {
        if self.transfer.fit.is_some() {
            graft.sizes().from.height
        } else {
            graft.texture_rows().end
        }
    }

    /// The graft for textures of `size`, made at the first of them while the others wait.
    fn graft(&self, size: Size) -> Result<Arc<Graft>> {
        let place = {
            let mut grafts = self.grafts.by_size.lock().unwrap_or_else(PoisonError::into_inner);
            grafts.entry(size).or_default().clone()
        };
        place.get_or_init(|| self.make_graft(size).map(Arc::new)).clone()
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
        let mut builder = Graft::builder(Arc::clone(self.pair), sizes)
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

    /// Which texels are covered, and how much, the same for textures of every size.
    pub(crate) fn mask(&self) -> Result<Texture> {
        match self.grafts.first.get() {
            Some(graft) => Ok(graft.mask()),
            // None was needed, so any size does.
            None => Ok(self.build_graft(Size::square(1))?.mask()),
        }
    }
}

/// What became of a file, as warnings; its errors sorted by whose fault they are.
pub(crate) fn losses(
    written: std::result::Result<Written, WriteError>,
    path: &Path,
) -> Result<Vec<String>> {
    let written = written.map_err(|error| match error {
        // The place was found to be writable before: now the disk is full, or gone.
        WriteError::Encode { reason: EncodeError::Io(_), .. } => Failure::work(error),
        error => Failure::input(error),
    })?;
    let losses = written.losses.into_iter();
    Ok(losses.map(|loss| format!("{}: {loss}", path.display())).collect())
}
