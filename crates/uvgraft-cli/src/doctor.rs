//! `uvgraft doctor`: what a problem report should contain, and what files may be used for.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;
use uvgraft_avatar::body::{ModelFile, ReadOptions};
use uvgraft_files::input::Input;
use uvgraft_gltf::container::{ContainerError, Glb};
use uvgraft_image::{MAX_BYTES, MAX_WHOLE_TEXELS};
use uvgraft_io::pair_file;
use uvgraft_metrics::lpips::LpipsNetwork;

use crate::failure::{OrBadInput, bad_input};
use crate::{outcome, terminal, version, weights};

/// Show the version, the environment and the licences of files
///
/// Prints the version, the optional features, threads and memory, the networks that were imported,
/// and, for each file given, the terms that it states: the note of a pair, the licence of a body
/// model, or the copyright of an avatar. Please include the output in problem reports.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Pairs, body models and avatars whose licences to show
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
}

#[derive(Serialize)]
struct Document<'a> {
    rows: &'a [Row],
}

/// A row of the report.
#[derive(Serialize)]
struct Row {
    name: String,
    value: String,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let mut rows: Vec<Row> = Vec::new();
    let mut row = |name: &str, value: String| rows.push(Row { name: name.to_owned(), value });
    version::rows().into_iter().for_each(|(name, value)| row(name, value));
    row("threads", rayon::current_num_threads().to_string());
    row("memory", memory());
    row(
        "images",
        format!(
            "up to {} GiB decoded; WebP up to {} million texels",
            MAX_BYTES >> 30,
            MAX_WHOLE_TEXELS / 1_000_000
        ),
    );
    row("networks for LPIPS", lpips());
    row("networks for faces", faces());
    for file in &args.files {
        row(&file.display().to_string(), terms(file)?);
    }
    outcome::report(
        || Document { rows: &rows },
        || {
            let mut text = String::new();
            for Row { name, value } in &rows {
                let _ =
                    writeln!(text, "{:<20} {}", terminal::inline(name), terminal::inline(value));
            }
            text
        },
    )?;
    Ok(ExitCode::SUCCESS)
}

/// The memory of the machine, and of it what the process may use, where the system tells.
fn memory() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let info = read("/proc/meminfo");
    let total = info.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let total = total.and_then(|text| text.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    let limit: Option<u64> = read("/sys/fs/cgroup/memory.max").trim().parse().ok();
    let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30));
    let mut text = "2 GiB for textures in parallel, unless --memory bounds all".to_owned();
    if let Some(kib) = total {
        let _ = write!(text, "; the machine has {}", gib(kib << 10));
    }
    if let Some(limit) = limit {
        let _ = write!(text, ", of which {} are allowed", gib(limit));
    }
    text
}

fn lpips() -> String {
    match weights::lpips(LpipsNetwork::Alex) {
        Ok(Some(_)) => "imported (BSD-2-Clause)".to_owned(),
        Ok(None) => "not imported".to_owned(),
        Err(error) => format!("unusable: {error:#}"),
    }
}

fn faces() -> String {
    match uvgraft_assembly::weights::face_models() {
        Ok(Some(models)) if models.iris.is_some() => {
            "imported, with the iris network (Apache-2.0)".to_owned()
        }
        Ok(Some(_)) => "imported, without the iris network (Apache-2.0)".to_owned(),
        Ok(None) => "not imported".to_owned(),
        Err(error) => format!("unusable: {error:#}"),
    }
}

/// The terms that a file states.
fn terms(path: &Path) -> anyhow::Result<String> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let stated = match extension.to_str().unwrap_or_default() {
        "uvpair" => {
            let file = pair_file::read(path).or_bad_input()?;
            let (source, target) = (&file.source_name, &file.target_name);
            let note = Some(file.note.clone()).filter(|note| !note.is_empty());
            return Ok(format!(
                "pair of {source} and {target}; {}",
                note.map_or("no note of their owners".to_owned(), |note| format!("note: {note}"))
            ));
        }
        "npz" | "pkl" => {
            let options = ReadOptions { betas: 1, correctives: false };
            ModelFile::read(path, &options).or_bad_input()?.license
        }
        "glb" | "vrm" => {
            const MAX_BYTES: u64 = 1 << 30;
            Input::from(path).parse(MAX_BYTES, copyright).or_bad_input()?
        }
        _ => {
            return Err(bad_input(format!(
                "{}: must be a pair (.uvpair), a body model (.npz, .pkl) or an avatar (.glb, .vrm)",
                path.display()
            )));
        }
    };
    Ok(stated.unwrap_or_else(|| "states no licence; ask where it is from".to_owned()))
}

/// The copyright of a binary glTF file, and the licence of a VRM.
fn copyright(bytes: &[u8]) -> Result<Option<String>, ContainerError> {
    let container = Glb::read(bytes)?;
    let json: serde_json::Value = serde_json::from_slice(container.json).unwrap_or_default();
    let texts = [
        json.pointer("/asset/copyright"),
        json.pointer("/extensions/VRMC_vrm/meta/copyrightInformation"),
        json.pointer("/extensions/VRMC_vrm/meta/licenseUrl"),
        json.pointer("/extensions/VRM/meta/licenseName"),
    ];
    let mut stated: Vec<&str> = texts.into_iter().flatten().filter_map(|it| it.as_str()).collect();
    stated.dedup();
    Ok((!stated.is_empty()).then(|| stated.join("; ")))
}
