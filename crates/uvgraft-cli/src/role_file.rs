//! Material maps as option values.

/// A material map, or the base of one, with its role.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RoleFile {
    pub(crate) role: String,
    pub(crate) file: String,
}

impl RoleFile {
    /// Parses `ROLE=FILE`.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((role, file)) if !role.is_empty() && !file.is_empty() => {
                Ok(Self { role: role.to_ascii_lowercase(), file: file.to_owned() })
            }
            _ => Err("must be ROLE=FILE, such as normal=face_normal.png".to_owned()),
        }
    }
}
