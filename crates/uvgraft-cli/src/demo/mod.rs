//! `uvgraft demo`: the whole workflow on a built-in example.

mod avatar;
mod blending;
mod open_body;
mod selfie;
mod views;

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use uvgraft::{Direction, Graft, Mesh, Pair, Size, Sizes, Texture};
use uvgraft_assembly::drawing::Sheet;
use uvgraft_assembly::{Input, ViewRequest, pair_picture};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_files::output::write_atomically;
use uvgraft_image::{self as image, Image, WriteOptions};
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::{arrays, obj, vertex_map};
use uvgraft_render::View;
use uvgraft_viewer::PAGE;

use self::blending::Blends;
use self::views::{FACE, FULL, render};
use crate::files::{OrCannotWrite, create_folder};
use crate::report::{grouped, parse_size};
use crate::{outcome, terminal};

/// Run the whole workflow on a built-in example
///
/// Generates a synthetic head and a synthetic body that contains the head in another UV layout,
/// transfers the painted face onto the body and back, and writes the meshes, textures, avatars and
/// pictures.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Output folder, created if missing
    #[arg(short, long, default_value = "uvgraft-demo", value_name = "FOLDER")]
    output: PathBuf,
    /// Size of both textures in texels
    #[arg(long, default_value = "2048", value_name = "N|WxH", value_parser = parse_size, allow_negative_numbers = true)]
    size: Size,
    /// Add an avatar of the open body: its model file, or `open`
    ///
    /// A file that `uvgraft body import` wrote. `open` imports it from the wheel that
    /// scripts/fetch-test-data.sh open-body puts into target/test-data.
    #[arg(long, value_name = "MODEL|open")]
    body: Option<PathBuf>,
    /// Photograph that an avatar is made of
    ///
    /// Left out, it is the astronaut's that scripts/fetch-test-data.sh puts into target/test-data, or
    /// one of the figure. There is no such avatar if the networks that find faces were not imported.
    #[arg(long, value_name = "PHOTO")]
    photo: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let folder = &args.output;
    create_folder(folder)?;
    let mut steps = Steps::new();
    let open_body = args.body.as_deref().map(|path| open_body::Files::new(path, args.size));
    let open_body = open_body.transpose()?;
    if let Some(built) = &open_body {
        steps.done("open body", &built.summary)?;
    }
    let transferred = Transferred::new(args.size, &mut steps)?;
    let pictures = Pictures::new(&transferred, &mut steps)?;
    let avatar = AnimatedFigure::new(&transferred, &mut steps)?;
    let selfie = Selfie::new(args, &transferred, &mut steps)?;
    let photo = selfie.as_ref().map(|selfie| selfie.photo.clone());
    let mut outputs = Outputs { folder, written: Vec::new() };
    transferred.write(&mut outputs, pictures)?;
    avatar.write(&mut outputs)?;
    open_body.map_or(Ok(()), |built| built.write(&mut outputs))?;
    selfie.map_or(Ok(()), |built| built.write(&mut outputs))?;
    steps.done("writing", &format!("{} files", outputs.written.len()))?;
    outcome::wrote(folder);
    print(&outputs, photo.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

/// The figure, its pair, and its textures before and after the transfer.
struct Transferred {
    figure: Figure,
    pair: Arc<Pair>,
    face: Texture,
    base: Texture,
    /// The body's texture with the face.
    body: Texture,
    /// The face transferred back from the body.
    back: Texture,
}

impl Transferred {
    fn new(size: Size, steps: &mut Steps) -> anyhow::Result<Self> {
        let figure = Figure::new();
        let [head, whole] = [&figure.head, &figure.body].map(|mesh| grouped(mesh.faces().len()));
        steps.done("meshes", &format!("head with {head} triangles, body with {whole}"))?;
        let face = paint_head(&figure, size);
        let base = paint_body(&figure, size);
        steps.done("painting", &format!("two textures of {size}"))?;

        let ids: Vec<i64> = figure.vertex_map.iter().map(|&id| i64::from(id)).collect();
        let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &ids)?;
        let pair = Arc::new(pair);
        steps.done("pair", &format!("{} triangles linked", grouped(pair.piece_count())))?;

        let sizes = Sizes { from: size, to: size };
        let forward = Graft::builder(Arc::clone(&pair), sizes).build()?;
        let backward =
            Graft::builder(Arc::clone(&pair), sizes).direction(Direction::Reverse).build()?;
        let texels = forward.map().stats().linked;
        steps.done("maps", &format!("both directions, {} body texels linked", grouped(texels)))?;
        let (source, target) = (face.clone(), base.clone());
        steps.skip();
        let body = forward.apply(source, target)?;
        steps.done("transfer", &format!("face onto body, {}", forward.filter()))?;
        let (source, target) = (body.clone(), face.clone());
        steps.skip();
        let back = backward.apply(source, target)?;
        steps.done("reverse", "body back onto head")?;
        Ok(Self { figure, pair, face, base, body, back })
    }

    fn write(self, outputs: &mut Outputs<'_>, pictures: Pictures) -> anyhow::Result<()> {
        let file = PairFile {
            pair: self.pair,
            source_name: "head.obj".to_owned(),
            target_name: "body.obj".to_owned(),
            note: "made by uvgraft's demo; free to use like uvgraft itself".to_owned(),
        };
        let Figure { head, body: whole, vertex_map, .. } = &self.figure;
        outputs
            .file("head.obj", "head mesh", |path| Ok(obj::save(head, path)?))?
            .file("body.obj", "body mesh", |path| Ok(obj::save(whole, path)?))?
            .file("head_to_body.npy", "body vertex for each head vertex", |path| {
                Ok(vertex_map::save_npy(vertex_map, path)?)
            })?
            .file("head_to_body.uvpair", "linked pair", |path| Ok(pair_file::write(&file, path)?))?
            .file("preview.png", "both layouts, linked region in colour", |path| {
                Ok(pair_picture::of_pair(&file, None)?.write(path)?)
            })?
            .texture("face.png", "face texture of the head", self.face)?
            .texture("body_base.png", "body texture before the transfer", self.base)?
            .texture("body_with_face.png", "body texture after the transfer", self.body)?
            .texture("face_back.png", "face transferred back from the body", self.back)?
            .file("before_after.png", "head before, body after", |path| {
                Ok(pictures.shots.picture().write(path)?)
            })?
            .file("blending.png", "face blended onto a body of darker skin", |path| {
                Ok(pictures.blended.write(path)?)
            })?
            .texture("body_darker.png", "texture of that body before", pictures.darker)?;
        Ok(())
    }
}

/// What shows the transfer.
struct Pictures {
    shots: Shots,
    /// Each way of blending, onto darker skin.
    blended: Sheet,
    /// The texture of the body with darker skin.
    darker: Texture,
}

impl Pictures {
    fn new(transferred: &Transferred, steps: &mut Steps) -> anyhow::Result<Self> {
        let Transferred { figure, pair, face, base, body, .. } = transferred;
        let shots = Shots::new(figure, face, base, body);
        let sizes = Sizes { from: face.size(), to: base.size() };
        let blends = Blends::new(figure, pair, face, sizes)?;
        let blended = blends.picture();
        steps.done("rendering", "before and after, blending onto darker skin")?;
        Ok(Self { shots, blended, darker: blends.body })
    }
}

/// The figure as an avatar: files and pictures.
struct AnimatedFigure {
    files: avatar::Files,
    pictures: avatar::Pictures,
}

impl AnimatedFigure {
    fn new(transferred: &Transferred, steps: &mut Steps) -> anyhow::Result<Self> {
        let files = avatar::Files::new(&transferred.figure, transferred.body.clone())?;
        steps.done("avatar", &files.summary)?;
        let pictures = avatar::Pictures::new(&files.glb)?;
        steps.done("animation", "turntable and stills of the avatar")?;
        Ok(Self { files, pictures })
    }

    fn write(self, outputs: &mut Outputs<'_>) -> anyhow::Result<()> {
        let Self { files, pictures } = &self;
        outputs
            .file("avatar.glb", "animated avatar", |path| bytes(path, &files.glb))?
            .file("avatar.vrm", "the same as VRM", |path| bytes(path, &files.vrm))?
            .file("wave.npz", "animation as an AMASS recording", |path| {
                Ok(arrays::save_npz(&files.motion, path)?)
            })?
            .file("avatar.png", "stills of the avatar", |path| Ok(pictures.sheet().write(path)?))?
            .file("turntable.gif", "waving avatar from all sides", |path| {
                pictures.write_turntable(path)
            })?;
        if PAGE.is_some() {
            let page = ViewRequest::new(Input::bytes("avatar.glb", &*files.glb)).make(&())?;
            let what = "avatar in a viewer for the browser";
            outputs.file("avatar.html", what, |path| bytes(path, &page))?;
        }
        Ok(())
    }
}

/// An avatar of a photograph.
struct Selfie {
    photo: PathBuf,
    glb: Vec<u8>,
    sheet: Sheet,
}

impl Selfie {
    /// `None` without networks that find faces.
    fn new(
        args: &Args,
        transferred: &Transferred,
        steps: &mut Steps,
    ) -> anyhow::Result<Option<Self>> {
        let Transferred { figure, body, .. } = transferred;
        let photo = selfie::photo(args.photo.as_deref(), figure, body, &args.output)?;
        let Some(photo) = photo else { return Ok(None) };
        let (glb, sheet) = selfie::build(&photo)?;
        steps.done("selfie", "avatar of a photograph")?;
        Ok(Some(Self { photo, glb, sheet }))
    }

    fn write(self, outputs: &mut Outputs<'_>) -> anyhow::Result<()> {
        if self.photo.starts_with(outputs.folder) {
            // It was written when it was made.
            outputs.file(selfie::PORTRAIT, "photograph of the figure", |_| Ok(()))?;
        }
        outputs.file("selfie.glb", "avatar of a photograph", |path| bytes(path, &self.glb))?.file(
            "selfie.png",
            "the photograph and its avatar",
            |path| Ok(self.sheet.write(path)?),
        )?;
        Ok(())
    }
}

/// A file that scripts fetch for tests and demo, whether it is there or not.
fn fetched(name: &str) -> PathBuf {
    let folder = std::env::var_os("UVGRAFT_TEST_DATA");
    folder.map_or_else(|| PathBuf::from("target/test-data"), PathBuf::from).join(name)
}

/// Pictures side by side, each in the middle of a panel.
fn row(pictures: &[Texture], panel: Size) -> Sheet {
    const GAP: u32 = 8;
    let count = pictures.len() as u32;
    let size = Size::new(count * panel.width + (count - 1) * GAP, panel.height);
    let mut row = Sheet::new(size, [24, 26, 30]);
    for (column, picture) in (0..).zip(pictures) {
        let [left, top] =
            [panel.width - picture.size().width, panel.height - picture.size().height];
        row.paste(picture, column * (panel.width + GAP) + left / 2, top / 2);
    }
    row
}

fn bytes(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    Ok(write_atomically::<io::Error>(path, |out| out.write_all(bytes))?)
}

fn print(outputs: &Outputs<'_>, photo: Option<&Path>) -> anyhow::Result<()> {
    let mut text = String::new();
    let _ = writeln!(text, "\nFiles in {}:", terminal::path(outputs.folder));
    for (name, what) in &outputs.written {
        let _ = writeln!(text, "  {name:<20} {what}");
    }
    let path = |name: &str| outcome::argument(&outputs.folder.join(name));
    let [before, after] = ["body_base.png", "body_with_face.png"].map(path);
    let [body, face, avatar] = ["body.obj", "face.png", "avatar.glb"].map(path);
    let [shown, turning] = ["shown.png", "turning.gif"].map(path);
    text += &commands(
        "Look at the body before and after, and at the avatar from all sides",
        &[
            format!("render {body} -t {before} -t {after} -o {shown}"),
            match PAGE {
                Some(_) => format!("view {avatar}"),
                None => format!("render {avatar} --turntable -o {turning}"),
            },
        ],
    );
    let [head, ids, wave] = ["head.obj", "head_to_body.npy", "wave.npz"].map(path);
    text += &commands(
        "The same steps one by one, for files of your own in place of these",
        &[
            format!("pair {head} {body} --vertex-map {ids} -o my.uvpair"),
            format!("transfer my.uvpair {face} --onto {before} -o my.png"),
            format!(
                "avatar my.uvpair {face} --onto {before} --body demo --motion {wave} -o me.glb"
            ),
        ],
    );
    if let Some(photo) = photo {
        let small =
            if photo.ends_with(selfie::ASTRONAUT) { ", where the astronaut's has 108" } else { "" };
        text += &commands(
            &format!(
                "The same with a photograph of yours (a face should be 200 pixels high or more{small})"
            ),
            &["avatar --selfie me.jpg --body demo -o selfie.glb".to_owned()],
        );
    } else {
        let _ = writeln!(
            text,
            "\nNo avatar of a photograph: the networks that find faces were not imported; see \
             `uvgraft weights --help`"
        );
    }
    if PAGE.is_none() {
        let _ = writeln!(
            text,
            "\nThis build has no viewer, so avatar.html and `uvgraft view` are not available: run \
             scripts/build-viewer.sh and build with the feature `viewer`"
        );
    }
    terminal::print(&text)
}

/// Commands to try, under what they are for.
fn commands(what: &str, commands: &[String]) -> String {
    let lines = commands.iter().map(|arguments| format!("  {}\n", outcome::command(arguments)));
    format!("\n{what}:\n{}", lines.collect::<String>())
}

/// Prints each step as it ends, and how long it took.
struct Steps {
    since: Instant,
}

impl Steps {
    fn new() -> Self {
        Self { since: Instant::now() }
    }

    fn done(&mut self, name: &str, what: &str) -> anyhow::Result<()> {
        let took = self.since.elapsed().as_secs_f64();
        self.skip();
        terminal::print(&format!("{name:<10} {:>8.1} ms   {what}\n", took * 1e3))
    }

    /// Restarts the clock without a step.
    fn skip(&mut self) {
        self.since = Instant::now();
    }
}

/// The written files and their descriptions.
struct Outputs<'a> {
    folder: &'a Path,
    written: Vec<(&'static str, &'static str)>,
}

impl Outputs<'_> {
    fn file(
        &mut self,
        name: &'static str,
        what: &'static str,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<&mut Self> {
        let path = self.folder.join(name);
        write(&path).or_cannot_write(&path)?;
        self.written.push((name, what));
        Ok(self)
    }

    fn texture(
        &mut self,
        name: &'static str,
        what: &'static str,
        texture: Texture,
    ) -> anyhow::Result<&mut Self> {
        self.file(name, what, |path| {
            // Nothing is lost: PNG stores an 8-bit RGB texture without a profile exactly.
            let _ = image::write(&Image::from(texture), path, &WriteOptions::default())?;
            Ok(())
        })
    }
}

/// Pictures of the figure: the head with its texture, the body before, and the body after.
struct Shots {
    panels: [Panel; 3],
}

/// Two close-ups, one above the other, next to a picture of the whole figure, if given.
struct Panel {
    caption: &'static str,
    whole: Option<Texture>,
    close: [Texture; 2],
}

impl Shots {
    const WHOLE: Size = Size::new(580, 800);
    const CLOSE: Size = Size::new(400, 400);

    fn new(figure: &Figure, face: &Texture, base: &Texture, body: &Texture) -> Self {
        let close_ups = |mesh: &Mesh, texture: &Texture| {
            let turned = View { azimuth: -48.0, ..FACE };
            [FACE, turned].map(|view| render(mesh, texture, &view, Self::CLOSE))
        };
        let of_body = |caption, texture: &Texture| Panel {
            caption,
            whole: Some(render(&figure.body, texture, &FULL, Self::WHOLE)),
            close: close_ups(&figure.body, texture),
        };
        let head = Panel {
            caption: "the head's texture",
            whole: None,
            close: close_ups(&figure.head, face),
        };
        Self { panels: [head, of_body("the body before", base), of_body("the body after", body)] }
    }

    fn picture(&self) -> Sheet {
        const CAPTION: u32 = 44;
        const GAP: u32 = 8;
        let (whole, close) = (Self::WHOLE, Self::CLOSE);
        let width = 2 * whole.width + 3 * close.width + 2 * GAP;
        let size = Size::new(width, CAPTION + whole.height);
        let mut picture = Sheet::new(size, [24, 26, 30]);
        let mut left = 0;
        for panel in &self.panels {
            let first = left;
            if let Some(texture) = &panel.whole {
                picture.paste(texture, left, CAPTION);
                left += whole.width;
            }
            picture.paste(&panel.close[0], left, CAPTION);
            picture.paste(&panel.close[1], left, CAPTION + close.height);
            left += close.width;
            let space = (left - first).saturating_sub(Sheet::text_width(panel.caption, 2));
            picture.text(panel.caption, first + space / 2, 14, 2, [236, 238, 242]);
            left += GAP;
        }
        picture
    }
}
