//! The plan of a transfer: which files it reads and writes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use uvgraft_files::input::Input;
use uvgraft_image::Format;

use crate::base_source::BaseSource;
use crate::failure::{Blame, Context, Failure, Result};
use crate::manifest::name_within;
use crate::material::Values;
use crate::texture_list::{Listed, TextureList};
use crate::transfer::{Inputs, MaterialMap, Transfer};

/// A texture to transfer and its output.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    pub(crate) source: Input,
    pub(crate) output: PathBuf,
}

/// Textures that are processed alike and share a base.
#[derive(Debug)]
pub(crate) struct Batch {
    pub(crate) values: Values,
    pub(crate) onto: Option<BaseSource>,
    pub(crate) jobs: Vec<Job>,
}

/// All batches, and the output folder to create.
#[derive(Debug)]
pub(crate) struct TransferPlan {
    pub(crate) batches: Vec<Batch>,
    pub(crate) new_folder: Option<PathBuf>,
    /// The folder of the outputs, whether or not it is new.
    pub(crate) folder: PathBuf,
}

impl TransferPlan {
    /// Creates the folders of outputs that do not exist. Other shards may be doing the same.
    pub(crate) fn create_folders(&mut self) -> Result<()> {
        let new = self.new_folder.take();
        // A list of textures may name outputs in subfolders.
        let folders: BTreeSet<&Path> = self.jobs().filter_map(|job| job.output.parent()).collect();
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.is_dir();
        let missing = folders.into_iter().filter(missing);
        for folder in new.iter().map(PathBuf::as_path).chain(missing) {
            let what = format_args!("cannot create the folder {}", folder.display());
            std::fs::create_dir_all(folder).or_input().context(what)?;
        }
        Ok(())
    }

    pub(crate) fn new(transfer: &Transfer) -> Result<Self> {
        match &transfer.inputs {
            Inputs::Textures { sources, onto, values } => {
                let jobs = TextureJobs::new(transfer, sources)?;
                Ok(jobs.into_plan(onto.as_ref(), *values))
            }
            Inputs::Listed { list, onto, values } => {
                let jobs = TextureJobs::listed(transfer, list)?;
                Ok(jobs.into_plan(onto.as_ref(), *values))
            }
            Inputs::Material(maps) => Self::of_maps(transfer, maps),
        }
    }

    /// All jobs, batch by batch.
    pub(crate) fn jobs(&self) -> impl Iterator<Item = &Job> {
        self.batches.iter().flat_map(|batch| &batch.jobs)
    }

    /// One job for each material map, its output named after the role, in the format of the source.
    fn of_maps(transfer: &Transfer, maps: &[MaterialMap]) -> Result<Self> {
        let folder = &*transfer.output;
        let is_new = is_new_folder(folder, "`map`")?;
        let mut batches: Vec<Batch> = Vec::with_capacity(maps.len());
        for MaterialMap { role, source, onto } in maps {
            let extension = match &transfer.format {
                Some(extension) => extension.clone(),
                None => {
                    source.name().extension().unwrap_or_default().to_string_lossy().into_owned()
                }
            };
            if Format::from_extension(&extension).is_none() {
                return Err(Failure::option(format!(
                    "{source}: cannot infer the output format of the map {} from the file name; use \
                     `format`, such as `format` png",
                    role.name()
                )));
            }
            let output = folder.join(role.name()).with_extension(extension);
            let mut others = batches.iter().flat_map(|batch| &batch.jobs);
            if others.any(|job| job.output.file_stem() == output.file_stem()) {
                return Err(Failure::option(format!("`map` {}: role given twice", role.name())));
            }
            let jobs = vec![Job { source: source.clone(), output }];
            batches.push(Batch { values: role.values(), onto: onto.clone(), jobs });
        }
        let folder = folder.to_path_buf();
        Ok(Self { batches, new_folder: is_new.then(|| folder.clone()), folder })
    }
}

/// The jobs of textures with one base.
struct TextureJobs {
    jobs: Vec<Job>,
    folder: PathBuf,
    is_new: bool,
}

impl TextureJobs {
    fn new(transfer: &Transfer, sources: &[Input]) -> Result<Self> {
        let output = &*transfer.output;
        for source in sources.iter().filter_map(Input::path) {
            // A path without an image extension usually means a missing folder.
            if Format::from_path(source).is_none() {
                source.metadata().or_input().context(source.display())?;
            }
        }
        if let [source] = sources
            && folder_at(source).is_none()
            && !output.is_dir()
            && !says_folder(output)
        {
            return Self::single(transfer, source);
        }
        let is_new = is_new_folder(output, "several textures or a folder")?;
        let mut jobs = Vec::new();
        for source in sources {
            if let Some(folder) = folder_at(source) {
                for source in images_in(folder)? {
                    jobs.extend(job_in_folder(transfer, source.into())?);
                }
            } else {
                jobs.extend(job_in_folder(transfer, source.clone())?);
            }
        }
        check_distinct(&jobs)?;
        Ok(Self { jobs, folder: output.to_path_buf(), is_new })
    }

    fn into_plan(self, onto: Option<&BaseSource>, values: Values) -> TransferPlan {
        let Self { jobs, folder, is_new } = self;
        let new_folder = is_new.then(|| folder.clone());
        let batches = vec![Batch { values, onto: onto.cloned(), jobs }];
        TransferPlan { batches, new_folder, folder }
    }

    /// The textures of a list. Whether they exist is found out when they are transferred.
    fn listed(transfer: &Transfer, list: &TextureList) -> Result<Self> {
        let folder = &*transfer.output;
        let is_new = is_new_folder(folder, "`manifest`")?;
        let mut jobs = Vec::new();
        list.for_each(|Listed { source, output }| {
            let source = Input::File(source);
            jobs.extend(match output {
                None => job_in_folder(transfer, source)?,
                Some(name) => {
                    check_format(transfer, &name)?;
                    let output = folder.join(name);
                    is_in_shard(transfer, folder, &output).then_some(Job { source, output })
                }
            });
            Ok(())
        })?;
        check_distinct(&jobs)?;
        Ok(Self { jobs, folder: folder.to_path_buf(), is_new })
    }

    /// A texture whose output is a file.
    fn single(transfer: &Transfer, source: &Input) -> Result<Self> {
        let output = &*transfer.output;
        check_format(transfer, output)?;
        let job = Job { source: source.clone(), output: output.to_path_buf() };
        let folder = output.parent().unwrap_or(Path::new("")).to_path_buf();
        let is_wanted = is_in_shard(transfer, &folder, output);
        Ok(Self { jobs: is_wanted.then_some(job).into_iter().collect(), folder, is_new: false })
    }
}

/// Checks the extension of an output whose name is given.
fn check_format(transfer: &Transfer, name: &Path) -> Result<()> {
    let format = format_of(name)?;
    match transfer.format.as_deref() {
        Some(wanted) if Format::from_extension(wanted) != Some(format) => Err(Failure::option(
            format!("`format` {wanted} contradicts the extension of the output {}", name.display()),
        )),
        _ => Ok(()),
    }
}

/// The folder that a source is.
fn folder_at(source: &Input) -> Option<&Path> {
    source.path().filter(|path| path.is_dir())
}

fn says_folder(output: &Path) -> bool {
    output.as_os_str().as_encoded_bytes().ends_with(b"/")
}

/// Whether an output folder has to be created.
///
/// - `what`: makes the output a folder.
fn is_new_folder(output: &Path, what: &str) -> Result<bool> {
    // Looked at once: another shard may be creating it.
    let (is_new, is_folder) = match output.metadata() {
        Ok(found) => (false, found.is_dir()),
        Err(_) => (true, says_folder(output) || Format::from_path(output).is_none()),
    };
    if is_folder {
        return Ok(is_new);
    }
    let output = output.display();
    Err(Failure::option(format!("with {what}, the output must be a folder, got {output}")))
}

/// The job of a texture whose output is named after it; `None` if it belongs to another shard.
fn job_in_folder(transfer: &Transfer, source: Input) -> Result<Option<Job>> {
    let name = source.name().file_name().map(PathBuf::from).unwrap_or_default();
    let name = match &transfer.format {
        Some(format) => name.with_extension(format),
        None => name,
    };
    let output = transfer.output.join(&name);
    if Format::from_path(&name).is_none() {
        return Err(Failure::option(format!(
            "{source}: cannot infer the format of the output {} from the file name; use `format`, \
             such as `format` png",
            output.display()
        )));
    }
    let is_wanted = is_in_shard(transfer, &transfer.output, &output);
    Ok(is_wanted.then_some(Job { source, output }))
}

fn is_in_shard(transfer: &Transfer, folder: &Path, output: &Path) -> bool {
    let Some(shard) = transfer.shard else { return true };
    name_within(folder, output).is_some_and(|name| shard.has(&name))
}

/// Checks that no two textures have the same output. Those that do are in the same shard.
fn check_distinct(jobs: &[Job]) -> Result<()> {
    // Indices, since the paths of a million jobs take much memory.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|&a, &b| jobs[a].output.cmp(&jobs[b].output));
    let same = order.windows(2).filter(|pair| jobs[pair[0]].output == jobs[pair[1]].output);
    match same.min_by_key(|pair| pair[1]) {
        None => Ok(()),
        Some(pair) => {
            let [a, b] = [pair[0], pair[1]].map(|index| &jobs[index]);
            Err(Failure::input(format!(
                "{} and {} have the same output {}",
                a.source,
                b.source,
                a.output.display()
            )))
        }
    }
}

/// The image files of a folder, recognised by extension and sorted. Hidden files are skipped: some
/// systems put a `._face.png`, which is not an image, next to each `face.png`.
///
/// # Errors
/// As bad input if the folder cannot be read or has no images.
pub fn images_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = folder.read_dir().and_then(Iterator::collect::<std::result::Result<Vec<_>, _>>);
    let what = format_args!("cannot read the folder {}", folder.display());
    let entries = entries.or_input().context(what)?;
    let mut images: Vec<PathBuf> = entries
        .into_iter()
        .map(|entry| entry.path())
        // The name first: it costs no look at the file.
        .filter(|path| Format::from_path(path).is_some() && !is_hidden(path) && path.is_file())
        .collect();
    if images.is_empty() {
        let wanted = Format::extension_list();
        return Err(Failure::input(format!(
            "{} must contain at least one image ({wanted})",
            folder.display()
        )));
    }
    images.sort();
    Ok(images)
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

pub(crate) fn format_of(path: &Path) -> Result<Format> {
    Format::from_path(path).ok_or_else(|| {
        Failure::input(format!(
            "{}: extension must be one of {}",
            path.display(),
            Format::extension_list()
        ))
    })
}
