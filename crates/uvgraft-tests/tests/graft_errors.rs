//! Inputs that a graft refuses, and the errors it returns.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::{Growth, RegionError, Side};
use uvgraft::{
    Blend, BlendDomain, BlendOptions, Channels, Content, Depth, Direction, Encoding, Extent,
    Filter, FitOptions, Graft, GraftBuilder, GraftError, NormalOptions, Overlap, Pair, Piece, Size,
    Sizes, Texels, Texture, TextureError, ToneError,
};
use uvgraft_tests::synthetic;

const FROM: Size = Size::square(64);
const TO: Size = Size::new(96, 80);

fn builder(pair: &Arc<Pair>) -> GraftBuilder {
    Graft::builder(Arc::clone(pair), Sizes { from: FROM, to: TO })
}

fn filled(size: Size, channels: Channels) -> Texture {
    let values = &[0.5; 4][..channels.count()];
    Texture::filled(size, channels, Encoding::Srgb, Depth::U8, values).unwrap()
}

fn fit(graft: &Graft, texture: &Texture) -> Result<(), GraftError> {
    let format = filled(TO, Channels::Rgb).format();
    graft.fit(texture, format, &FitOptions::default(), &mut |_| {}).map(drop)
}

#[test]
fn textures_of_other_sizes() {
    let graft = builder(&synthetic::pair()).build().unwrap();
    let (texture, base) = (filled(FROM, Channels::Rgb), filled(TO, Channels::Rgb));
    let refused = |what, found, wanted| Err(GraftError::Size { what, found, wanted });
    assert_eq!(graft.apply(&base, &base), refused("texture", TO, FROM));
    assert_eq!(graft.apply(&texture, &texture), refused("base", FROM, TO));
    assert_eq!(
        graft.overlay(&base, base.format()).map(drop),
        refused("texture", TO, FROM).map(|_: Texture| ())
    );
    assert_eq!(fit(&graft, &base), refused("texture", TO, FROM).map(|_: Texture| ()));
    let error = graft.apply(&texture, &texture).unwrap_err().to_string();
    assert_eq!(error, "the base must be 96×80, got 64×64");
    let overlay = graft.overlay(texture, base.format()).unwrap();
    for (first_row, band) in [(70, Size::new(96, 11)), (0, FROM), (u32::MAX, Size::new(96, 1))] {
        let error = overlay.lay(first_row, filled(band, Channels::Rgb)).unwrap_err();
        assert_eq!((error.first_row, error.found, error.target), (first_row, band, TO));
    }
}

#[test]
fn impossible_texture_sizes() {
    let pair = synthetic::pair();
    let most = Texture::MAX_SIDE;
    for (bad, is_empty) in
        [(Size::new(0, 8), true), (Size::square(0), true), (Size::new(most + 1, 1), false)]
    {
        for sizes in [Sizes { from: bad, to: TO }, Sizes { from: FROM, to: bad }] {
            let error = Graft::builder(Arc::clone(&pair), sizes).build().unwrap_err();
            let wanted =
                if is_empty { TextureError::Empty(bad) } else { TextureError::TooLarge(bad) };
            assert_eq!(error, GraftError::Texture(wanted));
            let resized = builder(&pair).build().unwrap().with_texture_size(bad);
            assert_eq!(resized.map(drop), Err(error));
        }
    }
}

#[test]
fn regions_of_other_pairs() {
    let (pair, other) = (synthetic::pair(), synthetic::turned_charts());
    let linked =
        |pair: &Arc<Pair>, direction| BlendDomain::new(Arc::clone(pair), direction).linked();
    let here = linked(&pair, Direction::Forward);
    for (region, wanted) in [
        (here.clone(), None),
        // A clone of the pair is accepted.
        (linked(&Arc::new(Pair::clone(&pair)), Direction::Forward), None),
        (linked(&pair, Direction::Reverse), Some("this pair and Reverse")),
        (linked(&other, Direction::Forward), Some("another pair and Forward")),
    ] {
        let refused = |what: &str| {
            wanted.map(|wanted| {
                format!(
                    "the {what} must belong to this pair and the direction Forward, got {wanted}"
                )
            })
        };
        let text = |result: Result<Graft, GraftError>| result.err().map(|error| error.to_string());
        assert_eq!(text(builder(&pair).region(region.clone()).build()), refused("region"));
        let blend = Arc::new(Blend::new(&region, BlendOptions::default()).unwrap());
        assert_eq!(text(builder(&pair).shared_blend(blend).build()), refused("blend"));
        let is_refused = |result| matches!(result, Err(RegionError::Domain));
        assert_eq!(is_refused(here.intersection(&region)), wanted.is_some());
        assert_eq!(is_refused(region.union(&here)), wanted.is_some());
        assert_eq!(is_refused(region.difference(&here)), wanted.is_some());
    }
}

#[test]
fn tones_of_other_regions() {
    let (texture, base) = (filled(FROM, Channels::Rgb), filled(TO, Channels::Rgb));
    let half = (0..64 * 64).map(|k| if k % 64 + k / 64 < 64 { 255 } else { 0 });
    let half = Texels::U8(half.collect());
    let half = Texture::new(FROM, Channels::Grey, Encoding::Data, half).unwrap();
    let charts = synthetic::turned_charts();
    // The same meshes with one link fewer.
    let (source, target) = (charts.source().clone(), charts.target().clone());
    let fewer = charts.pieces().take(charts.piece_count() - 1);
    let other = Arc::new(Pair::from_pieces(source, target, fewer).unwrap());
    let [here, there] = [charts, other].map(|pair| {
        let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
        let region = domain.painted(Side::Target, &half).unwrap();
        let blend = BlendOptions::default().feather(0.1).membrane();
        builder(&pair).region(region).blend(blend).build().unwrap()
    });
    let tone = |graft: &Graft| graft.toning(&texture, &base, base.format()).unwrap().unwrap();
    let overlay = here.overlay(&texture, base.format()).unwrap();
    assert!(overlay.clone().with_tone(&tone(&here)).is_ok());
    assert_eq!(overlay.with_tone(&tone(&there)).map(drop), Err(ToneError::Domain));
}

#[test]
fn region_of_pieces_that_fill_no_triangle() {
    let pair = synthetic::pair();
    let shrunk = |share: f64| {
        let middle = (1.0 - share) / 3.0;
        let corners = [0, 1, 2].map(|k| [0, 1, 2].map(|i| middle + f64::from(i == k) * share));
        let pieces = pair.pieces().map(|piece| match piece.extent {
            Extent::Whole(to) => {
                let read = corners.map(|weights| {
                    let mut read = [0.0; 3];
                    (0..3).for_each(|k| read[usize::from(to[k])] = weights[k]);
                    read
                });
                Piece::part((piece.target, corners), (piece.source, read))
            }
            Extent::Part { .. } => piece,
        });
        Arc::new(Pair::from_pieces(pair.source().clone(), pair.target().clone(), pieces).unwrap())
    };
    let blended = |share| builder(&shrunk(share)).blend(BlendOptions::default()).build();
    let whole = builder(&pair).blend(BlendOptions::default()).build().unwrap().mask();
    let white = |mask: &Texture| match mask.texels() {
        Texels::U8(values) => values.iter().filter(|&&value| value == 255).count(),
        _ => unreachable!("masks have 8 bits"),
    };
    // Cut surfaces omit slivers; the rest is transferred.
    let most = blended(0.999).unwrap().mask();
    assert!(white(&most) * 100 >= white(&whole) * 98 && white(&most) <= white(&whole));
    assert!(builder(&shrunk(0.9)).build().is_ok());
    let error = blended(0.9).unwrap_err().to_string();
    assert_eq!(
        error,
        "the region is empty: it contains no wholly linked triangle, only parts of triangles"
    );
}

#[test]
fn empty_regions() {
    let pair = synthetic::turned_charts();
    let linked = BlendDomain::new(Arc::clone(&pair), Direction::Forward).linked();
    let domain = linked.domain();
    let half = (0..64 * 64).map(|k| if k % 64 < 32 { 255 } else { 0 });
    let half = Texels::U8(half.collect());
    let half = Texture::new(FROM, Channels::Grey, Encoding::Data, half).unwrap();
    let half = domain.painted(Side::Target, &half).unwrap();
    for region in [linked.difference(&linked).unwrap(), half.grown(Growth::Length(-1e6))] {
        let error = builder(&pair).region(region).build().unwrap_err();
        assert!(matches!(error, GraftError::Region(RegionError::Empty(_))), "{error}");
    }
    let black = Texture::filled(FROM, Channels::Grey, Encoding::Data, Depth::U8, &[0.0]).unwrap();
    assert!(matches!(domain.painted(Side::Target, &black), Err(RegionError::Empty(_))));
    assert!(matches!(domain.vertices(Side::Source, &[]), Err(RegionError::Empty(_))));
    let vertices = pair.source().positions().len();
    let found = vertices as u32;
    assert_eq!(
        domain.vertices(Side::Source, &[0, found]).err(),
        Some(RegionError::Vertex { found, vertices })
    );
}

#[test]
fn normals_without_three_channels() {
    let content = Content::Normals(NormalOptions::default());
    let graft = builder(&synthetic::turned_charts()).content(content).build().unwrap();
    let base = filled(TO, Channels::Rgb);
    for found in [Channels::Grey, Channels::GreyAlpha] {
        let texture = filled(FROM, found);
        assert_eq!(graft.apply(&texture, &base), Err(GraftError::Channels { found }));
    }
    for channels in [Channels::Rgb, Channels::Rgba] {
        // A single-channel base is converted to three channels.
        let result = graft.apply(filled(FROM, channels), filled(TO, Channels::Grey)).unwrap();
        assert_eq!(result.channels(), channels);
    }
}

#[test]
fn unsolvable_fits() {
    let pair = synthetic::pair();
    let texture = filled(FROM, Channels::Rgb);
    for (builder, reason) in [
        (builder(&pair).filter(Filter::Nearest), "nearest"),
        (builder(&pair).overlap(Overlap::Average), "averaged"),
        (builder(&pair).content(Content::Normals(NormalOptions::default())), "normal maps"),
    ] {
        let error = fit(&builder.build().unwrap(), &texture).unwrap_err();
        assert!(matches!(error, GraftError::Fit(_)), "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    }
    let graft = builder(&pair).build().unwrap();
    let options = FitOptions::default();
    for bad in [
        options.min_gain(f64::NAN),
        options.regularization(f32::NAN),
        options.regularization(-1.0),
        options.regularization(f32::INFINITY),
        options.smoothness(f32::NAN),
        options.smoothness(-0.1),
    ] {
        let error = graft.fit(&texture, texture.format(), &bad, &mut |_| {}).map(drop).unwrap_err();
        assert!(matches!(error, GraftError::Fit(_)), "{error}");
    }
    // Without overlaps, averaging can be fitted: every texel has a single island to solve for.
    let alone = builder(&synthetic::turned_charts()).overlap(Overlap::Average).build().unwrap();
    assert_eq!(fit(&alone, &texture), Ok(()));
    let graft = builder(&pair).build().unwrap();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut values = vec![0.5; FROM.texels() * 3];
        values[(5 * 64 + 7) * 3 + 2] = value;
        let texture =
            Texture::new(FROM, Channels::Rgb, Encoding::Linear, Texels::F32(values)).unwrap();
        assert_eq!(fit(&graft, &texture), Err(GraftError::NotFinite { x: 7, y: 5 }));
    }
}

#[test]
fn tones_without_a_boundary() {
    // The whole surface is transferred, so there is nothing around it to take a tone from.
    let pair = synthetic::turned_charts();
    let graft = builder(&pair).blend(BlendOptions::default().membrane()).build().unwrap();
    let (texture, base) = (filled(FROM, Channels::Rgb), filled(TO, Channels::Rgb));
    let refused = GraftError::ToneCorrection(ToneError::NoBoundary);
    assert_eq!(graft.apply(&texture, &base), Err(refused));
    assert!(matches!(graft.toning(&texture, &base, base.format()), Err(ToneError::NoBoundary)));
    // It can be laid over without toning.
    let overlay = graft.overlay(&texture, base.format()).unwrap();
    assert_eq!(overlay.lay(0, base.clone()).unwrap().size(), TO);
    // Neither normals nor data have a tone.
    for content in [Content::Data, Content::Normals(NormalOptions::default())] {
        let builder = builder(&pair).blend(BlendOptions::default().membrane()).content(content);
        let graft = builder.build().unwrap();
        assert!(graft.toning(&texture, &base, base.format()).unwrap().is_none());
        graft.apply(&texture, &base).unwrap();
    }
}
