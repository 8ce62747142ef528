//! What platforms publish about how heavy an avatar may be, and where a file stands.
//!
//! | platform | figures | source |
//! |---|---|---|
//! | VRChat mobile, VRChat PC | ranks | VRChat, "Performance Ranks" (creators.vrchat.com/avatars/avatar-performance-ranking-system; its text is `avatar-performance-ranking-system.md` of github.com/vrchat-community/creator-docs) |
//! | the same | size of downloads | VRChat, "Avatar Size Limits" (creators.vrchat.com/avatars/avatar-size-limits) |
//! | Scene Viewer | recommended limits | Google, "Scene Viewer" (developers.google.com/ar/develop/scene-viewer), as presented in 2019 |
//! | AR Quick Look | recommended limits | Apple, WWDC 2018, "Integrating Apps and Content with AR Quick Look", confirmed in 2021 (developer.apple.com/forums/thread/693867) |
//!
//! Platforms change their numbers; these are meant to tell early what an upload will say.

use std::fmt;

use crate::glb::{AvatarMaterial, Picture, PictureFormat, Report};

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Figure {
    /// Triangles.
    Triangles,
    /// Vertices, after splitting them along seams.
    Vertices,
    /// Bytes that textures take once compressed for graphics processors.
    TextureMemory,
    /// Texels on the longer side of the largest texture.
    TextureSide,
    /// Joints.
    Bones,
    /// Meshes that follow joints.
    SkinnedMeshes,
    /// Materials, counted for each mesh.
    MaterialSlots,
    /// Bytes of the file.
    FileSize,
    /// Seconds of the longest animation.
    Animation,
}

impl Figure {
    /// What people call it.
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

    /// A value in words.
    fn text(self, value: f64) -> String {
        match self {
            Self::TextureMemory | Self::FileSize => format!("{:.1} MB", value / MEGABYTE),
            Self::TextureSide => format!("{value} texels"),
            Self::Animation => format!("{value:.1} s"),
            _ => grouped(value as u64),
        }
    }
}

/// VRChat and Unity count in 1024s.
const MEGABYTE: f64 = 1024.0 * 1024.0;

fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// What a platform publishes.
#[derive(Debug, PartialEq)]
pub struct Limits {
    /// The platform.
    pub platform: &'static str,
    /// The names of ranks, the best first.
    pub ranks: &'static [&'static str],
    /// For each figure the most that each rank allows.
    pub figures: &'static [(Figure, &'static [f64])],
    /// What has to be done to a file before the platform takes it.
    pub before: Option<&'static str>,
}

const VRCHAT_RANKS: &[&str] = &["Excellent", "Good", "Medium", "Poor"];
const MB: f64 = MEGABYTE;

/// VRChat on phones and on headsets of their own.
pub const VRCHAT_MOBILE: Limits = Limits {
    platform: "VRChat mobile",
    ranks: VRCHAT_RANKS,
    figures: &[
        (Figure::Triangles, &[7_500.0, 10_000.0, 15_000.0, 20_000.0]),
        (Figure::TextureMemory, &[10.0 * MB, 18.0 * MB, 25.0 * MB, 40.0 * MB]),
        (Figure::Bones, &[75.0, 90.0, 150.0, 150.0]),
        (Figure::SkinnedMeshes, &[1.0, 1.0, 2.0, 2.0]),
        (Figure::MaterialSlots, &[1.0, 1.0, 2.0, 4.0]),
        // A hard limit, whatever the rank; Unity's bundle differs from the file, mostly downwards.
        (Figure::FileSize, &[10.0 * MB]),
    ],
    before: None,
};

/// VRChat on Windows.
pub const VRCHAT_PC: Limits = Limits {
    platform: "VRChat PC",
    ranks: VRCHAT_RANKS,
    figures: &[
        (Figure::Triangles, &[32_000.0, 70_000.0, 70_000.0, 70_000.0]),
        (Figure::TextureMemory, &[40.0 * MB, 75.0 * MB, 110.0 * MB, 150.0 * MB]),
        (Figure::Bones, &[75.0, 150.0, 256.0, 400.0]),
        (Figure::SkinnedMeshes, &[1.0, 2.0, 8.0, 16.0]),
        (Figure::MaterialSlots, &[4.0, 8.0, 16.0, 32.0]),
        (Figure::FileSize, &[200.0 * MB]),
    ],
    before: None,
};

/// Google's viewer for web pages on Android, the strictest of what opens GLB files in browsers.
pub const SCENE_VIEWER: Limits = Limits {
    platform: "Scene Viewer",
    ranks: &["recommended"],
    figures: &[
        (Figure::Vertices, &[30_000.0]),
        (Figure::TextureSide, &[2048.0]),
        (Figure::Bones, &[254.0]),
        (Figure::MaterialSlots, &[10.0]),
        (Figure::FileSize, &[10.0 * MB]),
    ],
    before: None,
};

/// Apple's viewer. It opens USDZ only, which Apple's Reality Converter makes of a GLB file.
pub const AR_QUICK_LOOK: Limits = Limits {
    platform: "AR Quick Look",
    ranks: &["recommended"],
    figures: &[
        (Figure::Triangles, &[100_000.0]),
        (Figure::TextureSide, &[2048.0]),
        (Figure::MaterialSlots, &[1.0]),
        (Figure::Animation, &[10.0]),
    ],
    before: Some(
        "opens USDZ, not this file: convert it, with Apple's Reality Converter or Blender, say. Its limits are \
         compared with what is converted",
    ),
};

/// What platforms look at in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    report: Report,
    /// Bytes of textures with their mip levels, one byte a texel: block compression as KTX2 has it, and
    /// Unity at import (BC7, ASTC 4×4; coarser ones take less). VRChat counts what Unity made.
    pub texture_memory: u64,
    /// The same where nothing compresses, four bytes a texel: PNG, JPEG and WebP in browsers.
    pub texture_memory_raw: u64,
    texture_side: u32,
}

impl Measured {
    /// Of a file that was written.
    pub fn new(report: &Report, looks: &(impl AsRef<[AvatarMaterial]> + ?Sized)) -> Self {
        let pictures = || looks.as_ref().iter().flat_map(AvatarMaterial::pictures);
        let texels = |picture: &Picture| picture.size().texels() as u64;
        // Each mip level has a quarter of the one before: 1 + 1/4 + 1/16 + ... = 4/3.
        let with_mips = |bytes: u64| bytes * 4 / 3;
        let raw = |picture: &Picture| {
            let bytes = if picture.format() == PictureFormat::Ktx2 { 1 } else { 4 };
            with_mips(bytes * texels(picture))
        };
        let side = |picture: &Picture| picture.size().width.max(picture.size().height);
        Self {
            report: *report,
            texture_memory: pictures().map(|picture| with_mips(texels(picture))).sum(),
            texture_memory_raw: pictures().map(raw).sum(),
            texture_side: pictures().map(side).max().unwrap_or(0),
        }
    }

    /// One figure, in bytes and seconds.
    pub fn get(&self, figure: Figure) -> f64 {
        match figure {
            Figure::Triangles => self.report.triangles as f64,
            Figure::Vertices => self.report.vertices as f64,
            Figure::TextureMemory => self.texture_memory as f64,
            Figure::TextureSide => f64::from(self.texture_side),
            Figure::Bones => self.report.joints as f64,
            Figure::SkinnedMeshes => self.report.meshes as f64,
            Figure::MaterialSlots => self.report.materials as f64,
            Figure::FileSize => self.report.bytes as f64,
            Figure::Animation => f64::from(self.report.longest_clip),
        }
    }
}

/// Where a file stands by one figure. As text: `triangles: 9,998 (VRChat mobile: Good, up to 10,000)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The platform.
    pub platform: &'static str,
    /// What was counted.
    pub figure: Figure,
    /// The count, in bytes and seconds.
    pub value: f64,
    /// The best rank that allows it; `None` if none does.
    pub rank: Option<&'static str>,
    /// The most that this rank allows, or the last one.
    pub limit: f64,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (figure, limit) = (self.figure, self.figure.text(self.limit));
        let (name, value) = (figure.name(), figure.text(self.value));
        match self.rank {
            Some(rank) => write!(f, "{name}: {value} ({}: {rank}, up to {limit})", self.platform),
            None => write!(f, "{name}: {value} ({}: more than {limit})", self.platform),
        }
    }
}

impl Limits {
    /// Where a file stands, figure by figure.
    pub fn report(&self, measured: &Measured) -> Vec<Line> {
        let line = |&(figure, limits): &(Figure, &[f64])| {
            let value = measured.get(figure);
            let reached = limits.iter().position(|&limit| value <= limit);
            // Where there is one limit for all ranks, keeping it says nothing about the rank.
            let rank = |index: usize| if limits.len() == 1 { "allowed" } else { self.ranks[index] };
            let limit = limits[reached.unwrap_or(limits.len() - 1)];
            Line { platform: self.platform, figure, value, rank: reached.map(rank), limit }
        };
        self.figures.iter().map(line).collect()
    }

    /// The rank of the whole: the worst of its figures. `None` if one is beyond all limits.
    pub fn rank(&self, measured: &Measured) -> Option<&'static str> {
        let mut worst = 0;
        for (figure, limits) in self.figures {
            let reached = limits.iter().position(|&limit| measured.get(*figure) <= limit)?;
            worst = worst.max(if limits.len() == 1 { 0 } else { reached });
        }
        self.ranks.get(worst).copied()
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_avatar::rig::Pruning;

    use super::*;

    fn measured(triangles: usize, texture_memory: u64) -> Measured {
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
        Measured { report, texture_memory, texture_memory_raw: 0, texture_side: 1024 }
    }

    #[test]
    fn each_figure_has_its_rank() {
        let found = measured(9_998, 20 << 20);
        let lines: Vec<String> =
            VRCHAT_MOBILE.report(&found).iter().map(ToString::to_string).collect();
        assert_eq!(lines[0], "triangles: 9,998 (VRChat mobile: Good, up to 10,000)");
        assert_eq!(lines[1], "texture memory: 20.0 MB (VRChat mobile: Medium, up to 25.0 MB)");
        assert_eq!(lines[2], "bones: 76 (VRChat mobile: Good, up to 90)");
        assert_eq!(lines[5], "file size: 3.0 MB (VRChat mobile: allowed, up to 10.0 MB)");
        assert_eq!(VRCHAT_MOBILE.rank(&found), Some("Medium"));
        let heavy = measured(20_001, 0);
        let line = VRCHAT_MOBILE.report(&heavy)[0].to_string();
        assert_eq!(line, "triangles: 20,001 (VRChat mobile: more than 20,000)");
        assert_eq!(VRCHAT_MOBILE.rank(&heavy), None);
        assert_eq!(VRCHAT_PC.rank(&measured(32_000, 0)), Some("Good"));
        assert_eq!(AR_QUICK_LOOK.rank(&heavy), Some("recommended"));
    }

    #[test]
    fn tables_are_whole() {
        for limits in [VRCHAT_MOBILE, VRCHAT_PC, SCENE_VIEWER, AR_QUICK_LOOK] {
            for (figure, values) in limits.figures {
                assert!(values.len() == 1 || values.len() == limits.ranks.len(), "{figure:?}");
                assert!(values.is_sorted(), "{figure:?}");
            }
        }
    }
}
