//! Transfers between UDIM tiles: textures with an image for each tile, under names with `<UDIM>`.
//!
//! The images of a texture are joined into an atlas, and for each tile of the target a transfer runs
//! between the atlas and that tile's unit square, into a temporary folder. Only when all are done are
//! the results moved into place.

mod names;
mod renamed;
mod sources;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use uvgraft::listing::listed;
use uvgraft::{Tile, TileAtlas};
use uvgraft_files::input::Input;
use uvgraft_files::output::{AtomicFile, TemporaryFolder};
use uvgraft_io::pair_file::{self, PairFile};

use crate::base_source::BaseSource;
use crate::failure::{Blame, Context, Failure, Result};
use crate::material::{Role, Values};
use crate::observer::Observer;
use crate::outputs::Outputs;
use crate::plan::{Job, TransferPlan};
use crate::transfer::{Correspondence, Existing, Inputs, MaterialMap, Transfer, Transferred};
use names::{PLACEHOLDER, Pattern, numbered, with_placeholder};
use renamed::Renamed;
use sources::TiledSource;

/// A texture, what it is for, and the outputs of its tiles.
struct TiledJob {
    values: Values,
    role: Option<Role>,
    source: TiledSource,
    outputs: BTreeMap<Tile, PathBuf>,
    bases: BTreeMap<Tile, Option<BaseSource>>,
}

impl Transfer {
    /// Whether textures have an image for each tile. Numbers in file names count where the pair has
    /// links in all tiles that they name.
    pub(crate) fn is_tiled(&self) -> Result<bool> {
        let (sources, bases) = self.images();
        // Names of bytes are only for messages.
        let paths = || sources.iter().filter_map(|source| source.path());
        let bases = bases.into_iter().filter_map(Input::path);
        let outputs = std::iter::once(&*self.output).chain(self.mask.as_deref());
        if paths().chain(bases).chain(outputs).any(has_placeholder) {
            return Ok(true);
        }
        let numbers: Vec<Tile> = paths().filter_map(numbered).map(|it| it.1).collect();
        let Correspondence::Pair(pair) = &self.correspondence else { return Ok(false) };
        if numbers.is_empty() || numbers.len() < sources.len() {
            return Ok(false);
        }
        let file = pair_file::read(pair).or_input()?;
        let read: BTreeSet<Tile> =
            file.pair.tiles(self.direction).map(|(_, [read, _])| read).collect();
        Ok(read.iter().any(|tile| *tile != Tile::FIRST)
            && numbers.iter().all(|it| read.contains(it)))
    }

    /// The textures and bases that are not in a list.
    fn images(&self) -> (Vec<&Input>, Vec<&Input>) {
        let (sources, bases): (_, Vec<&BaseSource>) = match &self.inputs {
            Inputs::Textures { sources, onto, .. } => {
                (sources.iter().collect(), onto.iter().collect())
            }
            Inputs::Listed { onto, .. } => (Vec::new(), onto.iter().collect()),
            Inputs::Material(maps) => (
                maps.iter().map(|map| &map.source).collect(),
                maps.iter().filter_map(|map| map.onto.as_ref()).collect(),
            ),
        };
        (sources, bases.into_iter().filter_map(BaseSource::as_image).collect())
    }

    /// As [`Transfer::run`], tile by tile.
    pub(crate) fn run_tiled(&self, observer: &dyn Observer) -> Result<Transferred> {
        self.check_tiled()?;
        let Correspondence::Pair(pair) = &self.correspondence else {
            return Err(Failure::option(format!(
                "{PLACEHOLDER} cannot be used with `with_map`: a map has no tiles"
            )));
        };
        let grouped = self.with_patterns()?;
        let plan = TransferPlan::new(&grouped)?;
        self.check_encoding(&plan)?;
        let file = pair_file::read(pair).or_input()?;
        let filled: BTreeSet<Tile> =
            file.pair.tiles(self.direction).map(|(_, [_, filled])| filled).collect();
        let jobs = grouped.tiled_jobs(&plan, &filled)?;
        let masks = match &self.mask {
            Some(mask) => names::of_tiles(mask, &filled, false)?,
            None => BTreeMap::new(),
        };
        self.check_tiled_outputs(&plan, &jobs, &masks)?;
        let folder = TemporaryFolder::create().or_work()?;
        let mut done = Transferred::default();
        let mut written = Vec::new();
        for (index, job) in jobs.iter().enumerate() {
            job.source.report_missing(&file.pair, self.direction, observer);
            let at = folder.path().join(index.to_string());
            std::fs::create_dir(&at).or_work()?;
            let (atlas, texture) = job.source.join(&at)?;
            for (&tile, output) in &job.outputs {
                let masks = if index == 0 { masks.get(&tile) } else { None };
                let step = Step { atlas: &atlas, texture: &texture, folder: &at, tile, output };
                let Some(mut result) = self.run_step(job, &file, &step, masks, observer)? else {
                    continue;
                };
                done.failures.append(&mut result.done.failures);
                done.blend = done.blend.or(result.done.blend);
                written.append(&mut result.written);
            }
        }
        if done.failures.is_empty() {
            if written.is_empty() {
                return Err(Failure::input(format!(
                    "{pair}: no links between the tiles of the textures and those of the outputs"
                )));
            }
            done.written = written.iter().filter(|(_, is_texture)| *is_texture).count();
            if let Some(new) = &plan.new_folder {
                let what = format_args!("cannot create the folder {}", new.display());
                std::fs::create_dir(new).or_input().context(what)?;
            }
            move_all(written.into_iter().map(|(moved, _)| moved).collect())?;
        }
        done.pair = Some(file);
        Ok(done)
    }

    /// Refuses options whose images belong to a single unit square.
    fn check_tiled(&self) -> Result<()> {
        let blending = self.blending.as_ref();
        let is_material = matches!(self.inputs, Inputs::Material(_));
        let (sources, bases) = self.images();
        let is_in_memory = sources.iter().chain(&bases).any(|image| image.path().is_none());
        let ruled_out = [
            (is_in_memory, "images in memory"),
            (self.source_mask.is_some(), "`source_mask`"),
            (self.fill.is_some(), "`fill`"),
            (blending.is_some_and(|it| it.skin.is_some()), "`skin`"),
            (blending.is_some_and(|it| it.labels.is_some()), "label images"),
            (self.draw_labels.is_some(), "`labels`"),
            (blending.is_some() && is_material, "both `map` and `blend`"),
            (self.existing == Existing::KeepUpToDate, "`skip_existing`"),
            (matches!(self.inputs, Inputs::Listed { .. }), "`manifest`"),
            (self.shard.is_some(), "`shard`"),
        ];
        match ruled_out.into_iter().find(|(is_asked, _)| *is_asked) {
            Some((_, what)) => Err(Failure::option(format!(
                "textures of several tiles ({PLACEHOLDER}) cannot be used with {what}"
            ))),
            None => Ok(()),
        }
    }

    /// The transfer with a placeholder in place of the numbers of tiles, one texture for all of its
    /// tiles.
    fn with_patterns(&self) -> Result<Self> {
        let mut grouped = self.clone();
        let as_pattern = |path: &Path| numbered(path).map_or_else(|| path.to_path_buf(), |it| it.0);
        match &mut grouped.inputs {
            Inputs::Textures { sources, .. } => {
                // With a placeholder anywhere, every other name means what it says.
                let is_numbered = sources.iter().all(|source| numbered(source.name()).is_some());
                if is_numbered && sources.len() > 1 {
                    let mut patterns: BTreeMap<PathBuf, BTreeSet<&Path>> = BTreeMap::new();
                    for path in sources.iter().map(Input::name) {
                        // A missing file is an error, other than a missing image of a pattern.
                        path.metadata().or_input().context(path.display())?;
                        patterns.entry(as_pattern(path)).or_default().insert(path);
                    }
                    for (pattern, given) in &patterns {
                        let files = Pattern::parse(pattern)?.files()?;
                        if let Some((tile, file)) =
                            files.iter().find(|(_, file)| !given.contains(&***file))
                        {
                            return Err(Failure::input(format!(
                                "{}: the image of tile {tile} is not given; give those of all tiles, \
                                 or {}",
                                file.display(),
                                pattern.display()
                            )));
                        }
                    }
                    let patterns = patterns.into_keys().map(Input::File).collect();
                    *sources = patterns;
                }
            }
            Inputs::Listed { .. } | Inputs::Material(_) => {}
        }
        Ok(grouped)
    }

    fn tiled_jobs(&self, plan: &TransferPlan, filled: &BTreeSet<Tile>) -> Result<Vec<TiledJob>> {
        let is_folder = plan.new_folder.is_some() || self.output.is_dir();
        let roles: Vec<Option<Role>> = match &self.inputs {
            Inputs::Textures { .. } | Inputs::Listed { .. } => vec![None; plan.batches.len()],
            Inputs::Material(maps) => maps.iter().map(|map| Some(map.role)).collect(),
        };
        if filled.len() > 1 && self.blending.is_some() {
            return Err(Failure::option(format!(
                "`blend` cannot be used where the target has several tiles ({}): blends end at the \
                 borders of tiles",
                listed(filled)
            )));
        }
        let mut jobs = Vec::new();
        for (batch, role) in plan.batches.iter().zip(roles) {
            for Job { source, output } in &batch.jobs {
                let outputs = names::of_tiles(output, filled, is_folder)?;
                let base = |tile: Tile| -> Result<Option<BaseSource>> {
                    Ok(match &batch.onto {
                        Some(BaseSource::Image(Input::File(path)))
                            if outputs.len() > 1 || has_placeholder(path) =>
                        {
                            Some(BaseSource::image(with_placeholder(path)?.of(tile)))
                        }
                        onto => onto.clone(),
                    })
                };
                let bases =
                    outputs.keys().map(|&tile| Ok((tile, base(tile)?))).collect::<Result<_>>()?;
                let source = TiledSource::find(source.name())?;
                jobs.push(TiledJob { values: batch.values, role, source, outputs, bases });
            }
        }
        Ok(jobs)
    }

    fn check_tiled_outputs(
        &self,
        plan: &TransferPlan,
        jobs: &[TiledJob],
        masks: &BTreeMap<Tile, PathBuf>,
    ) -> Result<()> {
        let bases = jobs.iter().flat_map(|job| job.bases.values());
        let bases = bases.filter_map(|base| base.as_ref()?.path());
        let sources = jobs.iter().flat_map(|job| job.source.files().values().map(PathBuf::as_path));
        let inputs = std::iter::once(self.correspondence.input()).chain(self.region.inputs());
        let inputs = inputs.filter_map(Input::path);
        let mut outputs = Outputs::new(inputs.chain(bases).chain(sources));
        match &plan.new_folder {
            None => (jobs.iter().flat_map(|job| job.outputs.values()))
                .try_for_each(|path| outputs.check(path))?,
            Some(folder) => crate::outputs::check_new_folder(folder)?,
        }
        masks.values().chain(&self.extra_outputs).try_for_each(|path| outputs.check(path))
    }

    /// Fills one tile; `None` if it has no links to the texture.
    fn run_step(
        &self,
        job: &TiledJob,
        file: &PairFile,
        step: &Step<'_>,
        mask: Option<&PathBuf>,
        observer: &dyn Observer,
    ) -> Result<Option<StepResult>> {
        let Some(pair) = file.pair.in_tiles(self.direction, step.atlas, step.tile) else {
            let (tile, output) = (step.tile, step.output.display());
            observer.note(format_args!(
                "{output}: not written, since tile {tile} has no links to the texture"
            ));
            return Ok(None);
        };
        let folder = step.folder.join(step.tile.to_string());
        std::fs::create_dir(&folder).or_work()?;
        let pair_path = folder.join("tile.uvpair");
        let pair = PairFile { pair: pair.into(), ..file.clone() };
        pair_file::write(&pair, &pair_path).or_work()?;
        let mut inner = self.clone();
        inner.correspondence = Correspondence::Pair(pair_path.into());
        let (source, onto) = (Input::from(step.texture), job.bases[&step.tile].clone());
        let extension = step.output.extension().unwrap_or_default();
        let name = |stem: &str| folder.join(stem).with_extension(extension);
        let temporary = match job.role {
            // The output of a material is a folder, and its files have the names of roles.
            Some(role) => {
                inner.inputs = Inputs::Material(vec![MaterialMap { role, source, onto }]);
                inner.format = Some(extension.to_string_lossy().into_owned());
                inner.output.clone_from(&folder);
                name(role.name())
            }
            None => {
                let values = job.values;
                inner.inputs = Inputs::Textures { sources: vec![source], onto, values };
                inner.output = name("result");
                inner.output.clone()
            }
        };
        inner.extra_outputs.clear();
        let temporary_mask = mask
            .map(|mask| folder.join("mask").with_extension(mask.extension().unwrap_or_default()));
        inner.mask.clone_from(&temporary_mask);
        let mut names = vec![(temporary.clone(), step.output.to_path_buf())];
        names.push((step.texture.to_path_buf(), job.source.name().to_path_buf()));
        names.extend(temporary_mask.clone().zip(mask.cloned()));
        let renamed = Renamed { observer, names };
        let mut done = inner.run(&renamed).map_err(|failure| renamed.failure(&failure))?;
        done.failures = done.failures.iter().map(|failure| renamed.failure(failure)).collect();
        let mut written = Vec::new();
        if done.failures.is_empty() {
            written.push(((temporary, step.output.to_path_buf()), true));
            written.extend(temporary_mask.zip(mask.cloned()).map(|mask| (mask, false)));
        }
        Ok(Some(StepResult { done, written }))
    }
}

/// One tile of the target.
struct Step<'a> {
    atlas: &'a TileAtlas,
    /// The file of the atlas.
    texture: &'a Path,
    folder: &'a Path,
    tile: Tile,
    output: &'a Path,
}

struct StepResult {
    done: Transferred,
    /// Temporary files, where they belong, and whether they are textures.
    written: Vec<((PathBuf, PathBuf), bool)>,
}

/// Whether a name has a placeholder for tiles.
pub(crate) fn has_placeholder(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.contains(PLACEHOLDER))
}

/// Copies files next to their places, and only then renames all of them.
fn move_all(files: Vec<(PathBuf, PathBuf)>) -> Result<()> {
    let mut copies = Vec::with_capacity(files.len());
    for (temporary, output) in files {
        let copied = || -> std::io::Result<AtomicFile> {
            let mut copy = AtomicFile::create(&output)?;
            std::io::copy(&mut std::fs::File::open(&temporary)?, &mut copy)?;
            Ok(copy)
        };
        let what = format!("cannot write {}", output.display());
        copies.push((copied().or_work().context(&what)?, what));
    }
    for (copy, what) in copies {
        copy.commit().or_work().context(what)?;
    }
    Ok(())
}
