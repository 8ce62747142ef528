//! `uvgraft view`: an avatar as one HTML file, opened in the browser.

use std::convert::Infallible;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft_gltf::scene::{PoseRequest, Scene};
use uvgraft_io::image::{self, ImageError};
use uvgraft_io::input::{Input, ReadError};
use uvgraft_io::output;
use uvgraft_pipeline::Outputs;
use uvgraft_render::Bounds;
use uvgraft_viewer::{Glb, LookAt, PAGE, Page, Picture, Template};

use crate::failure::{OrBadInput, bad_input, note};
use crate::render::{Aim, aim};
use crate::terminal;

/// Show a GLB, VRM or glTF file in the browser
///
/// Writes one HTML file that holds the avatar and the viewer, and opens it: orbit the camera, play
/// animations, choose poses, expressions and textures, and save screenshots. The page works
/// offline, without a server, and sends no data.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// GLB, VRM or glTF file
    ///
    /// Compressed data and files beside the model are decoded and embedded into the page.
    #[arg(value_name = "AVATAR")]
    model: PathBuf,
    /// HTML file to write [default: beside the avatar]
    #[arg(short, long, value_name = "OUT.html")]
    output: Option<PathBuf>,
    /// Alternative texture to offer in the viewer (PNG, JPEG or WebP); repeatable
    #[arg(long = "texture", value_name = "FILE")]
    textures: Vec<PathBuf>,
    /// Initial target of the camera
    ///
    /// A bone by its VRM name (leftHand), any node by its name, or a box given by two corners in
    /// metres.
    #[arg(long, value_name = "BONE|X0,Y0,Z0,X1,Y1,Z1", value_parser = aim, allow_hyphen_values = true)]
    look_at: Option<Aim>,
    /// Write the file without opening it
    #[arg(long)]
    no_open: bool,
}

/// Browsers limit strings to about half a gigabyte, and base64 is a third longer than its input.
const MAX_MODEL_BYTES: u64 = 256 << 20;
const MAX_TEXTURE_BYTES: u64 = 64 << 20;

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let Some(page) = PAGE else {
        return Err(bad_input(
            "this build has no viewer; in the sources, run scripts/build-viewer.sh (needs npm), \
             then cargo install --path crates/uvgraft-cli --features viewer",
        ));
    };
    let template = Template::new(page)?;
    let output = args.output.clone().unwrap_or_else(|| args.model.with_extension("html"));
    if !output.extension().is_some_and(|ending| {
        ["html", "htm"].iter().any(|wanted| ending.eq_ignore_ascii_case(wanted))
    }) {
        let name = output.display();
        return Err(bad_input(format!("{name}: extension must be .html")));
    }
    let inputs = args.textures.iter().chain([&args.model]).map(PathBuf::as_path);
    Outputs::new(inputs).check(&output)?;

    // Whole and uncompressed, so that the page needs neither files next to it nor decoders.
    let bytes = uvgraft_gltf::scene::whole(&args.model).or_bad_input()?;
    if bytes.len() as u64 > MAX_MODEL_BYTES {
        let (name, found) = (args.model.display(), bytes.len());
        return Err(bad_input(format!(
            "{name}: must have at most {MAX_MODEL_BYTES} bytes uncompressed, got {found}"
        )));
    }
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let in_model = || format!("cannot show {}", args.model.display());
    let model = Glb::new(&bytes).with_context(in_model).or_bad_input()?;
    // What the renderer rejects, the viewer cannot show either.
    let scene = Scene::read(&bytes).with_context(in_model).or_bad_input()?;
    let look_at = match &args.look_at {
        Some(Aim::Named(name)) => {
            scene.extent(name, &PoseRequest::default()).with_context(in_model).or_bad_input()?;
            Some(LookAt::Named(name))
        }
        Some(Aim::Box(Bounds { low: [a, b, c], high: [d, e, f] })) => {
            Some(LookAt::Box([*a, *b, *c, *d, *e, *f]))
        }
        Some(Aim::Shot(_)) | None => None,
    };
    let files = args
        .textures
        .iter()
        .map(|path| Ok((path, name(path), read(path, MAX_TEXTURE_BYTES)?)))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let textures = files
        .iter()
        .map(|(path, name, bytes)| {
            let picture = Picture::new(bytes).ok_or_else(|| {
                bad_input(format!(
                    "{}: not an image; must be {}",
                    path.display(),
                    Picture::EXTENSIONS
                ))
            })?;
            // Browsers show formats that are unsupported here, but nothing of a damaged file.
            match image::decode(bytes) {
                Err(error @ (ImageError::Truncated { .. } | ImageError::Damaged { .. })) => {
                    Err(bad_input(format!("{}: {error}", path.display())))
                }
                _ => Ok((name.as_str(), picture)),
            }
        })
        .collect::<anyhow::Result<Vec<_>>>()?;
    let page = Page { name: &name(&args.model), model, textures, look_at };
    output::write_atomically::<io::Error>(&output, |out| page.write(&template, out))
        .with_context(|| format!("cannot write {}", output.display()))?;

    terminal::print(&format!("wrote {}\n", terminal::path(&output)))?;
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

/// The page of an avatar built by this program; `None` in builds without the viewer.
pub(crate) fn page(name: &str, glb: &[u8]) -> anyhow::Result<Option<Vec<u8>>> {
    let Some(page) = PAGE else { return Ok(None) };
    let page_of = Page { name, model: Glb::new(glb)?, textures: Vec::new(), look_at: None };
    let mut bytes = Vec::new();
    page_of.write(&Template::new(page)?, &mut bytes)?;
    Ok(Some(bytes))
}

fn read(path: &Path, max: u64) -> anyhow::Result<Vec<u8>> {
    let all = |bytes: &[u8]| Ok(bytes.to_vec());
    Input::from(path)
        .parse::<_, Infallible>(max, all)
        .map_err(|error: ReadError<Infallible>| error)
        .or_bad_input()
}

/// Whether there is a display, and someone to look at it.
fn can_open() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let needs_display = cfg!(all(unix, not(target_os = "macos")));
    !is_set("CI") && (!needs_display || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"))
}
