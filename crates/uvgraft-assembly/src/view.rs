//! A page that shows an avatar or a mesh in the browser.

use std::path::Path;

use uvgraft_avatar::motion::UpAxis;
use uvgraft_files::input::Input;
use uvgraft_gltf::scene::{PoseRequest, Scene, whole_within};
use uvgraft_image::{self as image, ImageError};
use uvgraft_pipeline::{Blame, Context, Failure, Observer, Result};
use uvgraft_render::Bounds;
use uvgraft_viewer::{Glb, LookAt, PAGE, Page, Template, WebImage};

use crate::render::Aim;
use crate::scene_memory::Bound;
use crate::shown::{self, Shown};

/// A request for one HTML page that holds an avatar or a mesh and a viewer, and works offline.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ViewRequest {
    /// A GLB, VRM or glTF file of any origin, or a mesh, which a part of such a file is too (`me.glb#Head`).
    /// Compressed data and files beside it are decoded and embedded into the page.
    pub avatar: Input,
    /// Of a model: alternative textures to offer: PNG, JPEG or WebP. Pages hold their pictures without metadata,
    /// such as where a photograph was taken.
    ///
    /// Of a mesh: its textures, of any format. The mesh is shown once with each, side by side.
    pub textures: Vec<Input>,
    /// The axis of a mesh that points up; by default Y, as always in models.
    pub up: Option<UpAxis>,
    /// Initial target of the camera; by default the whole model.
    pub look_at: Option<Aim>,
    /// Bound on the memory of the process, in bytes: a file that could exceed it is refused. By default a file may
    /// take memory by its size, a gibibyte and 200 times as much.
    pub memory: Option<u64>,
}

/// Copies of a mesh in a page, each with a texture, that fit into a screen side by side.
const MAX_TEXTURES: usize = 4;

/// Browsers limit strings to about half a gigabyte, and base64 is a third longer than its input.
const MAX_MODEL_BYTES: u64 = 256 << 20;
const MAX_TEXTURE_BYTES: u64 = 64 << 20;

/// Memory for the page without what it shows: the viewer has less than a megabyte.
const PAGE_BYTES: usize = 8 << 20;

impl ViewRequest {
    /// A request for a page without other textures.
    pub fn new(avatar: impl Into<Input>) -> Self {
        Self { avatar: avatar.into(), textures: Vec::new(), up: None, look_at: None, memory: None }
    }

    /// Checks that this build has a viewer.
    ///
    /// # Errors
    /// As bad input, with the way to such a build.
    pub fn check(&self) -> Result<()> {
        template().map(drop)
    }

    /// All inputs.
    pub fn inputs(&self) -> impl Iterator<Item = &Input> {
        [&self.avatar].into_iter().chain(&self.textures)
    }

    /// Makes the page.
    ///
    /// # Errors
    /// As bad input for files that cannot be shown, for names that the file does not have, and in a
    /// build without a viewer.
    pub fn make(&self, observer: &dyn Observer) -> Result<Vec<u8>> {
        let template = Template::new(template()?).or_work()?;
        match Shown::read(&self.avatar, self.up, !self.textures.is_empty(), observer)? {
            Shown::Model(input) => {
                // Whole and uncompressed, so that the page needs neither files next to it nor decoders.
                let bound = Bound::new(self.memory, 0);
                let bytes = bound.loaded(whole_within(&input, bound.budget()))?;
                self.page(&template, &bytes, &self.textures)
            }
            Shown::Mesh { mesh, name } => {
                if self.textures.len() > MAX_TEXTURES {
                    let found = self.textures.len();
                    return Err(Failure::option(format!(
                        "`texture` must be given at most {MAX_TEXTURES} times for a mesh, got {found}"
                    )));
                }
                let textures = self.textures.iter().map(|input| {
                    Ok((file_name(input), shown::texture(input, self.memory, observer)?))
                });
                let bytes = shown::model(&mesh, &name, textures.collect::<Result<_>>()?)?;
                self.page(&template, &bytes, &[])
            }
        }
    }

    /// - `bytes`: a GLB file.
    /// - `others`: textures to offer.
    fn page(&self, template: &Template<'_>, bytes: &[u8], others: &[Input]) -> Result<Vec<u8>> {
        if bytes.len() as u64 > MAX_MODEL_BYTES {
            let (name, found) = (&self.avatar, bytes.len());
            return Err(Failure::input(format!(
                "{name}: must have at most {MAX_MODEL_BYTES} bytes uncompressed, got {found}"
            )));
        }
        let in_model =
            |failure: Failure| failure.context(format_args!("cannot show {}", self.avatar));
        let model = Glb::new(bytes).or_input().map_err(in_model)?;
        let files = others
            .iter()
            .map(|input| {
                let bytes = input.read(MAX_TEXTURE_BYTES).or_input();
                Ok((input, file_name(input), bytes.context(input)?))
            })
            .collect::<Result<Vec<_>>>()?;
        let embedded = files.iter().fold(bytes.len(), |sum, (_, _, bytes)| sum + bytes.len());
        let page_bytes = embedded / 3 * 4 + PAGE_BYTES;
        let decoded = files.iter().map(|(_, _, bytes)| decoded_bytes(bytes)).max().unwrap_or(0);
        let bound = Bound::new(self.memory, page_bytes as u64 + decoded);
        // What the renderer rejects, the viewer cannot show either.
        let scene = bound.read(Scene::read_within(bytes, bound.budget())).map_err(in_model)?;
        let look_at = match &self.look_at {
            Some(Aim::Named(name)) => {
                scene.extent(name, &PoseRequest::default()).or_input().map_err(in_model)?;
                Some(LookAt::Named(name))
            }
            Some(Aim::Box(Bounds { low: [a, b, c], high: [d, e, f] })) => {
                Some(LookAt::Box([*a, *b, *c, *d, *e, *f]))
            }
            Some(Aim::Shot(_)) | None => None,
        };
        drop(scene);
        let files = files
            .into_iter()
            .map(|(input, name, bytes)| Ok((input, name, bare_picture(input, &bytes)?)))
            .collect::<Result<Vec<_>>>()?;
        let textures =
            files.iter().map(|(input, name, bytes)| Ok((&**name, picture(input, bytes)?)));
        let textures = textures.collect::<Result<Vec<_>>>()?;
        let page = Page { name: &file_name(&self.avatar), model, textures, look_at };
        let mut html = Vec::with_capacity(page_bytes);
        page.write(template, &mut html).or_work()?;
        Ok(html)
    }
}

fn template() -> Result<&'static str> {
    PAGE.ok_or_else(|| {
        Failure::input(
            "this build has no viewer; in the sources, run scripts/build-viewer.sh (needs npm), \
             then cargo install --path crates/uvgraft-cli --features viewer",
        )
    })
}

/// The file of a texture that browsers show, without metadata.
fn bare_picture(input: &Input, bytes: &[u8]) -> Result<Vec<u8>> {
    picture(input, bytes)?;
    // Browsers show formats that are unsupported here, but nothing of a damaged file.
    if let Err(error @ (ImageError::Truncated { .. } | ImageError::Damaged { .. })) =
        image::decode(bytes)
    {
        return Err(Failure::input(format!("{input}: {error}")));
    }
    image::without_metadata(bytes)
        .ok_or_else(|| Failure::input(format!("{input}: the file's parts do not fit together")))
}

/// A texture that browsers show.
fn picture<'a>(input: &Input, bytes: &'a [u8]) -> Result<WebImage<'a>> {
    WebImage::new(bytes).ok_or_else(|| {
        Failure::input(format!("{input}: not an image; must be {}", WebImage::EXTENSIONS))
    })
}

/// Bytes that a texture takes while it is decoded.
fn decoded_bytes(bytes: &[u8]) -> u64 {
    let header = image::decode_header(bytes).ok();
    header.map_or(0, |header| header.decoding_bytes)
}

fn file_name(input: &Input) -> String {
    input.name().file_name().unwrap_or(Path::new("").as_os_str()).to_string_lossy().into_owned()
}
