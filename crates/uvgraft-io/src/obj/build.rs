//! Builds a mesh from the statements of an OBJ file.

use uvgraft::mesh::{Corner, Mesh, MeshPart};

use super::cursor::Cursor;
use super::{ObjError, shown};
use crate::textured::{TexturedMesh, WithoutUv};

const VERTEX: &str = "vertex";
const TEXTURE_COORDINATE: &str = "texture coordinate";

/// Maximum bytes of names over all parts. Large scenes need a few megabytes.
const MAX_NAME_BYTES: usize = 1 << 26;

#[derive(Default)]
pub(super) struct Builder {
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    corners: Vec<Corner>,
    sizes: Vec<u32>,
    parts: Parts,
    forward_vertices: Forward,
    forward_uv: Forward,
    without_uv: WithoutUv,
    /// The error of the first polygon without texture coordinates.
    first_without_uv: Option<ObjError>,
}

impl Builder {
    /// Reads one statement, up to the end of its line or the part that is skipped.
    pub(super) fn statement(&mut self, cursor: &mut Cursor<'_>) -> Result<(), ObjError> {
        let Some(keyword) = cursor.word() else { return Ok(()) };
        let line = cursor.line();
        match keyword {
            b"v" => {
                let position = numbers(cursor, line, VERTEX)?;
                self.positions.push(position.map(|value| value as f32));
            }
            b"vt" => {
                let [u, v] = numbers(cursor, line, TEXTURE_COORDINATE)?;
                self.uv.push([u as f32, (1.0 - v) as f32]);
            }
            // `fo`, face outline, is the keyword for faces in early versions of the format.
            b"f" | b"fo" => self.face(cursor, line)?,
            b"o" => self.parts.rename(|parts| &mut parts.object, cursor.rest_of_line()),
            b"g" => self.parts.rename(|parts| &mut parts.group, cursor.rest_of_line()),
            b"usemtl" => self.parts.rename(|parts| &mut parts.material, cursor.rest_of_line()),
            [b'#', ..] => cursor.skip_comment(),
            _ => {
                if let Some(&byte) = keyword.iter().find(|byte| byte.is_ascii_control()) {
                    return Err(ObjError::Binary { line, byte });
                }
            }
        }
        Ok(())
    }

    fn face(&mut self, cursor: &mut Cursor<'_>, line: usize) -> Result<(), ObjError> {
        let start = self.corners.len();
        let (mut found, mut first_bare) = (0, None);
        while let Some(word) = cursor.value() {
            found += 1;
            match self.corner(word, CornerPosition { line, corner: found })? {
                (vertex, Some(uv)) => self.corners.push(Corner { vertex, uv }),
                _ => first_bare = first_bare.or(Some(found)),
            }
        }
        if found < 3 {
            return Err(ObjError::TooFewCorners { line, found });
        }
        if let Some(corner) = first_bare {
            let error = ObjError::NoTextureCoordinate { line, corner };
            if self.corners.len() > start {
                return Err(error);
            }
            let parts = self.without_uv.parts.len();
            self.without_uv.add(self.parts.names(), 1);
            if self.without_uv.parts.len() > parts {
                self.parts.spend_names(line)?;
            }
            self.first_without_uv.get_or_insert(error);
            return Ok(());
        }
        self.parts.add_polygon(line, saturated(self.sizes.len()))?;
        self.sizes.push(saturated(found));
        Ok(())
    }

    /// A corner's vertex, and its texture coordinate, if it has one.
    fn corner(&mut self, word: &[u8], at: CornerPosition) -> Result<(u32, Option<u32>), ObjError> {
        let CornerPosition { line, corner } = at;
        let wrong = || ObjError::Corner { line, corner, found: shown(word) };
        let mut fields = word.split(|&byte| byte == b'/');
        let vertex = fields.next().and_then(integer).ok_or_else(wrong)?;
        let uv = match fields.next() {
            None | Some(b"") => None,
            Some(field) => Some(integer(field).ok_or_else(wrong)?),
        };
        // Some exporters write an empty normal, as in `1/1/`, for none.
        if let Some(field) = fields.next().filter(|field| !field.is_empty()) {
            integer(field).ok_or_else(wrong)?;
        }
        if fields.next().is_some() {
            return Err(wrong());
        }
        let vertex = self.forward_vertices.resolve(VERTEX, vertex, self.positions.len(), at)?;
        let resolved = |uv| self.forward_uv.resolve(TEXTURE_COORDINATE, uv, self.uv.len(), at);
        Ok((vertex, uv.map(resolved).transpose()?))
    }

    /// The mesh, and the error of the first polygon that it lacks.
    pub(super) fn finish(self) -> Result<(TexturedMesh, Option<ObjError>), ObjError> {
        let vertices = self.positions.len();
        if self.sizes.is_empty() {
            if let Some(error) = self.first_without_uv {
                return Err(error);
            }
            let recognised = vertices > 0 || !self.uv.is_empty();
            return Err(if recognised { ObjError::NoFaces { vertices } } else { ObjError::NotObj });
        }
        let missing = [
            self.forward_vertices.missing(VERTEX, vertices),
            self.forward_uv.missing(TEXTURE_COORDINATE, self.uv.len()),
        ];
        if let Some((_, error)) = missing.into_iter().flatten().min_by_key(|&(at, _)| at) {
            return Err(error);
        }
        let mesh = Mesh::from_polygons(self.positions, self.uv, &self.corners, &self.sizes)?;
        let mesh = mesh.with_parts(self.parts.finish());
        Ok((TexturedMesh { mesh, without_uv: self.without_uv }, self.first_without_uv))
    }
}

/// The first `N` numbers on the rest of the line.
fn numbers<const N: usize>(
    cursor: &mut Cursor<'_>,
    line: usize,
    what: &'static str,
) -> Result<[f64; N], ObjError> {
    let mut values = [0.0; N];
    for (index, value) in values.iter_mut().enumerate() {
        let Some(word) = cursor.value() else {
            return Err(ObjError::TooFewNumbers { line, what, found: index, wanted: N });
        };
        *value = std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| ObjError::Number { line, what, found: shown(word) })?;
        if !(*value as f32).is_finite() {
            return Err(ObjError::NotFinite { line, what, found: shown(word) });
        }
    }
    Ok(values)
}

/// An integer with an optional sign. Overflow is far out of range in any case, and is reported as
/// the largest representable integer.
fn integer(field: &[u8]) -> Option<i64> {
    let (digits, sign) = match field {
        [b'-', digits @ ..] => (digits, -1),
        [b'+', digits @ ..] | digits => (digits, 1),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for digit in digits {
        let digit = digit.is_ascii_digit().then(|| i64::from(digit - b'0'))?;
        value = value.saturating_mul(10).saturating_add(digit);
    }
    Some(sign * value)
}

/// For 32-bit counts and indices: [`Mesh`] rejects saturated values as too large.
fn saturated(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct CornerPosition {
    line: usize,
    corner: usize,
}

/// Indices to elements that are not yet defined, to be checked at the end of the file.
///
/// Only those that exceed all previous ones are kept. The first missing one is always among them:
/// all before it exist, so it exceeds them.
#[derive(Default)]
struct Forward {
    records: Vec<(i64, CornerPosition)>,
}

impl Forward {
    /// The 0-based index for an index from 1, or from -1 backwards, with `count` elements so far.
    fn resolve(
        &mut self,
        what: &'static str,
        found: i64,
        count: usize,
        at: CornerPosition,
    ) -> Result<u32, ObjError> {
        let CornerPosition { line, corner } = at;
        let known = count as i64;
        let index = match found {
            0 => return Err(ObjError::ZeroIndex { line, corner, what }),
            1.. => found - 1,
            _ if found < -known => {
                return Err(ObjError::RelativeIndex { line, corner, what, found, count });
            }
            _ => known + found,
        };
        if found > known && self.records.last().is_none_or(|&(highest, _)| found > highest) {
            self.records.push((found, at));
        }
        Ok(u32::try_from(index).unwrap_or(u32::MAX))
    }

    /// The first index beyond the `count` elements at the end of the file.
    fn missing(&self, what: &'static str, count: usize) -> Option<(CornerPosition, ObjError)> {
        let &(found, at) = self.records.iter().find(|&&(found, _)| found > count as i64)?;
        let CornerPosition { line, corner } = at;
        Some((at, ObjError::Index { line, corner, what, found, count }))
    }
}

/// The current names, and the parts so far.
#[derive(Default)]
struct Parts {
    object: String,
    group: String,
    material: String,
    renamed: bool,
    parts: Vec<MeshPart>,
    name_bytes: usize,
}

impl Parts {
    fn rename(&mut self, which: impl FnOnce(&mut Self) -> &mut String, name: String) {
        *which(self) = name;
        self.renamed = true;
    }

    /// The names of the object, the group and the material.
    fn names(&self) -> [&str; 3] {
        [&self.object, &self.group, &self.material]
    }

    fn add_polygon(&mut self, line: usize, polygon: u32) -> Result<(), ObjError> {
        let renamed = std::mem::take(&mut self.renamed);
        if let Some(last) = self.parts.last_mut() {
            let same = |last: &MeshPart| {
                (&last.object, &last.group, &last.material)
                    == (&self.object, &self.group, &self.material)
            };
            if !renamed || same(last) {
                last.polygons.end = polygon.saturating_add(1);
                return Ok(());
            }
        }
        self.spend_names(line)?;
        self.parts.push(MeshPart {
            object: self.object.clone(),
            group: self.group.clone(),
            material: self.material.clone(),
            image: None,
            polygons: polygon..polygon.saturating_add(1),
        });
        Ok(())
    }

    /// Counts the names of a new part towards the limit.
    fn spend_names(&mut self, line: usize) -> Result<(), ObjError> {
        self.name_bytes += self.names().map(str::len).iter().sum::<usize>();
        match self.name_bytes > MAX_NAME_BYTES {
            true => Err(ObjError::Names { line, max: MAX_NAME_BYTES }),
            false => Ok(()),
        }
    }

    fn finish(self) -> Vec<MeshPart> {
        let named = |part: &MeshPart| {
            !(part.object.is_empty() && part.group.is_empty() && part.material.is_empty())
        };
        if self.parts.iter().any(named) { self.parts } else { Vec::new() }
    }
}
