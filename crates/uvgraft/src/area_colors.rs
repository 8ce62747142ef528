//! Colours of a texture within anatomical areas of a head, and their typical values.

use uvgraft_surface::anatomy::{Anatomy, Area};
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::piece::{mixed, wide};
use uvgraft_surface::statistics::{median, median_color};
use uvgraft_surface::threads::map_indices;

use crate::color::{Encoding, lab, lab_distance};
use crate::sampler::Sampler;
use crate::texture::Texture;

/// Red, green and blue, sRGB; 1.0 is full intensity.
type Rgb = [f32; 3];

/// Minimum number of colours for an estimate. Origin not recorded.
const MIN_SAMPLES: usize = 24;

/// Barycentric centroids of the four congruent sub-triangles of a triangle.
const QUARTERS: [[f64; 3]; 4] = {
    const SIX: f64 = 1.0 / 6.0;
    const TWO_THIRDS: f64 = 2.0 / 3.0;
    const THIRD: f64 = 1.0 / 3.0;
    [[TWO_THIRDS, SIX, SIX], [SIX, TWO_THIRDS, SIX], [SIX, SIX, TWO_THIRDS], [THIRD, THIRD, THIRD]]
};

/// Colours of a texture in an area, at up to four samples in each triangle whose corner weights in
/// the area average at least 0.5.
///
/// - `is_wanted`: keeps a sample; gets its UV coordinates.
pub fn of_area(
    mesh: &Mesh,
    anatomy: &Anatomy,
    area: Area,
    texture: &Texture,
    is_wanted: &(impl Fn([f64; 2]) -> bool + Sync),
) -> Vec<Rgb> {
    let weights = anatomy.area(area);
    let in_area = |face: usize| {
        mesh.faces()[face].iter().map(|&vertex| weights[vertex as usize]).sum::<f32>() >= 1.5
    };
    let faces: Vec<usize> = (0..mesh.faces().len()).filter(|&face| in_area(face)).collect();
    of_faces(mesh, texture, &faces, |_, _, uv| is_wanted(uv))
}

/// Colours of a texture at up to four samples in each of `faces`.
///
/// - `is_wanted`: keeps a sample; gets its face, its barycentric weights and its UV coordinates.
///
/// Samples with an alpha below 0.5 or a value that is not finite are skipped.
pub(crate) fn of_faces(
    mesh: &Mesh,
    texture: &Texture,
    faces: &[usize],
    is_wanted: impl Fn(usize, [f64; 3], [f64; 2]) -> bool + Sync,
) -> Vec<Rgb> {
    let sampler = Sampler::new(texture);
    let of_face = |index: usize| {
        let face = faces[index];
        let corners = wide(mesh.uv_triangle(face));
        let samples = QUARTERS.into_iter().map(|weights| (weights, mixed(&corners, weights)));
        let kept = samples.filter(|&(weights, uv)| is_wanted(face, weights, uv));
        let colors = kept.map(|(_, uv)| sampler.rgba_as(uv, Encoding::Srgb));
        let opaque =
            colors.filter(|rgba| rgba[3] >= 0.5 && rgba.iter().all(|value| value.is_finite()));
        opaque.map(|[r, g, b, _]| [r, g, b]).collect::<Vec<Rgb>>()
    };
    map_indices(faces.len(), of_face).concat()
}

/// The colours close to their median in CIELAB: within three times the median distance from it, or
/// 8 if that is more. `None` for fewer than 24 colours.
pub fn without_outliers(colors: Vec<Rgb>) -> Option<Vec<Rgb>> {
    if colors.len() < MIN_SAMPLES {
        return None;
    }
    let labs: Vec<[f32; 3]> = colors.iter().map(|&rgb| lab(rgb)).collect();
    let center = median_color(labs.iter().copied())?;
    let dist = |lab: &[f32; 3]| lab_distance(*lab, center);
    let reach = (3.0 * median(labs.iter().map(dist))?).max(8.0);
    let kept = colors.into_iter().zip(&labs).filter(|(_, lab)| dist(lab) <= reach);
    Some(kept.map(|(rgb, _)| rgb).collect())
}
