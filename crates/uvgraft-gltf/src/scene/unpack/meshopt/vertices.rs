//! Decoder for vertex attributes: each byte position is a separate stream of zigzag-coded
//! differences to the previous element.
//!
//! # Source
//! Khronos, "EXT_meshopt_compression", "Mode 0: attributes".

use super::Stream;

/// First byte of a stream.
const HEADER: u8 = 0xa0;
/// Elements in a group, whose differences have a common bit width.
const GROUP: usize = 16;
/// Minimum length of the stream's tail, which lets fast decoders read ahead.
const TAIL: usize = 32;

/// Decodes elements of `stride` bytes.
///
/// Elements are in blocks of at most 256 elements and 8192 bytes. A block stores byte 0 of all its
/// elements, then byte 1, and so on, as differences to the same byte of the previous element; the
/// first element's predecessor is stored at the end of the stream. Each group of 16 differences
/// has a width of 0, 2, 4 or 8 bits.
///
/// # Errors
/// If the stream has the wrong type, is truncated or has excess bytes.
pub fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err(format!("stride must be a multiple of 4 up to 256, got {stride}"));
    }
    let mut stream = Stream(bytes);
    let header = stream.byte()?;
    if header != HEADER {
        return Err(format!("attributes must start with {HEADER:#04x}, got {header:#04x}"));
    }
    let tail = stride.max(TAIL);
    let end = stream.0.len().checked_sub(tail).ok_or("truncated stream")?;
    // The predecessor of the first element is at the end of the stream.
    let mut last = bytes[bytes.len() - stride..].to_vec();
    stream.0 = &stream.0[..end];
    // Even constant elements take two bits for each byte position of 16 elements, which bounds the
    // number of elements by the length of the stream.
    if count / 64 * stride > end {
        return Err("truncated stream".to_owned());
    }
    let block = (8192 / stride).min(256) / GROUP * GROUP;
    let mut elements = vec![0; count * stride];
    let mut differences = vec![0; block];
    for elements in elements.chunks_mut(block * stride) {
        let count = elements.len() / stride;
        let differences = &mut differences[..count.next_multiple_of(GROUP)];
        for k in 0..stride {
            read(&mut stream, differences)?;
            let mut value = last[k];
            for (element, &difference) in elements.chunks_exact_mut(stride).zip(&*differences) {
                value = value.wrapping_add((difference >> 1) ^ (difference & 1).wrapping_neg());
                element[k] = value;
            }
        }
        last.copy_from_slice(&elements[elements.len() - stride..]);
    }
    if !stream.0.is_empty() {
        return Err(format!("stream has {} excess bytes", stream.0.len()));
    }
    Ok(elements)
}

/// Reads one byte position of a block: the widths of all groups, then the groups.
fn read(stream: &mut Stream<'_>, out: &mut [u8]) -> Result<(), String> {
    let widths = stream.take((out.len() / GROUP).div_ceil(4))?;
    for (index, group) in out.chunks_exact_mut(GROUP).enumerate() {
        match widths[index / 4] >> (index % 4 * 2) & 3 {
            0 => group.fill(0),
            1 => narrow(stream, group, 2)?,
            2 => narrow(stream, group, 4)?,
            _ => group.copy_from_slice(stream.take(GROUP)?),
        }
    }
    Ok(())
}

/// Reads values of 2 or 4 bits, highest bits of a byte first; values with all bits set are escapes,
/// replaced by full bytes stored after the group.
fn narrow(stream: &mut Stream<'_>, group: &mut [u8], bits: usize) -> Result<(), String> {
    let packed = stream.take(GROUP * bits / 8)?;
    let most = (1 << bits) - 1;
    for (index, value) in group.iter_mut().enumerate() {
        let bit = index * bits;
        let small = packed[bit / 8] >> (8 - bits - bit % 8) & most;
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
        let mut tail = [0; TAIL];
        tail[TAIL - 4..].copy_from_slice(&[10, 20, 30, 40]);
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
        other[0] = 0xa1;
        assert!(decode(&other, 2, 4).unwrap_err().contains("0xa1"));
    }
}
