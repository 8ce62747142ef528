//! The gender of the population that a body model was trained on.

use std::path::Path;

use uvgraft_io::arrays::NamedArrays;

/// Models of the SMPL family come in three variants, each with its own shape space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gender {
    /// Trained on everybody.
    Neutral,
    /// Trained on men.
    Male,
    /// Trained on women.
    Female,
}

impl Gender {
    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Neutral => "neutral",
            Self::Male => "male",
            Self::Female => "female",
        }
    }

    /// Parses a word or its first letter, in any case, also as Python prints bytes: `b'male'`.
    pub fn from_text(text: &str) -> Option<Self> {
        let text = text.trim().trim_matches('\0').to_lowercase();
        let inner = text.strip_prefix('b').filter(|inner| inner.starts_with(['\'', '"']));
        match inner.unwrap_or(&text).trim_matches(['\'', '"']) {
            "neutral" | "n" => Some(Self::Neutral),
            "male" | "m" => Some(Self::Male),
            "female" | "f" => Some(Self::Female),
            _ => None,
        }
    }

    /// From the entry `gender` of a file: a string, or an array of character codes.
    pub fn from_arrays(arrays: &NamedArrays) -> Option<Self> {
        if let Some(text) = arrays.text("gender") {
            return Self::from_text(text);
        }
        let codes = arrays.get("gender")?.integers()?;
        let text: Option<String> =
            codes.iter().map(|&code| u8::try_from(code).ok().map(char::from)).collect();
        Self::from_text(&text?)
    }

    /// From the name of a model's file, such as `SMPLX_FEMALE.npz` or
    /// `basicModel_m_lbs_10_207_0.pkl`, or else from the name of its folder, such as
    /// `smplh/male/model.npz`, because published models don't state the gender inside. `None` if
    /// the name has no gender, or several.
    pub fn of_file(path: impl AsRef<Path>) -> Option<Self> {
        let path = path.as_ref();
        let parent = path.parent().and_then(Path::file_name);
        let named = |name: Option<&std::ffi::OsStr>, letters: bool| {
            let name = name?.to_string_lossy().into_owned();
            let words = name.split(|c: char| !c.is_ascii_alphanumeric());
            let mut found: Vec<Self> = words
                .filter(|word| letters || word.len() > 1)
                .filter_map(Self::from_text)
                .collect();
            found.dedup();
            if let [gender] = found[..] { Some(gender) } else { None }
        };
        named(path.file_stem(), true).or_else(|| named(parent, false))
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::NumericArray;

    use super::*;

    #[test]
    fn every_notation_in_files() {
        for text in ["male", "MALE", "b'male'", "m", " male\0"] {
            assert_eq!(Gender::from_text(text), Some(Gender::Male), "{text}");
        }
        assert_eq!(Gender::from_text("unknown"), None);
        let mut arrays = NamedArrays::new();
        assert_eq!(Gender::from_arrays(&arrays), None);
        let codes = b"female".iter().map(|&byte| i64::from(byte)).collect();
        arrays.insert("gender", NumericArray::new_i64(vec![6], codes).unwrap());
        assert_eq!(Gender::from_arrays(&arrays), Some(Gender::Female));
        arrays.insert_text("gender", "neutral");
        assert_eq!(Gender::from_arrays(&arrays), Some(Gender::Neutral));
    }

    #[test]
    fn names_of_published_files() {
        for (path, gender) in [
            ("SMPLX_NEUTRAL_2020.npz", Some(Gender::Neutral)),
            ("smpl/basicModel_f_lbs_10_207_0_v1.0.0.pkl", Some(Gender::Female)),
            ("smplh/male/model.npz", Some(Gender::Male)),
            ("male/SMPL_FEMALE.pkl", Some(Gender::Female)),
            ("f/model.npz", None),
            ("male_or_female.npz", None),
            ("model.npz", None),
        ] {
            assert_eq!(Gender::of_file(Path::new(path)), gender, "{path}");
        }
    }
}
