//! Decoders for indices: triangles coded relative to recent edges and vertices, and sequences of
//! differences.
//!
//! # Source
//! Khronos, "EXT_meshopt_compression", "Mode 1: triangles" and "Mode 2: indices".

use super::{Stream, signed};

const TRIANGLES_HEADER: u8 = 0xe1;
const SEQUENCE_HEADER: u8 = 0xd1;
/// Length of the table at the end of a triangle stream: frequent pairs of vertex codes.
const TABLE: usize = 16;
/// Length of the tail of a sequence, in bytes.
const TAIL: usize = 4;

/// A FIFO of the last 16 values, addressed by age.
#[derive(Default)]
struct Recent<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, value: T) {
        self.ring[self.next] = value;
        self.next = (self.next + 1) % 16;
    }

    /// - `age`: 0 for the newest.
    fn get(&self, age: usize) -> T {
        self.ring[(self.next + 31 - age) % 16]
    }
}

/// The decoder state that corners of triangles are coded against.
struct Corners<'a> {
    data: Stream<'a>,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// The next new vertex.
    next: u32,
    /// The last explicitly coded vertex.
    last: u32,
}

/// Codes of a corner: a new vertex, or an explicit index; in between, a recent vertex.
const NEW: u8 = 0;
const EXPLICIT: u8 = 15;

impl Corners<'_> {
    fn new_vertex(&mut self) -> u32 {
        let vertex = self.next;
        self.next = vertex.wrapping_add(1);
        vertex
    }

    fn explicit(&mut self) -> Result<u32, String> {
        self.last = self.last.wrapping_add(signed(self.data.number()?));
        Ok(self.last)
    }

    /// A triangle that shares a recent edge.
    ///
    /// The high half of `code` selects the edge, the low half the third corner: new, recent, the
    /// last explicit vertex -1 or +1, or explicit.
    fn at_edge(&mut self, code: u8) -> Result<[u32; 3], String> {
        let [a, b] = self.edges.get(usize::from(code >> 4));
        let c = match code & 15 {
            NEW => self.new_vertex(),
            known @ 1..=12 => {
                let c = self.vertices.get(usize::from(known));
                self.edges.push([c, b]);
                self.edges.push([a, c]);
                return Ok([a, b, c]);
            }
            13 => {
                self.last = self.last.wrapping_sub(1);
                self.last
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                self.last
            }
            _ => self.explicit()?,
        };
        self.vertices.push(c);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// A triangle without a shared edge: codes of its three corners, the second and third in one
    /// byte.
    fn detached(&mut self, first: u8, pair: u8) -> Result<[u32; 3], String> {
        let codes = [first, pair >> 4, pair & 15];
        // New vertices are numbered before explicit ones are read.
        let mut corners = [0; 3];
        for (corner, code) in corners.iter_mut().zip(codes) {
            *corner = match code {
                NEW => self.new_vertex(),
                EXPLICIT => 0,
                known => self.vertices.get(usize::from(known) - 1),
            };
        }
        for (corner, code) in corners.iter_mut().zip(codes) {
            if code == EXPLICIT {
                *corner = self.explicit()?;
            }
        }
        for (corner, code) in corners.into_iter().zip(codes) {
            if code == NEW || code == EXPLICIT {
                self.vertices.push(corner);
            }
        }
        let [a, b, c] = corners;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok(corners)
    }
}

/// Decodes triangles to indices of `stride` bytes.
///
/// A code byte for each triangle says how it is formed: `0x00` to `0xef` shares a recent edge,
/// `0xf0` to `0xfd` starts at a new vertex with a frequent pair of codes from the table, and `0xfe`
/// and `0xff` have an explicit pair of codes, with a new or explicit first corner.
///
/// # Errors
/// If the stream has the wrong type, is truncated or has excess bytes.
pub fn triangles(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    if !count.is_multiple_of(3) {
        return Err(format!("indices must be a multiple of 3, got {count}"));
    }
    check(bytes, TRIANGLES_HEADER, stride)?;
    let mut stream = Stream(&bytes[1..]);
    let codes = stream.take(count / 3)?;
    let end = stream.0.len().checked_sub(TABLE).ok_or("truncated stream")?;
    let (data, table) = stream.0.split_at(end);
    let mut corners = Corners {
        data: Stream(data),
        edges: Recent::default(),
        vertices: Recent::default(),
        next: 0,
        last: 0,
    };
    let mut out = Vec::with_capacity(count * stride);
    for &code in codes {
        let triangle = match code {
            0xfe | 0xff => {
                let pair = corners.data.byte()?;
                // An explicit pair of zeros restarts the numbering of new vertices.
                if pair == 0 {
                    corners.next = 0;
                }
                corners.detached(if code == 0xfe { NEW } else { EXPLICIT }, pair)?
            }
            0xf0.. => corners.detached(NEW, table[usize::from(code & 15)])?,
            _ => corners.at_edge(code)?,
        };
        triangle.into_iter().for_each(|index| store(&mut out, index, stride));
    }
    corners.data.finish()?;
    Ok(out)
}

/// Decodes a plain index sequence to indices of `stride` bytes. Each value is a difference to one
/// of two baselines, selected by its lowest bit.
///
/// # Errors
/// If the stream has the wrong type, is truncated or has excess bytes.
pub fn sequence(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    check(bytes, SEQUENCE_HEADER, stride)?;
    let end = bytes.len().checked_sub(TAIL).filter(|&end| end >= 1);
    let mut stream = Stream(&bytes[1..end.ok_or("truncated stream")?]);
    // Each index takes at least one byte.
    if stream.0.len() < count {
        return Err("truncated stream".to_owned());
    }
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(count * stride);
    for _ in 0..count {
        let code = stream.number()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(signed(code >> 1));
        store(&mut out, *last, stride);
    }
    stream.finish()?;
    Ok(out)
}

fn check(bytes: &[u8], header: u8, stride: usize) -> Result<(), String> {
    if stride != 2 && stride != 4 {
        return Err(format!("indices must have 2 or 4 bytes, got {stride}"));
    }
    match bytes.first() {
        Some(&first) if first == header => Ok(()),
        Some(first) => Err(format!("indices must start with {header:#04x}, got {first:#04x}")),
        None => Err("truncated stream".to_owned()),
    }
}

fn store(out: &mut Vec<u8>, index: u32, stride: usize) {
    out.extend(&index.to_le_bytes()[..stride]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_follows_two_baselines() {
        // Baseline 1 rises by 5, baseline 2 by 100, baseline 1 falls by 1, baseline 2 stays.
        let codes = [5_u32 << 2, 100 << 2 | 1, 1 << 1, 1];
        let mut stream = vec![SEQUENCE_HEADER];
        for code in codes {
            if code > 127 {
                stream.extend([(code & 127 | 128) as u8, (code >> 7) as u8]);
            } else {
                stream.push(code as u8);
            }
        }
        stream.extend([0; TAIL]);
        let wanted: Vec<u8> = [5_u16, 100, 4, 100].into_iter().flat_map(u16::to_le_bytes).collect();
        assert_eq!(sequence(&stream, 4, 2).unwrap(), wanted);
        for length in 0..stream.len() {
            assert!(sequence(&stream[..length], 4, 2).is_err(), "{length}");
        }
        assert!(sequence(&stream, 3, 2).unwrap_err().contains("excess"));
    }

    #[test]
    fn triangles_share_edges() {
        // Three new vertices by the table's first pair, then a new one at the newest edge (2, 0),
        // reversed, and an explicit one.
        let mut stream = vec![TRIANGLES_HEADER, 0xf0, 0x00, 0x0f];
        stream.push(20 << 1);
        stream.extend([0; TABLE]);
        let found = triangles(&stream, 9, 4).unwrap();
        let found: Vec<u32> =
            found.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(found, [0, 1, 2, 0, 2, 3, 0, 3, 20]);
        for length in 0..stream.len() {
            assert!(triangles(&stream[..length], 9, 4).is_err(), "{length}");
        }
        assert!(triangles(&stream, 8, 4).is_err() && triangles(&stream, 9, 3).is_err());
    }

    /// Compared with meshoptimizer's own encoder, on a grid and on random triangles.
    #[cfg(feature = "simplify")]
    #[test]
    fn decodes_the_output_of_meshoptimizer() {
        let mut indices: Vec<u32> = Vec::new();
        for y in 0..40_u32 {
            for x in 0..30 {
                let a = y * 31 + x;
                indices.extend([a, a + 1, a + 31, a + 31, a + 1, a + 32]);
            }
        }
        let mut state = 7_u32;
        for _ in 0..999 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            indices.push((state >> 8) % 1271);
        }
        let encoded = meshopt::encode_index_buffer(&indices, 1271).unwrap();
        let decoded = triangles(&encoded, indices.len(), 4).unwrap();
        let found = decoded.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        // Corners may be rotated, but the winding is kept.
        let turned = |t: &[u32]| {
            let first = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
        };
        let found: Vec<u32> = found.collect();
        for (found, wanted) in found.chunks(3).zip(indices.chunks(3)) {
            assert_eq!(turned(found), turned(wanted));
        }
    }
}
