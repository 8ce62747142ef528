//! `uvgraft selfie`: the texture and the shape of a head from photographs.

mod options;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use uvgraft::{Size, Texture};
use uvgraft_assembly::drawing::{self, check_name};
use uvgraft_assembly::selfie::Head;
use uvgraft_assembly::{Input, SelfieRequest};
use uvgraft_image::{self as image, WriteOptions};
use uvgraft_io::obj;
use uvgraft_pipeline::Outputs;

pub(crate) use self::options::PhotoArgs;
use crate::failure::{Notes, warn};
use crate::files::{self, OrCannotWrite, check_extension};
use crate::heading;
use crate::outcome;
use crate::report::parse_size;

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

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let request = args.request();
    args.check(&request)?;
    let fitted = request.make(&Notes)?;
    save(fitted.texture(), &args.output)?;
    if let Some(path) = &args.known {
        save(fitted.known(), path)?;
    }
    if let Some(path) = &args.mesh {
        obj::save(&fitted.shaped_mesh()?, path).or_cannot_write(path)?;
        outcome::wrote(path);
    }
    if let Some(path) = &args.cameras {
        files::write(path, fitted.cameras_json()?.as_bytes())?;
    }
    if let Some(path) = &args.sheet {
        drawing::write(fitted.sheet()?, path)?;
        outcome::wrote(path);
    }
    fitted.warn(&Notes);
    let figures = fitted.figures();
    outcome::report(|| &figures, || figures.to_string())?;
    if let Some(mesh) = args.mesh.as_ref().or(Some(&args.head).filter(|head| head.is_file())) {
        outcome::look_by_picture(mesh, Some(&args.output), true);
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// The selfie that the options describe.
    fn request(&self) -> SelfieRequest {
        let head = match &*self.head {
            demo if demo == Path::new("demo") => Head::Figure,
            file => Head::File(file.into()),
        };
        let mut request = SelfieRequest::new(head, &self.photos);
        request.size = self.size;
        request.photo_options = self.photographs.options();
        request
    }

    /// Rejects inputs that are missing and outputs that cannot be written.
    fn check(&self, request: &SelfieRequest) -> anyhow::Result<()> {
        check_name(&self.output, "a texture")?;
        for (path, what) in [(&self.known, "a mask"), (&self.sheet, "a contact sheet")] {
            path.iter().try_for_each(|path| check_name(path, what))?;
        }
        for (path, extension) in [(&self.mesh, "obj"), (&self.cameras, "json")] {
            path.iter().try_for_each(|path| check_extension(path, &[extension]))?;
        }
        request.check()?;
        let inputs = request.inputs()?;
        let mut outputs = Outputs::new(inputs.iter().filter_map(Input::path));
        let optional = [&self.known, &self.mesh, &self.cameras, &self.sheet];
        for path in [&self.output].into_iter().chain(optional.into_iter().flatten()) {
            outputs.check(path)?;
        }
        Ok(())
    }
}

fn save(texture: &Texture, path: &Path) -> anyhow::Result<()> {
    let written = image::write(&texture.clone().into(), path, &WriteOptions::default());
    let written = written.or_cannot_write(path)?;
    written.losses.iter().for_each(|loss| warn(format_args!("{}: {loss}", path.display())));
    outcome::wrote(path);
    Ok(())
}
