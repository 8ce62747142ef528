//! Facial expressions of a body model as morph targets.

use super::Shaped;
use crate::Avatar;
use crate::face::{self, BlendBasis, Face, FaceError, Solved, UnmetTarget};
use crate::rig::{Expression, ExpressionPreset as Preset, Morph, Pose, RigError};

/// Angle of the jaw in the `jaw_open` morph, in radians: as far as in speech.
const JAW_OPEN: f32 = 0.25;
/// Widest opening of the jaw, in radians: as far as in a yawn.
const JAW_WIDEST: f32 = 0.45;
/// Limit of expression coefficients, which are in standard deviations: hardly any face
/// exceeds three.
const MAX_COEFFICIENT: f32 = 3.0;

/// Number of expression components exported as raw morphs if the face cannot be measured.
const COMPONENTS: usize = 10;

/// The result of adding expressions to a body.
#[derive(Debug, Clone, Default)]
pub struct ExpressionReport {
    /// The model has nothing that moves the face.
    pub has_none: bool,
    /// Expressions that the model cannot make, or only in part.
    pub shortfalls: Vec<UnmetTarget>,
    /// Why expressions could not be solved; the first components are raw morphs in that case.
    pub unmeasured: Option<FaceError>,
}

impl Shaped<'_> {
    /// Adds VRM's expressions to an avatar of this body: the solved ones, see
    /// [`Shaped::expressions`]; `blink` from the blinks of both eyes; the gaze directions; and
    /// `neutral`, which is the face at rest. Models without anything that moves the face get none.
    ///
    /// A model with expressions by name has them as morph targets and custom expressions, and the
    /// presets are combinations of them instead of being solved.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn add_expressions(&self, avatar: &mut Avatar) -> Result<ExpressionReport, RigError> {
        if !self.has_expressions() {
            return Ok(ExpressionReport { has_none: true, ..ExpressionReport::default() });
        }
        let mut outcome = ExpressionReport::default();
        if self.has_named_expressions() {
            self.add_named_expressions(avatar);
            face::add_gaze(avatar);
            avatar.expressions.push(Expression::preset(Preset::Neutral, Vec::new()));
            return Ok(outcome);
        }
        match Face::find(&avatar.mesh) {
            Ok(face) => {
                let solved = self.expressions(&face)?;
                for (preset, morph) in solved.morphs {
                    let number = avatar.morphs.len();
                    avatar.expressions.push(Expression::preset(preset, vec![(number, 1.0)]));
                    avatar.morphs.push(morph);
                }
                outcome.shortfalls = solved.shortfalls;
            }
            Err(error) => {
                avatar.morphs = self.components(COMPONENTS)?;
                if let Some(jaw) = avatar.morphs.iter().position(|morph| morph.name == "jaw_open") {
                    avatar.expressions.push(Expression::preset(Preset::Aa, vec![(jaw, 1.0)]));
                }
                outcome.unmeasured = Some(error);
            }
        }
        let number = |preset: Preset| avatar.morphs.iter().position(|m| m.name == preset.name());
        if let (Some(left), Some(right)) = (number(Preset::BlinkLeft), number(Preset::BlinkRight)) {
            let both = vec![(left, 1.0), (right, 1.0)];
            avatar.expressions.push(Expression::preset(Preset::Blink, both));
        }
        face::add_gaze(avatar);
        avatar.expressions.push(Expression::preset(Preset::Neutral, Vec::new()));
        Ok(outcome)
    }

    /// VRM's expressions, each a combination of everything that moves the face: the
    /// expression components within three standard deviations, and the jaw. Expressions
    /// that the model cannot make are left out and reported.
    ///
    /// - `face`: located on this shape.
    ///
    /// # Errors
    /// See [`Pose::check`].
    ///
    /// # Panics
    /// If `face` was located on a mesh with more vertices.
    pub fn expressions(&self, face: &Face) -> Result<Solved, RigError> {
        // Blend shapes by name are full expressions at 1, and have no opposite.
        let limits = if self.has_named_expressions() {
            [0.0, 1.0]
        } else {
            [-MAX_COEFFICIENT, MAX_COEFFICIENT]
        };
        let mut movements: Vec<BlendBasis> = (0..self.model.expressions())
            .map(|component| BlendBasis {
                offsets: self.model.expression(component).to_vec(),
                limits,
                is_jaw: false,
            })
            .collect();
        if let Some(offsets) = self.jaw_open(JAW_OPEN)? {
            let limits = [0.0, JAW_WIDEST / JAW_OPEN];
            movements.push(BlendBasis { offsets, limits, is_jaw: true });
        }
        Ok(face::solve(face, &self.positions, &movements))
    }

    /// Whether the model has anything that moves the face.
    pub fn has_expressions(&self) -> bool {
        self.model.expressions() > 0 || self.model.kind.jaw().is_some()
    }

    /// The first raw expression components, named `expression_00` and so on, where a weight of 1 is
    /// a coefficient of 1; and `jaw_open` if there is a jaw, with pose correctives.
    ///
    /// # Errors
    /// See [`Pose::check`].
    pub fn components(&self, count: usize) -> Result<Vec<Morph>, RigError> {
        let mut morphs: Vec<Morph> = (0..count.min(self.model.expressions()))
            .map(|component| {
                let name = format!("expression_{component:02}");
                Morph::from_dense(name, self.model.expression(component))
            })
            .collect();
        morphs.extend(self.jaw_open(JAW_OPEN)?.map(|open| Morph::from_dense("jaw_open", &open)));
        Ok(morphs)
    }

    /// Vertex offsets when the jaw opens by an angle.
    fn jaw_open(&self, angle: f32) -> Result<Option<Vec<[f32; 3]>>, RigError> {
        let Some(jaw) = self.model.kind.jaw() else { return Ok(None) };
        let mut turns = vec![[0.0; 3]; self.skeleton.joints().len()];
        turns[jaw] = [angle, 0.0, 0.0];
        let open = self.posed(&Pose::from_axis_angles([0.0; 3], &turns))?;
        let offset = |(open, rest): (&[f32; 3], &[f32; 3])| {
            std::array::from_fn(|axis| open[axis] - rest[axis])
        };
        Ok(Some(open.iter().zip(&self.positions).map(offset).collect()))
    }
}
