//! An avatar of a photograph for the demo.

use std::path::{Path, PathBuf};

use uvgraft::{Averaging, Channels, Depth, Filter, Size, Texture};
use uvgraft_assembly::drawing::Sheet;
use uvgraft_assembly::{AvatarRequest, Body, weights};
use uvgraft_figure::Figure;
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_render::View;

use super::avatar::{Studio, body, head};
use super::views::render;
use super::{fetched, row};
use crate::failure::{Notes, OrBadInput};

/// The photograph that scripts fetch, of the astronaut Eileen Collins, by NASA.
pub(super) const ASTRONAUT: &str = "photographs/astronaut.png";

/// File of the figure's photograph.
pub(super) const PORTRAIT: &str = "photo.png";

const PANEL: Size = Size::new(400, 540);

/// The photograph to use; `None` without networks that find faces.
///
/// - `given`: if one is asked for.
/// - `texture`: of the figure's body; a photograph of it is written to `folder` if there is no other.
pub(super) fn photo(
    given: Option<&Path>,
    figure: &Figure,
    texture: &Texture,
    folder: &Path,
) -> anyhow::Result<Option<PathBuf>> {
    if let Some(path) = given {
        return Ok(Some(path.to_path_buf()));
    }
    if weights::face_models()?.is_none() {
        return Ok(None);
    }
    let astronaut = fetched(ASTRONAUT);
    if astronaut.is_file() {
        return Ok(Some(astronaut));
    }
    const VIEW: View =
        View { azimuth: 8.0, elevation: 3.0, target: [0.0, 1.57, 0.0], height: 0.55, floor: false };
    let picture = render(&figure.body, texture, &VIEW, Size::new(900, 1200));
    let path = folder.join(PORTRAIT);
    // 8-bit PNG files lose nothing.
    let _ = image::write(&Image::from(picture), &path, &WriteOptions::default())?;
    Ok(Some(path))
}

/// Makes the figure an avatar of a photograph, as `uvgraft avatar --selfie` does, and draws the
/// photograph beside the avatar from the front, the side and as a whole.
pub(super) fn build(photo: &Path) -> anyhow::Result<(Vec<u8>, Sheet)> {
    let mut request = AvatarRequest::new(Body::Figure, "selfie.glb");
    request.photos = vec![photo.into()];
    let glb = request.make(&Notes)?.file;
    let studio = Studio::new(&glb)?;
    let panels = [
        fitted(image::read(photo).or_bad_input()?.texture)?,
        studio.shot(("idle", 0.0), &[], &head(0.0), PANEL)?,
        studio.shot(("idle", 0.0), &[], &head(35.0), PANEL)?,
        studio.shot(("wave", 1.2), &[], &body(15.0), PANEL)?,
    ];
    Ok((glb, row(&panels, PANEL)))
}

/// A photograph as large as a panel allows.
fn fitted(photo: Texture) -> anyhow::Result<Texture> {
    let size = photo.size();
    let [across, down] = [(PANEL.width, size.width), (PANEL.height, size.height)]
        .map(|(room, side)| f64::from(room) / f64::from(side));
    let scale = across.min(down);
    let side = |length: u32| ((f64::from(length) * scale) as u32).max(1);
    let small = Size::new(side(size.width), side(size.height));
    let photo = photo.encoded_as(uvgraft::Encoding::Srgb).converted(Channels::Rgb, Depth::U8);
    Ok(photo.resized(small, Filter::Lanczos3, Averaging::Encoded)?)
}
