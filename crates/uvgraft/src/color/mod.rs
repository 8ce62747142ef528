//! The sRGB transfer function, encodings of texture values, and perceptual colour difference.

mod delta_e;
mod lab;

pub use self::delta_e::delta_e;
pub(crate) use self::lab::LabTables;
pub use self::lab::{lab, lab_distance};

/// How a texture's values are encoded, which decides whether they may be colour-converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Encoding {
    /// Display-referred values with the sRGB transfer function, as in PNG and JPEG.
    Srgb,
    /// Linear light, as in EXR.
    Linear,
    /// Not a colour (normals, roughness, masks); never colour-managed.
    Data,
}

uvgraft_surface::choices!(Encoding {
    Srgb => "srgb", "Display-referred values with the sRGB transfer function";
    Linear => "linear", "Linear light";
    Data => "data", "Not a colour";
});

/// Linear light from an sRGB value; odd around 0, so values outside `0.0..=1.0` survive.
///
/// # Source
/// IEC 61966-2-1, extended to negative values as in scRGB.
pub fn linear_from_srgb(value: f32) -> f32 {
    let magnitude = value.abs();
    let linear = if magnitude <= 0.040_45 {
        magnitude / 12.92
    } else {
        ((magnitude + 0.055) / 1.055).powf(2.4)
    };
    linear.copysign(value)
}

/// Rec. 709 luma: the brightness of a colour as it is stored, with the sRGB transfer function, from 0.0 for
/// black to 1.0 for white. Unlike [`luminance`], it says how light a colour looks rather than how much
/// light there is.
pub fn luma([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Relative luminance: the brightness of linear light in the primaries of sRGB, 1.0 for white.
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// sRGB value from linear light; the inverse of [`linear_from_srgb`].
pub fn srgb_from_linear(value: f32) -> f32 {
    let magnitude = value.abs();
    let encoded = if magnitude <= 0.003_130_8 {
        magnitude * 12.92
    } else {
        1.055 * magnitude.powf(1.0 / 2.4) - 0.055
    };
    encoded.copysign(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_the_standard_at_known_points() {
        for (encoded, linear) in
            [(0.0, 0.0), (0.04, 0.003_095_975), (0.5, 0.214_041_14), (1.0, 1.0)]
        {
            assert!((linear_from_srgb(encoded) - linear).abs() < 1e-6);
            assert!((srgb_from_linear(linear) - encoded).abs() < 1e-6);
        }
        assert_eq!(linear_from_srgb(-0.5), -linear_from_srgb(0.5));
    }
}
