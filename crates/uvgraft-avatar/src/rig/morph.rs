//! Morph targets, and the expressions that combine them.

/// A morph target: vertex offsets at a weight of 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Morph {
    /// Unique among the morphs.
    pub name: String,
    /// The vertices that move and their offsets, in metres at rest. Each vertex occurs once.
    pub offsets: Vec<(u32, [f32; 3])>,
}

impl Morph {
    /// Builds a morph from an offset for each vertex, dropping those shorter than a micrometre.
    pub fn from_dense(name: impl Into<String>, offsets: &[[f32; 3]]) -> Self {
        const MIN: f32 = 1e-6;
        let moves = |offset: &[f32; 3]| offset.iter().map(|d| d * d).sum::<f32>() > MIN * MIN;
        let offsets = (0..).zip(offsets.iter().copied()).filter(|(_, offset)| moves(offset));
        Self { name: name.into(), offsets: offsets.collect() }
    }

    /// Adds the weighted offsets to positions.
    pub fn add(&self, weight: f32, positions: &mut [[f32; 3]]) {
        for &(vertex, offset) in &self.offsets {
            for (value, offset) in positions[vertex as usize].iter_mut().zip(offset) {
                *value += weight * offset;
            }
        }
    }
}

/// An expression preset of VRM 1.0.
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

/// A named combination of morphs.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    /// Unique among the expressions; VRM's name for a preset.
    pub name: String,
    /// The VRM preset, if it is one.
    pub preset: Option<ExpressionPreset>,
    /// Indices of morphs and their weights in the full expression.
    pub morphs: Vec<(usize, f32)>,
}

impl Expression {
    /// A VRM preset made of morphs.
    pub fn preset(preset: ExpressionPreset, morphs: Vec<(usize, f32)>) -> Self {
        Self { name: preset.name().to_owned(), preset: Some(preset), morphs }
    }
}
