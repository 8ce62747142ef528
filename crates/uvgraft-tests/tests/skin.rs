//! How well skin is separated from the rest of a body's texture, on the synthetic figure, whose
//! parts name their material.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::raster::ScanTriangle;
use uvgraft::skin::SkinModel;
use uvgraft::statistics::ColorMatch;
use uvgraft::{Graft, MeshPart, Pair, Size, Sizes, Texels, Texture};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_tests::real;

type Color = [f32; 3];

fn colors(texture: &Texture) -> Vec<Color> {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    let texels = values.as_chunks::<3>().0.iter();
    texels.map(|texel| texel.map(|value| f32::from(value) / 255.0)).collect()
}

/// The content of a texel.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shown {
    /// Chest and arms, without the hands' redness.
    Skin,
    /// Redder, with nails.
    Finger,
    /// Skin with features; blank if no face was transferred.
    Head,
    /// Eyes; blank if no face was transferred.
    Eye,
    Hair,
    Cloth,
    Shoe,
}

impl Shown {
    fn of(part: &MeshPart) -> Self {
        match (part.object.as_str(), part.material.as_str()) {
            ("head", "eye") => Self::Eye,
            ("head", "hair") => Self::Hair,
            ("head", _) => Self::Head,
            (_, "cloth") => Self::Cloth,
            (_, "leather") => Self::Shoe,
            _ if part.group.starts_with("finger") => Self::Finger,
            _ => Self::Skin,
        }
    }
}

/// The texels of the body's texture, with their content.
#[derive(Clone)]
struct Body {
    texels: Vec<(Shown, Color)>,
    /// The skin adjacent to the head, which a face's boundary meets.
    seeds: Vec<Color>,
}

impl Body {
    /// With a blank head, or with the face and the hair transferred.
    fn new(with_face: bool) -> Self {
        let figure = Figure::new();
        let size = Size::square(1024);
        let mut texture = paint_body(&figure, size);
        if with_face {
            let map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
            let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &map).unwrap();
            let graft = Graft::builder(pair, Sizes { from: size, to: size }).build().unwrap();
            texture = graft.apply(paint_head(&figure, size), texture).unwrap();
        }
        let texture = colors(&texture);
        let (mut texels, mut seeds) = (Vec::new(), Vec::new());
        let mesh = &figure.body;
        let mut of_head = vec![false; mesh.positions().len()];
        figure.vertex_map.iter().for_each(|&vertex| of_head[vertex as usize] = true);
        for part in mesh.parts() {
            let shown = Shown::of(part);
            for face in part.polygons.clone().flat_map(|polygon| mesh.polygon(polygon as usize)) {
                let at_rim = part.object == "body"
                    && mesh.faces()[face].iter().any(|&vertex| of_head[vertex as usize]);
                let corners = mesh.uv_triangle(face).map(|uv| uv.map(|x| f64::from(x) * 1024.0));
                let Some(triangle) = ScanTriangle::new(corners, size) else { continue };
                for row in triangle.rows() {
                    for x in triangle.span(row) {
                        let color = texture[(row * 1024 + x) as usize];
                        texels.push((shown, color));
                        if at_rim {
                            seeds.push(color);
                        }
                    }
                }
            }
        }
        assert!(seeds.len() > 1000, "{}", seeds.len());
        Self { texels, seeds }
    }

    /// With another complexion.
    fn recolored(&self, gain: Color, lift: f32) -> Self {
        let levels = |color: Color| -> Color {
            std::array::from_fn(|channel| {
                let value = color[channel] * gain[channel] + lift;
                (value * 255.0).round().clamp(0.0, 255.0) / 255.0
            })
        };
        let mut body = self.clone();
        for (shown, color) in &mut body.texels {
            if matches!(shown, Shown::Skin | Shown::Finger) {
                *color = levels(*color);
            }
        }
        body.seeds.iter_mut().for_each(|color| *color = levels(*color));
        body
    }

    fn of(&self, wanted: Shown) -> impl Iterator<Item = Color> + Clone {
        self.texels.iter().filter(move |(shown, _)| *shown == wanted).map(|(_, color)| *color)
    }

    /// Estimated from the boundary's colours and a sample of the whole body. The given shares of
    /// the boundary's colours are replaced by navy cloth and hair.
    fn model(&self, collar: f32, hair: f32) -> SkinModel {
        let mut seeds = self.seeds.clone();
        let count = |share: f32| (self.seeds.len() as f32 * share / (1.0 - collar - hair)) as usize;
        let dark = self.of(Shown::Cloth).filter(|color| color[0] < 0.2);
        seeds.extend(dark.step_by(17).take(count(collar)));
        seeds.extend(self.of(Shown::Hair).step_by(7).take(count(hair)));
        let others: Vec<Color> = self.texels.iter().step_by(37).map(|(_, color)| *color).collect();
        SkinModel::new(&seeds, &others).unwrap()
    }
}

/// Mean weight, and the 5th percentile.
fn weights(model: &SkinModel, colors: impl Iterator<Item = Color>) -> (f32, f32) {
    let mut weights: Vec<f32> = colors.map(|color| model.weight(color)).collect();
    weights.sort_unstable_by(f32::total_cmp);
    let mean = weights.iter().sum::<f32>() / weights.len() as f32;
    (mean, weights[weights.len() / 20])
}

/// Name, gains of the channels, and an offset added to all of them.
const COMPLEXIONS: [(&str, Color, f32); 7] = [
    ("its own", [1.0; 3], 0.0),
    ("in half the light", [0.5; 3], 0.0),
    ("dark", [0.50, 0.42, 0.36], 0.0),
    ("very dark", [0.25, 0.20, 0.17], 0.0),
    ("pale", [0.75, 0.80, 0.85], 0.22),
    ("blue", [0.35, 0.60, 1.30], 0.0),
    ("green", [0.40, 1.00, 0.50], 0.0),
];

/// For any complexion, even if a third of the boundary's colours are not skin.
#[test]
fn skin_is_separated_from_everything_else() {
    let body = Body::new(false);
    for (name, gain, lift) in COMPLEXIONS {
        let body = body.recolored(gain, lift);
        for (collar, hair) in [(0.0, 0.0), (0.2, 0.15)] {
            let model = body.model(collar, hair);
            let (mean, low) = weights(&model, body.of(Shown::Skin));
            assert!(mean > 0.99 && low > 0.99, "{name}: skin {mean}, {low}");
            // Fingertips are flushed, and a tenth of a finger is nail and its edge.
            let (mean, low) = weights(&model, body.of(Shown::Finger));
            assert!(mean > 0.94 && low > 0.5, "{name}: fingers {mean}, {low}");
            for other in [Shown::Cloth, Shown::Shoe, Shown::Hair, Shown::Eye] {
                let (mean, _) = weights(&model, body.of(other));
                assert!(mean < 0.02, "{name}: {other:?} {mean}");
            }
        }
    }
}

/// Baked lighting scales linear light rather than sRGB values, and the boundary has no sample of
/// it.
#[test]
fn shadowed_skin_is_skin() {
    let body = Body::new(false);
    let model = body.model(0.0, 0.0);
    for (light, least) in [(1.3, 0.99), (0.7, 0.99), (0.5, 0.99), (0.35, 0.9), (0.25, 0.4)] {
        let lit =
            |color: Color| color.map(|value| srgb_from_linear(linear_from_srgb(value) * light));
        let (mean, _) = weights(&model, body.of(Shown::Skin).map(lit));
        assert!(mean > least, "{light}: {mean}");
    }
}

/// With a face and hair on the body. Excludes dark skin, which is as brown as the hair, and pale
/// skin, as pink as the corners of the eyes: see below.
#[test]
fn hair_and_eyes_are_not_skin() {
    let body = Body::new(true);
    let complexions =
        COMPLEXIONS.into_iter().filter(|(name, ..)| !name.contains("dark") && *name != "pale");
    for (name, gain, lift) in complexions {
        let body = body.recolored(gain, lift);
        let model = body.model(0.2, 0.15);
        let (mean, low) = weights(&model, body.of(Shown::Skin));
        assert!(mean > 0.99 && low > 0.99, "{name}: skin {mean}, {low}");
        for other in [Shown::Hair, Shown::Eye, Shown::Cloth] {
            let (mean, _) = weights(&model, body.of(other));
            assert!(mean < 0.02, "{name}: {other:?} {mean}");
        }
    }
}

/// Limits of classification by colour alone.
#[test]
fn anything_in_the_skins_color_is_skin() {
    let body = Body::new(true);
    // Brown hair with skin of the same brown.
    let dark = body.recolored([0.50, 0.42, 0.36], 0.0);
    let (hair, _) = weights(&dark.model(0.0, 0.0), dark.of(Shown::Hair));
    assert!((0.05..0.3).contains(&hair), "{hair}");
    // Corners of the eyes with pale skin.
    let pale = body.recolored([0.75, 0.80, 0.85], 0.22);
    let (eyes, _) = weights(&pale.model(0.0, 0.0), pale.of(Shown::Eye));
    assert!((0.2..0.5).contains(&eyes), "{eyes}");
    // A slightly lighter shirt in the skin's colour, without threads or folds to distinguish it.
    let beige = body.of(Shown::Skin).map(|color| color.map(|value| value * 1.08));
    let (shirt, _) = weights(&body.model(0.0, 0.0), beige);
    assert!(shirt > 0.99, "{shirt}");
    // If most of the boundary is something else, that is taken for skin.
    let navy = body.model(0.6, 0.0);
    let (skin, _) = weights(&navy, body.of(Shown::Skin));
    assert!(skin < 0.01, "{skin}");
}

/// Painted features of the face, and nails: which of them change along with the skin.
#[test]
fn lips_and_polish_stay_and_nails_change() {
    let model = Body::new(false).model(0.0, 0.0);
    for (name, color) in [
        ("upper lip", [0.70, 0.375, 0.355]),
        ("lower lip", [0.79, 0.45, 0.42]),
        ("lashes", [0.07, 0.045, 0.04]),
        ("white of the eye", [0.95, 0.935, 0.915]),
        ("end of a nail", [0.95, 0.88, 0.82]),
        ("red polish", [0.70, 0.08, 0.12]),
        ("sole", [0.55, 0.42, 0.30]),
        ("bare head", [0.80, 0.755, 0.72]),
    ] {
        assert!(model.weight(color) < 0.05, "{name}: {}", model.weight(color));
    }
    let nail = model.weight([0.90, 0.66, 0.60]);
    assert!(nail > 0.9, "{nail}");
}

/// Skin takes the mean of another complexion, and everything else stays.
#[test]
fn skin_takes_anothers_colors() {
    let body = Body::new(false);
    let model = body.model(0.2, 0.15);
    let wanted = body.recolored([0.50, 0.42, 0.36], 0.0);
    let skin = |body: &Body| -> Vec<Color> { body.of(Shown::Skin).step_by(11).collect() };
    let map = ColorMatch::new(&skin(&body), &skin(&wanted)).unwrap();
    let blended = |color: Color| -> Color {
        let (weight, matched) = (model.weight(color), map.apply(color));
        std::array::from_fn(|channel| color[channel] + weight * (matched[channel] - color[channel]))
    };
    let mean = |colors: &mut dyn Iterator<Item = Color>| -> Color {
        let (sum, count) = colors.fold(([0.0_f64; 3], 0.0), |(sum, count), color| {
            (std::array::from_fn(|k| sum[k] + f64::from(color[k])), count + 1.0)
        });
        sum.map(|value| (value / count) as f32)
    };
    let change = |a: Color, b: Color| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
    // Trimmed and plain means of skin differ by less than a level: elbows and palms are redder.
    let after = mean(&mut body.of(Shown::Skin).map(blended));
    let target = mean(&mut wanted.of(Shown::Skin));
    assert!(change(after, target) < 2.0 / 255.0, "{after:?} {target:?}");
    for other in [Shown::Cloth, Shown::Hair, Shown::Eye] {
        let (before, after) = (mean(&mut body.of(other)), mean(&mut body.of(other).map(blended)));
        assert!(change(before, after) < 0.25 / 255.0, "{other:?}: {before:?} {after:?}");
    }
}

/// A photographed face above a white and blue shirt; a third of the seeds are the shirt.
#[test]
fn skin_of_a_photograph_is_separated_from_hair_and_shirt() {
    let Some(folder) = real::folder() else { return };
    let image = uvgraft_image::read(folder.join("flame_face_texture.png")).unwrap();
    let size = image.texture.size();
    assert_eq!(size, Size::square(512));
    let texels = colors(&image.texture);
    let within = |[left, top, right, bottom]: [usize; 4]| -> Vec<Color> {
        (top..bottom).flat_map(|y| texels[y * 512..][left..right].iter().copied()).collect()
    };
    let seeds = within([150, 400, 360, 500]);
    let others: Vec<Color> = texels.iter().copied().step_by(7).collect();
    let model = SkinModel::new(&seeds, &others).unwrap();
    for (name, area) in [("cheek", [150, 220, 200, 300]), ("neck", [200, 420, 300, 470])] {
        let (mean, low) = weights(&model, within(area).into_iter());
        assert!(mean > 0.95 && low > 0.8, "{name}: {mean}, {low}");
    }
    for (name, area) in [
        ("hair", [150, 30, 350, 90]),
        ("shirt", [10, 470, 100, 495]),
        ("lip", [235, 312, 265, 326]),
    ] {
        let (mean, _) = weights(&model, within(area).into_iter());
        assert!(mean < 0.05, "{name}: {mean}");
    }
}
