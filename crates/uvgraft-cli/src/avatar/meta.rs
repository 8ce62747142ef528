//! What a VRM file says of itself, as options give it.

use std::path::Path;

use serde_json::{Map, Value};
use uvgraft_gltf::glb::{Permissions, VrmMeta};

use crate::failure::bad_input;

/// Who made an avatar, and who may do what with it. A VRM file must say so; nothing is taken for granted.
#[derive(clap::Args)]
#[command(next_help_heading = "Whose avatar it is")]
pub(super) struct MetaArgs {
    /// What the avatar is called [default: the output's name]
    #[arg(long)]
    title: Option<String>,
    /// Who made it; may be repeated. A .vrm needs one; a .glb has it in asset.copyright and asset.extras
    #[arg(long = "author", value_name = "NAME")]
    authors: Vec<String>,
    /// What others may do with it; a .vrm needs it: `only-author` is for the author alone,
    /// `non-commercial` for everyone to use, change and give on without profit and with the author's name,
    /// `everyone` to earn with too
    #[arg(long, alias = "licence", value_name = "TERMS")]
    #[arg(value_parser = Permissions::NAMED.map(|(name, _)| name))]
    license: Option<String>,
    /// Where further terms are
    #[arg(long, value_name = "URL")]
    license_url: Option<String>,
    /// Licences of what it was made from, such as the body model's
    #[arg(long, value_name = "TEXT")]
    made_from: Option<String>,
}

impl MetaArgs {
    /// The avatar's name.
    pub(super) fn title(&self, output: &Path) -> String {
        let stem = || output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.title.clone().unwrap_or_else(stem)
    }

    /// What a GLB file says of itself, in a place that people and scripts find: `asset.extras`.
    pub(super) fn extras(&self) -> Map<String, Value> {
        let mut extras = Map::new();
        if let Some(title) = &self.title {
            extras.insert("title".to_owned(), title.clone().into());
        }
        if !self.authors.is_empty() {
            extras.insert("authors".to_owned(), self.authors.clone().into());
        }
        extras
    }

    /// Whom to credit, as GLB files say it.
    pub(super) fn copyright(&self) -> Option<String> {
        (!self.authors.is_empty()).then(|| self.authors.join(", "))
    }

    /// Refuses for a GLB what only a VRM file can say.
    pub(super) fn check_glb(&self) -> anyhow::Result<()> {
        let given = [
            ("--license", self.license.is_some()),
            ("--license-url", self.license_url.is_some()),
            ("--made-from", self.made_from.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(bad_input(format!(
                "{name}: a GLB file has no place for it; write a .vrm, or leave it out"
            ))),
            None => Ok(()),
        }
    }

    /// What a VRM file needs.
    pub(super) fn vrm(&self, output: &Path) -> anyhow::Result<VrmMeta> {
        let license = self.license.as_deref().and_then(Permissions::named);
        let Some(permissions) = license.filter(|_| {
            !self.authors.is_empty() && !self.authors.iter().any(|name| name.trim().is_empty())
        }) else {
            let terms = Permissions::NAMED.map(|(name, _)| name).join(", ");
            return Err(bad_input(format!(
                "{}: a VRM file says whose it is and what others may do with it: give --author NAME and \
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
