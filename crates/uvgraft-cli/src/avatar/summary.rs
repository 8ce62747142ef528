//! The printed summary of an avatar.

use std::fmt::Write as _;
use std::path::Path;

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::Deviation;
use uvgraft_gltf::glb::{AvatarMaterial, Report};
use uvgraft_gltf::preset::{Limits, Measurements};

use crate::report::grouped;
use crate::terminal;

/// An avatar that was written.
pub(super) struct Made<'a> {
    pub(super) output: &'a Path,
    pub(super) is_vrm: bool,
    pub(super) body: &'a str,
    pub(super) avatar: &'a Avatar,
    /// Its materials: the body's, then the head's own.
    pub(super) looks: &'a [AvatarMaterial],
    pub(super) report: &'a Report,
    /// Deviation of the clips from the body model.
    pub(super) apart: &'a [(String, Deviation)],
    /// Grounding of the clips.
    pub(super) grounds: &'a [String],
    /// Number of triangles of the fitted mouth.
    pub(super) mouth: Option<usize>,
    /// Number of triangles before, hidden, after, and requested.
    pub(super) fitted: Option<(usize, usize, usize, usize)>,
    /// Coarser levels: names and descriptions.
    pub(super) levels: Vec<(String, String)>,
    pub(super) limits: Option<&'a Limits>,
}

impl Made<'_> {
    pub(super) fn text(&self) -> String {
        let (report, avatar) = (self.report, self.avatar);
        let mut text = String::new();
        let mut row = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<14} {}", terminal::inline(&value));
        };
        let megabytes = |bytes: usize| format!("{:.1} MB", bytes as f64 / 1e6);
        row("body", self.body.to_owned());
        let (triangles, vertices) = (grouped(report.triangles), grouped(report.vertices));
        row("mesh", format!("{triangles} triangles, {vertices} vertices"));
        if let Some(triangles) = self.mouth {
            row("mouth", format!("cavity, teeth and tongue, {} triangles", grouped(triangles)));
        }
        if let Some((before, hidden, after, wanted)) =
            self.fitted.filter(|fitted| fitted.0 != fitted.2)
        {
            let mut how = format!("from {} triangles", grouped(before));
            if hidden > 0 {
                let _ = write!(how, ", {} of them hidden inside the eyes", grouped(hidden));
            }
            if after > wanted {
                let _ = write!(how, "; requested {}", grouped(wanted));
            }
            row("simplified", how);
        }
        row("joints", grouped(report.joints));
        let sizes: Vec<String> = self.looks.iter().map(textures).collect();
        row("texture", format!("{}, {}", sizes.join("; "), megabytes(report.image_bytes)));
        let names: Vec<&str> = avatar.morphs.iter().map(|morph| &*morph.name).collect();
        row("morph targets", listed(&names));
        let names: Vec<&str> =
            avatar.expressions.iter().map(|expression| &*expression.name).collect();
        let only = if self.is_vrm { "" } else { " (by these names in a .vrm)" };
        row("expressions", format!("{}{only}", listed(&names)));
        let clips: Vec<String> = avatar
            .clips
            .iter()
            .map(|clip| {
                format!("{} ({:.1} s, {} frames)", clip.name, clip.seconds(), clip.times.len())
            })
            .collect();
        row("animations", listed(&clips.iter().map(String::as_str).collect::<Vec<_>>()));
        for ground in self.grounds {
            row("ground", ground.clone());
        }
        if report.pruning.vertices > 0 {
            row(
                "skin weights",
                format!(
                    "limited to 4 joints per vertex; {} vertices had more, deviating by at most {:.2} mm",
                    grouped(report.pruning.vertices),
                    report.pruning_most * 1e3,
                ),
            );
        }
        for (clip, apart) in self.apart {
            row(
                "deviation",
                format!(
                    "{clip}: mean {:.1} mm, max {:.1} mm from the body model (no pose correctives)",
                    apart.mean_mm, apart.max_mm
                ),
            );
        }
        if report.posed_as_t {
            row("rest pose", "T-pose; clips look the same as in a GLB".to_owned());
        }
        for (name, text) in &self.levels {
            row(name, text.clone());
        }
        row("written", format!("{}, {}", self.output.display(), megabytes(report.bytes)));
        if let Some(limits) = self.limits {
            let measured = Measurements::new(report, self.looks);
            let rank = limits.rank(&measured).unwrap_or("beyond its limits");
            let _ = match limits.before {
                Some(before) => writeln!(text, "\n{} {before}: {rank}", limits.platform),
                None => writeln!(text, "\n{}: {rank}", limits.platform),
            };
            for line in limits.report(&measured) {
                let _ = writeln!(text, "  {line}");
            }
        }
        text
    }
}

/// The sizes of a material's textures.
fn textures(looks: &AvatarMaterial) -> String {
    let mut text = looks.color.size().to_string();
    let is_packed = looks.occlusion.is_some() && looks.occlusion == looks.roughness;
    let occlusion = looks.occlusion.as_ref().filter(|_| !is_packed);
    for (name, map) in [
        ("normal", looks.normal.as_ref()),
        (
            if is_packed { "occlusion, roughness, metallic" } else { "roughness, metallic" },
            looks.roughness.as_ref(),
        ),
        ("occlusion", occlusion),
        ("emissive", looks.emissive.as_ref()),
    ] {
        if let Some(map) = map {
            let _ = write!(text, ", {name} {}", map.size());
        }
    }
    if looks.is_head { format!("the head's own {text}") } else { text }
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
