//! Which texels of a body's texture are labelled as skin: on the synthetic figure, whose parts name
//! their material, and on real bodies.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use uvgraft::labels::skin_of_body;
use uvgraft::raster::ScanTriangle;
use uvgraft::{
    Anatomy, Area, Channels, Direction, Encoding, Graft, Pair, Size, Sizes, Texels, Texture,
};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_image as image;
use uvgraft_tests::looks::{BodyFrame, BodyLook, Label, LayoutSpots, Painted};
use uvgraft_tests::real;

const SIDE: usize = 1024;
const SIZE: Size = Size::square(1024);
type Color = [f32; 3];

/// What a texel of the body shows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shown {
    Nothing,
    Skin,
    Cloth,
    Shoe,
    /// The head, which has finer labels, and the paint on fingers.
    Other,
}

/// The figure's body with a face, and the content of each texel.
struct Scene {
    figure: Figure,
    colors: Vec<Color>,
    shown: Vec<Shown>,
    /// Position of each texel's triangle, in metres.
    at: Vec<[f32; 3]>,
}

impl Scene {
    fn new() -> Self {
        let figure = Figure::new();
        let map: Vec<i64> = figure.vertex_map.iter().map(|&vertex| vertex.into()).collect();
        let pair = Pair::by_vertex_map(figure.head.clone(), figure.body.clone(), &map).unwrap();
        let graft = Graft::builder(pair, Sizes { from: SIZE, to: SIZE }).build().unwrap();
        let texture = graft.apply(paint_head(&figure, SIZE), paint_body(&figure, SIZE)).unwrap();
        let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
        let texels = values.as_chunks::<3>().0.iter();
        let colors: Vec<Color> =
            texels.map(|texel| texel.map(|value| f32::from(value) / 255.0)).collect();
        let mut scene = Self {
            figure,
            shown: vec![Shown::Nothing; colors.len()],
            at: vec![[0.0; 3]; colors.len()],
            colors,
        };
        scene.mark();
        scene
    }

    fn mark(&mut self) {
        let mesh = &self.figure.body;
        for part in mesh.parts() {
            let shown = match (part.object.as_str(), part.material.as_str()) {
                ("head", _) => Shown::Other,
                (_, "cloth") => Shown::Cloth,
                (_, "leather") => Shown::Shoe,
                _ if part.group.starts_with("finger") => Shown::Other,
                _ => Shown::Skin,
            };
            for face in part.polygons.clone().flat_map(|polygon| mesh.polygon(polygon as usize)) {
                let corners = mesh.uv_triangle(face).map(|uv| uv.map(|x| f64::from(x) * 1024.0));
                let middle = mesh.faces()[face].map(|vertex| mesh.positions()[vertex as usize]);
                let middle = [0, 1, 2].map(|k| middle.iter().map(|at| at[k]).sum::<f32>() / 3.0);
                let Some(triangle) = ScanTriangle::new(corners, SIZE) else { continue };
                for row in triangle.rows() {
                    for x in triangle.span(row) {
                        let texel = row as usize * SIDE + x as usize;
                        // Sleeves are painted onto the arms.
                        let [r, _, b] = self.colors[texel];
                        let is_painted = shown == Shown::Skin && r < 1.2 * b;
                        self.shown[texel] = if is_painted { Shown::Cloth } else { shown };
                        self.at[texel] = middle;
                    }
                }
            }
        }
    }

    /// The colours repainted: a function of colour, content, position and texel.
    fn painted(&self, paint: impl Fn(Color, Shown, [f32; 3], usize) -> Color) -> Vec<Color> {
        let texels = 0..self.colors.len();
        texels.map(|k| paint(self.colors[k], self.shown[k], self.at[k], k)).collect()
    }

    /// Share of the skin that is found, and of the cloth that is mistaken for skin.
    fn found(&self, colors: &[Color]) -> [f64; 2] {
        let texels = colors.iter().flat_map(|rgb| rgb.map(|value| (value * 255.0 + 0.5) as u8));
        let texels = Texels::U8(texels.collect());
        let texture = Texture::new(SIZE, Channels::Rgb, Encoding::Srgb, texels).unwrap();
        let found = skin_of_body(&self.figure.body, &texture).unwrap();
        assert_eq!(found.size(), SIZE);
        let Texels::U8(levels) = found.texels() else { panic!("8 bits") };
        [&[Shown::Skin][..], &[Shown::Cloth, Shown::Shoe]].map(|wanted| {
            let of = (0..levels.len()).filter(|&texel| wanted.contains(&self.shown[texel]));
            let (mut skin, mut all) = (0, 0);
            for texel in of {
                skin += usize::from(levels[texel] >= 128);
                all += 1;
            }
            f64::from(skin as u32) / f64::from(all as u32)
        })
    }
}

/// The mean colour of the figure's skin.
fn skin_color(scene: &Scene) -> Color {
    let skin: Vec<Color> = (0..scene.colors.len())
        .filter(|&texel| scene.shown[texel] == Shown::Skin)
        .map(|texel| scene.colors[texel])
        .collect();
    [0, 1, 2].map(|k| skin.iter().map(|rgb| rgb[k]).sum::<f32>() / skin.len() as f32)
}

/// Threads of a weave, from -1 to 1.
fn weave(texel: usize) -> f32 {
    if (texel % SIDE / 2 + texel / SIDE / 2).is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[track_caller]
fn assert_found(what: &str, [skin, cloth]: [f64; 2]) {
    assert!(skin > 0.97, "{what}: {:.1} % of the skin", skin * 100.0);
    assert!(cloth < 0.02, "{what}: {:.1} % of the cloth", cloth * 100.0);
}

#[test]
fn skin_is_separated_from_clothes() {
    let scene = Scene::new();
    assert_found("as it is", scene.found(&scene.colors));
}

#[test]
fn clothes_of_skins_color_are_not_skin() {
    let scene = Scene::new();
    let skin = skin_color(&scene);
    for (what, gain) in
        [("beige", [1.06, 1.12, 1.1]), ("pink", [1.05, 0.93, 0.98]), ("brown", [0.8; 3])]
    {
        let colors = scene.painted(|rgb, shown, _, texel| match shown {
            Shown::Cloth => [0, 1, 2].map(|k| skin[k] * gain[k] + 0.008 * weave(texel)),
            _ => rgb,
        });
        assert_found(what, scene.found(&colors));
    }
}

#[test]
fn skin_of_any_tone_is_found() {
    let scene = Scene::new();
    let tones = [
        ("dark", [0.45, 0.38, 0.34]),
        ("very dark", [0.22, 0.19, 0.18]),
        ("blue", [0.45, 0.75, 1.4]),
    ];
    for (what, gain) in tones {
        let colors = scene.painted(|rgb, shown, _, _| match shown {
            Shown::Cloth | Shown::Shoe => rgb,
            _ => [0, 1, 2].map(|k| (rgb[k] * gain[k]).min(1.0)),
        });
        assert_found(what, scene.found(&colors));
    }
}

#[test]
fn a_body_of_one_color_is_skin() {
    let scene = Scene::new();
    let [skin, cloth] = scene.found(&vec![[0.8, 0.6, 0.5]; scene.colors.len()]);
    assert!(skin > 0.99 && cloth > 0.99, "{skin} {cloth}");
}

#[test]
fn soft_shadows_and_noise_do_not_stop_skin() {
    let scene = Scene::new();
    let mut rng = fastrand::Rng::with_seed(4);
    let noise: Vec<f32> = (0..scene.colors.len()).map(|_| 0.02 * (rng.f32() - 0.5)).collect();
    let colors = scene.painted(|rgb, _, at, texel| {
        let shade = 0.85 + 0.15 * (12.0 * at[1]).sin();
        rgb.map(|value| (value * shade + noise[texel]).clamp(0.0, 1.0))
    });
    assert_found("shaded", scene.found(&colors));
}

/// Sleeves, neck, arms and legs of the figure are separate shells, and here each is shaded
/// differently.
#[test]
fn skin_goes_on_from_shell_to_shell() {
    let figure = Figure::new();
    let layout = LayoutSpots::new(&figure.body, SIZE);
    for look in BodyLook::all() {
        let Painted { texture, truth } = look.paint(&figure.body, &BodyFrame::FIGURE, &layout);
        let found = skin_of_body(&figure.body, &texture).unwrap();
        let Texels::U8(levels) = found.texels() else { panic!("8 bits") };
        let share = |label: Label| {
            let of = (0..levels.len()).filter(|&texel| truth.of_texels[texel] == label);
            let skin = of.clone().filter(|&texel| levels[texel] >= 128).count();
            skin as f64 / of.count() as f64
        };
        let [skin, cloth] = [share(Label::Skin), share(Label::Cloth)];
        // Little of a neckline is farther from its edge than the margin.
        let least = if look.clothing.shirt.is_some() { 0.85 } else { 0.95 };
        assert!(skin > least, "{}: {:.1} % of the skin", look.name, skin * 100.0);
        assert!(cloth < 0.02, "{}: {:.1} % of the cloth", look.name, cloth * 100.0);
    }
}

/// Bodies whose legs are paler than their hands, and whose island edges bleed.
#[test]
fn real_bodies_without_clothes_are_skin_all_over() {
    let (Some(pair), Some(folder)) = (real::flame_to_smplx(), real::folder()) else { return };
    let mesh = pair.to(Direction::Forward);
    let anatomy = Anatomy::find(mesh).unwrap();
    let others = [Area::Scalp, Area::Eyes, Area::MouthInterior, Area::Brows, Area::Lips];
    let others = others.map(|area| anatomy.area(area));
    for name in ["body_light.jpg", "body_medium.jpg"] {
        let body = image::read(folder.join(name)).unwrap().texture;
        let found = skin_of_body(mesh, &body).unwrap();
        let side = f64::from(found.size().width);
        let (mut skin, mut all) = (0, 0);
        for (face, corners) in mesh.faces().iter().enumerate() {
            let is_other = |vertex: &u32| others.iter().any(|area| area[*vertex as usize] > 0.0);
            if mesh.is_outside(face) || corners.iter().any(is_other) {
                continue;
            }
            let uv = mesh.uv_triangle(face);
            let [x, y] = [0, 1].map(|k| {
                let middle = uv.iter().map(|uv| f64::from(uv[k])).sum::<f64>() / 3.0;
                (middle * side).clamp(0.0, side - 1.0) as u32
            });
            skin += usize::from(found.get(x, y, 0) >= 0.5);
            all += 1;
        }
        let share = skin as f64 / all as f64;
        assert!(share > 0.97, "{name}: {:.1} % of {all} triangles", share * 100.0);
    }
}
