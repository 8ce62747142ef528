//! Levels of detail: the same avatar with fewer and fewer triangles.

use uvgraft_avatar::Avatar;

use super::{Deviation, PresetError};

/// Maximum number of levels, each with half the triangles of the one before.
pub const MAX_LEVELS: usize = 6;

/// A coarser level of an avatar.
#[derive(Debug, Clone)]
pub struct Level {
    /// The avatar, with all its joints, morphs and clips.
    pub avatar: Avatar,
    /// Value for [`Export::normals`](crate::glb::Export::normals).
    pub normals: Vec<[f32; 3]>,
    /// Number of triangles.
    pub triangles: usize,
    /// Deviation of the finest level's vertices from this level in the rest pose, in metres.
    pub deviation: Deviation,
}

/// Creates coarser levels of an avatar, finest first, each with about half the triangles of the one
/// before. All are simplified from the original avatar, so errors do not accumulate.
///
/// - `normals`: the avatar's displayed normals, see
///   [`FittedAvatar::normals`](super::FittedAvatar::normals).
/// - `count`: number of levels, [`MAX_LEVELS`] at most.
///
/// # Errors
/// [`PresetError::Budget`] without the feature `simplify`, [`PresetError::Mesh`] if no triangle
/// would be left.
#[cfg(feature = "simplify")]
pub fn levels(
    avatar: &Avatar,
    normals: Option<&[[f32; 3]]>,
    count: usize,
) -> Result<Vec<Level>, PresetError> {
    let all = avatar.mesh.faces().len();
    let level = |number: usize| {
        let normals = normals.unwrap_or_default();
        let simplified = super::simplify::simplify_shown(avatar.clone(), normals, all >> number)?;
        Ok(Level {
            triangles: simplified.after,
            deviation: Deviation::between(&avatar.mesh, &simplified.avatar.mesh),
            avatar: simplified.avatar,
            normals: simplified.normals,
        })
    };
    (1..=count.min(MAX_LEVELS)).map(level).collect()
}

/// Levels of detail; not supported by this build.
///
/// # Errors
/// [`PresetError::Budget`] unless `count` is 0.
#[cfg(not(feature = "simplify"))]
pub fn levels(
    avatar: &Avatar,
    _: Option<&[[f32; 3]]>,
    count: usize,
) -> Result<Vec<Level>, PresetError> {
    let found = avatar.mesh.faces().len();
    if count == 0 { Ok(Vec::new()) } else { Err(PresetError::Budget { found, wanted: found / 2 }) }
}

#[cfg(all(test, feature = "simplify"))]
mod tests {
    use uvgraft_figure::Figure;

    use super::*;

    #[test]
    fn levels_halve_the_triangles_and_keep_the_rest() {
        let figure = Figure::new().avatar();
        let all = figure.mesh.faces().len();
        let levels = levels(&figure, None, 3).unwrap();
        let mut before = Deviation::default();
        for (number, level) in (1..).zip(&levels) {
            level.avatar.check().unwrap();
            let share = level.triangles as f64 / (all >> number) as f64;
            assert!((0.95..1.05).contains(&share), "{number}: {} of {all}", level.triangles);
            assert_eq!(level.normals.len(), level.avatar.mesh.positions().len());
            let names = |avatar: &Avatar| {
                let morphs = avatar.morphs.iter().map(|morph| morph.name.clone());
                morphs.chain(avatar.clips.iter().map(|clip| clip.name.clone())).collect::<Vec<_>>()
            };
            assert_eq!(names(&level.avatar), names(&figure));
            assert!(level.avatar.morphs.iter().all(|morph| !morph.offsets.is_empty()), "{number}");
            // The figure's eyes are 3 cm wide; with errors of two centimetres and more it
            // would look like another person.
            let Deviation { mean, most } = level.deviation;
            assert!(most < 0.02 && mean < 0.002, "{number}: {mean} {most}");
            assert!(level.deviation.mean > before.mean, "{:?}", level.deviation);
            before = level.deviation;
        }
    }
}
