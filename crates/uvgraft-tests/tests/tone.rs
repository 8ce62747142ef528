//! The tone of painted faces on painted bodies with known colours.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::CutMesh;
use uvgraft::{
    Anatomy, Area, Blend, BlendDomain, BlendOptions, Channels, Depth, Direction, Encoding, Graft,
    Pair, Size, Sizes, Texels, Texture, Tone,
};
use uvgraft_figure::Figure;
use uvgraft_metrics::seams::{SeamError, ToneMatch, ToneReferences, TransferredFace, measure_tone};
use uvgraft_tests::looks::frame::figure_pair;
use uvgraft_tests::looks::{
    BodyFrame, BodyLook, Collar, FaceLook, HeadFrame, Label, Labels, LayoutSpots, SkinTone,
};

const SIZES: Sizes = Sizes { from: Size::square(384), to: Size::square(768) };

/// A brown face, and a body with very light skin.
struct Stage {
    pair: Arc<Pair>,
    cut: CutMesh,
    anatomy: Anatomy,
    face: Texture,
    pasted: TransferredFace,
    base: Texture,
}

impl Stage {
    fn new() -> Self {
        let pair = figure_pair(&Figure::new());
        let look = FaceLook { skin: SkinTone::BROWN, ..FaceLook::all()[0] };
        let layout = LayoutSpots::new(pair.source(), SIZES.from);
        let face = look.paint(pair.source(), &HeadFrame::FIGURE, &layout).texture;
        let layout = LayoutSpots::new(pair.target(), SIZES.to);
        let body = BodyLook::new("very light", SkinTone::VERY_LIGHT);
        let base = body.paint(pair.target(), &BodyFrame::FIGURE, &layout).texture;
        let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
        let pasted = TransferredFace::new(&domain, &face, SIZES.to).unwrap();
        let blend = Blend::new(&domain.linked(), BlendOptions::default()).unwrap();
        let cut = blend.cut().unwrap();
        let anatomy = Anatomy::find(&cut.mesh).unwrap();
        Self { pair, cut, anatomy, face, pasted, base }
    }

    fn transferred(&self, options: BlendOptions) -> Texture {
        self.transfer(&self.face, options)
    }

    fn transfer(&self, face: &Texture, options: BlendOptions) -> Texture {
        let graft = Graft::builder(Arc::clone(&self.pair), SIZES).blend(options).build().unwrap();
        graft.apply(face, &self.base).unwrap()
    }

    fn measured(
        &self,
        texture: &Texture,
        references: ToneReferences<'_>,
    ) -> Result<ToneMatch, SeamError> {
        measure_tone(&self.cut.mesh, &self.anatomy, texture, &self.cut.inside, references)
    }

    fn all(&self) -> ToneReferences<'_> {
        ToneReferences { base: Some(&self.base), face: Some(&self.pasted) }
    }
}

#[test]
fn a_blend_without_tone_is_detected() {
    let stage = Stage::new();
    let feather = BlendOptions::default().feather(0.01);
    let measured = |options| stage.measured(&stage.transferred(options), stage.all()).unwrap();
    let (plain, toned) = (measured(feather), measured(feather.membrane()));
    for tone in [plain, toned] {
        let own = tone.own.unwrap();
        assert_eq!(own.chest_area, Area::Chest);
        assert!((2.0..16.0).contains(&own.delta_e()), "{tone:?}");
        assert!(tone.hair_shift.unwrap() < 1.0 && !tone.is_clipped(), "{tone:?}");
    }
    assert!(!plain.matches_body() && plain.excess().unwrap() > 8.0, "{plain:?}");
    assert!(toned.matches_body(), "{toned:?}");
}

#[test]
fn a_body_in_a_face_s_tone_keeps_its_contrast() {
    let stage = Stage::new();
    let membrane = BlendOptions::default().feather(0.01).membrane();
    for tone in [Tone::Base, Tone::Source, Tone::Both] {
        let found = stage.measured(&stage.transferred(membrane.tone(tone)), stage.all()).unwrap();
        let excess = found.excess().unwrap();
        assert!(excess.abs() < 2.0, "{tone:?}: cheek to chest off by {excess}");
    }
}

#[test]
fn missing_references_leave_measures_empty() {
    let stage = Stage::new();
    let texture = stage.transferred(BlendOptions::default());
    let alone = stage.measured(&texture, ToneReferences::default()).unwrap();
    assert!(alone.skin.is_some() && alone.own.is_none() && alone.hair_shift.is_none());
    // Nothing in a plain paste is clipped, with labels or without.
    assert!(alone.clipped.unwrap() < 0.01, "{alone:?}");
    let nothing = vec![false; stage.cut.inside.len()];
    let nothing =
        measure_tone(&stage.cut.mesh, &stage.anatomy, &texture, &nothing, stage.all()).unwrap();
    assert_eq!((nothing.clipped, nothing.hair_shift), (None, None));
    // A face compared with itself shows no shift.
    let own = stage.measured(&texture, stage.all()).unwrap();
    assert!(own.hair_shift.unwrap() < 0.5 && own.clipped == Some(0.0), "{own:?}");
}

#[test]
fn burnt_skin_is_clipped_skin() {
    let stage = Stage::new();
    let texture =
        recolored(&stage.transferred(BlendOptions::default()), |value, _, _| (value * 2.5).floor());
    let found = stage.measured(&texture, stage.all()).unwrap();
    assert!(found.clipped.unwrap() > 0.3 && found.is_clipped(), "{found:?}");
    assert!(found.hair_shift.unwrap() > 3.0, "{found:?}");
}

#[test]
fn mismatched_inputs_are_refused() {
    let stage = Stage::new();
    let of = |size, encoding| {
        Texture::filled(size, Channels::Rgb, encoding, Depth::U8, &[0.5; 3]).unwrap()
    };
    let (texture, data) = (of(SIZES.to, Encoding::Srgb), of(SIZES.to, Encoding::Data));
    let small = of(SIZES.from, Encoding::Srgb);
    let base = |base| ToneReferences { base: Some(base), face: None };
    let size = |what| SeamError::Size { what, found: SIZES.from, wanted: SIZES.to };
    let found = stage.measured(&texture, base(&small)).unwrap_err();
    assert_eq!(found, size("base"));
    assert_eq!(
        found.to_string(),
        "the base must have the size of the texture, 768×768, got 384×384"
    );
    for (texture, base_texture) in [(&data, &texture), (&texture, &data)] {
        let found = stage.measured(texture, base(base_texture)).unwrap_err();
        assert_eq!(found, SeamError::NotColor);
    }
    let found = stage.measured(&small, ToneReferences { base: None, ..stage.all() }).unwrap_err();
    assert_eq!(found, SeamError::Size { what: "face", found: SIZES.to, wanted: SIZES.from });
    let short =
        measure_tone(&stage.cut.mesh, &stage.anatomy, &texture, &[true], ToneReferences::default());
    assert!(matches!(short, Err(SeamError::Region { found: 1, .. })));
}

/// Colours at the centroids of the cheeks' triangles.
fn cheeks(stage: &Stage, texture: &Texture) -> Vec<[f32; 3]> {
    let mesh = &stage.cut.mesh;
    let weights = stage.anatomy.area(Area::Cheeks);
    let is_cheek = |face: &usize| {
        mesh.faces()[*face].iter().map(|&vertex| weights[vertex as usize]).sum::<f32>() >= 2.4
    };
    let color = |face: usize| {
        let corners = mesh.uv_triangle(face);
        let uv = [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f32>() / 3.0);
        let Size { width, height } = texture.size();
        let at = |uv: f32, side: u32| ((uv * side as f32) as u32).min(side - 1);
        [0, 1, 2].map(|k| texture.get(at(uv[0], width), at(uv[1], height), k))
    };
    (0..mesh.faces().len()).filter(is_cheek).map(color).collect()
}

fn mean(colors: &[[f32; 3]]) -> [f32; 3] {
    [0, 1, 2].map(|k| colors.iter().map(|color| color[k]).sum::<f32>() / colors.len() as f32)
}

/// A stage whose body has the same face already.
fn worn() -> Stage {
    let mut stage = Stage::new();
    let layout = LayoutSpots::new(stage.pair.target(), SIZES.to);
    let body = BodyLook::new("brown", SkinTone::BROWN);
    stage.base = body.paint(stage.pair.target(), &BodyFrame::FIGURE, &layout).texture;
    stage.base = stage.transferred(BlendOptions::default());
    stage
}

/// With each value replaced by a function of value, texel and channel, rounded.
fn recolored(texture: &Texture, value: impl Fn(f32, [u32; 2], usize) -> f32) -> Texture {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    let width = texture.size().width as usize;
    let value = |(index, &old): (usize, &u8)| {
        let (texel, channel) = (index / 3, index % 3);
        let at = [texel % width, texel / width].map(|place| place as u32);
        (value(f32::from(old), at, channel) + 0.5).clamp(0.0, 255.0) as u8
    };
    let values = values.iter().enumerate().map(value).collect();
    Texture::new(texture.size(), texture.channels(), Encoding::Srgb, Texels::U8(values)).unwrap()
}

#[test]
fn a_known_gain_is_taken_back() {
    let stage = worn();
    let wanted = cheeks(&stage, &stage.base);
    assert!(wanted.len() > 20, "{} triangles", wanted.len());
    for gain in [[0.75, 0.8, 0.7], [1.25, 1.15, 1.1], [0.9, 0.6, 0.8], [1.1, 1.3, 1.5], [0.5; 3]] {
        let face = recolored(&stage.face, |value, _, channel| value * gain[channel]);
        let found = cheeks(
            &stage,
            &stage.transfer(&face, BlendOptions::default().feather(0.01).membrane()),
        );
        let differences = found.iter().zip(&wanted).map(|(&a, &b)| uvgraft::color::delta_e(a, b));
        let mean = differences.sum::<f64>() / found.len() as f64;
        assert!(mean < 2.0, "{gain:?}: ΔE {mean}");
    }
}

#[test]
fn a_ramp_of_light_keeps_its_contrast() {
    let stage = worn();
    let wanted = mean(&cheeks(&stage, &stage.base));
    let contrast = |colors: &[[f32; 3]]| {
        let green = colors.iter().map(|color| color[1]);
        let mean = green.clone().sum::<f32>() / colors.len() as f32;
        (green.map(|value| (value - mean).powi(2)).sum::<f32>() / colors.len() as f32).sqrt() / mean
    };
    for (left, right) in [(0.75, 1.15), (1.2, 0.7), (0.6, 0.9)] {
        let face = recolored(&stage.face, |value, [x, _], _| {
            value * (left + (right - left) * x as f32 / SIZES.from.width as f32)
        });
        let pasted = cheeks(&stage, &stage.transfer(&face, BlendOptions::default()));
        let found = cheeks(
            &stage,
            &stage.transfer(&face, BlendOptions::default().feather(0.01).membrane()),
        );
        let off = uvgraft::color::delta_e(mean(&found), wanted);
        assert!(off < 2.0, "{left} to {right}: ΔE {off}");
        let kept = contrast(&found) / contrast(&pasted);
        assert!((kept - 1.0).abs() < 0.1, "{left} to {right}: {kept} of the contrast");
    }
}

/// The same texture at 16 bits, or as floats.
fn deeper(texture: &Texture, depth: Depth) -> Texture {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    let texels = match depth {
        Depth::U8 => Texels::U8(values.clone()),
        Depth::U16 => Texels::U16(values.iter().map(|&value| u16::from(value) * 257).collect()),
        Depth::F32 => Texels::F32(values.iter().map(|&value| f32::from(value) / 255.0).collect()),
    };
    Texture::new(texture.size(), texture.channels(), Encoding::Srgb, texels).unwrap()
}

#[test]
fn depths_do_not_matter() {
    let stage = Stage::new();
    let membrane = BlendOptions::default().feather(0.01).membrane();
    let modes = [
        membrane,
        membrane.tone(Tone::Source),
        membrane.tone(Tone::Both),
        membrane.match_skin(),
        BlendOptions::default().feather(0.01),
    ];
    for options in modes {
        let plain = stage.transferred(options);
        for depth in [Depth::U16, Depth::F32] {
            let graft = Graft::builder(Arc::clone(&stage.pair), SIZES).blend(options).build();
            let [face, base] = [&stage.face, &stage.base].map(|texture| deeper(texture, depth));
            let found = graft.unwrap().apply(&face, &base).unwrap();
            let Size { width, height } = found.size();
            let texels = (0..width * height).map(|index| (index % width, index / width));
            let most = texels
                .flat_map(|(x, y)| {
                    [0, 1, 2]
                        .map(|k| (found.get(x, y, k).clamp(0.0, 1.0) - plain.get(x, y, k)).abs())
                })
                .fold(0.0, f32::max);
            // Without a tone, floats keep the filters' overshoot. At 8 bits a level is rounded
            // before its gain of up to 3, and after it.
            assert!(most * 255.0 < 2.5, "{depth:?}, {options:?}: {} levels", most * 255.0);
        }
    }
}

/// The face with its skin brightened towards the cloth below it.
fn lit_by_cloth(face: &Texture, truth: &Labels, reach: u32) -> Texture {
    let Size { width, height } = face.size();
    let label = |x: u32, y: u32| truth.of_texels[(y * width + x) as usize];
    let gain = |x: u32, y: u32| {
        let cloth = (1..=reach).find(|far| y + far < height && label(x, y + far) == Label::Cloth);
        match cloth {
            Some(far) if label(x, y) == Label::Skin => 1.5 - 0.5 * far as f32 / reach as f32,
            _ => 1.0,
        }
    };
    recolored(face, |value, [x, y], _| value * gain(x, y))
}

#[test]
fn light_from_a_collar_does_not_reach_the_body() {
    let stage = Stage::new();
    let white = Collar::plain([0.93, 0.935, 0.95]);
    let look = FaceLook { skin: SkinTone::BROWN, ..FaceLook::all()[0] }.collar(white.cut(0.3, 0.5));
    let layout = LayoutSpots::new(stage.pair.source(), SIZES.from);
    let painted = look.paint(stage.pair.source(), &HeadFrame::FIGURE, &layout);
    let lit = lit_by_cloth(&painted.texture, &painted.truth, 20);
    let labels = Arc::new(uvgraft::Labels::new(stage.pair.source(), &painted.texture).unwrap());
    let all_skin =
        Texture::filled(Size::square(8), Channels::Grey, Encoding::Data, Depth::U8, &[1.0]);
    let all_skin = all_skin.unwrap();
    let body = LayoutSpots::new(stage.pair.target(), SIZES.to);
    for tone in [Tone::Source, Tone::Both] {
        let options = BlendOptions::default().feather(0.01).membrane().tone(tone);
        let graft = Graft::builder(Arc::clone(&stage.pair), SIZES).blend(options);
        let graft = graft.labels(Arc::clone(&labels)).skin(all_skin.clone()).build().unwrap();
        let [plain, lit] =
            [&painted.texture, &lit].map(|face| graft.apply(face, &stage.base).unwrap());
        let mask = graft.mask();
        let is_body = |&(x, y): &(u32, u32)| {
            mask.get(x, y, 0) < 0.5 && body.spots()[(y * SIZES.to.width + x) as usize].is_some()
        };
        let texels = (0..SIZES.to.height).flat_map(|y| (0..SIZES.to.width).map(move |x| (x, y)));
        let difference = |(x, y)| {
            let [a, b] = [&plain, &lit].map(|texture| [0, 1, 2].map(|k| texture.get(x, y, k)));
            uvgraft::color::delta_e(a, b)
        };
        let most = texels.filter(is_body).map(difference).fold(0.0, f64::max);
        assert!(most < 2.0, "{tone:?}: ΔE {most}");
    }
}
