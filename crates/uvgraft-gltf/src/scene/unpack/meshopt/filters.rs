//! Inverse filters, applied in place after decoding.
//!
//! # Source
//! Khronos, "KHR_meshopt_compression", appendix B; all but the filter for colours are in
//! "EXT_meshopt_compression", too.

/// Unit vectors from octahedral encoding: elements of four 8-bit or 16-bit integers, x and y, then
/// the value that represents 1, then one that is kept.
///
/// With `z = 1 - |x| - |y|`, points with negative `z` are unfolded: `x` and `y` move towards 0 by
/// `-z`. The result is normalised.
pub fn octahedral(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    let width = width(stride, "OCTAHEDRAL")?;
    let most = if width == 1 { 127.0 } else { 32_767.0 };
    for element in bytes.chunks_exact_mut(stride) {
        let [x, y, one] = [0, 1, 2].map(|k| get(element, k, width));
        let one = if one == 0.0 { 1.0 } else { one };
        let (x, y) = (x / one, y / one);
        let z = 1.0 - x.abs() - y.abs();
        // The lower hemisphere is folded over the upper one.
        let fold = (-z).max(0.0);
        let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
        let scale = most / (x * x + y * y + z * z).sqrt();
        for (k, value) in [x, y, z].into_iter().enumerate() {
            set(element, k, width, value * scale);
        }
    }
    Ok(())
}

/// Unit quaternions from their three smallest components; the fourth number holds the scale, and in
/// its lowest two bits the index of the largest component, `sqrt(1 - x² - y² - z²)`.
pub fn quaternion(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    if stride != 8 {
        return Err(format!("the stride for the filter QUATERNION must be 8, got {stride}"));
    }
    for element in bytes.chunks_exact_mut(stride) {
        let code = i16::from_le_bytes([element[6], element[7]]);
        let largest = usize::from(code as u16 & 3);
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(code | 3);
        let three = [0, 1, 2].map(|k| get(element, k, 2) * scale);
        let rest = 1.0 - three.iter().map(|value| value * value).sum::<f32>();
        set(element, largest, 2, rest.max(0.0).sqrt() * 32_767.0);
        for (k, value) in three.into_iter().enumerate() {
            set(element, (largest + 1 + k) % 4, 2, value * 32_767.0);
        }
    }
    Ok(())
}

/// Floats `mantissa · 2^exponent`, from a signed 24-bit mantissa with a signed 8-bit exponent above
/// it.
pub fn exponential(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    if !stride.is_multiple_of(4) {
        return Err(format!(
            "the stride for the filter EXPONENTIAL must be a multiple of 4, got {stride}"
        ));
    }
    for word in bytes.chunks_exact_mut(4) {
        let bits = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let (exponent, mantissa) = (bits >> 24, bits << 8 >> 8);
        let value = f64::from(mantissa) * f64::from(exponent).exp2();
        word.copy_from_slice(&(value as f32).to_le_bytes());
    }
    Ok(())
}

/// RGBA colours from luma and two differences of chroma (YCoCg) with `K` bits each, and `K - 1` bits of
/// alpha below a set bit, which tells `K`: elements of four 8-bit or 16-bit integers.
pub fn color(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    let width = width(stride, "COLOR")?;
    let largest = if width == 1 { 255.0 } else { 65_535.0 };
    for element in bytes.chunks_exact_mut(stride) {
        let [y, co, cg, alpha] = [0, 1, 2, 3].map(|k| get(element, k, width) as i32);
        let mask = if width == 1 { 0xff } else { 0xffff };
        let (y, alpha) = (y & mask, alpha & mask);
        // The most that `K` bits hold.
        let most = ((alpha as u32 + 1).next_power_of_two() - 1).max(1) as i32;
        // One bit less than the others: the lowest one is repeated.
        let a = alpha & (most >> 1);
        let rgba = [y + co - cg, y + cg, y - co - cg, a << 1 | a & 1];
        for (k, value) in rgba.into_iter().enumerate() {
            let value = (value as f32 * (largest / most as f32)).clamp(0.0, largest).round();
            element[k * width..][..width].copy_from_slice(&(value as u16).to_le_bytes()[..width]);
        }
    }
    Ok(())
}

/// Bytes of a number, in elements of four.
fn width(stride: usize, filter: &str) -> Result<usize, String> {
    match stride {
        4 | 8 => Ok(stride / 4),
        _ => Err(format!("the stride for the filter {filter} must be 4 or 8, got {stride}")),
    }
}

fn get(element: &[u8], index: usize, width: usize) -> f32 {
    if width == 1 {
        f32::from(element[index] as i8)
    } else {
        f32::from(i16::from_le_bytes([element[2 * index], element[2 * index + 1]]))
    }
}

/// Stores a rounded value; NaN becomes 0.
fn set(element: &mut [u8], index: usize, width: usize, value: f32) {
    if width == 1 {
        element[index] = value.round() as i8 as u8;
    } else {
        element[2 * index..][..2].copy_from_slice(&(value.round() as i16).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_octahedron_are_axes() {
        let mut bytes = [127_i8, 0, 127, 5, 0, 0, 127, -1, 127, 127, 127, 0].map(|v| v as u8);
        octahedral(&mut bytes, 4).unwrap();
        // The last one is the lower pole, to which all corners of the map are folded.
        assert_eq!(bytes.map(|v| v as i8), [127, 0, 0, 5, 0, 0, 127, -1, 0, 0, -127, 0]);
        assert!(octahedral(&mut bytes, 12).is_err());
        let mut zero = [0; 8];
        octahedral(&mut zero, 8).unwrap();
        assert_eq!(zero, [0, 0, 0, 0, 0xff, 0x7f, 0, 0]);
    }

    #[test]
    fn the_largest_component_is_reconstructed() {
        // A rotation by 180° about Y: all components but the largest, number 1, are 0.
        let mut bytes = [0, 0, 0, 0, 0, 0, 0xfd, 0x07];
        quaternion(&mut bytes, 8).unwrap();
        let value = |k: usize| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
        assert_eq!([0, 1, 2, 3].map(value), [0, 32_767, 0, 0]);
        assert!(quaternion(&mut bytes, 4).is_err());
    }

    #[test]
    fn a_mantissa_is_shifted() {
        let word = |exponent: i32, mantissa: i32| exponent << 24 | mantissa & 0xff_ffff;
        let mut bytes = [word(-3, 5), word(2, -1)].map(i32::to_le_bytes).concat();
        exponential(&mut bytes, 4).unwrap();
        assert_eq!(bytes, [0.625_f32, -4.0].map(f32::to_le_bytes).concat());
    }
    #[test]
    fn colours_come_from_luma_and_chroma() {
        let of = |y: i32, co: i32, cg: i32, alpha: i32| [y, co, cg, alpha].map(|value| value as u8);
        // Red 5, green 3 and blue 1 of 7, in three bits: luma 3, chroma 2 and 0. Alpha is 2 of 3, and
        // one of its bits is repeated.
        let mut bytes = [of(3, 2, 0, 0b110), of(255, 0, 0, 0xff), of(0, 0, 0, 0x80)].concat();
        color(&mut bytes, 4).unwrap();
        let seventh = |value: f32| (value * 255.0 / 7.0).round() as u8;
        assert_eq!(bytes[..4], [seventh(5.0), seventh(3.0), seventh(1.0), seventh(4.0)]);
        assert_eq!(bytes[4..], [255, 255, 255, 255, 0, 0, 0, 0]);
        // Sixteen bits, with green from negative chroma; nothing tells the bits of the last one.
        let words = [40_000_u16, 0, (-20_000_i16) as u16, 0xffff, 7, 0, 0, 0];
        let mut bytes = words.map(u16::to_le_bytes).concat();
        color(&mut bytes, 8).unwrap();
        let word = |k: usize| u16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
        assert_eq!([0, 1, 2, 3].map(word), [60_000, 20_000, 60_000, 65_535]);
        assert!(color(&mut bytes, 12).is_err());
    }
}
