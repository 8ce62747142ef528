//! Morph targets, and the expressions that mix them in.

/// A morph target: where vertices go when its weight is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Morph {
    /// Unlike those of all other morphs.
    pub name: String,
    /// The vertices that move, and by how much, in metres at rest. Each vertex comes once.
    pub offsets: Vec<(u32, [f32; 3])>,
}

impl Morph {
    /// From an offset for each vertex; those shorter than a micrometre are left out.
    pub fn from_dense(name: impl Into<String>, offsets: &[[f32; 3]]) -> Self {
        const LEAST: f32 = 1e-6;
        let moves = |offset: &[f32; 3]| offset.iter().map(|d| d * d).sum::<f32>() > LEAST * LEAST;
        let offsets = (0..).zip(offsets.iter().copied()).filter(|(_, offset)| moves(offset));
        Self { name: name.into(), offsets: offsets.collect() }
    }

    /// Adds it to positions.
    pub fn add(&self, weight: f32, positions: &mut [[f32; 3]]) {
        for &(vertex, offset) in &self.offsets {
            for (value, offset) in positions[vertex as usize].iter_mut().zip(offset) {
                *value += weight * offset;
            }
        }
    }
}

/// An expression that VRM 1.0 knows by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is VRM's name")]
pub enum ExpressionPreset {
    Happy,
    Angry,
    Sad,
    Relaxed,
    Surprised,
    Aa,
    Ih,
    Ou,
    Ee,
    Oh,
    Blink,
    BlinkLeft,
    BlinkRight,
    LookUp,
    LookDown,
    LookLeft,
    LookRight,
    Neutral,
}

impl ExpressionPreset {
    /// VRM's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Happy => "happy",
            Self::Angry => "angry",
            Self::Sad => "sad",
            Self::Relaxed => "relaxed",
            Self::Surprised => "surprised",
            Self::Aa => "aa",
            Self::Ih => "ih",
            Self::Ou => "ou",
            Self::Ee => "ee",
            Self::Oh => "oh",
            Self::Blink => "blink",
            Self::BlinkLeft => "blinkLeft",
            Self::BlinkRight => "blinkRight",
            Self::LookUp => "lookUp",
            Self::LookDown => "lookDown",
            Self::LookLeft => "lookLeft",
            Self::LookRight => "lookRight",
            Self::Neutral => "neutral",
        }
    }
}

/// A mix of morphs that has a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// Unlike those of all other expressions; VRM's name where there is a preset.
    pub name: String,
    /// Which of VRM's own it is.
    pub preset: Option<ExpressionPreset>,
    /// Numbers of morphs and their weights where the expression is full.
    pub morphs: Vec<(usize, f32)>,
}

impl Expression {
    /// One morph as one of VRM's expressions.
    pub fn preset(preset: ExpressionPreset, morphs: Vec<(usize, f32)>) -> Self {
        Self { name: preset.name().to_owned(), preset: Some(preset), morphs }
    }
}
