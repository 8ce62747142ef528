//! The plan of a transfer: which files it reads and writes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use uvgraft_io::image::Format;

use crate::base_source::BaseSource;
use crate::failure::{Blame, Failure, Result};
use crate::material::Values;
use crate::transfer::{Inputs, MaterialMap, Transfer};

/// A texture to transfer and its output.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    pub(crate) source: PathBuf,
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
pub(crate) struct Plan {
    pub(crate) batches: Vec<Batch>,
    pub(crate) new_folder: Option<PathBuf>,
}

impl Plan {
    pub(crate) fn new(transfer: &Transfer) -> Result<Self> {
        match &transfer.inputs {
            Inputs::Textures { sources, onto, values } => {
                let (jobs, new_folder) = jobs_of_textures(transfer, sources)?;
                let batch = Batch { values: *values, onto: onto.clone(), jobs };
                Ok(Self { batches: vec![batch], new_folder })
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
        let is_new = !folder.is_dir();
        let says_folder = folder.as_os_str().as_encoded_bytes().ends_with(b"/");
        if is_new && (folder.exists() || (Format::from_path(folder).is_some() && !says_folder)) {
            let folder = folder.display();
            return Err(Failure::input(format!(
                "with --map, the output must be a folder, got {folder}"
            )));
        }
        let mut batches: Vec<Batch> = Vec::with_capacity(maps.len());
        for MaterialMap { role, source, onto } in maps {
            let extension = match &transfer.format {
                Some(extension) => extension.clone(),
                None => source.extension().unwrap_or_default().to_string_lossy().into_owned(),
            };
            if Format::from_extension(&extension).is_none() {
                return Err(Failure::input(format!(
                    "{}: cannot infer the output format of the map {} from the file name; use \
                     --format, such as --format png",
                    source.display(),
                    role.name()
                )));
            }
            let output = folder.join(role.name()).with_extension(extension);
            let mut others = batches.iter().flat_map(|batch| &batch.jobs);
            if others.any(|job| job.output.file_stem() == output.file_stem()) {
                return Err(Failure::input(format!("--map {}: role given twice", role.name())));
            }
            let jobs = vec![Job { source: source.clone(), output }];
            batches.push(Batch { values: role.values(), onto: onto.clone(), jobs });
        }
        Ok(Self { batches, new_folder: is_new.then(|| folder.to_path_buf()) })
    }
}

/// One job for each texture, and the folder to create for them.
fn jobs_of_textures(
    transfer: &Transfer,
    sources: &[PathBuf],
) -> Result<(Vec<Job>, Option<PathBuf>)> {
    let output = &*transfer.output;
    for source in sources {
        // A path without an image extension usually means a missing folder.
        if Format::from_path(source).is_none() {
            source.metadata().or_input().map_err(|failure| failure.context(source.display()))?;
        }
    }
    let single = sources.len() == 1 && !sources[0].is_dir();
    let says_folder = output.as_os_str().as_encoded_bytes().ends_with(b"/");
    if single && !output.is_dir() && !says_folder {
        let format = format_of(output)?;
        if let Some(name) = transfer.format.as_deref()
            && Format::from_extension(name) != Some(format)
        {
            let output = output.display();
            return Err(Failure::input(format!(
                "--format {name} contradicts the extension of the output {output}"
            )));
        }
        let job = Job { source: sources[0].clone(), output: output.to_path_buf() };
        return Ok((vec![job], None));
    }
    let is_new = !output.is_dir();
    let says_file = Format::from_path(output).is_some() && !says_folder;
    if is_new && (output.exists() || says_file) {
        return Err(Failure::input(format!(
            "with several textures or a folder, the output must be a folder, got {}",
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
        let name = match &transfer.format {
            Some(format) => name.with_extension(format),
            None => name,
        };
        let output = output.join(&name);
        if Format::from_path(&name).is_none() {
            return Err(Failure::input(format!(
                "{}: cannot infer the format of the output {} from the file name; use --format, \
                 such as --format png",
                source.display(),
                output.display()
            )));
        }
        if let Some(other) = taken.insert(output.clone(), source.clone()) {
            let (other, source) = (other.display(), source.display());
            return Err(Failure::input(format!(
                "{other} and {source} have the same output {}",
                output.display()
            )));
        }
        jobs.push(Job { source, output });
    }
    Ok((jobs, is_new.then(|| output.to_path_buf())))
}

/// The image files of a folder, recognised by extension and sorted. Hidden files are skipped: some
/// systems put a `._face.png`, which is not an image, next to each `face.png`.
///
/// # Errors
/// As bad input if the folder cannot be read or has no images.
pub fn images_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = folder.read_dir().and_then(Iterator::collect::<std::result::Result<Vec<_>, _>>);
    let entries = entries.or_input().map_err(|failure| {
        failure.context(format_args!("cannot read the folder {}", folder.display()))
    })?;
    let mut images: Vec<PathBuf> = entries
        .into_iter()
        .map(|entry| entry.path())
        .filter(|path| path.is_file() && Format::from_path(path).is_some() && !is_hidden(path))
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
