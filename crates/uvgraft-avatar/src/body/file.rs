//! Reads body models from files, and no more of them than needed: a whole SMPL-X has 400 components
//! of shape and expression and 486 pose correctives, 110 MB, of which a rig uses a tenth.

use uvgraft_files::input::{Input, ReadError};
use uvgraft_io::arrays::{ArrayFile, ArraySelection as Wanted, NamedArrays};

use super::fields::Fields;
use super::model::{EXPRESSION_NAMES, read_kind, split};
use super::named_shapes::{GRIDS, PARAMETERS};
use super::{BodyError, BodyModel, Gender, posedirs};

/// The parts of a model to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadOptions {
    /// Upper limit of the number of shape components.
    pub betas: usize,
    /// Whether to read the correctives of all joints. Otherwise poses only have those
    /// of the jaw, which opens the mouth.
    pub correctives: bool,
}

impl ReadOptions {
    /// The whole model.
    pub const ALL: Self = Self { betas: usize::MAX, correctives: true };
}

/// A body model and the other contents of its file.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// The model.
    pub model: BodyModel,
    /// Its gender, if the file or its name states it.
    pub gender: Option<Gender>,
    /// The terms of the model, if the file states them: one line for each part, which copies and
    /// derived works should quote.
    pub license: Option<String>,
    /// Names of the parts of its mesh, such as `skin` and `tongue`, if the file states them.
    pub parts: Vec<String>,
    /// Names of arrays in the file that are not used.
    pub unused: Vec<String>,
}

/// The arrays read in full; `kintree_table`, `shapedirs` and `posedirs` are handled separately.
const WHOLE: [&str; 12] = [
    "v_template",
    "J_template",
    "J_shapedirs",
    "exprdirs",
    "J_regressor",
    "weights",
    "f",
    "hands_componentsl",
    "hands_componentsr",
    "hands_meanl",
    "hands_meanr",
    "gender",
];
/// Strings read in full.
const TEXTS: [&str; 4] = [EXPRESSION_NAMES, PARAMETERS, LICENSE, PART_NAMES];
/// What only other readers use.
const ELSEWHERE: [&str; 8] =
    ["license_texts", "face_part", "vt", "ft", "head_v", "head_f", "head_vt", "head_ft"];
const LICENSE: &str = "license";
const PART_NAMES: &str = "part_names";
const KIND: &str = "kintree_table";
const SHAPES: &str = "shapedirs";

impl ModelFile {
    /// Reads a model from a file or bytes; see [`BodyModel::from_arrays`] for the expected arrays, and
    /// [`uvgraft_io::arrays::parse`] for the file formats.
    ///
    /// The file is read in three passes: the joints, which determine the kind and thus
    /// the columns that are needed; then everything except the correctives; and finally
    /// these, after the other arrays have been freed.
    ///
    /// # Errors
    /// [`ReadError`] if the file cannot be read or [`BodyModel::from_arrays`] refuses its contents.
    pub fn read(
        input: impl Into<Input>,
        needs: &ReadOptions,
    ) -> Result<Self, ReadError<BodyError>> {
        Self::read_input(&input.into(), needs)
    }

    fn read_input(input: &Input, needs: &ReadOptions) -> Result<Self, ReadError<BodyError>> {
        let path = input.name();
        let refused = |reason: BodyError| ReadError::Content { path: path.to_path_buf(), reason };
        let mut file = ArrayFile::open(input).map_err(in_body)?;
        let (mut apart, mut is_named) = (false, false);
        let first = file.read(|name, _| {
            apart |= name == "exprdirs";
            is_named |= name == PARAMETERS;
            if name == KIND { Wanted::All } else { Wanted::Nothing }
        });
        let first = first.map_err(in_body)?;
        let kind = read_kind(&Fields(&first)).map_err(refused)?;

        let mut known = None;
        let mut arrays = file
            .read(|name, shape| match (name, shape) {
                (SHAPES, &[_, 3, all]) => {
                    let [betas, expressions] = split(kind, all, apart);
                    let kept = betas.min(needs.betas.max(1));
                    // Named shapes need all components.
                    let kept = if is_named { betas } else { kept };
                    known = Some([kept, expressions]);
                    Wanted::Columns(vec![0..kept, betas..betas + expressions])
                }
                _ if is_whole(name) || name == SHAPES => Wanted::All,
                _ => Wanted::Nothing,
            })
            .map_err(in_body)?;
        arrays.extend(first);
        let mut model =
            BodyModel::without_correctives(&Fields(&arrays), kind, known).map_err(refused)?;
        let gender = Gender::from_arrays(&arrays).or_else(|| Gender::of_file(path));
        let license = arrays.text(LICENSE).map(str::to_owned);
        let parts = arrays.text(PART_NAMES).unwrap_or_default();
        let parts = parts.lines().map(str::to_owned).collect();
        let unused = unused(&arrays);
        drop(arrays);

        let features = match (needs.correctives, kind.jaw()) {
            (true, _) => Some(0..kind.features()),
            (false, Some(jaw)) => Some(9 * (jaw - 1)..9 * jaw),
            (false, None) => None,
        };
        if let Some(features) = features {
            let vertices = model.vertices();
            let poses = file.read(|name, shape| match name {
                posedirs::KEY => posedirs::selection(shape, kind, vertices, &features),
                _ => Wanted::Nothing,
            });
            let poses = poses.map_err(in_body)?;
            let found = posedirs::read(&Fields(&poses), kind, vertices, features);
            (model.correctives, model.correctives_left_out) = found.map_err(refused)?;
        }
        Ok(Self { model, gender, license, parts, unused })
    }
}

/// Converts errors of array files to those of body models.
fn in_body(error: ReadError<uvgraft_io::arrays::ArraysError>) -> ReadError<BodyError> {
    match error {
        ReadError::Content { path, reason } => {
            // The file itself is damaged or in another format; "not a body model" would
            // add nothing.
            ReadError::Content { path, reason: BodyError::File(reason) }
        }
        ReadError::Io { path, reason } => ReadError::Io { path, reason },
        other => ReadError::Io {
            path: std::path::PathBuf::new(),
            reason: std::io::Error::other(other.to_string()),
        },
    }
}

fn is_whole(name: &str) -> bool {
    [&WHOLE[..], &TEXTS, &GRIDS].iter().any(|names| names.contains(&name))
}

fn unused(arrays: &NamedArrays) -> Vec<String> {
    let is_used = |name: &&str| {
        is_whole(name) || [KIND, SHAPES, posedirs::KEY].contains(name) || ELSEWHERE.contains(name)
    };
    arrays.names().filter(|name| !is_used(name)).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::{NumericArray, save_npz};

    use super::*;
    use crate::body::{BodyKind, Shape};
    use crate::rig::Pose;

    /// A FLAME model of seven vertices with `components` components, correctives and
    /// one unknown array.
    fn arrays(components: usize) -> NamedArrays {
        let mut arrays = NamedArrays::new();
        let value = |at: usize| (at * 7919 % 1009) as f32 / 1009.0 - 0.5;
        let mut floats = |name: &str, shape: &[usize]| {
            let values = (0..shape.iter().product()).map(|at| value(at).abs() + 0.1).collect();
            arrays.insert(name, NumericArray::new_f32(shape.to_vec(), values).unwrap());
        };
        floats("v_template", &[7, 3]);
        floats("shapedirs", &[7, 3, components]);
        floats("posedirs", &[7, 3, 36]);
        floats("J_regressor", &[5, 7]);
        floats("weights", &[7, 5]);
        floats("dynamic_lmk_bary_coords", &[4, 3]);
        let joints = vec![-1, 0, 1, 1, 1, 0, 1, 2, 3, 4];
        arrays.insert("kintree_table", NumericArray::new_i64(vec![2, 5], joints).unwrap());
        arrays.insert("f", NumericArray::new_i64(vec![1, 3], vec![0, 1, 2]).unwrap());
        arrays
    }

    fn saved(arrays: &NamedArrays) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("FLAME_FEMALE.npz");
        save_npz(arrays, &path).unwrap();
        (folder, path)
    }

    #[test]
    fn a_partly_read_model_agrees_with_the_whole_one() {
        for components in [12, 400, 437] {
            let arrays = arrays(components);
            let whole = BodyModel::from_arrays(&arrays).unwrap();
            let (_folder, path) = saved(&arrays);
            let needs = ReadOptions { betas: 4, correctives: false };
            let some = ModelFile::read(&path, &needs).unwrap();
            assert_eq!(some.gender, Some(Gender::Female));
            assert_eq!(some.unused, ["dynamic_lmk_bary_coords"]);
            assert_eq!((some.model.kind(), some.model.betas()), (BodyKind::Flame, 4));
            assert_eq!(some.model.expressions(), whole.expressions());
            let shape = Shape { betas: vec![0.5, -1.0, 0.0, 2.0], expression: vec![1.0, 0.3] };
            let [some, whole] = [&some.model, &whole].map(|model| model.shaped(&shape).unwrap());
            assert_eq!(some.positions(), whole.positions());
            assert_eq!(some.skeleton(), whole.skeleton());
            // The jaw alone.
            let mut turns = [[0.0; 3]; 5];
            turns[2] = [0.3, 0.1, 0.0];
            let jaw = Pose::from_axis_angles([0.0; 3], &turns);
            assert_eq!(some.posed(&jaw).unwrap(), whole.posed(&jaw).unwrap());
            turns[1] = [0.0, 0.4, 0.0];
            let neck = Pose::from_axis_angles([0.0; 3], &turns);
            assert_ne!(some.posed(&neck).unwrap(), whole.posed(&neck).unwrap());
            let all = ModelFile::read(&path, &ReadOptions::ALL).unwrap().model;
            assert_eq!(all.shaped(&shape).unwrap().posed(&neck), whole.posed(&neck));
        }
    }

    #[test]
    fn correctives_may_be_missing_but_not_damaged() {
        let mut without = arrays(12);
        without.take("posedirs");
        assert!(!BodyModel::from_arrays(&without).unwrap().has_correctives());
        let (_folder, path) = saved(&without);
        assert!(!ModelFile::read(&path, &ReadOptions::ALL).unwrap().model.has_correctives());
        let mut broken = arrays(12);
        let values = [&[f32::NAN], &[0.0; 755][..]].concat();
        broken.insert("posedirs", NumericArray::new_f32(vec![7, 3, 36], values).unwrap());
        let (_folder, path) = saved(&broken);
        let error = ModelFile::read(&path, &ReadOptions::ALL).unwrap_err().to_string();
        assert!(error.contains("`posedirs` must be finite, got NaN at index 0"), "{error}");
    }

    #[test]
    fn correctives_are_read_in_any_arrangement() {
        let usual = arrays(12);
        let values = usual.get("posedirs").unwrap().f32s().into_owned();
        let first: Vec<f32> =
            (0..36).flat_map(|k| values.iter().skip(k).step_by(36).copied()).collect();
        let turned = |turns: &[(usize, [f32; 3])]| {
            let mut all = [[0.0; 3]; 5];
            turns.iter().for_each(|&(joint, turn)| all[joint] = turn);
            Pose::from_axis_angles([0.0; 3], &all)
        };
        let jaw = turned(&[(2, [0.3, 0.1, 0.0])]);
        let both = turned(&[(1, [0.0, 0.4, 0.0]), (2, [0.3, 0.1, 0.0])]);
        let posed =
            |model: &BodyModel, pose| model.shaped(&Shape::default()).unwrap().posed(pose).unwrap();
        let wanted = BodyModel::from_arrays(&usual).unwrap();
        for (shape, values) in [
            (vec![7, 3, 36], &values),
            (vec![21, 36], &values),
            (vec![36, 7, 3], &first),
            (vec![36, 21], &first),
        ] {
            let mut arrays = usual.clone();
            let array = NumericArray::new_f32(shape.clone(), values.clone()).unwrap();
            arrays.insert("posedirs", array);
            let whole = BodyModel::from_arrays(&arrays).unwrap();
            assert_eq!(posed(&whole, &both), posed(&wanted, &both), "{shape:?}");
            let (_folder, path) = saved(&arrays);
            let all = ModelFile::read(&path, &ReadOptions::ALL).unwrap().model;
            assert_eq!(posed(&all, &both), posed(&wanted, &both), "{shape:?}");
            let few = ReadOptions { betas: 4, correctives: false };
            let few = ModelFile::read(&path, &few).unwrap().model;
            assert_eq!(posed(&few, &jaw), posed(&wanted, &jaw), "{shape:?}");
            assert_eq!(few.correctives_left_out(), None);
        }
    }

    #[test]
    fn unknown_correctives_are_left_out_with_a_reason() {
        for shape in [vec![7, 3, 35], vec![7, 3, 93], vec![756], vec![36, 7], vec![8, 3, 36]] {
            let mut arrays = arrays(12);
            let values = vec![0.5; shape.iter().product()];
            arrays.insert("posedirs", NumericArray::new_f32(shape.clone(), values).unwrap());
            let wanted = format!("`posedirs` must have shape [7, 3, 36], got {shape:?}");
            let (_folder, path) = saved(&arrays);
            let few = ReadOptions { betas: 4, correctives: false };
            for model in [
                BodyModel::from_arrays(&arrays).unwrap(),
                ModelFile::read(&path, &ReadOptions::ALL).unwrap().model,
                ModelFile::read(&path, &few).unwrap().model,
            ] {
                assert!(!model.has_correctives());
                assert_eq!(model.correctives_left_out(), Some(wanted.as_str()));
            }
        }
    }
}
