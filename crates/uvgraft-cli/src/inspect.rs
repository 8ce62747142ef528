//! `uvgraft inspect`: the contents of a pair file.

use std::path::PathBuf;
use std::process::ExitCode;

use uvgraft_io::pair_file;
use uvgraft_pipeline::Outputs;

use crate::failure::OrBadInput;
use crate::picture::check_name;
use crate::{preview, report};

/// Print the report of a pair file
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Pair file to inspect
    pair: PathBuf,
    /// Draw both layouts, with linked triangles in matching colours
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sizes: report::Sizes,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(preview) = &args.preview {
        check_name(preview, "a preview")?;
        Outputs::new([&*args.pair]).check(preview)?;
    }
    let file = pair_file::read(&args.pair).or_bad_input()?;
    report::print(&file, &args.sizes, args.json)?;
    if let Some(path) = &args.preview {
        preview::write(&file, path)?;
    }
    Ok(ExitCode::SUCCESS)
}
