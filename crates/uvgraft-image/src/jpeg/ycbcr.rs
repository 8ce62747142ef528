//! Colours of JFIF, where the decoder does not convert them.

/// From Y, Cb and Cr to R, G and B, in place.
pub(super) fn to_rgb(values: &mut [u8]) {
    for texel in values.as_chunks_mut().0 {
        *texel = rgb(*texel);
    }
}

/// JFIF 1.02: from ITU-R BT.601 with all 256 levels.
pub(super) fn rgb([y, cb, cr]: [u8; 3]) -> [u8; 3] {
    let (y, cb, cr) = (f32::from(y), f32::from(cb) - 128.0, f32::from(cr) - 128.0);
    [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb]
        .map(|value| (value + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_and_primaries_are_those_of_jfif() {
        assert_eq!(rgb([100, 128, 128]), [100; 3]);
        for (ycc, wanted) in [
            ([76, 85, 255], [254, 0, 0]),
            ([150, 44, 21], [0, 255, 1]),
            ([29, 255, 107], [0, 0, 254]),
        ] {
            let near = rgb(ycc).iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1);
            assert!(near, "{:?}", rgb(ycc));
        }
    }
}
