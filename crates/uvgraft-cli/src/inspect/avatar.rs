//! `uvgraft inspect` of a GLB, VRM or glTF file: what it contains.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use uvgraft_gltf::scene::{ClipContents, Contents, ImageContents, PartContents, contents};

use super::listed;
use crate::failure::OrBadInput;
use crate::outcome;
use crate::report::grouped;
use crate::terminal;

/// Whether a file is a GLB, VRM or glTF file, by its content.
pub(super) fn is_avatar(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).map(|file| file.take(64).read_to_end(&mut start));
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start).trim_ascii_start();
    read.is_ok() && (start.starts_with(b"glTF") || text.starts_with(b"{"))
}

pub(super) fn print(path: &Path) -> anyhow::Result<()> {
    let found = contents(path).or_bad_input()?;
    outcome::report(|| &found, || text(&found))
}

fn text(found: &Contents) -> String {
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<26} {value}");
    };
    row(
        "format",
        found.vrm.map_or_else(|| "glTF 2.0".to_owned(), |version| format!("VRM {version}")),
    );
    if let Some(generator) = &found.generator {
        row("written by", terminal::inline(generator).into_owned());
    }
    let sum = |count: fn(&PartContents) -> usize| {
        found.parts.iter().map(count).fold(0, usize::saturating_add)
    };
    let (vertices, triangles) =
        (grouped(sum(|part| part.vertices)), grouped(sum(|part| part.triangles)));
    row("parts", format!("{}; {vertices} vertices, {triangles} triangles", found.parts.len()));
    for part in &found.parts {
        row(&indented(&part_name(part)), of_part(part));
    }
    row("images", found.images.len().to_string());
    for image in &found.images {
        let name = if image.name.is_empty() { "(no name)" } else { &image.name };
        row(&indented(name), of_image(image));
    }
    row(
        "skeleton",
        match found.joints {
            0 => "none".to_owned(),
            joints => format!("{} joints", grouped(joints)),
        },
    );
    let counted = |names: &[String]| match names.len() {
        0 => "none".to_owned(),
        count => {
            let names: Vec<String> =
                names.iter().map(|it| terminal::inline(it).into_owned()).collect();
            format!("{}: {}", grouped(count), listed(&names))
        }
    };
    row("humanoid bones", counted(&found.bones));
    row("expressions", counted(&found.expressions));
    row("morph targets", counted(&found.morph_targets));
    let clips = found.clips.iter().map(of_clip);
    row("clips", counted(&clips.collect::<Vec<_>>()));
    text
}

/// A name in the column of names.
fn indented(name: &str) -> String {
    const LENGTH: usize = 24;
    let name = terminal::inline(name);
    if name.chars().count() <= LENGTH {
        return format!("  {name}");
    }
    let start: String = name.chars().take(LENGTH - 1).collect();
    format!("  {start}…")
}

/// The node and the material of a part, or its mesh where these have no names.
fn part_name(part: &PartContents) -> String {
    let node = if part.node.is_empty() { &part.mesh } else { &part.node };
    let names: Vec<&str> = [node, &part.material]
        .into_iter()
        .map(String::as_str)
        .filter(|it| !it.is_empty())
        .collect();
    if names.is_empty() { "(no name)".to_owned() } else { names.join(" / ") }
}

fn of_clip(clip: &ClipContents) -> String {
    let ignored = match clip.channels_without_keys {
        0 => String::new(),
        1 => ", 1 channel without keys is ignored".to_owned(),
        count => format!(", {} channels without keys are ignored", grouped(count)),
    };
    format!("{} ({:.2} s{ignored})", clip.name, clip.seconds)
}

fn of_part(part: &PartContents) -> String {
    let (vertices, triangles) = (grouped(part.vertices), grouped(part.triangles));
    let mut text = format!("{vertices} vertices, {triangles} triangles");
    if part.instances != 1 {
        let _ = write!(text, " in {} instances", grouped(part.instances));
    }
    let sets: Vec<String> = part.uv_sets.iter().map(u32::to_string).collect();
    let _ = match &sets[..] {
        [] => write!(text, ", no UV coordinates"),
        [set] => write!(text, ", UV set {set}"),
        _ => write!(text, ", UV sets {}", listed(&sets)),
    };
    if part.is_skinned {
        text += ", skinned";
    }
    if part.morph_targets > 0 {
        let _ = write!(text, ", {} morph targets", grouped(part.morph_targets));
    }
    text
}

fn size(bytes: usize) -> String {
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{} kB", bytes / 1_000),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

fn of_image(image: &ImageContents) -> String {
    let mut said = Vec::new();
    said.extend(image.format.map(str::to_owned));
    said.extend(image.size.map(|[width, height]| format!("{width}×{height}")));
    said.extend(image.bytes.map(size));
    let mut text = said.join(", ");
    if let Some(problem) = &image.problem {
        let _ = write!(
            text,
            "{}{}",
            if text.is_empty() { "" } else { ": " },
            terminal::inline(problem)
        );
    }
    let uses = image.uses.iter().map(|it| match it.material.as_deref() {
        Some("") => format!("{} of a material without a name", it.role),
        Some(material) => format!("{} of {material}", it.role),
        None => it.role.clone(),
    });
    let uses: Vec<String> = uses.map(|it| terminal::inline(&it).into_owned()).collect();
    let uses = if uses.is_empty() { "not used".to_owned() } else { listed(&uses) };
    format!("{text}; {uses}")
}
