//! Writes the seeds of all targets, a folder for each, and prints the names of the targets:
//! `cargo run -p uvgraft-fuzz --example seeds -- FOLDER`.

#![expect(clippy::print_stdout, reason = "the names are the output")]

use std::path::PathBuf;
use std::{env, fs, io};

use uvgraft_fuzz::TARGETS;

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.ok_or_else(|| io::Error::other("usage: seeds FOLDER"))?;
    for target in TARGETS {
        fs::create_dir_all(folder.join(target.name))?;
        for (index, seed) in (target.seeds)().iter().enumerate() {
            fs::write(folder.join(target.name).join(format!("seed-{index}")), seed)?;
        }
        println!("{}", target.name);
    }
    Ok(())
}
