//! The report on an avatar.

use std::fmt::Write as _;
use std::path::Path;

use uvgraft_avatar::Avatar;
use uvgraft_avatar::body::Deviation;
use uvgraft_avatar::rig::Clip;
use uvgraft_gltf::glb::{self, AvatarMaterial};
use uvgraft_gltf::preset::{Limits, Measurements};

use crate::report::{Report, grouped, megabytes};

/// An avatar that was made.
pub(super) struct AvatarSummary<'a> {
    pub(super) file_name: &'a Path,
    pub(super) is_vrm: bool,
    pub(super) body: &'a str,
    pub(super) avatar: &'a Avatar,
    /// Its materials: the body's, then the head's own.
    pub(super) looks: &'a [AvatarMaterial],
    pub(super) figures: &'a glb::Report,
    /// Deviation of the clips from the body model.
    pub(super) apart: &'a [(String, Deviation)],
    /// Grounding of the clips.
    pub(super) grounds: &'a [String],
    /// Number of triangles of the fitted mouth.
    pub(super) mouth: Option<usize>,
    pub(super) simplified: Option<Simplified>,
    /// Coarser levels: names and descriptions.
    pub(super) levels: Vec<(String, String)>,
    pub(super) limits: Option<&'a Limits>,
}

/// How an avatar was simplified, in triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Simplified {
    pub(super) before: usize,
    /// Those that nobody sees, which were removed.
    pub(super) hidden: usize,
    pub(super) after: usize,
    pub(super) wanted: usize,
}

impl AvatarSummary<'_> {
    pub(super) fn report(&self) -> Report {
        let (figures, avatar) = (self.figures, self.avatar);
        let mut report = Report::default();
        let mut row = |name: &str, value: String| report.row(name, value);
        row("body", self.body.to_owned());
        let (triangles, vertices) = (grouped(figures.triangles), grouped(figures.vertices));
        row("mesh", format!("{triangles} triangles, {vertices} vertices"));
        if let Some(triangles) = self.mouth {
            row("mouth", format!("cavity, teeth and tongue, {} triangles", grouped(triangles)));
        }
        if let Some(simplified) = self.simplified.filter(|it| it.before != it.after) {
            row("simplified", simplified.text());
        }
        row("joints", grouped(figures.joints));
        let sizes: Vec<String> = self.looks.iter().map(textures).collect();
        row("texture", format!("{}, {}", sizes.join("; "), megabytes(figures.image_bytes)));
        let names: Vec<&str> = avatar.morphs.iter().map(|morph| &*morph.name).collect();
        row("morph targets", listed(&names));
        let names: Vec<&str> =
            avatar.expressions.iter().map(|expression| &*expression.name).collect();
        let only = if self.is_vrm { "" } else { " (by these names in a .vrm)" };
        row("expressions", format!("{}{only}", listed(&names)));
        let clips: Vec<String> = avatar.clips.iter().map(clip_text).collect();
        row("animations", listed(&clips.iter().map(String::as_str).collect::<Vec<_>>()));
        for ground in self.grounds {
            row("ground", ground.clone());
        }
        if figures.pruning.vertices > 0 {
            row(
                "skin weights",
                format!(
                    "limited to 4 joints per vertex; {} vertices had more, deviating by at most {:.2} mm",
                    grouped(figures.pruning.vertices),
                    figures.pruning_most * 1e3,
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
        if figures.posed_as_t {
            row("rest pose", "T-pose; clips look the same as in a GLB".to_owned());
        }
        for (name, text) in &self.levels {
            row(name, text.clone());
        }
        row("written", format!("{}, {}", self.file_name.display(), megabytes(figures.bytes)));
        if let Some(limits) = self.limits {
            self.compare_with(limits, &mut report);
        }
        report
    }

    /// Adds how the avatar compares with the limits of a platform.
    fn compare_with(&self, limits: &Limits, report: &mut Report) {
        let measured = Measurements::new(self.figures, self.looks);
        let rank = limits.rank(&measured).unwrap_or("beyond its limits");
        match limits.before {
            Some(before) => report.below(format_args!("\n{} {before}: {rank}", limits.platform)),
            None => report.below(format_args!("\n{}: {rank}", limits.platform)),
        }
        for line in limits.report(&measured) {
            report.below(format_args!("  {line}"));
        }
    }
}

impl Simplified {
    fn text(self) -> String {
        let mut text = format!("from {} triangles", grouped(self.before));
        if self.hidden > 0 {
            let _ = write!(text, ", {} of them hidden inside the eyes", grouped(self.hidden));
        }
        if self.after > self.wanted {
            let _ = write!(text, "; requested {}", grouped(self.wanted));
        }
        text
    }
}

fn clip_text(clip: &Clip) -> String {
    format!("{} ({:.1} s, {} frames)", clip.name, clip.seconds(), clip.times.len())
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
