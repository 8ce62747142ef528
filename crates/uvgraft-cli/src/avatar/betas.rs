//! Shape coefficients of body models.

/// The people whom body models are learnt from are within this many standard deviations.
const MOST_BETA: f32 = 5.0;

/// A warning about coefficients far beyond those of the people whom models are learnt from.
pub(super) fn far_from_people(betas: &[f32]) -> Option<String> {
    let (at, beta) = betas.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (beta.abs() > MOST_BETA).then(|| {
        format!(
            "coefficient {at} is {beta}: bodies are distorted beyond ±{MOST_BETA} standard \
             deviations"
        )
    })
}
