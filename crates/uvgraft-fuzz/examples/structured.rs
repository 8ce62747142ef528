//! Writes the file that a target builds of choices, such as those in an input that `make fuzz` found:
//! `cargo run -p uvgraft-fuzz --example structured -- TARGET CHOICES FILE`.

use std::{env, fs, io};

use uvgraft_fuzz::target;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [name, choices, file] = &arguments[..] else {
        return Err(io::Error::other("usage: structured TARGET CHOICES FILE"));
    };
    let make = target(name).and_then(|target| target.file);
    let make =
        make.ok_or_else(|| io::Error::other(format!("{name} must be a target by structure")))?;
    fs::write(file, make(&fs::read(choices)?))
}
