//! Materials as drawings have them, for skin and cloth under a photographed or painted texture.
//!
//! Source: VRM Consortium, "VRMC_materials_mtoon-1.0" (specification, 2022).

use super::json::{MToon, TextureInfo};

/// The extension's name.
pub(super) const EXTENSION: &str = "VRMC_materials_mtoon";

/// The extension for a material.
///
/// - `color`: the base colour's texture, which shadows have as well.
pub(super) const fn material(color: TextureInfo) -> MToon {
    MToon {
        spec_version: "1.0",
        // Linear. Light that skin scatters is warm, so its shadows lose green and blue first.
        shade_color_factor: [0.62, 0.47, 0.43],
        shade_multiply_texture: color,
        // Light reaches a little around, and shadows begin softly: textures show pores and folds, which a
        // hard edge would cut through. `shift ± (1 - toony)` is where shading goes from shade to light.
        shading_shift_factor: -0.1,
        shading_toony_factor: 0.6,
        gi_equalization_factor: 0.9,
        // A rim as faint as skin's, and only where light falls.
        rim_lighting_mix_factor: 1.0,
        parametric_rim_color_factor: [0.06, 0.05, 0.045],
        parametric_rim_fresnel_power_factor: 4.0,
        parametric_rim_lift_factor: 0.0,
        outline_width_mode: "none",
    }
}
