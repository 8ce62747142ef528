//! The tone of painted faces on painted bodies, whose colours are known.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::CutMesh;
use uvgraft::seams::{PastedFace, SeamError, ToneMatch, ToneReferences, measure_tone};
use uvgraft::{
    Anatomy, Area, Blend, BlendOptions, Channels, Depth, Direction, Encoding, Graft, Ground, Pair,
    Size, Sizes, Texels, Texture,
};
use uvgraft_avatar::Figure;
use uvgraft_tests::looks::frame::figure_pair;
use uvgraft_tests::looks::{BodyFrame, BodyLook, FaceLook, HeadFrame, Layout, Skin};

const SIZES: Sizes = Sizes { from: Size::square(384), to: Size::square(768) };

/// A brown face, and a body of very light skin.
struct Stage {
    pair: Arc<Pair>,
    cut: CutMesh,
    anatomy: Anatomy,
    face: Texture,
    pasted: PastedFace,
    base: Texture,
}

impl Stage {
    fn new() -> Self {
        let pair = figure_pair(&Figure::new());
        let look = FaceLook { skin: Skin::BROWN, ..FaceLook::all()[0] };
        let layout = Layout::new(pair.source(), SIZES.from);
        let face = look.paint(pair.source(), &HeadFrame::FIGURE, &layout).texture;
        let layout = Layout::new(pair.target(), SIZES.to);
        let body = BodyLook::new("very light", Skin::VERY_LIGHT);
        let base = body.paint(pair.target(), &BodyFrame::FIGURE, &layout).texture;
        let ground = Ground::new(Arc::clone(&pair), Direction::Forward);
        let pasted = PastedFace::new(&ground, &face, SIZES.to).unwrap();
        let blend = Blend::new(&ground.linked(), BlendOptions::default()).unwrap();
        let cut = blend.cut().unwrap();
        let anatomy = Anatomy::find(&cut.mesh).unwrap();
        Self { pair, cut, anatomy, face, pasted, base }
    }

    fn carried(&self, options: BlendOptions) -> Texture {
        let graft = Graft::builder(Arc::clone(&self.pair), SIZES).blend(options).build().unwrap();
        graft.apply(&self.face, &self.base).unwrap()
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

/// The same with channels that are brighter.
fn brightened(texture: &Texture, gain: f32) -> Texture {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    let values = values.iter().map(|&value| (f32::from(value) * gain).min(255.0) as u8).collect();
    Texture::new(texture.size(), texture.channels(), Encoding::Srgb, Texels::U8(values)).unwrap()
}

#[test]
fn a_blend_without_tone_is_found_out() {
    let stage = Stage::new();
    let feather = BlendOptions::default().feather(0.01);
    let measured = |options| stage.measured(&stage.carried(options), stage.all()).unwrap();
    let (plain, toned) = (measured(feather), measured(feather.membrane()));
    for tone in [plain, toned] {
        let own = tone.own.unwrap();
        assert_eq!(own.chest_area, Area::Chest);
        assert!((2.0..16.0).contains(&own.delta_e()), "{tone:?}");
        assert!(tone.hair_shift.unwrap() < 1.0 && !tone.is_clipped(), "{tone:?}");
    }
    assert!(!plain.is_toned() && plain.excess().unwrap() > 8.0, "{plain:?}");
    assert!(toned.is_toned(), "{toned:?}");
}

#[test]
fn what_is_not_given_is_not_known() {
    let stage = Stage::new();
    let texture = stage.carried(BlendOptions::default());
    let alone = stage.measured(&texture, ToneReferences::default()).unwrap();
    assert!(alone.skin.is_some() && alone.own.is_none() && alone.hair_shift.is_none());
    // Nothing of a plain paste is full, labels or not.
    assert!(alone.clipped.unwrap() < 0.01, "{alone:?}");
    let nothing = vec![false; stage.cut.inside.len()];
    let nothing =
        measure_tone(&stage.cut.mesh, &stage.anatomy, &texture, &nothing, stage.all()).unwrap();
    assert_eq!((nothing.clipped, nothing.hair_shift), (None, None));
    // A face that is itself is not shifted.
    let own = stage.measured(&texture, stage.all()).unwrap();
    assert!(own.hair_shift.unwrap() < 0.5 && own.clipped == Some(0.0), "{own:?}");
}

#[test]
fn burnt_skin_is_clipped_skin() {
    let stage = Stage::new();
    let texture = brightened(&stage.carried(BlendOptions::default()), 2.5);
    let found = stage.measured(&texture, stage.all()).unwrap();
    assert!(found.clipped.unwrap() > 0.3 && found.is_clipped(), "{found:?}");
    assert!(found.hair_shift.unwrap() > 3.0, "{found:?}");
}

#[test]
fn refused() {
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
    assert_eq!(found.to_string(), "the base must be of the texture's size, 768×768, got 384×384");
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
