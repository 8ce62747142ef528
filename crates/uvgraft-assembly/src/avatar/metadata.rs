//! The metadata of avatars, as GLB and as VRM files store them.

use std::path::Path;

use serde_json::{Map, Value};
use uvgraft_gltf::glb::{Permissions, VrmMeta};
use uvgraft_pipeline::{Failure, Result};

use super::request::Metadata;

impl Metadata {
    /// The avatar's name.
    pub(super) fn title(&self, file_name: &Path) -> String {
        let stem = || file_name.file_stem().unwrap_or_default().to_string_lossy().into_owned();
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
    /// - `body`: as in [`Metadata::extras`].
    pub(super) fn copyright(&self, body: Option<&str>) -> Option<String> {
        let authors = (!self.authors.is_empty()).then(|| self.authors.join(", "));
        let body = body.unwrap_or_default().lines();
        let lines: Vec<&str> = authors.as_deref().into_iter().chain(body).collect();
        (!lines.is_empty()).then(|| lines.join("; "))
    }

    /// Rejects what only a VRM file can store.
    pub(super) fn check_glb(&self) -> Result<()> {
        let given = [
            ("license", self.license.is_some()),
            ("license_url", self.license_url.is_some()),
            ("made_from", self.made_from.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(Failure::option(format!("`{name}` is for .vrm outputs only"))),
            None => Ok(()),
        }
    }

    /// The metadata of a VRM file.
    pub(super) fn vrm(&self, file_name: &Path) -> Result<VrmMeta> {
        let are_named =
            !self.authors.is_empty() && !self.authors.iter().any(|name| name.trim().is_empty());
        let Some(permissions) = self.license.filter(|_| are_named) else {
            let terms = Permissions::NAMED.map(|(name, _)| name).join(", ");
            return Err(Failure::option(format!(
                "{}: a VRM file must name its author and terms of use: add `author` NAME and \
                 `license` TERMS ({terms})",
                file_name.display()
            )));
        };
        if let Some(url) = self.license_url.as_deref().filter(|url| !is_url(url)) {
            return Err(Failure::option(format!(
                "`license_url` must be a URL such as https://example.org/terms, got {url:?}"
            )));
        }
        let mut meta = VrmMeta::new(self.title(file_name), self.authors.clone(), permissions);
        meta.other_license_url.clone_from(&self.license_url);
        meta.third_party_licenses.clone_from(&self.made_from);
        Ok(meta)
    }
}

/// Whether a text is a web address, as far as readers of VRM files can open it.
fn is_url(text: &str) -> bool {
    let rest = ["https://", "http://"].iter().find_map(|scheme| {
        let (start, rest) = text.split_at_checked(scheme.len())?;
        start.eq_ignore_ascii_case(scheme).then_some(rest)
    });
    let host = rest.and_then(|rest| rest.split(['/', '?', '#']).next());
    host.is_some_and(|host| !host.is_empty())
        && !text.chars().any(|letter| letter.is_whitespace() || letter.is_control())
}

/// Adds the terms of the body model to the third-party licences of a VRM file.
pub(super) fn with_body_terms(mut vrm: VrmMeta, body: Option<&str>) -> VrmMeta {
    if let Some(body) = body {
        let given = vrm.third_party_licenses.as_deref();
        let lines: Vec<&str> = given.into_iter().chain([body]).collect();
        vrm.third_party_licenses = Some(lines.join("\n"));
    }
    vrm
}
