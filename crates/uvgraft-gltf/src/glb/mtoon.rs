//! Toon materials (MToon) for skin and cloth with a photographed or painted texture.
//!
//! Source: VRM Consortium, "VRMC_materials_mtoon-1.0" (specification, 2022).

use super::json::{MToon, TextureInfo};

/// The extension's name.
pub(super) const EXTENSION: &str = "VRMC_materials_mtoon";

/// The extension for a material.
///
/// - `color`: the base colour texture, also used in the shade.
pub(super) const fn material(color: TextureInfo) -> MToon {
    MToon {
        spec_version: "1.0",
        // Linear. Light scattered in skin is warm, so its shadows lose green and blue first.
        shade_color_factor: [0.62, 0.47, 0.43],
        shade_multiply_texture: color,
        // Light wraps slightly around and the terminator is soft: textures show pores
        // and folds, which a hard edge would cut through. Shading goes from shade to
        // light over `shift ± (1 - toony)`.
        shading_shift_factor: -0.1,
        shading_toony_factor: 0.6,
        gi_equalization_factor: 0.9,
        // Rim light as faint as on skin, and only where light falls.
        rim_lighting_mix_factor: 1.0,
        parametric_rim_color_factor: [0.06, 0.05, 0.045],
        parametric_rim_fresnel_power_factor: 4.0,
        parametric_rim_lift_factor: 0.0,
        outline_width_mode: "none",
    }
}
