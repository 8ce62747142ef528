//! What a transfer reads and writes: one file, several, or a folder of them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use uvgraft_io::image::Format;

use super::Args;
use super::treatment::RoleFile;
use crate::failure::{OrBadInput, bad_input};

/// A texture to carry and where its result goes.
pub(super) struct Job {
    pub(super) source: PathBuf,
    pub(super) output: PathBuf,
}

impl Job {
    /// Whether its output is there and newer than its source and than all of `shared`.
    pub(super) fn is_done<'a>(&'a self, shared: impl IntoIterator<Item = &'a Path>) -> bool {
        let changed = |path: &Path| path.metadata().and_then(|found| found.modified()).ok();
        let Some(written) = changed(&self.output).filter(|_| self.output.is_file()) else {
            return false;
        };
        let mut inputs = shared.into_iter().chain([&*self.source]);
        inputs.all(|input| changed(input).is_some_and(|changed| changed < written))
    }
}

/// What is to be done, and the folder that has to be made for it.
pub(super) struct Plan<'a> {
    pub(super) jobs: Vec<Job>,
    pub(super) new_folder: Option<&'a Path>,
}

impl<'a> Plan<'a> {
    /// One job, or one for each of several sources or each image of a folder.
    pub(super) fn new(args: &'a Args) -> anyhow::Result<Self> {
        let (sources, output) = (&args.sources, &*args.output);
        let single = sources.len() == 1 && !sources[0].is_dir();
        let says_folder = output.as_os_str().as_encoded_bytes().ends_with(b"/");
        if single && !output.is_dir() && !says_folder {
            let format = format_of(output)?;
            if let Some(name) = args.format.as_deref()
                && Format::from_extension(name) != Some(format)
            {
                let output = output.display();
                return Err(bad_input(format!("--format {name} contradicts the output {output}")));
            }
            let job = Job { source: sources[0].clone(), output: output.to_path_buf() };
            return Ok(Self { jobs: vec![job], new_folder: None });
        }
        let is_new = !output.is_dir();
        let says_file = Format::from_path(output).is_some() && !says_folder;
        if is_new && (output.exists() || says_file) {
            return Err(bad_input(format!(
                "output {} is no folder; several sources are written into one",
                output.display()
            )));
        }
        let mut paths = Vec::new();
        for source in sources {
            if source.is_dir() {
                paths.extend(images_in(source)?);
            } else {
                paths.push(source.clone());
            }
        }
        let mut taken: HashMap<PathBuf, PathBuf> = HashMap::new();
        let mut jobs = Vec::with_capacity(paths.len());
        for source in paths {
            let name = source.file_name().map(PathBuf::from).unwrap_or_default();
            let name = match &args.format {
                Some(format) => name.with_extension(format),
                None => name,
            };
            let output = output.join(&name);
            if Format::from_path(&name).is_none() {
                return Err(bad_input(format!(
                    "{}: its name says no format to write {} in; say --format png, for instance",
                    source.display(),
                    output.display()
                )));
            }
            if let Some(other) = taken.insert(output.clone(), source.clone()) {
                let (other, source) = (other.display(), source.display());
                return Err(bad_input(format!(
                    "{other} and {source} would both become {}",
                    output.display()
                )));
            }
            jobs.push(Job { source, output });
        }
        Ok(Self { jobs, new_folder: is_new.then_some(output) })
    }
}

/// One job for each map of a material, each named for its role, in the format of its file; and the folder
/// that has to be made for them.
pub(super) fn of_maps(args: &Args) -> anyhow::Result<(Vec<Job>, Option<&Path>)> {
    let folder = &*args.output;
    let is_new = !folder.is_dir();
    let says_folder = folder.as_os_str().as_encoded_bytes().ends_with(b"/");
    if is_new && (folder.exists() || (Format::from_path(folder).is_some() && !says_folder)) {
        let folder = folder.display();
        return Err(bad_input(format!("output {folder} is no folder; maps are written into one")));
    }
    let mut jobs: Vec<Job> = Vec::with_capacity(args.maps.len());
    for RoleFile { role, path } in &args.maps {
        let extension = match &args.format {
            Some(extension) => extension.clone(),
            None => path.extension().unwrap_or_default().to_string_lossy().into_owned(),
        };
        if Format::from_extension(&extension).is_none() {
            return Err(bad_input(format!(
                "{}: its name says no format to write {role} in; say --format png, for instance",
                path.display()
            )));
        }
        let output = folder.join(role).with_extension(extension);
        if jobs.iter().any(|job| job.output.file_stem() == output.file_stem()) {
            return Err(bad_input(format!("--map {role}= is given twice")));
        }
        jobs.push(Job { source: path.clone(), output });
    }
    Ok((jobs, is_new.then_some(folder)))
}

/// The files of a folder whose names say that they are images, sorted. Hidden ones are left out:
/// some systems put a `._face.png`, which is no image, beside each `face.png`.
fn images_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = folder.read_dir().and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries
        .with_context(|| format!("cannot read the folder {}", folder.display()))
        .or_bad_input()?;
    let mut images: Vec<PathBuf> = entries
        .into_iter()
        .map(|entry| entry.path())
        .filter(|path| path.is_file() && Format::from_path(path).is_some() && !is_hidden(path))
        .collect();
    if images.is_empty() {
        let wanted = Format::extension_list();
        return Err(bad_input(format!("{} holds no image ({wanted})", folder.display())));
    }
    images.sort();
    Ok(images)
}

fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

pub(super) fn format_of(path: &Path) -> anyhow::Result<Format> {
    Format::from_path(path).ok_or_else(|| {
        bad_input(format!(
            "{}: wanted a name that ends in {}",
            path.display(),
            Format::extension_list()
        ))
    })
}
