//! Transfers one texture, with what it shares with others.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;

use uvgraft::{Blend, Channels, FitSummary, Graft, Overlay, TexelFormat, Texture};
use uvgraft::{Depth, ToneCorrection};
use uvgraft_image::{EncodeError, Format, TextureSpec, WriteError, Written};

use crate::base::Bands;
use crate::blending;
use crate::failure::{Blame, Context, Failure, Result};
use crate::non_finite::without_non_finite;
use crate::observer::{Event, Observer};
use crate::segmented::Segmented;
use crate::shared::Shared;
use crate::source::{OpenSource, Source};
use crate::spawn::spawn_with;
use crate::stream::{self, Ahead};
use crate::target::{Encoded, Target};
use crate::toning::{toned, toning};

/// A texture to transfer.
pub(crate) struct Call<'a> {
    pub(crate) source: Source<'a>,
    pub(crate) target: Target<'a>,
    /// Whether no other texture is processed at the same time, so that decoding, sampling and
    /// encoding should overlap.
    pub(crate) alone: bool,
    /// Where its analysis goes, if it is wanted.
    pub(crate) analysis: Option<&'a Analysis>,
    pub(crate) observer: &'a dyn Observer,
}

/// What is found out about one texture and used by others: the first of a batch decides on the mask
/// and the preview of all.
pub(crate) struct Analysis {
    wants_mask: bool,
    found: OnceLock<Excluded>,
}

/// What is excluded from a texture.
pub(crate) struct Excluded {
    /// The blend restricted to what remains of the region.
    pub(crate) narrowed: Option<Arc<Blend>>,
    /// The mask of covered texels, if requested and anything is excluded.
    pub(crate) mask: Option<Texture>,
}

/// The outcome of a texture.
pub(crate) struct Outcome {
    pub(crate) result: Result<Done>,
    /// Notes and warnings.
    pub(crate) log: Log,
}

/// A texture that was transferred.
#[derive(Debug)]
pub(crate) struct Done {
    /// Summary of the fit, if the texture was fitted.
    pub(crate) fit: Option<FitSummary>,
    /// See [`uvgraft::blend::ToneReport::boundary_delta_e`].
    pub(crate) boundary_delta_e: Option<f64>,
    /// Length of the encoded result in bytes.
    pub(crate) bytes: u64,
    /// The encoded result; empty if it is in a file.
    pub(crate) image: Vec<u8>,
}

impl From<Failure> for Outcome {
    fn from(failure: Failure) -> Self {
        Self { result: Err(failure), log: Log::default() }
    }
}

/// Messages about a texture.
#[derive(Debug, Default)]
pub(crate) struct Log {
    pub(crate) notes: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

/// The formats of a texture, its base and the result.
struct Formats {
    /// Channels that the source has.
    found: Channels,
    /// Depth in which the source is processed.
    depth: Depth,
    source: TexelFormat,
    base: TexelFormat,
    /// Channels of the result.
    channels: Channels,
    icc: Option<Vec<u8>>,
}

/// A texture ready to be laid over its base.
struct Ready {
    overlay: Overlay,
    fit: Option<FitSummary>,
    boundary_delta_e: Option<f64>,
}

/// The rows of the base: decoded ahead by another thread, or when they are needed.
enum Rows<'a> {
    Ahead(Ahead),
    Here(Bands<'a>),
}

impl Analysis {
    /// - `wants_mask`: whether the mask of a texture with exclusions is needed.
    pub(crate) fn new(wants_mask: bool) -> Self {
        Self { wants_mask, found: OnceLock::new() }
    }

    pub(crate) fn found(&self) -> Option<&Excluded> {
        self.found.get()
    }

    fn store(&self, toning: &ToneCorrection, overlay: &Overlay) {
        let narrowed = toning.narrowed().cloned();
        let mask = (narrowed.is_some() && self.wants_mask).then(|| overlay.mask());
        let _ = self.found.set(Excluded { narrowed, mask });
    }
}

impl Shared {
    /// Transfers a texture.
    pub(crate) fn transfer(&self, call: &Call<'_>) -> Outcome {
        let mut log = Log::default();
        let result = self.try_transfer(call, &mut log);
        Outcome { result, log }
    }

    /// Decodes the source and prepares the graft, finds the tone, and streams the base through the
    /// overlay band by band. If the texture is processed alone, the first two run in parallel, and
    /// the base is decoded ahead meanwhile.
    fn try_transfer(&self, call: &Call<'_>, log: &mut Log) -> Result<Done> {
        call.observer.check()?;
        let source = call.source.open(self.options.values.space())?;
        let size = source.spec().size;
        self.mask_sizes.check_texture(size).context(call.source.name().display())?;
        let formats = self.formats(call, &source, log)?;
        let bands = self.base.bands(formats.base)?;
        let mut base_probe = None;
        let (encoded, ready) = thread::scope(|scope| {
            let row_bytes = self.base.row_bytes(formats.base);
            let band = stream::rows_in_band(row_bytes);
            let rows = if call.alone && self.unchanged.is_none() {
                Ahead::start(scope, bands, band, row_bytes).map_or_else(Rows::Here, Rows::Ahead)
            } else {
                Rows::Here(bands)
            };
            let (graft, texture) = self.read(source, call.alone)?;
            let ready = self.ready(call, &formats, &graft, texture, log)?;
            base_probe = self.base_probe();
            let spec = TextureSpec::new(self.base.size(), ready.overlay.format());
            let options = self.options.write.keeps_light(self.base.holds_light());
            let sink = call.target.create(spec, formats.icc.as_deref(), &options);
            let encoded = match (sink, rows) {
                (Err(error), _) => Err(error),
                (Ok(sink), Rows::Ahead(ahead)) => {
                    ahead.run(scope, &ready.overlay, &mut base_probe, sink, call.observer)?
                }
                (Ok(sink), Rows::Here(bands)) => match (&self.unchanged, sink.segments()) {
                    (Some(unchanged), Some(segments)) => {
                        let Self { base, .. } = self;
                        let (format, overlay) = (formats.base, &ready.overlay);
                        let segmented = Segmented { base, format, overlay, unchanged, segments };
                        segmented.run(sink, call.alone, call.observer)?
                    }
                    _ => {
                        let overlay = &ready.overlay;
                        stream::run(bands, band, overlay, &mut base_probe, sink, call.observer)?
                    }
                },
            };
            Ok((encoded, ready))
        })?;
        log.warnings.extend(self.misfit_of_base(base_probe));
        let Encoded { written, bytes, image } = encoded.map_err(write_failure)?;
        log.warnings.extend(losses(&written, call.target.name()));
        if !self.base.is_in_memory() {
            log.warnings.extend(self.base.non_finite());
        }
        let Ready { fit, boundary_delta_e, .. } = ready;
        Ok(Done { fit, boundary_delta_e, bytes, image })
    }

    fn formats(&self, call: &Call<'_>, source: &OpenSource<'_>, log: &mut Log) -> Result<Formats> {
        let (values, name) = (self.options.values, call.target.name());
        let found = source.spec().format();
        let depth = values.depth(found.depth, call.target.format());
        let format = values.reinterpret(TexelFormat { depth, ..found });
        log.warnings.extend(self.base.mismatch(source.icc(), call.source.name()));
        let (base, mut icc) = self.base.under(format, source.icc());
        let channels = format.channels.union(base.channels);
        // A profile is for greyscale or for RGB; readers reject images with the wrong kind.
        let owner = if self.base.is_image() { base } else { format };
        if channels.has_color() != owner.channels.has_color() && icc.take().is_some() {
            let warning = "ICC profile dropped: it is for greyscale, but the result is in colour";
            log.warnings.push(format!("{}: {warning}", name.display()));
        }
        if let Some(format) = call.target.format().filter(|format| !format.codec().has_alpha)
            && channels.has_alpha()
        {
            return Err(self.needs_alpha(name, format));
        }
        Ok(Formats { found: found.channels, depth, source: format, base, channels, icc })
    }

    fn needs_alpha(&self, output: &Path, format: Format) -> Failure {
        let hint = if self.base.is_clear_color() {
            "use an opaque base, such as `onto` '#808080', or write"
        } else {
            "choose"
        };
        Failure::option(format!(
            "cannot write {}: the result has an alpha channel, which {format} does not support; \
             {hint} {}",
            output.display(),
            Format::names_of(|format| format.has_alpha, "or")
        ))
    }

    /// The texture, and the graft for its size.
    fn read(&self, source: OpenSource<'_>, alone: bool) -> Result<(Arc<Graft>, Texture)> {
        let size = source.spec().size;
        let wanted = AtomicU32::new(size.height);
        let read = || {
            let is_wanted = |row| row < wanted.load(Ordering::Relaxed);
            source.read_while(is_wanted)
        };
        let prepare = || {
            let graft = self.graft(size)?;
            wanted.store(self.source_rows_end(&graft), Ordering::Relaxed);
            Ok(graft)
        };
        let (graft, texture) = if alone {
            thread::scope(|scope| match spawn_with(scope, read, |read| read()) {
                Ok(reading) => {
                    let graft = prepare();
                    let texture = reading.join();
                    let texture = texture.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                    (graft, texture.unwrap_or_else(|| Err(Failure::work("nothing was read"))))
                }
                Err(read) => (prepare(), read()),
            })
        } else {
            (prepare(), read())
        };
        let ((texture, damage), graft) = (texture?, graft?);
        // The decoder may have read further than needed, depending on timing; damage in rows that
        // are not needed must not matter.
        match damage {
            Some((row, failure)) if row < self.source_rows_end(&graft) => Err(failure),
            _ => Ok((graft, texture)),
        }
    }

    /// One past the last row of a texture that is needed.
    fn source_rows_end(&self, graft: &Graft) -> u32 {
        if self.options.fit.is_some() {
            graft.sizes().from.height
        } else {
            graft.texture_rows().end
        }
    }

    /// Finds the tone of a decoded texture, and samples or fits it.
    fn ready(
        &self,
        call: &Call<'_>,
        formats: &Formats,
        graft: &Graft,
        texture: Texture,
        log: &mut Log,
    ) -> Result<Ready> {
        let (name, values) = (call.source.name(), self.options.values);
        let texture = texture.converted(formats.found, formats.depth);
        let texture = texture.with_encoding(formats.source.encoding);
        let (texture, unknown) = without_non_finite(texture, name);
        let lacks_texels = unknown.is_some();
        log.warnings.extend(unknown);
        let rows = self.source_rows_end(graft);
        log.warnings.extend(self.misfit_of_source(&texture, rows, &name.display().to_string()));
        let unused_fill = self.known.unused_fill(&texture, values, name);
        let texture = self.known.complete(texture, values, name)?;
        log.notes.extend(unused_fill);
        let toning = self.toning(graft, &texture, formats.base, name, log)?;
        let (overlay, fit) = self.overlay(call, graft, texture, formats.base)?;
        let mut overlay = toned(overlay, toning.as_ref(), values.is_toned()).or_work()?;
        if let (Some(toning), Some(analysis)) = (&toning, call.analysis) {
            analysis.store(toning, &overlay);
        }
        if (self.known.adds_alpha() || lacks_texels) && !formats.channels.has_alpha() {
            overlay = overlay.opaque();
        }
        let boundary_delta_e = toning.and_then(|toning| toning.report().boundary_delta_e);
        Ok(Ready { overlay, fit, boundary_delta_e })
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
        let (name, is_toned) = (path.display(), self.options.values.is_toned());
        let (toning, warnings) = toning(graft, texture, is_toned, base, || self.base.colors())?;
        log.warnings.extend(warnings.into_iter().map(|warning| format!("{name}: {warning}")));
        let note = toning.as_ref().filter(|_| is_toned).and_then(blending::exclusion_note);
        log.notes.extend(note.map(|note| format!("{name}: {note}")));
        Ok(toning)
    }

    /// The texture, sampled or fitted.
    fn overlay(
        &self,
        call: &Call<'_>,
        graft: &Graft,
        texture: Texture,
        base: TexelFormat,
    ) -> Result<(Overlay, Option<FitSummary>)> {
        let source = call.source.name();
        let overlay = match &self.options.fit {
            None => graft.overlay(texture, base).map(|overlay| (overlay, None)),
            Some(options) => {
                let mut progress =
                    |progress| call.observer.event(Event::FitProgress { source, progress });
                let fitted = graft.fit(texture, base, options, &mut progress);
                fitted.map(|fitted| (fitted.overlay, Some(fitted.summary)))
            }
        };
        overlay.or_input().context(source.display())
    }
}

/// The losses of a written file as warnings.
pub(crate) fn losses(written: &Written, path: &Path) -> Vec<String> {
    written.losses.iter().map(|loss| format!("{}: {loss}", path.display())).collect()
}

/// The error of a file that was checked to be writable, classified by fault.
pub(crate) fn write_failure(error: WriteError) -> Failure {
    match error {
        // By now the disk is full or gone, unless somebody has just taken the right to write.
        WriteError::Encode { reason: EncodeError::Io(ref reason), .. }
            if !matches!(
                reason.kind(),
                ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem
            ) =>
        {
            Failure::work(error)
        }
        error => Failure::input(error),
    }
}
