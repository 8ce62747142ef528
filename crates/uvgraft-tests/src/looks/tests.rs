//! Tests of painters and measures against values known in advance.

use std::sync::Arc;

use uvgraft::blend::CutMesh;
use uvgraft::color::{linear_from_srgb, srgb_from_linear};
use uvgraft::{
    Blend, BlendDomain, BlendOptions, Channels, Direction, Encoding, Graft, Size, Sizes,
};
use uvgraft::{Texels, Texture};
use uvgraft_figure::Figure;

use super::frame::figure_pair;
use super::measure::{Bench, Case, Figures, agreement};
use super::*;

const FACE: Size = Size::square(256);
const BODY: Size = Size::square(512);

/// The figure with a face in a white collar, on a medium body.
struct Stage {
    bench: Bench,
    body: Painted,
    transferred: Labels,
    paste: Texture,
    region: CutMesh,
}

impl Stage {
    fn new(face: &FaceLook, body: &BodyLook) -> Self {
        let pair = figure_pair(&Figure::new());
        let frame = BodyFrame::FIGURE;
        let bench = Bench::new(Arc::clone(&pair), &frame, BODY);
        let layout = LayoutSpots::new(pair.source(), FACE);
        let face = face.paint(pair.source(), &HeadFrame::FIGURE, &layout);
        let body = body.paint(pair.target(), &frame, bench.layout());
        let transferred = bench.transfer(&face.truth);
        let sizes = Sizes { from: FACE, to: BODY };
        let graft = Graft::builder(Arc::clone(&pair), sizes).build().expect("sound sizes");
        let paste = graft.apply(&face.texture, &body.texture).expect("textures of these sizes");
        let linked = BlendDomain::new(pair, Direction::Forward).linked();
        let region = Blend::new(&linked, BlendOptions::default()).expect("a region").cut();
        let region = region.expect("a small mesh");
        Self { bench, body, transferred, paste, region }
    }

    fn measured(&self, base: &Texture, result: &Texture) -> Figures {
        self.bench.measure(&Case {
            face: Some(&self.transferred),
            body: Some(&self.body.truth),
            base,
            paste: &self.paste,
            result,
            region: &self.region,
        })
    }
}

fn mapped(texture: &Texture, change: impl Fn(usize, Color) -> Color) -> Texture {
    let size = texture.size();
    let values = (0..size.texels())
        .flat_map(|at| {
            let (x, y) = (at as u32 % size.width, at as u32 / size.width);
            let color = change(at, [0, 1, 2].map(|k| texture.get(x, y, k)));
            color.map(|value| (value * 255.0).round() as u8)
        })
        .collect();
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).expect("as many")
}

fn gained(color: Color, gain: f32) -> Color {
    color.map(|value| srgb_from_linear(linear_from_srgb(value) * gain).clamp(0.0, 1.0))
}

#[test]
fn faces_show_the_features_of_their_look() {
    let figure = Figure::new();
    let layout = LayoutSpots::new(&figure.head, FACE);
    for look in FaceLook::all() {
        let painted = look.paint(&figure.head, &HeadFrame::FIGURE, &layout);
        let share = |label: Label| painted.truth.count(label) as f64 / FACE.texels() as f64;
        let name = look.name;
        assert!(share(Label::Skin) > 0.1, "{name}: skin {}", share(Label::Skin));
        assert!(share(Label::Brow) > 0.003, "{name}: brows {}", share(Label::Brow));
        assert!(share(Label::Eye) > 0.003, "{name}: eyes {}", share(Label::Eye));
        let has_hair = look.hair != HairColor::Bald || look.beard == Beard::Full;
        assert_eq!(share(Label::Hair) > 0.02, has_hair, "{name}: hair {}", share(Label::Hair));
        let cloth = share(Label::Cloth);
        assert_eq!(cloth > 0.003, look.collar.is_some(), "{name}: cloth {cloth}");
        let again = look.paint(&figure.head, &HeadFrame::FIGURE, &layout);
        assert!(again.texture == painted.texture && again.truth == painted.truth, "{name}");
    }
}

#[test]
fn bodies_are_paler_on_the_chest_and_wear_their_clothes() {
    let stage = Stage::new(&FaceLook::all()[0], &BodyLook::all()[0]);
    let figure = Figure::new();
    for look in BodyLook::all() {
        let painted = look.paint(&figure.body, &BodyFrame::FIGURE, stage.bench.layout());
        let name = look.name;
        assert!(painted.truth.count(Label::Skin) > BODY.texels() / 20, "{name}");
        let clothing = look.clothing;
        let is_dressed = clothing.shirt.is_some() || clothing.trousers.is_some();
        let cloth = painted.truth.count(Label::Cloth);
        // Shoes are labelled as cloth, too.
        assert_eq!(cloth > BODY.texels() / 15, is_dressed, "{name}: {cloth}");
        let figures = stage.bench.measure(&Case {
            face: Some(&painted.truth),
            body: Some(&painted.truth),
            base: &painted.texture,
            paste: &painted.texture,
            result: &painted.texture,
            region: &stage.region,
        });
        let own = figures.own_cheek_to_chest.expect("cheeks and a chest");
        assert!((3.0..16.0).contains(&own), "{name}: {own}");
        assert_eq!(figures.cheek_to_chest, figures.own_cheek_to_chest, "{name}");
    }
}

#[test]
fn unchanged_textures_show_no_shift() {
    let stage = Stage::new(&FaceLook::all()[0], &BodyLook::all()[1]);
    let same = stage.measured(&stage.body.texture, &stage.paste);
    for shift in [same.hair, same.brow, same.eye, same.cloth, same.skin] {
        assert_eq!(shift.expect("some texels").p95, 0.0);
    }
    assert_eq!((same.clipped_high, same.clipped_low), (Some(0.0), Some(0.0)));
    assert_eq!((same.hands, same.feet.unwrap_or(0.0)), (Some(0.0), 0.0));
    // A very light face in a white collar pasted on a medium body.
    assert!(same.rim > same.own_rim, "{:?} {:?}", same.rim, same.own_rim);
}

/// With all light halved, hands follow the chest, and hair shifts by its own colour difference.
#[test]
fn a_known_gain_is_measured() {
    let stage = Stage::new(&FaceLook::all()[0], &BodyLook::all()[1]);
    let darker = mapped(&stage.paste, |_, color| gained(color, 0.5));
    let figures = stage.measured(&stage.body.texture, &darker);
    let hair = stage.transferred.well_inside(Label::Hair, 2);
    let mut wanted: Vec<f64> = (0..BODY.texels())
        .filter(|&at| hair[at])
        .map(|at| {
            let (x, y) = (at as u32 % BODY.width, at as u32 / BODY.width);
            let of = |texture: &Texture| [0, 1, 2].map(|k| texture.get(x, y, k));
            uvgraft::color::delta_e(of(&stage.paste), of(&darker))
        })
        .collect();
    wanted.sort_by(f64::total_cmp);
    let found = figures.hair.expect("hair").median;
    assert!((found - wanted[wanted.len() / 2]).abs() < 0.05, "{found}");
    assert!(figures.hands.expect("hands") < 0.5, "{:?}", figures.hands);
    // Hands left unchanged would be noticed.
    let frame = BodyFrame::FIGURE;
    let is_hand = |at: usize| {
        stage.bench.layout().spots()[at].is_some_and(|spot| {
            frame.along_arm(frame.head.local(spot.position)).is_some_and(|along| along > 1.0)
        })
    };
    let torn =
        mapped(&stage.paste, |at, color| if is_hand(at) { color } else { gained(color, 0.5) });
    let figures = stage.measured(&stage.body.texture, &torn);
    assert!(figures.hands.expect("hands") > 10.0, "{:?}", figures.hands);
}

#[test]
fn clipped_texels_are_counted() {
    let stage = Stage::new(&FaceLook::new("", SkinTone::MEDIUM), &BodyLook::all()[1]);
    let skin: Vec<usize> =
        (0..BODY.texels()).filter(|&at| stage.transferred.of_texels[at] == Label::Skin).collect();
    let burnt: std::collections::HashSet<usize> = skin.iter().copied().step_by(4).collect();
    let result =
        mapped(&stage.paste, |at, color| if burnt.contains(&at) { [1.0; 3] } else { color });
    let figures = stage.measured(&stage.body.texture, &result);
    let found = figures.clipped_high.expect("skin");
    assert!((found - 0.25).abs() < 0.02, "{found}");
    assert_eq!(figures.clipped_low, Some(0.0));
    // A soft clip below the maximum does not keep colours from washing out.
    let pale = [250.0 / 255.0; 3];
    let result = mapped(&stage.paste, |at, color| if burnt.contains(&at) { pale } else { color });
    let figures = stage.measured(&stage.body.texture, &result);
    assert_eq!(figures.clipped_high, Some(0.0));
    let found = figures.washed_out.expect("skin");
    assert!((found - 0.25).abs() < 0.02, "{found}");
}

#[test]
fn agreement_of_labels_by_hand() {
    let labels = |of: &[Label]| Labels { size: Size::new(6, 1), of_texels: of.to_vec() };
    use Label::{Cloth, Hair, Other, Skin};
    let truth = labels(&[Cloth, Cloth, Cloth, Skin, Skin, Hair]);
    let found = agreement(&labels(&[Cloth, Cloth, Skin, Cloth, Skin, Other]), &truth);
    assert_eq!(found.cloth_iou, Some(0.5));
    assert_eq!(found.lost_skin, 0.5);
    let nothing = labels(&[Skin; 6]);
    assert_eq!(agreement(&nothing, &nothing).cloth_iou, None);
}

#[test]
fn labels_survive_textures_and_erosion_takes_their_edges() {
    let mut of_texels = vec![Label::Skin; 49];
    of_texels[3 * 7 + 3] = Label::Hair;
    let labels = Labels { size: Size::square(7), of_texels };
    assert_eq!(Labels::from_texture(&labels.texture()), labels);
    let inside = labels.well_inside(Label::Skin, 1);
    // The texels along the border and those around the hair are eroded: 25 - 9.
    assert_eq!(inside.iter().filter(|&&inside| inside).count(), 16);
    assert_eq!(labels.well_inside(Label::Hair, 0).iter().filter(|&&inside| inside).count(), 1);
}

#[test]
fn recolouring_and_ramps_multiply_light() {
    let figure = Figure::new();
    let layout = LayoutSpots::new(&figure.head, FACE);
    let painted =
        FaceLook::new("", SkinTone::DARK).paint(&figure.head, &HeadFrame::FIGURE, &layout);
    let brighter = recolored(&painted, [2.0, 1.0, 0.5]);
    let lit = ramped(&painted, &layout, [1.0, 0.0, 0.0], 1.0);
    let mut sides = [[0.0_f32; 2]; 2];
    for (at, spot) in layout.spots().iter().enumerate() {
        let (x, y) = (at as u32 % FACE.width, at as u32 / FACE.width);
        let before = linear_from_srgb(painted.texture.get(x, y, 0));
        let after = linear_from_srgb(brighter.texture.get(x, y, 0));
        assert!((after - (2.0 * before).min(1.0)).abs() < 0.01);
        assert_eq!(painted.texture.get(x, y, 1), brighter.texture.get(x, y, 1));
        if let Some(spot) = spot.filter(|spot| spot.position[0].abs() > 0.06) {
            let side = &mut sides[usize::from(spot.position[0] > 0.0)];
            side[0] += before;
            side[1] += linear_from_srgb(lit.texture.get(x, y, 0));
        }
    }
    let [right, left] = sides.map(|[before, after]| after / before);
    assert!(right < 0.85 && left > 1.18, "{right} {left}");
    assert_eq!(lit.truth, painted.truth);
}
