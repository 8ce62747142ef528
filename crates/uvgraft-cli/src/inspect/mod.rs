//! `uvgraft inspect`: the contents of a pair file, and of a mesh.

mod layout_picture;
mod mesh;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft_io::pair_file;
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input, warn};
use crate::{recognition, report};
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::pair_picture;

/// Print the report of a pair file or of a mesh
///
/// `uvgraft inspect PAIR` is for pair files, `uvgraft inspect mesh MESH` for meshes.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    subject: Option<Subject>,
    /// Pair file to inspect
    #[arg(required = true)]
    pair: Option<PathBuf>,
    /// Draw both layouts, with linked triangles in matching colours
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sizes: report::Sizes,
}

#[derive(clap::Subcommand)]
enum Subject {
    Mesh(mesh::Args),
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match (&args.subject, &args.pair) {
        (Some(Subject::Mesh(args)), _) => mesh::run(args),
        (None, Some(pair)) => inspect_pair(args, pair),
        // clap asks for one of the two.
        (None, None) => anyhow::bail!("no pair file given"),
    }
}

fn inspect_pair(args: &Args, pair: &Path) -> anyhow::Result<ExitCode> {
    if let Some(preview) = &args.preview {
        check_name(preview, "a preview")?;
        Outputs::new([pair]).check(preview)?;
    }
    let file = match pair_file::read(pair) {
        Err(error) if is_named_like_a_mesh(pair) => {
            let error = anyhow::Error::new(error);
            return Err(bad_input(format!("{error:#}; to inspect a mesh, use `inspect mesh`")));
        }
        read => read.or_bad_input()?,
    };
    report::print(&file, &report::of_pair(&file, &args.sizes), args.json)?;
    let names = [&*file.source_name, &*file.target_name];
    recognition::pairing_warnings([file.pair.source(), file.pair.target()], names)
        .into_iter()
        .for_each(warn);
    if let Some(path) = &args.preview {
        pair_picture::of_pair(&file, None)?.write(path)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn is_named_like_a_mesh(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    ["obj", "glb", "gltf", "ply"].iter().any(|mesh| extension == *mesh)
}
