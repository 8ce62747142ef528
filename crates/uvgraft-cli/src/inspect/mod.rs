//! `uvgraft inspect`: the contents of a pair file, of an avatar, and of a mesh.

mod avatar;
mod layout_picture;
mod mesh;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft_io::pair_file;
use uvgraft_pipeline::Outputs;

use crate::failure::{OrBadInput, bad_input, warn};
use crate::outcome;
use crate::report::{self, grouped};
use uvgraft_assembly::drawing::check_name;
use uvgraft_assembly::mesh_file;
use uvgraft_assembly::pair_picture;
use uvgraft_assembly::recognition;

/// Print the report of a pair file, an avatar or a mesh
///
/// `uvgraft inspect PAIR` is for pair files, `uvgraft inspect AVATAR` for GLB, VRM and glTF files: their
/// parts, images, skeleton, expressions and animations. `uvgraft inspect mesh MESH` is for meshes and
/// their UV layouts.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    subject: Option<Subject>,
    /// Pair file, or GLB, VRM or glTF file, to inspect
    #[arg(required = true)]
    pair: Option<PathBuf>,
    /// Draw both layouts of a pair, with linked triangles in matching colours
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
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
    if avatar::is_avatar(pair) {
        if args.preview.is_some() {
            let pair = pair.display();
            return Err(bad_input(format!(
                "{pair}: --preview is for pair files, got an avatar; for its UV layout, use \
                 `inspect mesh --preview`, for a picture of it `render`"
            )));
        }
        avatar::print(pair)?;
        return Ok(ExitCode::SUCCESS);
    }
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
    let recognised = recognition::recognised(&file);
    if let Some(path) = &args.preview {
        pair_picture::of_pair(&file, None)?.write(path)?;
        outcome::wrote(path);
    }
    report::print(&file, None, &recognised, &report::of_pair(&file, &args.sizes))?;
    recognition::pairing_warnings(&file, &recognised).into_iter().for_each(warn);
    Ok(ExitCode::SUCCESS)
}

/// As many names as fit a line.
fn listed(names: &[String]) -> String {
    const LENGTH: usize = 64;
    let mut text = String::new();
    for (index, name) in names.iter().enumerate() {
        if index > 0 && text.chars().count() + name.chars().count() > LENGTH {
            let _ = write!(text, " and {} more", grouped(names.len() - index));
            break;
        }
        let _ = write!(text, "{}{name}", if index > 0 { ", " } else { "" });
    }
    text
}

fn is_named_like_a_mesh(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    mesh_file::EXTENSIONS.iter().any(|mesh| extension == *mesh)
}
