//! `uvgraft view`: an avatar or a mesh as one HTML file, opened in the browser.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft_assembly::mesh_file::MeshFile;
use uvgraft_assembly::render::Aim;
use uvgraft_assembly::{Input, ViewRequest};
use uvgraft_avatar::motion::UpAxis;
use uvgraft_pipeline::{Outputs, parse_memory};

use crate::choice::choice;
use crate::failure::{Notes, bad_input, note};
use crate::files;

/// Show an avatar, or a mesh with a texture, in the browser
///
/// Writes one HTML file that holds the avatar and the viewer, and opens it: orbit the camera, play
/// animations, choose poses, expressions and textures, and save screenshots. The page works
/// offline, without a server, and sends no data.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// GLB, VRM or glTF file, or a mesh (OBJ, PLY, body model)
    ///
    /// A part of a file, such as avatar.glb#Head, is shown alone, as a mesh. Compressed data and files beside
    /// a model are decoded and embedded into the page.
    #[arg(value_name = "AVATAR|MESH[#PART]")]
    model: PathBuf,
    /// HTML file to write [default: beside the avatar]
    #[arg(short, long, value_name = "OUT.html")]
    output: Option<PathBuf>,
    /// Texture of a mesh, or another one to offer for an avatar; repeatable
    ///
    /// A mesh is shown once for each texture, side by side, at most four times. The viewer offers the textures of
    /// an avatar to choose from; these must be PNG, JPEG or WebP files.
    #[arg(short, long, value_name = "IMAGE")]
    texture: Vec<PathBuf>,
    /// Up axis of a mesh [default: y]
    #[arg(long, value_name = "AXIS", value_parser = choice::<UpAxis>(), allow_hyphen_values = true)]
    up: Option<UpAxis>,
    /// Initial target of the camera
    ///
    /// A bone by its VRM name (leftHand), any node by its name, or a box given by two corners in
    /// metres.
    #[arg(long, value_name = "BONE|X0,Y0,Z0,X1,Y1,Z1", value_parser = Aim::parse, allow_hyphen_values = true)]
    look_at: Option<Aim>,
    /// Bound on memory, such as 500M or 4G [default: 1G and 200 times the size of the avatar]
    ///
    /// An avatar that could exceed it is refused.
    #[arg(long, value_name = "SIZE", value_parser = parse_memory, allow_negative_numbers = true)]
    memory: Option<u64>,
    /// Write the file without opening it
    #[arg(long)]
    no_open: bool,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let mut request = ViewRequest::new(&args.model);
    request.check()?;
    request.textures = args.texture.iter().map(Into::into).collect();
    request.up = args.up;
    request.look_at.clone_from(&args.look_at);
    request.memory = args.memory;
    let output = args.output.clone().unwrap_or_else(|| page_beside(&args.model));
    if !output.extension().is_some_and(|ending| {
        ["html", "htm"].iter().any(|wanted| ending.eq_ignore_ascii_case(wanted))
    }) {
        let name = output.display();
        return Err(bad_input(format!("{name}: extension must be .html")));
    }
    Outputs::new(request.inputs().filter_map(Input::path)).check(&output)?;
    let page = request.make(&Notes)?;
    files::write(&output, &page)?;
    if !args.no_open {
        if !can_open() {
            note("no display to open the page on; open it in a browser");
        } else if let Err(error) = open::that_detached(&output) {
            // The page exists, which is what was requested.
            note(format!("cannot open the page ({error}); open it in a browser"));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The page of a model or mesh, beside its file; that of a part has the part's name.
fn page_beside(model: &Path) -> PathBuf {
    let given = MeshFile::parse(&model.into());
    match given.file.path() {
        Some(path) if path != model => {
            path.with_file_name(given.name().replace(['#', '/', '\\', ':'], "_") + ".html")
        }
        _ => model.with_extension("html"),
    }
}

/// Whether there is a display, and someone to look at it.
fn can_open() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let needs_display = cfg!(all(unix, not(target_os = "macos")));
    !is_set("CI") && (!needs_display || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"))
}
