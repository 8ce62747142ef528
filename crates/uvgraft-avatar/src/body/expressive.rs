//! What the face of a body model can do, as morphs.

use super::Shaped;
use crate::Avatar;
use crate::face::{self, Face, FaceError, Movement, Shortfall, Solved};
use crate::rig::{Expression, ExpressionPreset as Preset, Morph, Pose, RigError};

/// How far the jaw opens as a morph, in radians: as far as in speech.
const JAW_OPEN: f32 = 0.25;
/// How far it opens at most: as far as in a yawn.
const JAW_WIDEST: f32 = 0.45;
/// Coefficients of expression are standard deviations: hardly a face is beyond three.
const MOST_COEFFICIENT: f32 = 3.0;

/// As many components are morphs of their own where a face cannot be measured.
const COMPONENTS: usize = 10;

/// What became of a body's expressions.
#[derive(Debug, Clone, Default)]
pub struct Expressiveness {
    /// Nothing moves the face.
    pub has_none: bool,
    /// What the model cannot do, or not in full.
    pub shortfalls: Vec<Shortfall>,
    /// Why expressions could not be solved; then the first components are morphs as they are.
    pub unmeasured: Option<FaceError>,
}

impl Shaped<'_> {
    /// Gives an avatar of this body VRM's expressions: solved ones, see [`Shaped::expressions`]; both eyes' blinks as
    /// `blink`; where eyes look; and `neutral`, which is the face at rest. Models without anything that moves the
    /// face get none.
    ///
    /// # Errors
    /// As [`Pose::check`].
    pub fn give_expressions(&self, avatar: &mut Avatar) -> Result<Expressiveness, RigError> {
        if !self.has_expressions() {
            return Ok(Expressiveness { has_none: true, ..Expressiveness::default() });
        }
        let mut told = Expressiveness::default();
        match Face::find(&avatar.mesh) {
            Ok(face) => {
                let solved = self.expressions(&face)?;
                for (preset, morph) in solved.morphs {
                    let number = avatar.morphs.len();
                    avatar.expressions.push(Expression::preset(preset, vec![(number, 1.0)]));
                    avatar.morphs.push(morph);
                }
                told.shortfalls = solved.shortfalls;
            }
            Err(error) => {
                avatar.morphs = self.components(COMPONENTS)?;
                if let Some(jaw) = avatar.morphs.iter().position(|morph| morph.name == "jaw_open") {
                    avatar.expressions.push(Expression::preset(Preset::Aa, vec![(jaw, 1.0)]));
                }
                told.unmeasured = Some(error);
            }
        }
        let number = |preset: Preset| avatar.morphs.iter().position(|m| m.name == preset.name());
        if let (Some(left), Some(right)) = (number(Preset::BlinkLeft), number(Preset::BlinkRight)) {
            let both = vec![(left, 1.0), (right, 1.0)];
            avatar.expressions.push(Expression::preset(Preset::Blink, both));
        }
        face::add_gaze(avatar);
        avatar.expressions.push(Expression::preset(Preset::Neutral, Vec::new()));
        Ok(told)
    }

    /// VRM's expressions, each as a mix of all that moves the face: components of expression within three
    /// standard deviations, and the jaw. What the model cannot do is left out and named.
    ///
    /// - `face`: found on this shape.
    ///
    /// # Errors
    /// As [`Pose::check`].
    ///
    /// # Panics
    /// If `face` was found on a mesh of more vertices.
    pub fn expressions(&self, face: &Face) -> Result<Solved, RigError> {
        let mut movements: Vec<Movement> = (0..self.model.expressions())
            .map(|component| Movement {
                offsets: self.model.expression(component).to_vec(),
                limits: [-MOST_COEFFICIENT, MOST_COEFFICIENT],
                is_jaw: false,
            })
            .collect();
        if let Some(offsets) = self.jaw_open(JAW_OPEN)? {
            let limits = [0.0, JAW_WIDEST / JAW_OPEN];
            movements.push(Movement { offsets, limits, is_jaw: true });
        }
        Ok(face::solve(face, &self.positions, &movements))
    }

    /// Whether anything moves the face.
    pub fn has_expressions(&self) -> bool {
        self.model.expressions() > 0 || self.model.kind.jaw().is_some()
    }

    /// The first components of expression as they are, `expression_00` and so on, with a coefficient of 1
    /// where the weight is 1; and `jaw_open` where there is a jaw, correctives included.
    ///
    /// # Errors
    /// As [`Pose::check`].
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

    /// Where vertices go when the jaw opens by an angle.
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
