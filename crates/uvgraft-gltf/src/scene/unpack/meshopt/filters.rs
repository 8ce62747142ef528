//! Filters that are undone after decoding, in place.
//!
//! # Source
//! Khronos, "EXT_meshopt_compression", appendix B.

/// Unit vectors from an octahedron's map: elements of four numbers, of 8 or 16 bits, of which the third
/// is what stands for 1, and the fourth is kept.
pub fn octahedral(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    let width = match stride {
        4 => 1,
        8 => 2,
        _ => return Err(format!("the filter OCTAHEDRAL wants a stride of 4 or 8, got {stride}")),
    };
    let most = if width == 1 { 127.0 } else { 32_767.0 };
    for element in bytes.chunks_exact_mut(stride) {
        let [x, y, one] = [0, 1, 2].map(|k| get(element, k, width));
        let one = if one == 0.0 { 1.0 } else { one };
        let (x, y) = (x / one, y / one);
        let z = 1.0 - x.abs() - y.abs();
        // The lower half is folded over the upper one.
        let fold = (-z).max(0.0);
        let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
        let scale = most / (x * x + y * y + z * z).sqrt();
        for (k, value) in [x, y, z].into_iter().enumerate() {
            set(element, k, width, value * scale);
        }
    }
    Ok(())
}

/// Rotations from their three smallest components; the fourth number tells the range, and in its lowest
/// two bits which one is the largest.
pub fn quaternion(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    if stride != 8 {
        return Err(format!("the filter QUATERNION wants a stride of 8, got {stride}"));
    }
    for element in bytes.chunks_exact_mut(stride) {
        let told = i16::from_le_bytes([element[6], element[7]]);
        let largest = usize::from(told as u16 & 3);
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(told | 3);
        let three = [0, 1, 2].map(|k| get(element, k, 2) * scale);
        let rest = 1.0 - three.iter().map(|value| value * value).sum::<f32>();
        set(element, largest, 2, rest.max(0.0).sqrt() * 32_767.0);
        for (k, value) in three.into_iter().enumerate() {
            set(element, (largest + 1 + k) % 4, 2, value * 32_767.0);
        }
    }
    Ok(())
}

/// Floats from a signed mantissa of 24 bits and an exponent of 8 above it.
pub fn exponential(bytes: &mut [u8], stride: usize) -> Result<(), String> {
    if !stride.is_multiple_of(4) {
        return Err(format!("the filter EXPONENTIAL wants a multiple of 4 bytes, got {stride}"));
    }
    for word in bytes.chunks_exact_mut(4) {
        let told = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let (exponent, mantissa) = (told >> 24, told << 8 >> 8);
        let value = f64::from(mantissa) * f64::from(exponent).exp2();
        word.copy_from_slice(&(value as f32).to_le_bytes());
    }
    Ok(())
}

fn get(element: &[u8], index: usize, width: usize) -> f32 {
    if width == 1 {
        f32::from(element[index] as i8)
    } else {
        f32::from(i16::from_le_bytes([element[2 * index], element[2 * index + 1]]))
    }
}

/// Rounded to the nearest; what is no number is 0.
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
        // The last one is the lower pole, to where all corners of the map are folded.
        assert_eq!(bytes.map(|v| v as i8), [127, 0, 0, 5, 0, 0, 127, -1, 0, 0, -127, 0]);
        assert!(octahedral(&mut bytes, 12).is_err());
        let mut zero = [0; 8];
        octahedral(&mut zero, 8).unwrap();
        assert_eq!(zero, [0, 0, 0, 0, 0xff, 0x7f, 0, 0]);
    }

    #[test]
    fn the_largest_component_is_what_is_left() {
        // Half a turn about y: everything but the largest, which is number 1, is 0.
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
}
