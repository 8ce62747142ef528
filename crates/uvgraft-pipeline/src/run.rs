//! Executes a transfer.

use std::fs::Metadata;
use std::path::Path;
use std::sync::Arc;

use uvgraft::{Blend, BlendDomain, Filter, Overlap, Size, Tone, threads};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, Format, Image};

use crate::base::{Base, BaseOptions};
use crate::base_source::BaseSource;
use crate::batch;
use crate::blending::{Blending, KnownTexels};
use crate::failure::{Blame, Context, Failure, Result};
use crate::fingerprint::Seen;
use crate::layout_checks::LayoutChecks;
use crate::link::Link;
use crate::manifest::Manifest;
use crate::masks::MaskSizes;
use crate::material::Values;
use crate::observer::{Event, Observer};
use crate::outputs::{self, Outputs};
use crate::plan::{Batch, Job, TransferPlan, format_of};
use crate::records::Records;
use crate::shared::{Grafts, Options, Shared};
use crate::texture_transfer::{Analysis, losses, write_failure};
use crate::transfer::{Existing, Inputs, Transfer, Transferred};
use crate::unchanged::Unchanged;
use crate::worker::TransferWorker;

impl Transfer {
    /// Runs the transfer.
    ///
    /// A texture that fails does not stop the others: see [`Transferred::failures`].
    ///
    /// # Errors
    /// [`Failure`] for what concerns all textures: conflicting options, an unreadable pair or base,
    /// an output that cannot be written, or cancellation by the observer.
    pub fn run(&self, observer: &dyn Observer) -> Result<Transferred> {
        self.check()?;
        if self.is_tiled()? {
            return self.run_tiled(observer);
        }
        let mut done = Transferred::default();
        let planned = self.planned(&mut done, observer)?;
        let Some((mut plan, records)) = planned else { return Ok(done) };
        let has_jobs = plan.jobs().next().is_some();
        let link = Arc::new(Link::read(&self.correspondence)?);
        let size = link.size(self.size)?;
        let known = KnownTexels::read(self.source_mask.as_ref(), self.fill.as_ref())?;
        known.check(observer)?;
        let known = Arc::new(known);
        let mask_sizes = Arc::new(self.mask_sizes());
        self.check_batches(&plan, &link, size, &mask_sizes)?;
        let (blend, mut first_base) =
            self.blend_and_first_base(&plan, (&link, &known), size, observer)?;
        done.blend = blend;
        observer.check()?;
        plan.create_folders()?;
        let mut mask = self.mask.as_deref();
        let mut narrowed = None;
        for (batch, records) in plan.batches.iter().zip(&records) {
            observer.check()?;
            let base = match first_base.take() {
                Some(base) => base,
                None => self.base(batch, size)?,
            };
            base.non_finite().into_iter().for_each(|warning| observer.warn(warning));
            let several = batch.jobs.len() > 1;
            let shared = Shared {
                unchanged: (several && base.is_in_memory()).then(|| Unchanged::of_base(&base)),
                options: Options::new(self, batch.values),
                link: Arc::clone(&link),
                base,
                blend: done.blend.clone(),
                known: Arc::clone(&known),
                mask_sizes: Arc::clone(&mask_sizes),
                grafts: Grafts::default(),
                layout_checks: LayoutChecks::default(),
            };
            let first =
                (batch.jobs.first().map(|job| &job.source), Analysis::new(self.mask.is_some()));
            let worker = TransferWorker { transfer: self, shared: &shared, observer, first };
            let batch_done = batch::run(&worker, &batch.jobs, records.as_ref())?;
            if (batch_done.written > 0 || !has_jobs)
                // The mask of the first texture transferred stands for all.
                && let Some(path) = mask.take()
            {
                self.write_image(&worker.mask()?.into(), path, observer)?;
            }
            let found = worker.first.1.found();
            narrowed = narrowed.or_else(|| found.and_then(|found| found.narrowed.clone()));
            done.written += batch_done.written;
            done.failures.extend(batch_done.failures);
        }
        done.blend = narrowed.or(done.blend);
        done.pair = Arc::into_inner(link).and_then(Link::into_pair_file);
        Ok(done)
    }

    /// The batches without the textures that are up to date, and their records; `None` if nothing is
    /// left to do.
    fn planned(
        &self,
        done: &mut Transferred,
        observer: &dyn Observer,
    ) -> Result<Option<(TransferPlan, Vec<Option<Records>>)>> {
        let mut plan = TransferPlan::new(self)?;
        self.check_encoding(&plan)?;
        self.check_outputs(&plan)?;
        let records = self.records(&plan)?;
        let planned = plan.jobs().count();
        for (batch, records) in plan.batches.iter_mut().zip(&records) {
            if let Some(records) = records {
                skip_up_to_date(batch, records, observer);
            }
        }
        observer.check()?;
        let left = plan.jobs().count();
        done.up_to_date = planned - left;
        let keeps = self.existing == Existing::KeepUpToDate;
        let up_to_date = keeps.then_some(done.up_to_date);
        observer.event(Event::Planned { textures: planned, up_to_date });
        let is_done = keeps && self.mask.is_none() && self.extra_outputs.is_empty();
        // A shard may have no textures.
        let has_nothing = left == 0 && (is_done || self.shard.is_some());
        Ok((!has_nothing).then_some((plan, records)))
    }

    /// Checks formats, sizes and memory, as far as the headers of the bases tell them.
    fn check_batches(
        &self,
        plan: &TransferPlan,
        link: &Link,
        size: Option<Size>,
        mask_sizes: &MaskSizes,
    ) -> Result<()> {
        for batch in &plan.batches {
            let options = self.base_options(batch.onto.as_ref(), batch.values, size);
            let header = options.header();
            let target = size.or_else(|| header.map(|header| header.size));
            target.map_or(Ok(()), |target| check_formats(batch, target))?;
            mask_sizes.check_base(header)?;
            self.check_memory(batch, link, &options, header)?;
        }
        Ok(())
    }

    /// Decoding a base and preparing a blend take about the same time.
    fn blend_and_first_base(
        &self,
        plan: &TransferPlan,
        (link, known): (&Link, &KnownTexels),
        size: Option<Size>,
        observer: &dyn Observer,
    ) -> Result<(Option<Arc<Blend>>, Option<Base>)> {
        let (blend, first_base) = threads::join(
            || self.blend(link, known, self.labelled_texture(plan), observer),
            || plan.batches.first().map(|batch| self.base(batch, size)),
        );
        let blend = blend?;
        if let Some(path) = &self.draw_labels {
            self.write_labels(blend.as_deref(), path, observer)?;
        }
        if plan.batches.len() > 1 {
            plan.batches.iter().try_for_each(|batch| {
                self.base_options(batch.onto.as_ref(), batch.values, size).check()
            })?;
        }
        Ok((blend, first_base.transpose()?))
    }

    /// Checks for conflicting options.
    fn check(&self) -> Result<()> {
        let is_empty = match &self.inputs {
            Inputs::Textures { sources, .. } => sources.is_empty(),
            Inputs::Listed { .. } => false,
            Inputs::Material(maps) => maps.is_empty(),
        };
        if is_empty {
            return Err(Failure::input("no textures to transfer"));
        }
        if matches!(self.inputs, Inputs::Listed { .. }) && self.draw_labels.is_some() {
            return Err(Failure::option("`labels` cannot be used with several textures"));
        }
        if self.shard.is_some() {
            self.check_shard()?;
        }
        self.check_options()
    }

    /// Checks that the encoding options mean something to an output. Those of another shard may be of
    /// another format.
    pub(crate) fn check_encoding(&self, plan: &TransferPlan) -> Result<()> {
        if self.shard.is_some() {
            return Ok(());
        }
        let formats = plan.jobs().filter_map(|job| Format::from_path(&job.output));
        self.write.check(&formats.collect::<Vec<_>>()).map_err(Failure::option)
    }

    /// Checks that every output belongs to one shard.
    fn check_shard(&self) -> Result<()> {
        let ruled_out = [
            (matches!(self.inputs, Inputs::Material(_)), "`map`"),
            (self.mask.is_some(), "`mask`"),
            (self.draw_labels.is_some(), "`labels`"),
            (!self.extra_outputs.is_empty(), "`preview`"),
        ];
        match ruled_out.into_iter().find(|(is_asked, _)| *is_asked) {
            Some((_, what)) => Err(Failure::option(format!(
                "`shard` cannot be used with {what}, whose outputs belong to no shard"
            ))),
            None => Ok(()),
        }
    }

    /// As [`Transfer::check`], whatever the textures are.
    pub(crate) fn check_options(&self) -> Result<()> {
        self.check_map()?;
        self.region.check()?;
        let values = match &self.inputs {
            Inputs::Textures { values, .. } | Inputs::Listed { values, .. } => Some(*values),
            Inputs::Material(_) => None,
        };
        if let Some(format) = &self.format
            && Format::from_extension(format).is_none()
        {
            let wanted = Format::extension_list();
            return Err(Failure::option(format!("`format` must be one of {wanted}, got {format}")));
        }
        self.check_known()?;
        if self.fit.is_some() {
            if self.filter(values.unwrap_or_default()) == Filter::Nearest {
                return Err(Failure::option(
                    "`fit` cannot be used with `filter` nearest, which does not blend texels",
                ));
            }
            if self.overlap == Overlap::Average {
                return Err(Failure::option("`fit` cannot be used with `overlap` average"));
            }
            if values.is_none() {
                return Err(Failure::option("`fit` cannot be used with `map`"));
            }
            if values == Some(Values::Normals) {
                return Err(Failure::option("`fit` cannot be used with normal maps"));
            }
        }
        if values.is_some_and(Values::is_data) {
            let skin = self.blending.as_ref().and_then(|blending| blending.skin.as_ref());
            if [skin, self.source_mask.as_ref(), self.fill.as_ref()].iter().any(Option::is_some) {
                return Err(Failure::option(
                    "`data` cannot be used with `skin`, `source_mask` or `fill`: data has neither \
                     opacity nor tone",
                ));
            }
            if self.blending.as_ref().is_some_and(Blending::needs_colors) {
                return Err(Failure::option(
                    "`data` cannot be used with `match_skin` or `blend` membrane: data has no tone; \
                     use `blend` feather or `tone` none",
                ));
            }
        }
        Ok(())
    }

    /// Checks that the material has maps to which a mask or a mean texture means something.
    fn check_known(&self) -> Result<()> {
        let Inputs::Material(maps) = &self.inputs else { return Ok(()) };
        let none = |is: fn(Values) -> bool| !maps.iter().any(|map| is(map.role.values()));
        if self.fill.is_some() && none(Values::is_toned) {
            return Err(Failure::option("`fill` needs a `map` that is filled, such as albedo"));
        }
        // With a blend, data ends at the boundary of the mask too.
        if self.source_mask.is_some() && self.blending.is_none() && none(|it| !it.is_data()) {
            return Err(Failure::option(
                "`source_mask` needs `blend`, or a `map` of colours: data has no alpha",
            ));
        }
        Ok(())
    }

    /// Checks that all outputs can be written, and are neither inputs nor each other.
    fn check_outputs(&self, plan: &TransferPlan) -> Result<()> {
        let sources = plan.jobs().map(|job| &job.source);
        let inputs = self.shared_inputs(plan).into_iter().chain(sources);
        let mut outputs = Outputs::new(inputs.filter_map(Input::path).chain(self.list_path()));
        match &plan.new_folder {
            None => {
                plan.jobs().try_for_each(|job| outputs.check_below(&plan.folder, &job.output))?;
            }
            Some(folder) => outputs::check_new_folder(folder)?,
        }
        if let Some(mask) = &self.mask {
            let format = format_of(mask)?;
            if format.codec().is_lossy {
                let mask = mask.display();
                return Err(Failure::option(format!(
                    "`mask` must not be a {format} file, got {mask}; use .png"
                )));
            }
            outputs.check(mask)?;
        }
        self.extra_outputs.iter().chain(&self.draw_labels).try_for_each(|path| outputs.check(path))
    }

    /// Prepares the blend, if there is one.
    ///
    /// - `only`: the only texture, if its labels are to be detected here.
    pub(crate) fn blend(
        &self,
        link: &Link,
        known: &KnownTexels,
        only: Option<&Input>,
        observer: &dyn Observer,
    ) -> Result<Option<Arc<Blend>>> {
        let Some(pair) = link.pair() else { return Ok(None) };
        if self.blending.is_none() && self.region.is_everything() {
            return Ok(None);
        }
        let domain = BlendDomain::new(Arc::clone(pair), self.direction);
        let blending = self.blending.clone().unwrap_or_default();
        let ends_at_mask = matches!(self.inputs, Inputs::Material(_));
        let blend = blending.prepare(&self.region, &domain, known, ends_at_mask, observer)?;
        let texture = match (self.labelled_map(), only) {
            (Some(albedo), _) => image::read(albedo).or_input()?.texture,
            // Errors are reported when the texture is transferred.
            (None, Some(texture)) => match image::read(texture) {
                Ok(image) => image.texture,
                Err(_) => return Ok(Some(blend)),
            },
            (None, None) => return Ok(Some(blend)),
        };
        Ok(Some(match blend.labels(&texture) {
            Some(labels) => Arc::new(Arc::unwrap_or_clone(blend).with_labels(labels)),
            None => blend,
        }))
    }

    /// The material map whose labels apply to all maps, if labels matter and no label image is
    /// given.
    pub(crate) fn labelled_map(&self) -> Option<&Input> {
        let asks = |blending: &Blending| blending.needs_labels() && blending.labels.is_none();
        match &self.inputs {
            Inputs::Material(maps) if self.blending.as_ref().is_some_and(asks) => {
                maps.iter().find(|map| map.role.values().is_toned()).map(|map| &map.source)
            }
            _ => None,
        }
    }

    /// The only texture, if its labels can be detected while its base is decoded: judged by file
    /// size, the base must take longer to decode than the texture does twice. If the skin of the
    /// base is needed too, both are detected together later.
    fn labelled_texture<'a>(&self, plan: &'a TransferPlan) -> Option<&'a Input> {
        let asks = |blending: &Blending| {
            let in_base_tone = blending.options.tone == Tone::Base;
            blending.needs_colors() && in_base_tone && blending.labels.is_none()
        };
        let ([batch], [job]) = (&plan.batches[..], &plan.batches.first()?.jobs[..]) else {
            return None;
        };
        let base = batch.onto.as_ref()?.as_image()?;
        let bytes = |input: &Input| match input {
            // A pipe can be read only once.
            Input::File(path) => {
                path.metadata().ok().filter(Metadata::is_file).map(|file| file.len())
            }
            Input::Bytes { bytes, .. } => Some(bytes.len() as u64),
        };
        let (texture, base) = (bytes(&job.source)?, bytes(base)?);
        let is_plain = self.source_mask.is_none() && self.fill.is_none() && batch.values.is_toned();
        let is_asked = self.blending.as_ref().is_some_and(asks);
        (is_asked && is_plain && 2 * texture < base).then_some(&job.source)
    }

    /// Draws the labels of the only texture.
    fn write_labels(
        &self,
        blend: Option<&Blend>,
        path: &Path,
        observer: &dyn Observer,
    ) -> Result<()> {
        let source = match &self.inputs {
            Inputs::Textures { sources, .. } => sources.first(),
            Inputs::Listed { .. } => None,
            Inputs::Material(maps) => {
                maps.iter().find(|map| map.role.values().is_toned()).map(|map| &map.source)
            }
        };
        let (Some(source), Some(blend)) = (source, blend) else {
            return Err(Failure::option("`labels` requires `blend`"));
        };
        let texture = image::read(source).or_input()?.texture;
        let domain = blend.domain();
        let labels = domain
            .labels(&texture)
            .map_err(|error| Failure::input(format!("{source}: cannot detect labels: {error}")))?;
        self.write_image(&labels.picture().into(), path, observer)
    }

    /// Writes an image next to the results.
    fn write_image(&self, image: &Image, path: &Path, observer: &dyn Observer) -> Result<()> {
        let written = image::write(image, path, &self.write).map_err(write_failure)?;
        for loss in losses(&written, path) {
            observer.warn(loss);
        }
        Ok(())
    }

    /// - `size`: of the results, if it is not that of the base.
    pub(crate) fn base_options<'a>(
        &self,
        onto: Option<&'a BaseSource>,
        values: Values,
        size: Option<Size>,
    ) -> BaseOptions<'a> {
        BaseOptions {
            onto,
            size,
            values,
            filter: self.filter(values),
            averaging: self.averaging,
            is_material: matches!(self.inputs, Inputs::Material(_)),
        }
    }

    fn base(&self, batch: &Batch, size: Option<Size>) -> Result<Base> {
        let options = self.base_options(batch.onto.as_ref(), batch.values, size);
        Base::new(&options, self.keeps_base(batch))
    }

    /// Whether the base of a batch is read more than once.
    pub(crate) fn keeps_base(&self, batch: &Batch) -> bool {
        let needs_colors = self.blending.as_ref().is_some_and(Blending::needs_colors);
        batch.jobs.len() > 1 || (batch.values.is_toned() && needs_colors)
    }

    /// The records of each batch; `None` if not requested.
    fn records(&self, plan: &TransferPlan) -> Result<Vec<Option<Records>>> {
        if self.existing == Existing::Replace {
            return Ok(plan.batches.iter().map(|_| None).collect());
        }
        // A missing file is reported where it is read; without a fingerprint nothing is skipped.
        let list = self.list_path().map(Input::from);
        let seen = Seen::before(self.shared_inputs(plan).into_iter().chain(&list));
        let common = self.common_fingerprint().ok();
        let of_batch = |batch: &Batch| {
            let shared = common
                .clone()
                .and_then(|common| common.of_batch(batch.values, batch.onto.as_ref()).ok());
            let Some(shared) = shared else { return Ok(None) };
            let manifest = Manifest::open(&plan.folder, self.shard)?;
            Ok(Some(Records { manifest, shared, seen: seen.clone() }))
        };
        plan.batches.iter().map(of_batch).collect()
    }
}

/// Checks that the formats of a batch's outputs can have their size.
fn check_formats(batch: &Batch, target: Size) -> Result<()> {
    let mut checked = None;
    for job in &batch.jobs {
        let format = format_of(&job.output)?;
        if checked.replace(format) != Some(format) {
            let what = format_args!("cannot write {}", job.output.display());
            image::check_size(format, target).or_input().context(what)?;
        }
    }
    Ok(())
}

/// Removes the jobs whose outputs are up to date.
fn skip_up_to_date(batch: &mut Batch, records: &Records, observer: &dyn Observer) {
    let is_done = |job: &_| !observer.is_cancelled() && records.is_up_to_date(job);
    let jobs = &batch.jobs;
    let is_done = threads::map_indices(jobs.len(), |index| is_done(&jobs[index]));
    let mut is_done = is_done.into_iter();
    batch.jobs.retain(|Job { source, output }| {
        let is_done = is_done.next().unwrap_or(false);
        if is_done {
            observer.event(Event::TextureUpToDate { source: source.name(), output });
        }
        !is_done
    });
}
