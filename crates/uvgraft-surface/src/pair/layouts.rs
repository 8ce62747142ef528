//! Leaves out the parts of a mesh that have another texture than its linked parts.
//!
//! Avatars have several materials, each with an image and all of the unit square for itself: face,
//! hair, clothes. Laid over each other in one texture, linked hair would own texels of the face, and
//! other hair those around it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{Direction, Pair, Side};
use crate::bits;
use crate::listing::listed;
use crate::mesh::{Mesh, MeshPart, triangle_area};
use crate::piece::Piece;
use crate::raster::{ScanTriangle, corners_px};
use crate::size::Size;

/// Side of the texture in which overlaps are counted.
const SIDE: u32 = 512;

/// Where images are unknown, an unlinked part has a layout of its own if it covers more than this share
/// of the linked texels. Parts in one texture share none (the figure's), or a line of texels where islands
/// touch; two parts that each fill the square share 30 % and more.
const OVERLAP: f64 = 0.02;

/// The parts of one mesh that [`Pair::in_one_layout`] left out.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OtherLayouts {
    /// Whose parts they are.
    pub side: Side,
    /// The image of the parts that are kept, as [`MeshPart::image`].
    pub image: Option<String>,
    /// Names of the parts that are kept.
    pub kept: Vec<String>,
    /// The parts that are left out, by name, with their images.
    pub left_out: BTreeMap<String, Option<String>>,
    /// Share of the linked area that they had, 0 to 1.
    pub lost: f64,
}

impl OtherLayouts {
    /// Share of the linked area beyond which leaving parts out is a loss. A neck or a fringe that
    /// lies on the face has less.
    const LOSS: f64 = 0.05;

    /// Whether so much of the linked surface was left out that one should know.
    pub fn is_loss(&self) -> bool {
        self.lost > Self::LOSS
    }

    /// What was left out, and how to choose another part, for a mesh of that name.
    pub fn text(&self, mesh: &str) -> String {
        let image = |image: &Option<String>| match image.as_deref() {
            None => String::new(),
            Some("") => " (no image)".to_owned(),
            Some(image) => format!(" (image {image:?})"),
        };
        let mut text = format!("{mesh}: linked is the layout of {}", listed(&self.kept));
        text += &image(&self.image);
        let names: Vec<String> =
            self.left_out.iter().map(|(name, of)| format!("{name}{}", image(of))).collect();
        let _ = write!(text, "; left out, with layouts of their own: {}", listed(&names));
        if self.is_loss() {
            let _ = write!(text, ", among them {:.0} % of the linked area", 100.0 * self.lost);
        }
        // A selector follows the name of the file.
        let file = mesh.split_once('#').map_or(mesh, |(file, _)| file);
        if let Some(name) = self.left_out.keys().next() {
            let _ = write!(text, "; {file}#{name} selects one");
        }
        text
    }
}

impl Pair {
    /// The pair without the parts of either mesh that do not share the texture of the linked parts, and
    /// what was left out of each mesh.
    ///
    /// - Where images are known, parts with one image are kept: that with the largest linked area.
    /// - Where they are not, parts with links are kept, and others that do not overlap them.
    ///
    /// Vertices and UV coordinates keep their indices, faces do not.
    pub fn in_one_layout(self) -> (Self, Vec<OtherLayouts>) {
        let mut pair = self;
        let mut left_out = Vec::new();
        for (side, direction) in
            [(Side::Source, Direction::Reverse), (Side::Target, Direction::Forward)]
        {
            let Some((keep, others)) = others(&pair, side, direction) else { continue };
            if let Some(restricted) = pair.only_parts(side, &keep) {
                pair = restricted;
                left_out.push(others);
            }
        }
        (pair, left_out)
    }

    /// The pair with the parts of one mesh that are to be kept; `None` if no piece is left.
    fn only_parts(&self, side: Side, keep: &[bool]) -> Option<Self> {
        let mesh = self.mesh(side);
        let mut number = 0;
        let kept = mesh.only_parts(|_| {
            number += 1;
            keep[number - 1]
        });
        let mut numbers = vec![None; mesh.faces().len()];
        let mut next = 0;
        for (part, _) in mesh.parts().iter().zip(keep).filter(|(_, is_kept)| **is_kept) {
            for face in faces_of(mesh, part) {
                numbers[face] = Some(next);
                next += 1;
            }
        }
        let kept = kept.ok().filter(|kept| kept.faces().len() == next as usize)?;
        let pieces = self.pieces().chain(self.pieces_in_other_tiles()).filter_map(|piece| {
            Some(match side {
                Side::Source => Piece { source: numbers[piece.source as usize]?, ..piece },
                Side::Target => Piece { target: numbers[piece.target as usize]?, ..piece },
            })
        });
        let (source, target) = match side {
            Side::Source => (kept, self.target.clone()),
            Side::Target => (self.source.clone(), kept),
        };
        Self::from_pieces(source, target, pieces).ok()
    }

    fn mesh(&self, side: Side) -> &Mesh {
        match side {
            Side::Source => &self.source,
            Side::Target => &self.target,
        }
    }
}

/// Which parts of a mesh are kept, and the others; `None` if all are.
fn others(pair: &Pair, side: Side, direction: Direction) -> Option<(Vec<bool>, OtherLayouts)> {
    let mesh = pair.mesh(side);
    let parts = mesh.parts();
    if parts.len() < 2 {
        return None;
    }
    let pieces = pair.face_pieces(direction);
    let is_linked = |face: usize| !pieces.of_face(face).is_empty();
    let linked: Vec<f64> = parts
        .iter()
        .map(|part| {
            let faces = faces_of(mesh, part).filter(|&face| is_linked(face));
            faces.map(|face| triangle_area(mesh.triangle(face))).sum()
        })
        .collect();
    let keep = if parts.iter().all(|part| part.image.is_some()) {
        with_one_image(parts, &linked)
    } else {
        without_overlaps(mesh, &is_linked)
    };
    if keep.iter().all(|&is_kept| is_kept) {
        return None;
    }
    let lost: f64 =
        linked.iter().zip(&keep).filter(|(_, is_kept)| !**is_kept).map(|(area, _)| area).sum();
    let chosen = |is_kept: bool| {
        parts.iter().zip(&keep).filter(move |(_, kept)| **kept == is_kept).map(|(part, _)| part)
    };
    let names = Names::new(parts, &keep);
    let kept: BTreeSet<&str> = chosen(true).map(|part| names.of(part)).collect();
    let left_out =
        chosen(false).map(|part| (names.of(part).to_owned(), part.image.clone())).collect();
    let others = OtherLayouts {
        side,
        image: chosen(true).next().and_then(|part| part.image.clone()),
        kept: kept.into_iter().map(str::to_owned).collect(),
        left_out,
        lost: lost / linked.iter().sum::<f64>(),
    };
    Some((keep, others))
}

/// The parts with the image that has the largest linked area.
fn with_one_image(parts: &[MeshPart], linked: &[f64]) -> Vec<bool> {
    let mut areas: BTreeMap<&Option<String>, f64> = BTreeMap::new();
    for (part, area) in parts.iter().zip(linked) {
        *areas.entry(&part.image).or_default() += area;
    }
    let best = areas.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(image, _)| image);
    parts.iter().map(|part| Some(&part.image) == best).collect()
}

/// The parts with links, and those that overlap none of them. Parts with the same material, or else the
/// same object, go together.
fn without_overlaps(mesh: &Mesh, is_linked: &dyn Fn(usize) -> bool) -> Vec<bool> {
    let parts = mesh.parts();
    let key = |part: &MeshPart| {
        let names = [&part.material, &part.object, &part.group];
        names.into_iter().find(|name| !name.is_empty()).cloned()
    };
    let mut of_group: BTreeMap<Option<String>, Vec<usize>> = BTreeMap::new();
    for part in parts {
        of_group.entry(key(part)).or_default().extend(faces_of(mesh, part));
    }
    let covered = texels_of(mesh, (0..mesh.faces().len()).filter(|&face| is_linked(face)));
    let count = |words: &mut dyn Iterator<Item = u64>| words.map(u64::count_ones).sum::<u32>();
    let texels = count(&mut covered.iter().copied());
    let mut apart: BTreeSet<Option<String>> = BTreeSet::new();
    for (group, faces) in of_group {
        if faces.iter().any(|&face| is_linked(face)) {
            continue;
        }
        let own = texels_of(mesh, faces.into_iter());
        let shared = count(&mut own.iter().zip(&covered).map(|(own, covered)| own & covered));
        if f64::from(shared) > OVERLAP * f64::from(texels) {
            apart.insert(group);
        }
    }
    parts.iter().map(|part| !apart.contains(&key(part))).collect()
}

/// The texels of faces in a texture of [`SIDE`]²: for each row a bit set of columns.
fn texels_of(mesh: &Mesh, faces: impl Iterator<Item = usize>) -> Vec<u64> {
    let size = Size::square(SIDE);
    let words = bits::words(SIDE);
    let mut covered = vec![0; words * SIDE as usize];
    let inside = faces.filter(|&face| !mesh.is_outside(face));
    for triangle in inside.filter_map(|face| ScanTriangle::new(corners_px(mesh, face, size), size))
    {
        for row in triangle.rows() {
            let columns = &mut covered[row as usize * words..][..words];
            bits::insert_range(columns, &triangle.span(row));
        }
    }
    covered
}

/// The triangles of a part. Ranges of parts are for information and may be wrong.
fn faces_of(mesh: &Mesh, part: &MeshPart) -> impl Iterator<Item = usize> {
    let end = (part.polygons.end as usize).min(mesh.polygon_count());
    let polygons = part.polygons.start as usize..end;
    if polygons.is_empty() {
        0..0
    } else {
        mesh.polygon(polygons.start).start..mesh.polygon(end - 1).end
    }
}

/// What to call parts: by a name that only parts have which are kept, or which are left out, so that
/// it selects them.
struct Names<'a> {
    shared: [BTreeSet<&'a str>; 3],
}

impl<'a> Names<'a> {
    fn new(parts: &'a [MeshPart], keep: &[bool]) -> Self {
        let shared = [0, 1, 2].map(|kind| {
            let named = |is_kept: bool| -> BTreeSet<&str> {
                let chosen = parts.iter().zip(keep).filter(|(_, kept)| **kept == is_kept);
                chosen.map(|(part, _)| of_kind(part)[kind]).collect()
            };
            named(true).intersection(&named(false)).copied().collect()
        });
        Self { shared }
    }

    fn of<'p>(&self, part: &'p MeshPart) -> &'p str {
        let names = of_kind(part);
        let own = names
            .into_iter()
            .zip(&self.shared)
            .find(|(name, shared)| !name.is_empty() && !shared.contains(name));
        let any = || names.into_iter().find(|name| !name.is_empty());
        own.map(|(name, _)| name).or_else(any).unwrap_or("a part without a name")
    }
}

/// The names of a part, in the order in which selectors look for them.
fn of_kind(part: &MeshPart) -> [&str; 3] {
    [&part.object, &part.group, &part.material]
}
