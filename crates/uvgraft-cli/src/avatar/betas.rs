//! Shape coefficients of body models.

/// The people that body models are learnt from are within this many standard deviations.
const MAX_BETA: f32 = 5.0;

/// A warning about coefficients far beyond those of the training data.
pub(super) fn far_from_people(betas: &[f32]) -> Option<String> {
    let (at, beta) = betas.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (beta.abs() > MAX_BETA).then(|| {
        format!(
            "coefficient {} of {} is {beta}; bodies are distorted beyond ±{MAX_BETA} standard \
             deviations",
            at + 1,
            betas.len()
        )
    })
}
