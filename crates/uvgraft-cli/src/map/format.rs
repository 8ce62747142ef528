//! The formats of `uvgraft map`, and which options each of them has.

use std::path::Path;

use uvgraft::choices;

use crate::failure::bad_input;

/// A format that maps are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MapFormat {
    Npy,
    Npz,
    Exr,
    Csr,
}

choices!(MapFormat {
    Npy => "npy", "Array of positions";
    Npz => "npz", "Positions for grid_sample, as the reference implementation stores them";
    Exr => "exr", "ST map for compositors";
    Csr => "csr", "Transfer as a sparse matrix for SciPy";
});

impl MapFormat {
    /// The format that a file name asks for.
    pub(super) fn of_path(path: &Path) -> anyhow::Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let endings = [
            (".csr.npz", Self::Csr),
            (".npy", Self::Npy),
            (".npz", Self::Npz),
            (".exr", Self::Exr),
        ];
        let found = endings.into_iter().find(|(ending, _)| name.ends_with(ending));
        found.map(|(_, format)| format).ok_or_else(|| {
            bad_input(format!(
                "cannot write {}: extension must be .npy, .npz, .csr.npz or .exr, or add --format",
                path.display()
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_formats() {
        for (name, wanted) in [
            ("a.npy", MapFormat::Npy),
            ("b/grid.NPZ", MapFormat::Npz),
            ("H.csr.npz", MapFormat::Csr),
            ("csr.npz", MapFormat::Npz),
            ("st.exr", MapFormat::Exr),
        ] {
            assert_eq!(MapFormat::of_path(Path::new(name)).unwrap(), wanted, "{name}");
        }
        for name in ["a.png", "a", ""] {
            assert!(MapFormat::of_path(Path::new(name)).is_err(), "{name}");
        }
    }
}
