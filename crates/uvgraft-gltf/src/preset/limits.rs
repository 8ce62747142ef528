//! Published limits of platforms for avatars, and how a file compares with them.
//!
//! | platform | quantities | source |
//! |---|---|---|
//! | VRChat mobile, VRChat PC | ranks | VRChat, "Performance Ranks" (creators.vrchat.com/avatars/avatar-performance-ranking-system; its text is `avatar-performance-ranking-system.md` of github.com/vrchat-community/creator-docs) |
//! | the same | download size | VRChat, "Avatar Size Limits" (creators.vrchat.com/avatars/avatar-size-limits) |
//! | Scene Viewer | recommended limits | Google, "Scene Viewer" (developers.google.com/ar/develop/scene-viewer), as presented in 2019 |
//! | AR Quick Look | recommended limits | Apple, WWDC 2018, "Integrating Apps and Content with AR Quick Look", confirmed in 2021 (developer.apple.com/forums/thread/693867) |
//!
//! Platforms change their limits; these are meant as an early estimate of what an upload will
//! report.

use std::fmt;

use uvgraft::listing::grouped;

use crate::glb::{AvatarMaterial, EmbeddedFormat, EmbeddedImage, Report};

/// A quantity that platforms limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Triangles.
    Triangles,
    /// Vertices, after splitting them at UV seams.
    Vertices,
    /// Size of textures after GPU compression, in bytes.
    TextureMemory,
    /// Longer side of the largest texture, in texels.
    TextureSide,
    /// Joints.
    Bones,
    /// Skinned meshes.
    SkinnedMeshes,
    /// Materials, counted once for each mesh.
    MaterialSlots,
    /// File size, in bytes.
    FileSize,
    /// Duration of the longest animation, in seconds.
    Animation,
}

impl Quantity {
    /// Name for users.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Vertices => "vertices",
            Self::TextureMemory => "texture memory",
            Self::TextureSide => "texture side",
            Self::Bones => "bones",
            Self::SkinnedMeshes => "skinned meshes",
            Self::MaterialSlots => "material slots",
            Self::FileSize => "file size",
            Self::Animation => "animation",
        }
    }

    /// Formats a value with its unit.
    fn text(self, value: f64) -> String {
        match self {
            Self::TextureMemory | Self::FileSize => format!("{:.1} MiB", value / MIB),
            Self::TextureSide => format!("{value} texels"),
            Self::Animation => format!("{value:.1} s"),
            _ => grouped(value as u64),
        }
    }
}

/// VRChat and Unity count in these, and call them megabytes.
const MIB: f64 = 1024.0 * 1024.0;

/// The published limits of a platform.
#[derive(Debug, PartialEq)]
pub struct Limits {
    /// The platform.
    pub platform: &'static str,
    /// Names of the ranks, best first.
    pub ranks: &'static [&'static str],
    /// For each quantity, the maximum of each rank, or one maximum for all.
    pub quantities: &'static [(Quantity, &'static [f64])],
    /// What must be done to a file before the platform accepts it.
    pub before: Option<&'static str>,
}

const VRCHAT_RANKS: &[&str] = &["Excellent", "Good", "Medium", "Poor"];

/// VRChat on phones and standalone headsets.
pub const VRCHAT_MOBILE: Limits = Limits {
    platform: "VRChat mobile",
    ranks: VRCHAT_RANKS,
    quantities: &[
        (Quantity::Triangles, &[7_500.0, 10_000.0, 15_000.0, 20_000.0]),
        (Quantity::TextureMemory, &[10.0 * MIB, 18.0 * MIB, 25.0 * MIB, 40.0 * MIB]),
        (Quantity::Bones, &[75.0, 90.0, 150.0, 150.0]),
        (Quantity::SkinnedMeshes, &[1.0, 1.0, 2.0, 2.0]),
        (Quantity::MaterialSlots, &[1.0, 1.0, 2.0, 4.0]),
        // A hard limit for all ranks; the size of Unity's asset bundle differs from the
        // file's and is usually smaller.
        (Quantity::FileSize, &[10.0 * MIB]),
    ],
    before: None,
};

/// VRChat on Windows.
pub const VRCHAT_PC: Limits = Limits {
    platform: "VRChat PC",
    ranks: VRCHAT_RANKS,
    quantities: &[
        (Quantity::Triangles, &[32_000.0, 70_000.0, 70_000.0, 70_000.0]),
        (Quantity::TextureMemory, &[40.0 * MIB, 75.0 * MIB, 110.0 * MIB, 150.0 * MIB]),
        (Quantity::Bones, &[75.0, 150.0, 256.0, 400.0]),
        (Quantity::SkinnedMeshes, &[1.0, 2.0, 8.0, 16.0]),
        (Quantity::MaterialSlots, &[4.0, 8.0, 16.0, 32.0]),
        (Quantity::FileSize, &[200.0 * MIB]),
    ],
    before: None,
};

/// Google's viewer for web pages on Android, the strictest of the viewers that open GLB files from
/// browsers.
pub const SCENE_VIEWER: Limits = Limits {
    platform: "Scene Viewer",
    ranks: &["recommended"],
    quantities: &[
        (Quantity::Vertices, &[30_000.0]),
        (Quantity::TextureSide, &[2048.0]),
        (Quantity::Bones, &[254.0]),
        (Quantity::MaterialSlots, &[10.0]),
        (Quantity::FileSize, &[10.0 * MIB]),
    ],
    before: None,
};

/// Apple's viewer. It opens only USDZ, which Apple's Reality Converter can create from a GLB file.
pub const AR_QUICK_LOOK: Limits = Limits {
    platform: "AR Quick Look",
    ranks: &["recommended"],
    quantities: &[
        (Quantity::Triangles, &[100_000.0]),
        (Quantity::TextureSide, &[2048.0]),
        (Quantity::MaterialSlots, &[1.0]),
        (Quantity::Animation, &[10.0]),
    ],
    before: Some(
        "opens only USDZ; convert this file, for example with Apple's Reality Converter or Blender. \
         Limits are compared with this file, before conversion",
    ),
};

/// The quantities of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurements {
    report: Report,
    /// Size of textures with mip levels, in bytes, at one byte for each texel: block compression as
    /// in KTX2 and in Unity's import (BC7, ASTC 4×4; coarser ASTC blocks take less). VRChat
    /// measures the result of Unity's import.
    pub texture_memory: u64,
    /// The same without GPU compression, at four bytes for each texel: PNG, JPEG and WebP in
    /// browsers.
    pub texture_memory_raw: u64,
    texture_side: u32,
}

impl Measurements {
    /// Measures a written file.
    pub fn new(report: &Report, materials: &(impl AsRef<[AvatarMaterial]> + ?Sized)) -> Self {
        let pictures = || materials.as_ref().iter().flat_map(AvatarMaterial::pictures);
        let texels = |picture: &EmbeddedImage| picture.size().texels() as u64;
        // Each mip level has a quarter of the texels of the one before: 1 + 1/4 + 1/16 + ... = 4/3.
        let with_mips = |bytes: u64| bytes * 4 / 3;
        let raw = |picture: &EmbeddedImage| {
            let bytes = if picture.format() == EmbeddedFormat::Ktx2 { 1 } else { 4 };
            with_mips(bytes * texels(picture))
        };
        let side = |picture: &EmbeddedImage| picture.size().width.max(picture.size().height);
        Self {
            report: *report,
            texture_memory: pictures().map(|picture| with_mips(texels(picture))).sum(),
            texture_memory_raw: pictures().map(raw).sum(),
            texture_side: pictures().map(side).max().unwrap_or(0),
        }
    }

    /// Value of a quantity; sizes in bytes, durations in seconds.
    pub fn get(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Triangles => self.report.triangles as f64,
            Quantity::Vertices => self.report.vertices as f64,
            Quantity::TextureMemory => self.texture_memory as f64,
            Quantity::TextureSide => f64::from(self.texture_side),
            Quantity::Bones => self.report.joints as f64,
            Quantity::SkinnedMeshes => self.report.meshes as f64,
            Quantity::MaterialSlots => self.report.materials as f64,
            Quantity::FileSize => self.report.bytes as f64,
            Quantity::Animation => f64::from(self.report.longest_clip),
        }
    }
}

/// Comparison of one quantity with the limits. Displayed as
/// `triangles: 9,998 (VRChat mobile: Good, up to 10,000)`.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitCheck {
    /// The platform.
    pub platform: &'static str,
    /// The quantity.
    pub quantity: Quantity,
    /// Its value; sizes in bytes, durations in seconds.
    pub value: f64,
    /// The best rank that allows this value; `None` if none does.
    pub rank: Option<&'static str>,
    /// The maximum of this rank, or of the last rank.
    pub limit: f64,
}

impl fmt::Display for LimitCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (quantity, limit) = (self.quantity, self.quantity.text(self.limit));
        let (name, value) = (quantity.name(), quantity.text(self.value));
        match self.rank {
            Some(rank) => write!(f, "{name}: {value} ({}: {rank}, up to {limit})", self.platform),
            None => write!(f, "{name}: {value} ({}: more than {limit})", self.platform),
        }
    }
}

impl Limits {
    /// Compares a file with the limits, quantity by quantity.
    pub fn report(&self, measured: &Measurements) -> Vec<LimitCheck> {
        let line = |&(quantity, limits): &(Quantity, &[f64])| {
            let value = measured.get(quantity);
            let reached = limits.iter().position(|&limit| value <= limit);
            // A single limit for all ranks does not determine a rank.
            let rank = |index: usize| if limits.len() == 1 { "allowed" } else { self.ranks[index] };
            let limit = limits[reached.unwrap_or(limits.len() - 1)];
            LimitCheck { platform: self.platform, quantity, value, rank: reached.map(rank), limit }
        };
        self.quantities.iter().map(line).collect()
    }

    /// The overall rank: the worst over all quantities. `None` if a quantity exceeds all limits.
    pub fn rank(&self, measured: &Measurements) -> Option<&'static str> {
        let mut worst = 0;
        for (quantity, limits) in self.quantities {
            let reached = limits.iter().position(|&limit| measured.get(*quantity) <= limit)?;
            worst = worst.max(if limits.len() == 1 { 0 } else { reached });
        }
        self.ranks.get(worst).copied()
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_avatar::rig::Pruning;

    use super::*;

    fn measured(triangles: usize, texture_memory: u64) -> Measurements {
        let report = Report {
            vertices: 1000,
            triangles,
            meshes: 1,
            materials: 1,
            joints: 76,
            morphs: 0,
            clips: 0,
            longest_clip: 0.0,
            pruning: Pruning::default(),
            pruning_most: 0.0,
            pruning_mean: 0.0,
            posed_as_t: false,
            image_bytes: 0,
            bytes: 3 << 20,
        };
        Measurements { report, texture_memory, texture_memory_raw: 0, texture_side: 1024 }
    }

    #[test]
    fn each_figure_has_its_rank() {
        let found = measured(9_998, 20 << 20);
        let lines: Vec<String> =
            VRCHAT_MOBILE.report(&found).iter().map(ToString::to_string).collect();
        assert_eq!(lines[0], "triangles: 9,998 (VRChat mobile: Good, up to 10,000)");
        assert_eq!(lines[1], "texture memory: 20.0 MiB (VRChat mobile: Medium, up to 25.0 MiB)");
        assert_eq!(lines[2], "bones: 76 (VRChat mobile: Good, up to 90)");
        assert_eq!(lines[5], "file size: 3.0 MiB (VRChat mobile: allowed, up to 10.0 MiB)");
        assert_eq!(VRCHAT_MOBILE.rank(&found), Some("Medium"));
        let heavy = measured(20_001, 0);
        let line = VRCHAT_MOBILE.report(&heavy)[0].to_string();
        assert_eq!(line, "triangles: 20,001 (VRChat mobile: more than 20,000)");
        assert_eq!(VRCHAT_MOBILE.rank(&heavy), None);
        assert_eq!(VRCHAT_PC.rank(&measured(32_000, 0)), Some("Good"));
        assert_eq!(AR_QUICK_LOOK.rank(&heavy), Some("recommended"));
    }

    #[test]
    fn tables_are_complete() {
        for limits in [VRCHAT_MOBILE, VRCHAT_PC, SCENE_VIEWER, AR_QUICK_LOOK] {
            for (quantity, values) in limits.quantities {
                assert!(values.len() == 1 || values.len() == limits.ranks.len(), "{quantity:?}");
                assert!(values.is_sorted(), "{quantity:?}");
            }
        }
    }
}
