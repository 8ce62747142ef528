//! Meshes in files of any supported format, with a selector for a part of one.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use uvgraft::Mesh;
use uvgraft::listing::listed;
use uvgraft::mesh::MeshPart;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_gltf::scene::{MeshChoice, SceneMeshError, load_mesh, read_mesh};
use uvgraft_image as image;
use uvgraft_io::obj::ObjError;
use uvgraft_io::pair_file::{self, PairFile};
use uvgraft_io::textured::{TexturedMesh, WithoutUv};
use uvgraft_io::{arrays, model_mesh, obj, ply};
use uvgraft_pipeline::{Blame, Context, Failure, Observer, Result};

use crate::report::grouped;

/// Characters shown of a name.
const MAX_SHOWN: usize = 40;

/// Extensions of mesh files. Formats are detected from the content; these tell what a damaged file was meant to be.
pub const EXTENSIONS: [&str; 7] = ["obj", "ply", "glb", "gltf", "vrm", "npz", "pkl"];

/// Selects the head of a body model.
const HEAD: &str = "head";

/// A mesh, and what to call it.
#[derive(Debug)]
pub struct LoadedMesh {
    /// All of the file, or the selected part.
    pub mesh: Mesh,
    /// Name of the file without its folder, with the selector.
    pub name: String,
    /// What of it is not in `mesh`.
    pub without_uv: WithoutUv,
}

impl LoadedMesh {
    /// What was left out, for a message; `None` if nothing was.
    pub fn left_out(&self) -> Option<String> {
        let (name, count) = (&self.name, self.without_uv.polygons);
        let all = grouped(count + self.mesh.polygon_count());
        let message = match count {
            0 => return None,
            1 => format!("{name}: 1 of {all} polygons has no UV coordinates and is left out"),
            _ => format!(
                "{name}: {} of {all} polygons have no UV coordinates and are left out",
                grouped(count)
            ),
        };
        let parts = self.without_uv.listed(self.mesh.parts());
        Some(if parts.is_empty() { message } else { format!("{message}: {parts}") })
    }
}

/// A file and a part of it, written `FILE`, `FILE#SET`, `FILE#NAME` or `FILE#NAME/SET`.
#[derive(Debug, PartialEq)]
pub struct MeshFile {
    /// The file.
    pub file: Input,
    /// What follows the `#`; not empty.
    selector: Option<String>,
}

impl MeshFile {
    /// Splits a file from its selector. Names of files may contain `#`: the longest prefix that is
    /// a file counts. Without one, all is the path, so that errors name what was given. Bytes are
    /// followed by what is behind the last `#` of their name.
    pub fn parse(given: &Input) -> Self {
        let whole = || Self { file: given.clone(), selector: None };
        let (path, is_path) = (given.name(), given.path().is_some());
        let is_file = |path: &Path| match is_path {
            true => path.metadata().is_ok_and(|found| !found.is_dir()),
            false => true,
        };
        // Selectors are text.
        let is_whole = is_path && is_file(path);
        let Some(text) = path.to_str().filter(|_| !is_whole) else { return whole() };
        let mut splits = text.rmatch_indices('#').map(|(at, _)| (&text[..at], &text[at + 1..]));
        splits.find(|(path, _)| is_file(Path::new(path))).map_or_else(whole, |(path, selector)| {
            let selector = Some(selector.to_owned()).filter(|selector| !selector.is_empty());
            let file = match given {
                Input::File(_) => path.into(),
                Input::Bytes { bytes, .. } => Input::bytes(path, Arc::clone(bytes)),
            };
            Self { file, selector }
        })
    }

    /// Whether it is all of a GLB, VRM or glTF file, of a damaged one by its extension, or no file.
    ///
    /// # Errors
    /// As bad input for files that cannot be read.
    pub(crate) fn is_model(&self) -> Result<bool> {
        let format = match &self.file {
            Input::Bytes { bytes, .. } => Format::detected(bytes),
            Input::File(path) => {
                let named = |reason| Failure::input(format!("{}: {reason}", path.display()));
                match path.metadata().map_err(named)?.is_file() {
                    true => Format::of(path).map_err(named)?,
                    false => Format::Gltf,
                }
            }
        };
        let extension = self.file.name().extension().unwrap_or_default();
        let is_named = ["glb", "gltf", "vrm"].iter().any(|it| extension.eq_ignore_ascii_case(it));
        let is_model = format == Format::Gltf || (format == Format::Obj && is_named);
        Ok(self.selector.is_none() && is_model)
    }

    /// The name of the file without its folder, with the selector.
    pub fn name(&self) -> String {
        let path = self.file.name();
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        match &self.selector {
            Some(selector) => format!("{file}#{selector}"),
            None => file.into_owned(),
        }
    }

    /// Whether the head of a body model is selected, in its own layout.
    fn is_head(&self) -> bool {
        self.selector.as_deref() == Some(HEAD)
    }

    /// The selector as a name and a UV set: digits alone, or after the last slash, are a set.
    fn choice(&self) -> MeshChoice {
        let set = |text: &str| {
            text.parse().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()))
        };
        let Some(selector) = self.selector.as_deref() else { return MeshChoice::default() };
        if let Some(uv_set) = set(selector) {
            return MeshChoice { name: None, uv_set: Some(uv_set) };
        }
        if let Some((name, last)) = selector.rsplit_once('/')
            && let Some(uv_set) = set(last)
        {
            return MeshChoice { name: Some(name.to_owned()), uv_set: Some(uv_set) };
        }
        MeshChoice { name: Some(selector.to_owned()), uv_set: None }
    }
}

/// The file of a mesh, without the selector of a part.
pub(crate) fn file_of(given: &Input) -> Input {
    MeshFile::parse(given).file
}

/// Whether a file can be a mesh, from its first bytes: OBJ files may begin with any line of text.
pub fn may_be_mesh(start: &[u8]) -> bool {
    let is_text = |byte: &u8| !byte.is_ascii_control() || byte.is_ascii_whitespace();
    Format::detected(start) != Format::Obj || start.iter().all(is_text)
}

/// Reads a mesh, and notes what of it is left out.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_noting(given: &Input, observer: &dyn Observer) -> Result<LoadedMesh> {
    let loaded = read(given.clone())?;
    if let Some(left_out) = loaded.left_out() {
        observer.note(format_args!("{left_out}"));
    }
    Ok(loaded)
}

/// Reads a mesh whose format is detected from its content: OBJ, PLY, GLB (or VRM), glTF with its
/// external buffers, a body model with UV coordinates (NPZ, pickle), or the target of a pair file (its
/// source with `#source`). Polygons without UV coordinates are left out, as long as there are others:
/// see [`LoadedMesh::without_uv`].
///
/// - `given`: a file, optionally with a selector: `FILE#SET`, `FILE#NAME` or `FILE#NAME/SET`.
///
/// # Errors
/// For files that cannot be read, and for selectors of what does not exist, as bad input.
pub fn read(given: impl Into<Input>) -> Result<LoadedMesh> {
    let file = MeshFile::parse(&given.into());
    let TexturedMesh { mesh, without_uv } = load(&file)?;
    Ok(LoadedMesh { mesh, name: file.name(), without_uv })
}

fn load(file: &MeshFile) -> Result<TexturedMesh> {
    let Some(path) = file.file.path() else { return from_bytes(file) };
    let named = |reason: io::Error| Failure::input(format!("{}: {reason}", path.display()));
    let kind = path.metadata().map_err(named)?;
    if !kind.is_file() && !kind.is_dir() {
        return from_bytes(file);
    }
    let part = |mesh| part(mesh, file).context(&file.file);
    // A folder is refused where files are read.
    let format = if kind.is_dir() { Format::Obj } else { Format::of(path).map_err(named)? };
    match format {
        Format::Image(found) => Err(is_image(found).context(&file.file)),
        Format::Gltf => load_mesh(path, &file.choice())
            .map_err(|error| read_failure(error, |reason| with_hint(reason, file))),
        Format::Ply => part(ply::read(path).or_input()?),
        Format::Pair => side(&pair_file::read(path).or_input()?, file).context(&file.file),
        Format::Model if file.is_head() => model_mesh::read_head(path).or_input().map(whole),
        Format::Model => part(whole(model_mesh::read(path).or_input()?)),
        Format::Obj => {
            part(obj::read_textured(path).map_err(|error| read_failure(error, foreign))?)
        }
    }
}

/// A mesh of a format in which all polygons have UV coordinates.
fn whole(mesh: Mesh) -> TexturedMesh {
    TexturedMesh { mesh, without_uv: WithoutUv::default() }
}

/// An error of reading, with other words for that of the content.
fn read_failure<E: std::error::Error>(
    error: ReadError<E>,
    words: impl Fn(&E) -> String,
) -> Failure {
    match error {
        ReadError::Content { path, reason } => {
            Failure::input(format!("{}: {}", path.display(), words(&reason)))
        }
        error => Failure::input(error),
    }
}

/// Bytes and pipes, which can be read only once, have no files beside them.
fn from_bytes(file: &MeshFile) -> Result<TexturedMesh> {
    let bytes = file.file.read(obj::MAX_FILE_BYTES).or_input().context(&file.file)?;
    parsed(&bytes, file).context(&file.file)
}

fn parsed(bytes: &[u8], file: &MeshFile) -> Result<TexturedMesh> {
    match Format::detected(bytes) {
        Format::Image(found) => Err(is_image(found)),
        Format::Gltf => read_mesh(bytes, &file.choice())
            .map_err(|error| Failure::input(with_hint(&error, file))),
        Format::Ply => part(ply::parse(bytes).or_input()?, file),
        Format::Pair => side(&pair_file::decode(bytes).or_input()?, file),
        Format::Obj => {
            let found = obj::parse_textured(bytes);
            part(found.map_err(|error| Failure::input(foreign(&error)))?, file)
        }
        Format::Model => {
            let arrays = arrays::parse(bytes).or_input()?;
            match file.is_head() {
                true => model_mesh::head_from_arrays(&arrays).or_input().map(whole),
                false => part(whole(model_mesh::from_arrays(&arrays).or_input()?), file),
            }
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Gltf,
    Model,
    /// A pair file, which has two meshes.
    Pair,
    /// No mesh at all.
    Image(image::Format),
}

impl Format {
    fn of(path: &Path) -> io::Result<Self> {
        let mut start = Vec::new();
        File::open(path)?.take(512).read_to_end(&mut start)?;
        Ok(Self::detected(&start))
    }

    /// The format of a file from its first bytes. An OBJ file may begin with any line of text.
    fn detected(start: &[u8]) -> Self {
        if let Some(found) = image::Format::detect(start) {
            return Self::Image(found);
        }
        let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
        match start {
            [b'g', b'l', b'T', b'F', ..] => Self::Gltf,
            _ if ply::is_ply(start) => Self::Ply,
            _ if pair_file::is_pair_file(start) => Self::Pair,
            // A ZIP archive, a single array, and how pickles of a dict begin.
            [b'P', b'K', 3 | 5, ..] | [0x93, b'N', b'U', ..] | [0x80, ..] => Self::Model,
            [b'(', b'd', ..] | [b'}', b'q' | 0x94 | b'(' | b'.', ..] => Self::Model,
            _ if text.first() == Some(&b'{') => Self::Gltf,
            _ => Self::Obj,
        }
    }
}

fn is_image(found: image::Format) -> Failure {
    Failure::input(format!(
        "a mesh must be an OBJ, PLY, GLB or glTF file, a body model (NPZ, pickle) or a pair file, got a \
         {found} image"
    ))
}

/// The target of a pair, or the selected side.
fn side(pair: &PairFile, file: &MeshFile) -> Result<TexturedMesh> {
    let mesh = match file.selector.as_deref() {
        None | Some("target") => pair.pair.target(),
        Some("source") => pair.pair.source(),
        Some(other) => {
            let other = shortened(other);
            return Err(Failure::input(format!(
                "the side of a pair must be source or target, got {other:?}"
            )));
        }
    };
    Ok(whole(mesh.clone()))
}

/// What the user can select where a UV set is missing.
fn with_hint(error: &SceneMeshError, file: &MeshFile) -> String {
    let SceneMeshError::NoUvSet { sets, .. } = error else { return error.to_string() };
    let name = file.file.name().file_name().unwrap_or_default().to_string_lossy();
    let other = match sets.first().and_then(|set| set.strip_prefix("TEXCOORD_")) {
        Some(set) => format!("another set ({name}#{set}) or "),
        None => String::new(),
    };
    format!("{error}; select {other}a node, mesh or material with that set ({name}#NAME)")
}

/// Anything unknown is read as OBJ, whose reader does not know of the other formats.
fn foreign(error: &ObjError) -> String {
    match error {
        ObjError::Binary { .. } | ObjError::NotObj => format!(
            "{error}; a mesh must be an OBJ, PLY, GLB or glTF file, or a body model (NPZ, pickle)"
        ),
        _ => error.to_string(),
    }
}

/// The polygons of the selected object, group or material, or all without a selector. Of these
/// three kinds the first one counts that has the name.
fn part(found: TexturedMesh, file: &MeshFile) -> Result<TexturedMesh> {
    let Some(name) = file.selector.as_deref() else { return Ok(found) };
    let TexturedMesh { mesh, without_uv } = found;
    let kinds: [fn(&MeshPart, &str) -> bool; 3] = [
        |part, name| part.object == name,
        // A polygon may be in several groups.
        |part, name| part.group == name || part.group.split_whitespace().any(|word| word == name),
        |part, name| part.material == name,
    ];
    let bare = &without_uv.parts;
    let Some(kind) =
        kinds.into_iter().find(|kind| mesh.parts().iter().chain(bare).any(|p| kind(p, name)))
    else {
        let hint = match file.choice() {
            MeshChoice { name: None, .. } => " (only GLB and glTF files have several UV sets)",
            _ => "",
        };
        return Err(Failure::input(format!(
            "no object, group or material is named {:?}{hint}; {}",
            shortened(name),
            known(&mesh.parts().iter().chain(bare))
        )));
    };
    let is_kept = |part: &MeshPart| kind(part, name);
    if !mesh.parts().iter().any(is_kept) {
        let name = shortened(name);
        return Err(Failure::input(format!("no polygon of {name:?} has UV coordinates")));
    }
    let without_uv = without_uv.only_parts(is_kept);
    let mesh = mesh.only_parts(is_kept).or_input()?;
    Ok(TexturedMesh { mesh, without_uv })
}

/// The names of parts, for messages.
fn known<'p>(parts: &(impl Iterator<Item = &'p MeshPart> + Clone)) -> String {
    let kinds: [fn(&MeshPart) -> &str; 3] = [|p| &p.object, |p| &p.group, |p| &p.material];
    let all = kinds.into_iter().flat_map(|kind| parts.clone().map(kind));
    let mut known = HashSet::new();
    let names: Vec<&str> = all.filter(|name| !name.is_empty() && known.insert(*name)).collect();
    if names.is_empty() {
        return "the file names none".to_owned();
    }
    format!("must be one of {}", listed(names.into_iter().map(shortened)))
}

fn shortened(name: &str) -> String {
    match name.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    #[test]
    fn the_longest_existing_path_counts() {
        let folder = folder(&[("a.glb", ""), ("b#1.glb", ""), ("c", ""), ("c#d", "")]);
        std::fs::create_dir(folder.path().join("e#f")).unwrap();
        std::fs::write(folder.path().join("e#f/a.obj"), "").unwrap();
        for (given, path, selector) in [
            ("a.glb", "a.glb", None),
            ("a.glb#", "a.glb", None),
            ("a.glb#1", "a.glb", Some("1")),
            ("a.glb#Head/1", "a.glb", Some("Head/1")),
            ("a.glb#Head #2", "a.glb", Some("Head #2")),
            ("b#1.glb", "b#1.glb", None),
            ("b#1.glb#0", "b#1.glb", Some("0")),
            ("c#d", "c#d", None),
            ("c#d#x", "c#d", Some("x")),
            ("c#x", "c", Some("x")),
            ("e#f/a.obj", "e#f/a.obj", None),
            ("e#f/a.obj#x", "e#f/a.obj", Some("x")),
            ("none.glb#1", "none.glb#1", None),
        ] {
            let file = Input::from(folder.path().join(path));
            let wanted = MeshFile { file, selector: selector.map(str::to_owned) };
            let given = Input::from(folder.path().join(given));
            assert_eq!(MeshFile::parse(&given), wanted, "{given}");
        }
    }

    #[test]
    fn selectors_are_names_and_uv_sets() {
        for (selector, name, uv_set) in [
            (None, None, None),
            (Some("1"), None, Some(1)),
            (Some("Head"), Some("Head"), None),
            (Some("Head/1"), Some("Head"), Some(1)),
            (Some("1/0"), Some("1"), Some(0)),
            (Some("a/b"), Some("a/b"), None),
            (Some("+1"), Some("+1"), None),
            (Some("99999999999"), Some("99999999999"), None),
        ] {
            let file = MeshFile { file: "a.glb".into(), selector: selector.map(str::to_owned) };
            let wanted = MeshChoice { name: name.map(str::to_owned), uv_set };
            assert_eq!(file.choice(), wanted, "{selector:?}");
        }
        let file = MeshFile { file: "x/a.glb".into(), selector: Some("Head/1".to_owned()) };
        assert_eq!(file.name(), "a.glb#Head/1");
    }

    #[test]
    fn formats_are_detected_from_the_content() {
        let cases: [(&[u8], Format); 17] = [
            (b"\x89PNG\r\n\x1a\n\0", Format::Image(image::Format::PNG)),
            (b"\x07\x01\0\0\0\0\0\0{\"__", Format::Pair),
            (b"{\"a\": 1}", Format::Gltf),
            (b"glTF\x02\0\0\0", Format::Gltf),
            (b"\xef\xbb\xbf \n{", Format::Gltf),
            (b"ply\r\nformat", Format::Ply),
            (b"PK\x03\x04", Format::Model),
            (b"\x93NUMPY", Format::Model),
            (b"\x80\x02}q", Format::Model),
            (b"(dp0\n", Format::Model),
            (b"}q\x01(", Format::Model),
            (b"# Blender", Format::Obj),
            (b"PK is not an archive", Format::Obj),
            (b"\xef\xbb\xbfv 0 0 0", Format::Obj),
            (b"plywood", Format::Obj),
            (b"", Format::Obj),
            (b"g lTF", Format::Obj),
        ];
        for (start, wanted) in cases {
            assert_eq!(Format::detected(start), wanted, "{}", start.escape_ascii());
        }
    }

    #[test]
    fn bytes_are_read_as_files_are() {
        let text = format!("{SQUARE}o face\nf 1/1 2/2 3/3\no cap\nf 1/1 3/3 4/4\n");
        let loaded = read(Input::bytes("a.obj#cap", text.as_bytes())).unwrap();
        assert_eq!((loaded.mesh.polygon_count(), &*loaded.name), (1, "a.obj#cap"));
        let refused = read(Input::bytes("a.obj#hat", text.as_bytes())).unwrap_err().to_string();
        assert!(refused.starts_with("a.obj: ") && refused.ends_with("face, cap"), "{refused}");
    }

    #[test]
    fn parts_without_coordinates_are_left_out() {
        let text = format!(
            "{SQUARE}o face\nf 1/1 2/2 3/3\no hair\nf 1 3 4\nf 1 2 4\nusemtl skin\nf 1/1 3/3 4/4\n\
             o cap\nf 2 3 4\n"
        );
        let load = |selector: &str| read(Input::bytes(format!("a.obj{selector}"), text.as_bytes()));
        for (selector, polygons, left_out) in [
            (
                "",
                2,
                Some(
                    "a.obj: 3 of 5 polygons have no UV coordinates and are left out: \"hair\", \"cap\"",
                ),
            ),
            ("#face", 1, None),
            (
                "#hair",
                1,
                Some(
                    "a.obj#hair: 2 of 3 polygons have no UV coordinates and are left out: \"hair\"",
                ),
            ),
            (
                "#skin",
                1,
                Some("a.obj#skin: 1 of 2 polygons has no UV coordinates and is left out: \"cap\""),
            ),
        ] {
            let loaded = load(selector).unwrap();
            let found = (loaded.mesh.polygon_count(), loaded.left_out());
            assert_eq!(found, (polygons, left_out.map(str::to_owned)), "{selector}");
        }
        let refused = |selector: &str| load(selector).unwrap_err().to_string();
        assert_eq!(refused("#cap"), "a.obj: no polygon of \"cap\" has UV coordinates");
        assert!(
            refused("#hat").ends_with("must be one of face, hair, cap, skin"),
            "{}",
            refused("#hat")
        );
    }

    #[test]
    fn objects_groups_and_materials_are_selected() {
        let text = format!(
            "{SQUARE}o face\ng lids left\nusemtl skin\nf 1/1 2/2 3/3 4/4\n\
             o face\ng skin\nusemtl hair\nf 1/1 2/2 3/3\no cap\nusemtl hair\nf 1/1 3/3 4/4\n"
        );
        let folder =
            folder(&[("a.obj", &text), ("plain.obj", &format!("{SQUARE}f 1/1 2/2 3/3\n"))]);
        let load = |name: &str| read(folder.path().join(name)).map_err(|error| error.to_string());
        for (selector, polygons) in
            [("face", 2), ("cap", 1), ("left", 1), ("lids left", 1), ("skin", 2), ("hair", 2)]
        {
            let loaded = load(&format!("a.obj#{selector}")).unwrap();
            assert_eq!(loaded.mesh.polygon_count(), polygons, "{selector}");
            assert_eq!(loaded.mesh.positions().len(), 4);
            assert_eq!(loaded.name, format!("a.obj#{selector}"));
        }
        assert_eq!(load("a.obj#left").unwrap().mesh.polygon_corners(0).len(), 4);
        let error = load("a.obj#hat").unwrap_err();
        let wanted = "a.obj: no object, group or material is named \"hat\"; must be one of face, cap, \
                      lids left, skin, hair";
        assert!(error.ends_with(wanted), "{error}");
        let error = load("plain.obj#1").unwrap_err();
        let wanted = "(only GLB and glTF files have several UV sets); the file names none";
        assert!(error.ends_with(wanted), "{error}");
    }
}
