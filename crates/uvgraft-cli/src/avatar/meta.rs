//! Options for the metadata of avatars.

use std::path::Path;

use clap::builder::{PossibleValue, PossibleValuesParser};
use serde_json::{Map, Value};
use uvgraft_gltf::glb::{Permissions, VrmMeta};

use crate::failure::bad_input;
use crate::heading;

/// Who made an avatar, and who may do what with it. A VRM file must say so, and has no defaults.
#[derive(clap::Args)]
#[command(next_help_heading = heading::METADATA)]
pub(super) struct MetaArgs {
    /// Name of the avatar [default: the output's file name]
    #[arg(long, value_name = "NAME")]
    title: Option<String>,
    /// Author of the avatar; repeatable, required for .vrm
    ///
    /// A .glb stores authors in asset.copyright and asset.extras.
    #[arg(long = "author", value_name = "NAME")]
    authors: Vec<String>,
    /// What others may do with the avatar; required for .vrm
    #[arg(long, alias = "licence", value_name = "TERMS", value_parser = licenses())]
    license: Option<String>,
    /// URL of further licence terms (.vrm only)
    #[arg(long, value_name = "URL")]
    license_url: Option<String>,
    /// Third-party content and its licences, such as the body model (.vrm only)
    #[arg(long, value_name = "TEXT")]
    made_from: Option<String>,
}

/// The names of sets of permissions, each with its meaning.
fn licenses() -> PossibleValuesParser {
    PossibleValuesParser::new(Permissions::NAMED.map(|(name, permissions)| {
        PossibleValue::new(name).help(match permissions {
            Permissions::ONLY_AUTHOR => "Use by the author only",
            Permissions::NON_COMMERCIAL => {
                "Use, modification and redistribution by anyone, non-commercially, with credit"
            }
            _ => "As non-commercial, and commercial use too",
        })
    }))
}

impl MetaArgs {
    /// The avatar's name.
    pub(super) fn title(&self, output: &Path) -> String {
        let stem = || output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.title.clone().unwrap_or_else(stem)
    }

    /// Metadata of a GLB file, in `asset.extras`, where people and scripts find it.
    ///
    /// - `body`: terms of the body model, if its file states them.
    pub(super) fn extras(&self, body: Option<&str>) -> Map<String, Value> {
        let mut extras = Map::new();
        if let Some(title) = &self.title {
            extras.insert("title".to_owned(), title.clone().into());
        }
        if !self.authors.is_empty() {
            extras.insert("authors".to_owned(), self.authors.clone().into());
        }
        if let Some(body) = body {
            let lines: Vec<&str> = body.lines().collect();
            extras.insert("madeFrom".to_owned(), lines.into());
        }
        extras
    }

    /// The copyright notice of a GLB file.
    ///
    /// - `body`: as in [`MetaArgs::extras`].
    pub(super) fn copyright(&self, body: Option<&str>) -> Option<String> {
        let authors = (!self.authors.is_empty()).then(|| self.authors.join(", "));
        let body = body.unwrap_or_default().lines();
        let lines: Vec<&str> = authors.as_deref().into_iter().chain(body).collect();
        (!lines.is_empty()).then(|| lines.join("; "))
    }

    /// Rejects options that only a VRM file can store.
    pub(super) fn check_glb(&self) -> anyhow::Result<()> {
        let given = [
            ("--license", self.license.is_some()),
            ("--license-url", self.license_url.is_some()),
            ("--made-from", self.made_from.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(bad_input(format!("{name} is for .vrm outputs only"))),
            None => Ok(()),
        }
    }

    /// The metadata of a VRM file.
    pub(super) fn vrm(&self, output: &Path) -> anyhow::Result<VrmMeta> {
        let license = self.license.as_deref().and_then(Permissions::named);
        let Some(permissions) = license.filter(|_| {
            !self.authors.is_empty() && !self.authors.iter().any(|name| name.trim().is_empty())
        }) else {
            let terms = Permissions::NAMED.map(|(name, _)| name).join(", ");
            return Err(bad_input(format!(
                "{}: a VRM file must name its author and terms of use: add --author NAME and \
                 --license TERMS ({terms})",
                output.display()
            )));
        };
        let mut meta = VrmMeta::new(self.title(output), self.authors.clone(), permissions);
        meta.other_license_url.clone_from(&self.license_url);
        meta.third_party_licenses.clone_from(&self.made_from);
        Ok(meta)
    }
}

/// Adds the terms of the body model to the third-party licences of a VRM file.
pub(super) fn made_from(mut vrm: VrmMeta, body: Option<&str>) -> VrmMeta {
    if let Some(body) = body {
        let given = vrm.third_party_licenses.as_deref();
        let lines: Vec<&str> = given.into_iter().chain([body]).collect();
        vrm.third_party_licenses = Some(lines.join("\n"));
    }
    vrm
}
