//! Decoder for vertex attributes: each byte position is a separate stream of differences to the
//! previous element.
//!
//! # Source
//! Khronos, "KHR_meshopt_compression", "Mode 0: attributes"; version 0 is that of
//! "EXT_meshopt_compression".

use super::Stream;

/// First byte of a stream of version 0; that of version 1 is one more.
const HEADER: u8 = 0xa0;
/// Elements in a group, whose differences have a common bit width.
const GROUP: usize = 16;
/// Bytes that are decoded to values together.
const CHANNEL: usize = 4;

/// Bit widths that a group's two header bits select.
type Widths = [u8; 4];
/// Widths in version 0.
const PLAIN: Widths = [0, 2, 4, 8];
/// Widths of a byte position in control modes 0 and 1 of version 1.
const CONTROLLED: [Widths; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// How the four bytes of a channel are differences to those of the previous element.
#[derive(Debug, Clone, Copy)]
enum Mode {
    /// Zigzag-coded differences of bytes.
    Bytes,
    /// Zigzag-coded differences of 16-bit integers.
    Words,
    /// Bits that differ, rotated to the left by a number of bits.
    Bits(u32),
}

impl Mode {
    fn new(code: u8) -> Result<Self, String> {
        Ok(match (code & 15, code >> 4) {
            (0, 0) => Self::Bytes,
            (1, 0) => Self::Words,
            (2, rotation) => Self::Bits(rotation.into()),
            _ => {
                return Err(format!(
                    "channel mode must be 0, 1 or 2 in its lower four bits and 0 in the others unless it \
                     is 2, got {code:#04x}"
                ));
            }
        })
    }

    /// Writes the values of a channel that are `differences` to their predecessors.
    ///
    /// - `differences`: of each byte position, one after the other; may be more than the elements.
    /// - `last`: values of the element before the first.
    /// - `start`: where the channel is in an element.
    fn add_up(
        self,
        differences: &[u8],
        last: [u8; CHANNEL],
        start: usize,
        (elements, stride): (&mut [u8], usize),
    ) {
        let columns = differences.chunks_exact(differences.len() / CHANNEL);
        if matches!(self, Self::Bytes) {
            for (k, (differences, mut value)) in columns.zip(last).enumerate() {
                let elements = elements.chunks_exact_mut(stride);
                for (element, &zigzag) in elements.zip(differences) {
                    value = value.wrapping_add((zigzag >> 1) ^ (zigzag & 1).wrapping_neg());
                    element[start + k] = value;
                }
            }
            return;
        }
        let columns: Vec<&[u8]> = columns.collect();
        let mut value = u32::from_le_bytes(last);
        for (index, element) in elements.chunks_exact_mut(stride).enumerate() {
            let difference = u32::from_le_bytes([0, 1, 2, 3].map(|k| columns[k][index]));
            value = match self {
                Self::Bits(rotation) => value ^ difference.rotate_right(rotation),
                _ => words(value, difference),
            };
            element[start..start + CHANNEL].copy_from_slice(&value.to_le_bytes());
        }
    }
}

/// Adds zigzag-coded differences to both 16-bit halves.
fn words(value: u32, zigzag: u32) -> u32 {
    let halves = [0, 16].map(|shift| {
        let (value, zigzag) = ((value >> shift) as u16, (zigzag >> shift) as u16);
        let sum = value.wrapping_add((zigzag >> 1) ^ (zigzag & 1).wrapping_neg());
        u32::from(sum) << shift
    });
    halves[0] | halves[1]
}

/// Decodes elements of `stride` bytes.
///
/// Elements are in blocks of at most 256 elements and 8192 bytes. A block stores byte 0 of all its
/// elements, then byte 1, and so on, as differences to the previous element; the first element's
/// predecessor is stored at the end of the stream. Each group of 16 differences has a width of up to
/// 8 bits. Version 1 states at the start of a block how the widths of each byte position are coded, and
/// at the end of the stream how the differences of each four byte positions are meant.
///
/// # Errors
/// If the stream has the wrong type, is truncated or has excess bytes.
pub fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(CHANNEL) {
        return Err(format!("stride must be a multiple of 4 up to 256, got {stride}"));
    }
    let mut stream = Stream(bytes);
    let header = stream.byte()?;
    let is_new = header == HEADER + 1;
    if header != HEADER && !is_new {
        return Err(format!("attributes must start with 0xa0 or 0xa1, got {header:#04x}"));
    }
    // The tail has a minimum length, which lets fast decoders read ahead.
    let (modes, least) = if is_new { (stride / CHANNEL, 24) } else { (0, 32) };
    let end = stream.0.len().checked_sub((stride + modes).max(least)).ok_or("truncated stream")?;
    // The predecessor of the first element is at the end of the stream, only modes follow.
    let (first, modes) = bytes[bytes.len() - stride - modes..].split_at(stride);
    let mut last = first.to_vec();
    let modes = match is_new {
        true => modes.iter().map(|&code| Mode::new(code)).collect::<Result<Vec<_>, _>>()?,
        false => vec![Mode::Bytes; stride / CHANNEL],
    };
    stream.0 = &stream.0[..end];
    let block = (8192 / stride).min(256) / GROUP * GROUP;
    // What even constant elements take bounds the number of elements by the length of the stream: two
    // bits for each byte position, of every 16 elements or in version 1 of every block.
    let least = if is_new { count / block * stride / CHANNEL } else { count / 64 * stride };
    if least > end {
        return Err("truncated stream".to_owned());
    }
    let mut elements = vec![0; count * stride];
    let mut differences = vec![0; CHANNEL * block];
    for elements in elements.chunks_mut(block * stride) {
        let count = elements.len() / stride;
        let padded = count.next_multiple_of(GROUP);
        let controls = if is_new { Some(stream.take(stride / CHANNEL)?) } else { None };
        for (channel, &mode) in modes.iter().enumerate() {
            for (k, out) in differences[..CHANNEL * padded].chunks_exact_mut(padded).enumerate() {
                let control = controls.map(|controls| controls[channel] >> (2 * k) & 3);
                read(&mut stream, control, count, out)?;
            }
            let start = channel * CHANNEL;
            let last = [0, 1, 2, 3].map(|k| last[start + k]);
            mode.add_up(&differences[..CHANNEL * padded], last, start, (&mut *elements, stride));
        }
        last.copy_from_slice(&elements[elements.len() - stride..]);
    }
    stream.finish()?;
    Ok(elements)
}

/// Reads one byte position of a block.
///
/// - `control`: in version 1, how it is stored.
/// - `count`: number of elements; `out` has as many, rounded up to whole groups.
fn read(
    stream: &mut Stream<'_>,
    control: Option<u8>,
    count: usize,
    out: &mut [u8],
) -> Result<(), String> {
    match control {
        None => groups(stream, PLAIN, out),
        Some(2) => {
            out.fill(0);
            Ok(())
        }
        Some(3) => {
            out[..count].copy_from_slice(stream.take(count)?);
            Ok(())
        }
        Some(mode) => groups(stream, CONTROLLED[usize::from(mode & 1)], out),
    }
}

/// Reads the widths of all groups, then the groups.
fn groups(stream: &mut Stream<'_>, widths: Widths, out: &mut [u8]) -> Result<(), String> {
    let headers = stream.take((out.len() / GROUP).div_ceil(4))?;
    for (index, group) in out.chunks_exact_mut(GROUP).enumerate() {
        match widths[usize::from(headers[index / 4] >> (index % 4 * 2) & 3)] {
            0 => group.fill(0),
            8 => group.copy_from_slice(stream.take(GROUP)?),
            1 => narrow::<1>(stream, group)?,
            2 => narrow::<2>(stream, group)?,
            _ => narrow::<4>(stream, group)?,
        }
    }
    Ok(())
}

/// Reads values of `BITS` bits, 1, 2 or 4, highest bits of a byte first, but single bits lowest first; values
/// with all bits set are escapes, replaced by full bytes stored after the group.
fn narrow<const BITS: usize>(stream: &mut Stream<'_>, group: &mut [u8]) -> Result<(), String> {
    let packed = stream.take(GROUP * BITS / 8)?;
    let most = (1 << BITS) - 1;
    for (index, value) in group.iter_mut().enumerate() {
        let bit = index * BITS;
        let shift = if BITS == 1 { bit % 8 } else { 8 - BITS - bit % 8 };
        let small = packed[bit / 8] >> shift & most;
        *value = if small == most { stream.byte()? } else { small };
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two elements of four bytes, computed by hand: byte 0 rises by 1, then 2; byte 1
    /// falls by 1, then stays; byte 2 rises by 100 (zigzag 200, more than four bits
    /// hold); byte 3 stays at the baseline.
    fn by_hand() -> Vec<u8> {
        let mut stream = vec![HEADER];
        // Widths of the only group: 2 bits, with an escape for 4 (zigzag of +2).
        stream.extend([0b01, 0b10_11_00_00, 0, 0, 0, 4]);
        stream.extend([0b01, 0b01_00_00_00, 0, 0, 0]);
        stream.push(0b11);
        stream.extend([200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        stream.push(0b00);
        let mut tail = [0; 32];
        tail[28..].copy_from_slice(&[10, 20, 30, 40]);
        stream.extend(tail);
        stream
    }

    #[test]
    fn differences_add_up() {
        assert_eq!(decode(&by_hand(), 2, 4).unwrap(), [11, 19, 130, 40, 13, 19, 130, 40]);
    }

    #[test]
    fn streams_of_another_length_are_refused() {
        let stream = by_hand();
        for length in 0..stream.len() {
            assert!(decode(&stream[..length], 2, 4).is_err(), "{length}");
        }
        // More elements than the stream has widths for.
        assert!(decode(&stream, 300, 4).is_err());
        let mut long = stream.clone();
        long.insert(30, 0);
        assert!(decode(&long, 2, 4).unwrap_err().contains("excess"));
        for stride in [0, 3, 260] {
            assert!(decode(&stream, 2, stride).is_err());
        }
        let mut other = stream;
        other[0] = 0xa2;
        assert!(decode(&other, 2, 4).unwrap_err().contains("0xa2"));
    }
    /// Elements of a formula, compressed by meshoptimizer (1.2) to version 1: 16-bit differences,
    /// exclusive or, and differences of bytes, with all kinds of widths.
    const SAMPLE: &str = "\
        a1b769e3ad0058585858585858585858585858585858585858052aaaaaaaaa00000000999999999999999999\
        999999999999999999990208808808808808800b000808080201551155115511550f0001010505000e2a4662\
        7e9ab6d2eef5d9bda185694d311506020020080200c2c2c2c2c2c2c2c2c2c2c2c2c2c2c2c2c2c2c202015051\
        15051150510b00010505000414001404041400140404140014040414001400000000e80360ea0000803f0000\
        09000000000001420042";

    fn sample() -> (Vec<u8>, Vec<u8>) {
        let digits = SAMPLE.as_bytes().chunks_exact(2);
        let stream = digits.map(|pair| {
            let digits = std::str::from_utf8(pair).unwrap();
            u8::from_str_radix(digits, 16).unwrap()
        });
        let elements = (0..20_u32).flat_map(|i| {
            let words = [1000 + 300 * i as u16, 60_000 - 77 * i as u16].map(u16::to_le_bytes);
            let sign = if i % 3 == 1 { -1.0 } else { 1.0 };
            let float = sign * (1.0 + (i * i % 8) as f32 / 8.0);
            let bytes = [i * i * 7, i / 5, 9, i * 97].map(|value| value as u8);
            let bits = (i * i % 5) * 0x1000_0040;
            [
                words.concat(),
                float.to_le_bytes().to_vec(),
                bytes.to_vec(),
                bits.to_le_bytes().to_vec(),
            ]
            .concat()
        });
        (stream.collect(), elements.collect())
    }

    #[test]
    fn version_1_has_modes_for_bytes_and_channels() {
        let (stream, elements) = sample();
        assert_eq!(decode(&stream, 20, 16).unwrap(), elements);
        for length in 0..stream.len() {
            assert!(decode(&stream[..length], 20, 16).is_err(), "{length}");
        }
        // Only exclusive or has a rotation, and there are three modes.
        for (channel, code) in [(3, 0x12), (3, 0x11), (3, 0x10), (2, 3)] {
            let mut other = stream.clone();
            let at = other.len() - 4 + channel;
            other[at] = code;
            let found = decode(&other, 20, 16);
            assert_eq!(found.is_err(), code != 0x12, "{code:#x}: {found:?}");
        }
        // More elements than there can be.
        assert!(decode(&stream, 1 << 20, 16).unwrap_err().contains("truncated"));
    }

    #[test]
    fn flipped_bytes_of_version_1_never_panic() {
        let (stream, _) = sample();
        for at in 0..stream.len() {
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let mut stream = stream.clone();
                stream[at] ^= flip;
                let _ = decode(&stream, 20, 16);
            }
        }
    }

    #[test]
    fn widths_of_version_1_are_chosen_for_each_byte() {
        // Two elements: byte 0 with single bits, of which the second is an escape for +3; byte 1 is
        // stored as it is; byte 2 does not change; byte 3 has four bits.
        let mut stream = vec![HEADER + 1, 0b01_10_11_00];
        stream.extend([0b01, 0b10, 0, 6]);
        stream.extend([1, 4]);
        stream.extend([0b10, 0x23, 0, 0, 0, 0, 0, 0, 0]);
        stream.extend([0; 24 - 5]);
        stream.extend([10, 20, 30, 40, 0]);
        assert_eq!(decode(&stream, 2, 4).unwrap(), [10, 19, 30, 41, 13, 21, 30, 39]);
    }
}
