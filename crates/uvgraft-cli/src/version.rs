//! What this program is: its version, its commit, and what it was built with.

use std::fmt::Write as _;

/// The version alone.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The commit that releases are built from; builds from other sources do not know theirs.
const COMMIT: Option<&str> = option_env!("UVGRAFT_COMMIT");

/// Optional features, and whether this program has them.
const FEATURES: [(&str, bool); 5] = [
    ("flip", cfg!(feature = "flip")),
    ("gpu", cfg!(feature = "gpu")),
    ("ktx2", cfg!(feature = "ktx2")),
    ("simplify", cfg!(feature = "simplify")),
    ("viewer", cfg!(feature = "viewer")),
];

/// Rows of what the program is.
pub(crate) fn rows() -> Vec<(&'static str, String)> {
    let commit = COMMIT.filter(|commit| !commit.is_empty()).unwrap_or("unknown");
    let features = |wanted| {
        let names = FEATURES.iter().filter(|(_, has)| *has == wanted).map(|(name, _)| *name);
        let names = names.collect::<Vec<_>>().join(", ");
        if names.is_empty() { "none".to_owned() } else { names }
    };
    vec![
        ("version", VERSION.to_owned()),
        ("commit", commit.to_owned()),
        ("built for", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)),
        ("features", features(true)),
        ("without", features(false)),
        ("SIMD", uvgraft::simd_level().to_owned()),
    ]
}

/// What `uvgraft --version --verbose` prints.
pub(crate) fn verbose() -> String {
    let mut text = format!("uvgraft {VERSION}\n");
    for (name, value) in rows().into_iter().skip(1) {
        let _ = writeln!(text, "{name:<10} {value}");
    }
    text
}
