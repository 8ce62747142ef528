//! The painted skin of bodies in the open body's layout.

use uvgraft::{Size, Texture};
use uvgraft_avatar::body::{ModelFile, ReadOptions, Shape};
use uvgraft_files::input::Input;
use uvgraft_io::model_mesh;
use uvgraft_open_body::skin::{SkinOptions, SkinTone, paint_skin};
use uvgraft_pipeline::{Blame, Failure, Result};

/// Colour of the hair cap.
pub const HAIR: [f32; 3] = [0.17, 0.115, 0.085];

/// The skin of the open body in a usual tone; `None` for other models.
pub(crate) fn usual(model: &Input, size: Size) -> Result<Option<Texture>> {
    /// Light brown. An avatar's skin takes on the tone of its face anyway.
    const TONE: f32 = 0.35;
    match model_mesh::read(model) {
        Ok(mesh) if !mesh.parts().is_empty() => {
            let mut options = SkinOptions::new(SkinTone::on_scale(TONE));
            options.hair = Some(HAIR);
            painted(model, size, &options).map(Some)
        }
        _ => Ok(None),
    }
}

/// The skin of a model file in the open body's layout.
///
/// # Errors
/// As bad input for files that cannot be read, and for other models.
pub fn painted(model: &Input, size: Size, options: &SkinOptions) -> Result<Texture> {
    let mesh = model_mesh::read(model).or_input()?;
    if mesh.parts().is_empty() {
        return Err(Failure::input(format!(
            "{model}: must be the open body, which has named parts"
        )));
    }
    let needs = ReadOptions { betas: 0, correctives: false };
    let file = ModelFile::read(model, &needs).or_input()?;
    let body = file.model.shaped(&Shape::default()).or_input()?;
    if file.model.kind().name() != "SMPL-X" {
        return Err(Failure::input(format!("{model}: must be the open body")));
    }
    Ok(paint_skin(&mesh, &body, size, options))
}
