//! What pictures and pages show: a model as its file has it, or a mesh, which becomes a model.

use std::path::Path;

use uvgraft::listing::listed;
use uvgraft::{Channels, Depth, Encoding, Mesh, Size, Texels, Texture, TextureError};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::motion::UpAxis;
use uvgraft_avatar::rig::{Joint, Skeleton, Skin};
use uvgraft_files::input::Input;
use uvgraft_gltf::glb::{self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export};
use uvgraft_image as image;
use uvgraft_io::obj;
use uvgraft_pipeline::{
    Blame, Context, Failure, Observer, Result, memory_taken, without_non_finite,
};
use uvgraft_render::Bounds;

use crate::mesh_file::{self, MeshFile};
use crate::pairing::OutsideFaces;

/// Colour of meshes without a texture: a grey in which shading shows well.
const GREY: u8 = 180;

/// Distance of meshes side by side, as a share of their width.
const GAP: f32 = 0.1;

/// A model or a mesh.
pub(crate) enum Shown {
    /// A GLB, VRM or glTF file, shown with all that it has.
    Model(Input),
    /// A mesh of any file, or a part of a model, which has positions and UV coordinates alone.
    Mesh { mesh: Mesh, name: String },
}

impl Shown {
    /// Reads a mesh; models are only recognised. Notes what of a mesh is not shown as one would expect.
    ///
    /// - `up`: the axis of a mesh that points up; by default Y.
    /// - `is_textured`: whether a texture will be shown on it.
    ///
    /// # Errors
    /// As bad input for files that are neither, for parts that do not exist, and for the up axis of a model.
    pub fn read(
        given: &Input,
        up: Option<UpAxis>,
        is_textured: bool,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let given = whole(given)?;
        if MeshFile::parse(&given).is_model()? {
            return match up {
                None | Some(UpAxis::Y) => Ok(Self::Model(given)),
                Some(_) => Err(Failure::option(format!(
                    "{given}: `up` is for meshes; Y is up in GLB, VRM and glTF files"
                ))),
            };
        }
        let loaded = mesh_file::read_noting(&given, observer)?;
        let (mesh, name) = (upright(loaded.mesh, up.unwrap_or(UpAxis::Y))?, loaded.name);
        if up.is_none() {
            note_lying(&mesh, &name, observer);
        }
        if is_textured {
            note_tiles(&mesh, &name, observer);
        } else {
            observer.note(format_args!("{name}: shown in grey; `texture` shows a texture on it"));
        }
        Ok(Self::Mesh { mesh, name })
    }
}

/// A mesh whose up axis becomes Y.
fn upright(mesh: Mesh, up: UpAxis) -> Result<Mesh> {
    let turn: fn([f32; 3]) -> [f32; 3] = match up {
        UpAxis::Y => return Ok(mesh),
        UpAxis::Z => |[x, y, z]| [x, z, -y],
        UpAxis::MinusY => |[x, y, z]| [x, -y, -z],
        UpAxis::MinusZ => |[x, y, z]| [x, -z, y],
    };
    let positions = mesh.positions().iter().map(|&position| turn(position)).collect();
    mesh.with_positions(positions).or_work()
}

/// Notes that a mesh seems to lie: SMPL-X on its back is five times as deep as it is high.
fn note_lying(mesh: &Mesh, name: &str, observer: &dyn Observer) {
    const MAX_DEPTH: f32 = 3.0;
    let [_, height, depth] = extent(mesh);
    if depth > MAX_DEPTH * height && height > 0.0 {
        observer.note(format_args!(
            "{name}: {:.1} times as deep as it is high; if Z is up in it, use `up` z",
            depth / height
        ));
    }
}

/// Width, height and depth of what triangles use of a mesh.
fn extent(mesh: &Mesh) -> [f32; 3] {
    let used = mesh.faces().iter().flatten().map(|&vertex| mesh.positions()[vertex as usize]);
    Bounds::of(used).map_or([0.0; 3], |Bounds { low, high }| [0, 1, 2].map(|k| high[k] - low[k]))
}

/// What a pipe gives, which can be read only once; anything else as it is.
fn whole(given: &Input) -> Result<Input> {
    let is_pipe =
        |path: &Path| path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir());
    let Some(path) = given.path().filter(|path| is_pipe(path)) else { return Ok(given.clone()) };
    let bytes = given.read(obj::MAX_FILE_BYTES).or_input().context(path.display())?;
    Ok(Input::bytes(path, bytes.into_owned()))
}

/// Reads a texture to show: 8-bit sRGB.
///
/// - `memory`: bound on its decoding, in bytes.
///
/// # Errors
/// As bad input for files that are not images or exceed the bound.
pub(crate) fn texture(
    input: &Input,
    memory: Option<u64>,
    observer: &dyn Observer,
) -> Result<Texture> {
    let opened = image::open(input).or_input()?;
    let needed = opened.header().decoding_bytes.saturating_add(memory_taken());
    if let Some(memory) = memory.filter(|&memory| needed > memory) {
        let [needed, allowed] = [needed.div_ceil(1 << 20), memory >> 20];
        return Err(Failure::option(format!(
            "{input}: decoding it takes {needed} MiB of memory, but `memory` allows {allowed}; if \
             that is right, add `memory` {needed}M"
        )));
    }
    let texture = opened.decode().or_input()?.texture;
    let (texture, unknown) = without_non_finite(texture, input.name());
    unknown.iter().for_each(|unknown| observer.warn(unknown));
    over_grey(&texture.encoded_as(Encoding::Srgb)).or_work()
}

/// A texture of 8 bits without alpha: where it is transparent, the grey of meshes without a texture shows.
fn over_grey(texture: &Texture) -> std::result::Result<Texture, TextureError> {
    let texture = texture.clone().converted(texture.channels().with_alpha(), Depth::U8);
    let (size, channels) = (texture.size(), texture.channels());
    let Texels::U8(values) = texture.texels() else { return Ok(texture) };
    let count = channels.count();
    let mut opaque = Vec::with_capacity(size.texels() * (count - 1));
    for texel in values.chunks_exact(count) {
        let alpha = u32::from(texel[count - 1]);
        let over = |&value: &u8| {
            let sum = u32::from(value) * alpha + u32::from(GREY) * (255 - alpha);
            ((sum + 127) / 255) as u8
        };
        opaque.extend(texel[..count - 1].iter().map(over));
    }
    Texture::new(size, channels.without_alpha(), Encoding::Srgb, Texels::U8(opaque))
}

/// Notes where a texture of the unit square is shown a second time.
fn note_tiles(mesh: &Mesh, name: &str, observer: &dyn Observer) {
    let Some(outside) = OutsideFaces::of(mesh) else { return };
    let start = outside.message_start(name);
    let numbers = match outside.tiles.is_empty() {
        true => String::new(),
        false => format!(" (tiles {})", listed(outside.tiles)),
    };
    observer.note(format_args!("{start}{numbers}, where the texture repeats"));
}

/// A mesh as a model: a GLB file with one copy of the mesh for each texture, side by side.
///
/// - `textures`: with their names; without any, the mesh is grey.
///
/// # Errors
/// For meshes that a file cannot hold.
pub(crate) fn model(mesh: &Mesh, name: &str, textures: Vec<(String, Texture)>) -> Result<Vec<u8>> {
    let textures = match textures.is_empty() {
        true => vec![(name.to_owned(), plain(GREY)?)],
        false => textures,
    };
    let copies = textures.len();
    let materials = textures
        .into_iter()
        .map(|(name, texture)| {
            let color = EmbeddedImage::encode(texture, EmbeddedFormat::Png, 100).or_work()?;
            Ok(AvatarMaterial { name, double_sided: true, ..AvatarMaterial::new(color) })
        })
        .collect::<Result<Vec<_>>>()?;
    let faces = mesh.faces().len();
    let mesh = beside_each_other(mesh, copies)?;
    let joint = Joint { name: "mesh".to_owned(), parent: None, position: [0.0; 3], human: None };
    let vertices = mesh.positions().len();
    let avatar = Avatar {
        materials: (0..copies as u8).flat_map(|copy| std::iter::repeat_n(copy, faces)).collect(),
        skeleton: Skeleton::new(vec![joint]).or_work()?,
        skin: Skin::new((0..vertices).map(|_| [(0, 1.0)]), 1).or_work()?,
        mesh,
        morphs: Vec::new(),
        expressions: Vec::new(),
        clips: Vec::new(),
    };
    let export = Export { name: name.to_owned(), ..Export::default() };
    Ok(glb::write(&avatar, &materials, &export).or_work()?.bytes)
}

/// A texture of one grey.
fn plain(value: u8) -> Result<Texture> {
    let texels = Texels::U8(vec![value; 3]);
    Texture::new(Size::square(1), Channels::Rgb, Encoding::Srgb, texels).or_work()
}

/// Copies of a mesh from left to right, as seen from the front.
fn beside_each_other(mesh: &Mesh, copies: usize) -> Result<Mesh> {
    let [width, ..] = extent(mesh);
    let count = mesh.positions().len() as u32;
    let (mut positions, mut faces, mut uv_faces) = (Vec::new(), Vec::new(), Vec::new());
    for copy in 0..copies as u32 {
        let shift = width * (1.0 + GAP) * (copy as f32 - (copies as f32 - 1.0) / 2.0);
        positions.extend(mesh.positions().iter().map(|&[x, y, z]| [x + shift, y, z]));
        faces.extend(mesh.faces().iter().map(|face| face.map(|vertex| vertex + copy * count)));
        uv_faces.extend_from_slice(mesh.uv_faces());
    }
    Mesh::from_triangles(positions, mesh.uv().to_vec(), &faces, &uv_faces).or_work()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use uvgraft_gltf::scene::{PoseRequest, Scene};
    use uvgraft_pipeline::Event;

    use super::*;

    const SQUARES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                           vt 2 0\nvt 2 1\nf 1/1 2/2 3/3 4/4\no eye\nf 1/2 2/5 3/6 4/3\n";

    #[derive(Default)]
    struct Recorder(Mutex<Vec<String>>);

    impl Observer for Recorder {
        fn event(&self, event: Event<'_>) {
            if let Event::Note(text) = event {
                self.0.lock().unwrap().push(text.to_owned());
            }
        }
    }

    fn read(name: &str, is_textured: bool) -> (Shown, Vec<String>) {
        let messages = Recorder::default();
        let shown =
            Shown::read(&Input::bytes(name, SQUARES.as_bytes()), None, is_textured, &messages)
                .unwrap();
        (shown, messages.0.into_inner().unwrap())
    }

    #[test]
    fn copies_stand_side_by_side_each_with_its_texture() {
        let (Shown::Mesh { mesh, name }, _) = read("a.obj", true) else { panic!("a mesh") };
        let textures = [10, 200].map(|value| (format!("{value}.png"), plain(value).unwrap()));
        let file = model(&mesh, &name, textures.to_vec()).unwrap();
        let scene = Scene::read(&file).unwrap();
        let drawn = scene.pose(&PoseRequest::default()).unwrap();
        let span = |index: usize| {
            let x = || drawn[index].positions.iter().map(|position| position[0]);
            [x().fold(f32::MAX, f32::min), x().fold(f32::MIN, f32::max)]
        };
        assert_eq!([span(0), span(1)], [[-0.55, 0.45], [0.55, 1.55]]);
        let names: Vec<_> = drawn.iter().map(|it| &*scene.materials()[it.material].name).collect();
        assert_eq!(names, ["10.png", "200.png"]);
        let colors: Vec<_> = scene.textures().iter().map(|it| it.texels().clone()).collect();
        assert_eq!(colors, [10, 200].map(|value| Texels::U8(vec![value; 3])));
    }

    #[test]
    fn meshes_stand_up() {
        let lying = "v 0 0 0\nv 1 0 0\nv 1 0.2 9\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n";
        let messages = Recorder::default();
        let given = Input::bytes("a.obj", lying.as_bytes());
        let read = |up| match Shown::read(&given, up, true, &messages).unwrap() {
            Shown::Mesh { mesh, .. } => mesh.positions()[2],
            Shown::Model(_) => panic!("a mesh"),
        };
        assert_eq!(read(None), [1.0, 0.2, 9.0]);
        assert_eq!(read(Some(UpAxis::Z)), [1.0, 9.0, -0.2]);
        assert_eq!(read(Some(UpAxis::MinusZ)), [1.0, -9.0, 0.2]);
        assert_eq!(read(Some(UpAxis::MinusY)), [1.0, -0.2, -9.0]);
        let wanted = "a.obj: 45.0 times as deep as it is high; if Z is up in it, use `up` z";
        assert_eq!(*messages.0.lock().unwrap(), [wanted]);
    }

    #[test]
    fn what_is_transparent_is_grey() {
        let texels = Texels::U8(vec![10, 255, 10, 0, 110, 128]);
        let texture = Texture::new(Size::new(3, 1), Channels::GreyAlpha, Encoding::Srgb, texels);
        let shown = over_grey(&texture.unwrap()).unwrap();
        assert_eq!(shown.texels(), &Texels::U8(vec![10, 180, 145]));
    }

    #[test]
    fn what_is_not_shown_as_expected_is_noted() {
        let (_, messages) = read("a.obj", false);
        assert_eq!(messages, ["a.obj: shown in grey; `texture` shows a texture on it"]);
        let (_, messages) = read("a.obj", true);
        let wanted = "a.obj: 2 triangles have UV coordinates outside the unit square (tiles 1002), \
                      where the texture repeats";
        assert_eq!(messages, [wanted]);
    }
}
