//! `uvgraft selfie`: the texture and the shape of a head from photographs.

mod cameras;
mod frames;
mod made;
mod networks;
mod options;
mod photo;
mod sheet;
mod summary;
mod tracked;
mod window;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use uvgraft::{Mesh, Size, Texture};
use uvgraft_figure::Figure;
use uvgraft_io::image::{self, WriteOptions};
use uvgraft_io::obj;
use uvgraft_pipeline::Outputs;

use crate::failure::{bad_input, warn};
use crate::heading;
use crate::mesh_file::{self, MeshFile};
use crate::picture::check_name;
use crate::report::parse_size;
use crate::terminal;
pub(crate) use frames::Frames;
pub(crate) use made::{GivenHead, Selfie};
pub(crate) use options::PhotoArgs;

/// Make a head texture from photographs of a face
///
/// Finds the face in one photograph or several of the same person, fits the head's shape to it, and
/// projects the photographs onto the head's UV layout. What they do not show is mirrored or filled.
///
/// The networks that find faces have to be imported once: see `uvgraft weights --help`.
///
/// Outputs contain nothing of the photographs' metadata: no EXIF, no location, no file names.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Photographs of the same person, or a folder of frames
    #[arg(required = true, value_name = "PHOTO")]
    photos: Vec<PathBuf>,
    /// Mesh with a head and UV coordinates, or `demo` for the built-in figure
    ///
    /// An OBJ, PLY, GLB or glTF file, or a body model (NPZ, pickle): a head, a bust or a whole body.
    #[arg(long, value_name = "MESH|demo", help_heading = heading::FILES)]
    head: PathBuf,
    /// Texture to write, in the head's UV layout
    #[arg(short, long, value_name = "OUT.png", help_heading = heading::FILES)]
    output: PathBuf,
    /// Size of the texture in texels
    #[arg(long, default_value = "2048", value_name = "N|WxH", value_parser = parse_size)]
    #[arg(allow_negative_numbers = true, help_heading = heading::FILES)]
    size: Size,
    /// Also write what the photographs show, white where a texel is known fully
    #[arg(long, value_name = "OUT.png", help_heading = heading::FILES)]
    known: Option<PathBuf>,
    /// Also write the head with the fitted shape
    #[arg(long, value_name = "OUT.obj", help_heading = heading::FILES)]
    mesh: Option<PathBuf>,
    /// Also write the cameras as JSON
    ///
    /// For each photograph: rotation (by rows) and translation from the head's space to the camera's,
    /// whose x points to the right, y down and z forwards; focal length and centre in pixels, where the
    /// centre of the first pixel is at 0.5; size of the photograph; and the median distance of the
    /// landmarks from those of the fitted head.
    #[arg(long, value_name = "OUT.json", help_heading = heading::FILES)]
    cameras: Option<PathBuf>,
    /// Also draw a contact sheet: landmarks, fit, coverage and result
    #[arg(long, value_name = "OUT.png", help_heading = heading::FILES)]
    sheet: Option<PathBuf>,
    #[command(flatten)]
    photographs: PhotoArgs,
}

/// Largest number of texels of a texture: each needs some 150 bytes while it is made.
const MOST_TEXELS: usize = 4096 * 4096;

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let frames = args.check()?;
    let (mesh, name) = read_head(&args.head)?;
    let flame = tracked::flame(&args.head);
    let head = GivenHead { mesh, name: &name, flame: flame.as_ref() };
    let selfie = Selfie::new(head, &frames, &args.photographs, args.size)?;
    let mut text = selfie.text(&name);
    save(&selfie.made.texture, &args.output)?;
    text += &summary::output("texture", &args.output);
    if let Some(path) = &args.known {
        save(&selfie.made.known, path)?;
        text += &summary::output("known texels", path);
    }
    if let Some(path) = &args.mesh {
        obj::save(&selfie.shaped_mesh()?, path)
            .with_context(|| format!("cannot write {}", path.display()))?;
        text += &summary::output("shape", path);
    }
    if let Some(path) = &args.cameras {
        cameras::write(&selfie, path)?;
        text += &summary::output("cameras", path);
    }
    if let Some(path) = &args.sheet {
        sheet::write(&selfie, path)?;
        text += &summary::output("contact sheet", path);
    }
    selfie.warn();
    terminal::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// Rejects inputs that are missing and outputs that cannot be written.
    fn check(&self) -> anyhow::Result<Frames> {
        check_name(&self.output, "a texture")?;
        for (path, what) in [(&self.known, "a mask"), (&self.sheet, "a contact sheet")] {
            path.iter().try_for_each(|path| check_name(path, what))?;
        }
        for (path, extension) in [(&self.mesh, "obj"), (&self.cameras, "json")] {
            if let Some(path) = path
                && !path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
            {
                return Err(bad_input(format!(
                    "{}: extension must be .{extension}",
                    path.display()
                )));
            }
        }
        if self.size.texels() > MOST_TEXELS {
            let found = self.size;
            return Err(bad_input(format!("--size must be at most 4096×4096 texels, got {found}")));
        }
        let frames = Frames::new(&self.photos, &self.photographs)?;
        let head = MeshFile::parse(&self.head).path;
        frames.check()?;
        let mut outputs = Outputs::new(frames.files().chain([&*head]));
        let optional = [&self.known, &self.mesh, &self.cameras, &self.sheet];
        for path in [&self.output].into_iter().chain(optional.into_iter().flatten()) {
            outputs.check(path)?;
        }
        Ok(frames)
    }
}

/// The mesh, and what to call it.
fn read_head(path: &Path) -> anyhow::Result<(Mesh, String)> {
    if path == Path::new("demo") {
        return Ok((Figure::new().head, "the demo's figure".to_owned()));
    }
    let loaded = mesh_file::read(path)?;
    Ok((loaded.mesh, loaded.name))
}

fn save(texture: &Texture, path: &Path) -> anyhow::Result<()> {
    let written = image::write(&texture.clone().into(), path, &WriteOptions::default())
        .with_context(|| format!("cannot write {}", path.display()))?;
    written.losses.iter().for_each(|loss| warn(format_args!("{}: {loss}", path.display())));
    Ok(())
}
