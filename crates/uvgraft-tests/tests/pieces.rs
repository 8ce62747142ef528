//! Pieces of triangles: wherever a triangle is cut, the result stays the same, also between
//! different triangulations.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::Side;
use uvgraft::{
    BlendDomain, BlendOptions, Channels, Content, Depth, Direction, Encoding, Extent, Filter,
    FitOptions, Graft, GraftBuilder, Mesh, NormalOptions, Overlap, Pair, PairReport, Piece, Prefer,
    Size, Sizes, Texels, TexelsMut, Texture, Tone, Weights,
};
use uvgraft_metrics::seams::{SeamOptions, measure};
use uvgraft_tests::{real, synthetic};

const CORNERS: [Weights; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const DIRECTIONS: [Direction; 2] = [Direction::Forward, Direction::Reverse];

/// The same pair with all of its pieces cut.
///
/// - `parts`: returns the parts of one triangle.
fn cut(pair: &Pair, mut parts: impl FnMut() -> Vec<[Weights; 3]>) -> Arc<Pair> {
    let pieces = pair.pieces().flat_map(|piece| {
        let Extent::Whole(corners) = piece.extent else { panic!("whole triangles") };
        let in_source = move |weights: Weights| {
            let mut found = [0.0; 3];
            corners.iter().zip(weights).for_each(|(&k, weight)| found[usize::from(k)] = weight);
            found
        };
        let Piece { target, source, .. } = piece;
        let parts = parts().into_iter();
        parts.map(move |part| Piece::part((target, part), (source, part.map(in_source))))
    });
    let pieces: Vec<Piece> = pieces.collect();
    Arc::new(Pair::from_pieces(pair.source().clone(), pair.target().clone(), pieces).unwrap())
}

/// Cuts each triangle into three at a random interior point.
fn in_three(pair: &Pair) -> Arc<Pair> {
    let mut rng = fastrand::Rng::with_seed(13);
    cut(pair, || {
        let [s, t] = [rng.f64(), rng.f64()].map(|value| 0.02 + 0.96 * value);
        let inner = [s * t, s * (1.0 - t), 1.0 - s];
        [0, 1, 2].map(|k| [CORNERS[k], CORNERS[(k + 1) % 3], inner]).to_vec()
    })
}

/// Cuts each triangle into four at the midpoints of its edges, where its neighbours are cut as
/// well.
fn in_four(pair: &Pair) -> Arc<Pair> {
    let middle = |k: usize| [0, 1, 2].map(|axis| if axis == k { 0.0 } else { 0.5 });
    let parts = vec![
        [CORNERS[0], middle(2), middle(1)],
        [CORNERS[1], middle(0), middle(2)],
        [CORNERS[2], middle(1), middle(0)],
        [0, 1, 2].map(middle),
    ];
    cut(pair, || parts.clone())
}

/// A pair in its original form, and cut in different ways.
struct Variants {
    whole: Arc<Pair>,
    cut: Vec<(&'static str, Arc<Pair>)>,
}

impl Variants {
    fn of(whole: Arc<Pair>) -> Self {
        let cut = vec![("in three", in_three(&whole)), ("in four", in_four(&whole))];
        Self { whole, cut }
    }

    /// Calls `check` with the results of `find` for each cut pair and for the original.
    fn compare<R>(&self, find: impl Fn(&Arc<Pair>) -> R, check: impl Fn(&str, &R, &R)) {
        let wanted = find(&self.whole);
        for (name, pair) in &self.cut {
            check(name, &find(pair), &wanted);
        }
    }
}

fn builder(pair: &Arc<Pair>, direction: Direction, [from, to]: [Size; 2]) -> GraftBuilder {
    let (from, to) = match direction {
        Direction::Forward => (from, to),
        Direction::Reverse => (to, from),
    };
    Graft::builder(Arc::clone(pair), Sizes { from, to }).direction(direction)
}

/// A picture in any format, with alpha of 0, 1 and in between if it has any.
fn picture(size: Size, seed: u64, channels: Channels, depth: Depth) -> Texture {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut texture = synthetic::detailed(size, seed).converted(channels, Depth::F32);
    let TexelsMut::F32(values) = texture.texels_mut() else { panic!("floats") };
    if channels.has_alpha() {
        for texel in values.chunks_exact_mut(channels.count()) {
            let opacity = [0.0, 1.0, 1.0, rng.f32()][rng.usize(..4)];
            texel[channels.count() - 1] = opacity;
        }
    }
    texture.converted(channels, depth)
}

fn plain(size: Size, seed: u64) -> Texture {
    picture(size, seed, Channels::Rgb, Depth::U8)
}

/// The greatest difference between two textures' values; 1.0 from black to white.
fn difference(a: &Texture, b: &Texture) -> f32 {
    assert_eq!(a.format(), b.format());
    let size = a.size();
    let mut most = 0.0_f32;
    for y in 0..size.height {
        for x in 0..size.width {
            for channel in 0..a.channels().count() {
                most = most.max((a.get(x, y, channel) - b.get(x, y, channel)).abs());
            }
        }
    }
    most
}

/// More than one level of 8 bits, and less than two.
const ONE_LEVEL: f32 = 1.001 / 255.0;

const SMALL: [Size; 2] = [Size::new(230, 310), Size::new(420, 333)];

#[test]
fn cuts_do_not_show_in_pictures() {
    let variants = Variants::of(synthetic::pair());
    let formats = [
        (Channels::Rgb, Depth::U8),
        (Channels::Rgb, Depth::U16),
        (Channels::Rgb, Depth::F32),
        (Channels::Rgba, Depth::U8),
        (Channels::GreyAlpha, Depth::F32),
    ];
    for direction in DIRECTIONS {
        for filter in Filter::ALL {
            let carried = |pair: &Arc<Pair>| {
                let graft = builder(pair, direction, SMALL).filter(filter).gutter_px(9).build();
                let graft = graft.unwrap();
                let Sizes { from, to } = graft.sizes();
                let results = formats.map(|(channels, depth)| {
                    let source = picture(from, 4, channels, depth);
                    graft.apply(source, picture(to, 5, channels, depth)).unwrap()
                });
                (results, graft.mask(), graft.map().stats())
            };
            variants.compare(carried, |name, found, wanted| {
                let context = || format!("{name}, {direction:?}, {filter}");
                assert_eq!(found.2, wanted.2, "{}", context());
                assert!(found.1 == wanted.1, "mask, {}", context());
                for (found, wanted) in found.0.iter().zip(&wanted.0) {
                    let off = difference(found, wanted);
                    assert!(found == wanted, "{}, {:?}: {off}", context(), found.format());
                }
            });
        }
    }
}

#[test]
fn cuts_do_not_show_where_islands_overlap() {
    let variants = Variants::of(synthetic::pair());
    let cases = [
        (Prefer::First, Overlap::First),
        (Prefer::Left, Overlap::First),
        (Prefer::Right, Overlap::First),
        (Prefer::First, Overlap::Average),
        (Prefer::Left, Overlap::Average),
    ];
    for (prefer, overlap) in cases {
        for [from, to] in [[512, 300], [200, 1000]] {
            let carried = |pair: &Arc<Pair>| {
                let sizes = [Size::square(from), Size::square(to)];
                let graft = builder(pair, Direction::Forward, sizes).prefer(prefer);
                let graft = graft.overlap(overlap).filter(Filter::Bilinear).build().unwrap();
                assert!(graft.map().stats().overlapping > 0);
                graft.apply(plain(sizes[0], 1), plain(sizes[1], 2)).unwrap()
            };
            variants.compare(carried, |name, found, wanted| {
                let off = difference(found, wanted);
                assert!(found == wanted, "{name}, {prefer:?}, {overlap:?}, {to}: {off}");
            });
        }
    }
}

/// Sums of floats in another order differ in their last digits.
#[test]
fn cuts_do_not_show_in_the_matrix_and_in_fits() {
    let variants = Variants::of(synthetic::pair());
    for direction in DIRECTIONS {
        for filter in [Filter::Bilinear, Filter::CatmullRom, Filter::Lanczos3] {
            let found = |pair: &Arc<Pair>| {
                let graft = builder(pair, direction, SMALL).filter(filter).build().unwrap();
                let Sizes { from, to } = graft.sizes();
                let values = |size: Size, seed| -> Vec<f32> {
                    let mut rng = fastrand::Rng::with_seed(seed);
                    (0..size.texels() * 3).map(|_| rng.f32()).collect()
                };
                let operator = graft.operator();
                let matrix = [
                    operator.apply(3, &values(from, 1)),
                    operator.apply_transposed(3, &values(to, 2)),
                ];
                let (source, base) = (plain(from, 3), plain(to, 4));
                let options = FitOptions::default().max_steps(6);
                let fitted = graft.fit(source, base.format(), &options, &mut |_| {}).unwrap();
                (matrix, fitted.overlay.lay(0, base).unwrap(), fitted.summary)
            };
            variants.compare(found, |name, found, wanted| {
                let context = format!("{name}, {direction:?}, {filter}");
                for (found, wanted) in found.0.iter().zip(&wanted.0) {
                    let off =
                        found.iter().zip(wanted).map(|(a, b)| (a - b).abs() / b.abs().max(1.0));
                    let off = off.fold(0.0, f32::max);
                    assert!(off < 1e-6, "{context}: {off}");
                }
                let off = difference(&found.1, &wanted.1);
                assert!(off < ONE_LEVEL, "{context}: {off}");
                let (found, wanted) = (found.2, wanted.2);
                assert_eq!((found.steps, found.share_met), (wanted.steps, wanted.share_met));
                let off = (found.fitted_rms - wanted.fitted_rms).abs();
                assert!(off < 1e-6, "{context}: {found:?}, {wanted:?}");
            });
        }
    }
}

/// Unit normals that point anywhere in front.
fn normals(size: Size, depth: Depth) -> Texture {
    let mut rng = fastrand::Rng::with_seed(8);
    let values = (0..size.texels()).flat_map(|_| {
        let [x, y] = [rng.f32(), rng.f32()].map(|value| value * 1.2 - 0.6);
        [x, y, (1.0 - x * x - y * y).sqrt()].map(|value| value * 0.5 + 0.5)
    });
    let values = Texels::F32(values.collect());
    Texture::new(size, Channels::Rgb, Encoding::Data, values)
        .unwrap()
        .converted(Channels::Rgb, depth)
}

fn compare_normals(variants: &Variants, sizes: [Size; 2]) {
    for direction in DIRECTIONS {
        for (depth, allowed) in [(Depth::U8, ONE_LEVEL), (Depth::F32, 1e-5)] {
            let carried = |pair: &Arc<Pair>| {
                let content = Content::Normals(NormalOptions::default());
                let graft = builder(pair, direction, sizes).content(content).build().unwrap();
                let Sizes { from, to } = graft.sizes();
                graft.apply(normals(from, depth), normals(to, depth)).unwrap()
            };
            variants.compare(carried, |name, found, wanted| {
                let off = difference(found, wanted);
                assert!(off < allowed, "{name}, {direction:?}, {depth:?}: {off}");
            });
        }
    }
}

#[test]
fn cuts_do_not_show_in_normals() {
    compare_normals(&Variants::of(synthetic::turned_charts()), SMALL);
    // Bent differently in the source, so that each vertex is rotated by its own angle.
    let pair = synthetic::turned_charts();
    let bent = synthetic::posed(pair.source(), false, |[x, y, z]| {
        let (sin, cos) = (2.0 * x).sin_cos();
        [sin * (0.5 + z), y, cos * (0.5 + z) - 0.5]
    });
    let bent = Pair::from_pieces(bent, pair.target().clone(), pair.pieces()).unwrap();
    compare_normals(&Variants::of(Arc::new(bent)), SMALL);
}

fn blends() -> [BlendOptions; 4] {
    let plain = BlendOptions::default();
    [
        plain,
        plain.feather(0.1),
        plain.feather(0.1).membrane(),
        plain.feather(0.05).membrane().tone(Tone::Source),
    ]
}

#[test]
fn cuts_do_not_show_in_blends_and_at_seams() {
    // The other pair's triangles have no area in space.
    let variants = Variants::of(synthetic::turned_charts());
    let side = 96;
    let disc = (0..side * side).map(|k| {
        let [u, v] = [k % side, k / side].map(|at| (f64::from(at) + 0.5) / f64::from(side));
        if (u - 0.4).hypot(v - 0.4) < 0.3 { 255 } else { 0 }
    });
    let disc = Texels::U8(disc.collect());
    let disc = Texture::new(Size::square(side), Channels::Grey, Encoding::Data, disc).unwrap();
    for (direction, side) in DIRECTIONS.into_iter().flat_map(|direction| {
        [None, Some(Side::Source), Some(Side::Target)].map(|side| (direction, side))
    }) {
        for options in blends() {
            let found = |pair: &Arc<Pair>| {
                let domain = BlendDomain::new(Arc::clone(pair), direction);
                let region = match side {
                    None => domain.linked(),
                    Some(side) => domain.painted(side, &disc).unwrap(),
                };
                let white = Texture::filled(
                    Size::square(1),
                    Channels::Grey,
                    Encoding::Data,
                    Depth::U8,
                    &[1.0],
                );
                let graft = builder(pair, direction, SMALL)
                    .filter(Filter::Bilinear)
                    .region(region)
                    .blend(options)
                    .skin(white.unwrap())
                    .build()
                    .unwrap();
                let Sizes { from, to } = graft.sizes();
                let (source, base) = (plain(from, 5), plain(to, 6));
                // A region of the whole surface has no boundary.
                let toning = graft.toning(&source, &base, base.format());
                let overlay = graft.overlay(source, base.format()).unwrap();
                let overlay = match toning.as_ref().ok().and_then(Option::as_ref) {
                    Some(toning) => overlay.with_tone(toning).unwrap(),
                    None => overlay,
                };
                let result = overlay.lay(0, base).unwrap();
                let cut = graft.blend().unwrap().cut().unwrap();
                let seams = measure(&cut.mesh, &result, &cut.inside, &SeamOptions::default());
                (result, graft.mask(), toning.err(), cut, seams.ok())
            };
            variants.compare(found, |name, found, wanted| {
                let context = format!("{name}, {direction:?}, {side:?}, {options:?}");
                assert_eq!(found.2, wanted.2, "{context}");
                let is_toned = options.needs_colors() && side.is_some();
                assert!(!is_toned || wanted.2.is_none(), "{context}: {:?}", wanted.2);
                let off = difference(&found.1, &wanted.1);
                assert!(off < ONE_LEVEL, "mask, {context}: {off}");
                let off = difference(&found.0, &wanted.0);
                assert!(off < ONE_LEVEL, "{context}: {off}");
                assert!(found.3 == wanted.3, "rim, {context}");
                let [found, wanted] = [&found.4, &wanted.4].map(|seams| {
                    let steps = seams.as_ref().and_then(|seams| seams.rim.delta_e);
                    steps.map(|steps| [steps.median, steps.p95])
                });
                assert_eq!(found.is_some(), wanted.is_some(), "{context}");
                if let (Some(found), Some(wanted)) = (found, wanted) {
                    let off = (0..2).map(|k| (found[k] - wanted[k]).abs()).fold(0.0, f64::max);
                    assert!(off < 0.3, "{context}: {found:?}, {wanted:?}");
                }
            });
        }
    }
}

#[test]
fn cuts_do_not_show_in_reports() {
    let variants = Variants::of(synthetic::pair());
    let report = |pair: &Arc<Pair>| PairReport::new(pair, Sizes { from: SMALL[0], to: SMALL[1] });
    variants.compare(report, |name, found, wanted| {
        assert_eq!(found.links % wanted.links, 0, "{name}");
        let times = found.links / wanted.links;
        assert!((3..=4).contains(&times), "{name}: {times}");
        assert_eq!(
            [found.mirrored, found.opposite_windings],
            [times * wanted.mirrored, times * wanted.opposite_windings],
            "{name}"
        );
        assert_eq!((&found.source, &found.target), (&wanted.source, &wanted.target), "{name}");
        let [found, wanted] = [found, wanted].map(|report| report.forward_density.unwrap());
        assert!((found.median - wanted.median).abs() < 1e-3 * wanted.median, "{name}");
        assert!((found.max - wanted.max).abs() < 1e-3 * wanted.max, "{name}");
    });
}

#[test]
fn cuts_do_not_show_on_real_meshes() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let variants = Variants::of(pair);
    let sizes = [Size::square(512), Size::square(1024)];
    for direction in DIRECTIONS {
        for prefer in [Prefer::First, Prefer::Left] {
            let carried = |pair: &Arc<Pair>| {
                let graft = builder(pair, direction, sizes).prefer(prefer).build().unwrap();
                let Sizes { from, to } = graft.sizes();
                (graft.apply(plain(from, 1), plain(to, 2)).unwrap(), graft.map().stats())
            };
            variants.compare(carried, |name, found, wanted| {
                assert_eq!(found.1, wanted.1, "{name}, {direction:?}");
                let off = difference(&found.0, &wanted.0);
                assert!(found.0 == wanted.0, "{name}, {direction:?}, {prefer:?}: {off}");
            });
        }
    }
    compare_normals(&variants, sizes);
}

/// The texels that a map reaches; asserts that each is reached once.
fn reached(graft: &Graft) -> Vec<bool> {
    let size = graft.sizes().to;
    let mut reached = vec![false; size.texels()];
    for row in 0..size.height {
        for run in graft.map().row(row) {
            for x in run.x..run.x + run.len {
                let texel = &mut reached[(row * size.width + x) as usize];
                assert!(!*texel, "texel ({x}, {row}) is there twice");
                *texel = true;
            }
        }
    }
    reached
}

/// Two thirds, one third or nothing of each triangle.
#[test]
fn uncovered_texels_keep_the_base() {
    let whole = synthetic::pair();
    let mut rng = fastrand::Rng::with_seed(3);
    let pieces: Vec<Piece> = in_three(&whole).pieces().filter(|_| rng.u8(..3) > 0).collect();
    let partial = Pair::from_pieces(whole.source().clone(), whole.target().clone(), pieces);
    let partial = Arc::new(partial.unwrap());
    for direction in DIRECTIONS {
        for gutter_px in [0, 8] {
            let grafts = [&whole, &partial].map(|pair| {
                let builder = builder(pair, direction, SMALL).gutter_px(gutter_px);
                builder.filter(Filter::CatmullRom).build().unwrap()
            });
            let Sizes { from, to } = grafts[0].sizes();
            let (source, base) = (plain(from, 7), plain(to, 8));
            let [of_whole, of_part] =
                [&grafts[0], &grafts[1]].map(|graft| graft.apply(&source, &base).unwrap());
            let [in_whole, in_part] = [&grafts[0], &grafts[1]].map(reached);
            let (mask, all) = (grafts[1].mask(), grafts[0].mask());
            let (mut lost, mut kept) = (0, 0);
            for (texel, (in_part, in_whole)) in in_part.into_iter().zip(in_whole).enumerate() {
                let (x, y) = (texel as u32 % to.width, texel as u32 / to.width);
                assert!(!in_part || in_whole);
                assert!(mask.get(x, y, 0) <= all.get(x, y, 0));
                kept += u32::from(in_part);
                lost += u32::from(in_whole && !in_part);
                // Around an island's corner the gutter may extend the other of the two edges there.
                if in_part && mask.get(x, y, 0) == 0.0 {
                    continue;
                }
                let wanted = if in_part { &of_whole } else { &base };
                for channel in 0..3 {
                    let [found, wanted] = [&of_part, wanted].map(|it| it.get(x, y, channel));
                    assert_eq!(found, wanted, "{direction:?}, {gutter_px}, ({x}, {y})");
                }
            }
            assert!(kept > 10_000 && lost > 5_000, "{kept} and {lost}");
            let stats = [&grafts[0], &grafts[1]].map(|graft| graft.map().stats());
            assert!(stats[1].linked < stats[0].linked && stats[1].gutter <= stats[0].gutter);
            assert_eq!(stats[1].covered, stats[0].covered);
            assert_eq!(stats[1].overlapping, stats[0].overlapping);
        }
    }
    let sizes = Sizes { from: SMALL[0], to: SMALL[1] };
    let (report, of_whole) = (PairReport::new(&partial, sizes), PairReport::new(&whole, sizes));
    assert_eq!(report.links, partial.piece_count());
    assert!(report.target.linked <= of_whole.target.linked);
    // A twenty-seventh of the triangles has lost all its pieces.
    assert!(report.target.linked * 10 > of_whole.target.linked * 9);
    assert!(report.target.texels.linked * 2 > of_whole.target.texels.linked);
    assert!(report.forward_density.unwrap().median > 0.0);
    // Other code copes, too: a partly linked triangle is not part of a region of whole triangles.
    let graft = builder(&partial, Direction::Forward, SMALL).blend(BlendOptions::default());
    let graft = graft.build().unwrap();
    assert!(graft.map().stats().linked > 0);
    let (source, base) = (plain(SMALL[0], 1), plain(SMALL[1], 2));
    graft.fit(source, base.format(), &FitOptions::default(), &mut |_| {}).unwrap();
}

/// A piece owns what earlier ones left, whether it is a part or a whole triangle.
#[test]
fn the_first_of_several_pieces_owns() {
    let square = synthetic::square(0.0);
    // Off the centre, so that its edges pass through no texel centre.
    let half = [CORNERS[0], CORNERS[1], [0.5363, 0.0, 0.4637]];
    let part = Piece::part((0, half), (1, half));
    let whole = Piece::whole(0, 0, [0, 1, 2]);
    let size = Size::square(64);
    let carried = |pieces: &[Piece]| {
        let pair = Pair::from_pieces(square.clone(), square.clone(), pieces.iter().copied());
        let sizes = Sizes { from: size, to: size };
        let graft = Graft::builder(pair.unwrap(), sizes).filter(Filter::Nearest).gutter_px(0);
        let graft = graft.build().unwrap();
        reached(&graft);
        let black = Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.0; 3]);
        (graft.apply(plain(size, 1), black.unwrap()).unwrap(), graft.mask())
    };
    let ((of_part, part_mask), (of_whole, _)) = (carried(&[part]), carried(&[whole]));
    let (both, _) = carried(&[part, whole]);
    let mut counts = [0, 0];
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let is_part = part_mask.get(x, y, 0) == 1.0;
        let wanted = if is_part { &of_part } else { &of_whole };
        counts[usize::from(is_part)] += 1;
        for channel in 0..3 {
            assert_eq!(both.get(x, y, channel), wanted.get(x, y, channel), "({x}, {y})");
        }
    }
    assert!(counts[0] > 1000 && counts[1] > 500, "{counts:?}");
    assert!(carried(&[whole, part]).0 == of_whole);
}

type Point = [f64; 2];

/// Where the diagonals of a quadrilateral cross, as parameters along each.
fn crossing([a, b, c, d]: [Point; 4]) -> [f64; 2] {
    let (p, q) = ([c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]);
    let offset = [b[0] - a[0], b[1] - a[1]];
    let determinant = p[1] * q[0] - p[0] * q[1];
    [
        (offset[1] * q[0] - offset[0] * q[1]) / determinant,
        (offset[1] * p[0] - offset[0] * p[1]) / determinant,
    ]
}

fn quad(corners: [Point; 4], uv: [Point; 4], faces: &[[u32; 3]; 2]) -> Mesh {
    let positions = corners.map(|[x, y]| [x as f32, y as f32, 0.0]).to_vec();
    let uv = uv.map(|at| at.map(|value| value as f32)).to_vec();
    Mesh::from_triangles(positions, uv, faces, faces).unwrap()
}

/// Two quads of one shape, split along different diagonals: four pieces, with the position of their
/// corners in both layouts.
fn diagonals(shape: [Point; 4], source_uv: [Point; 4], target_uv: [Point; 4]) -> Arc<Pair> {
    let source = quad(shape, source_uv, &[[0, 1, 2], [0, 2, 3]]);
    let target = quad(shape, target_uv, &[[0, 1, 3], [1, 2, 3]]);
    let [s, t] = crossing(shape);
    // The crossing in each source face lies on the edge 0-2, in each target face on the edge 1-3.
    let in_source = [[1.0 - s, 0.0, s], [1.0 - s, s, 0.0]];
    let in_target = [[0.0, 1.0 - t, t], [1.0 - t, 0.0, t]];
    let weights =
        |face: [u32; 3], corner: u32| [0, 1, 2].map(|k| if face[k] == corner { 1.0 } else { 0.0 });
    // The sides 0-1, 1-2, 2-3 and 3-0, with their faces.
    let sides = [(0, 0, 0), (1, 0, 1), (2, 1, 1), (3, 1, 0)];
    let pieces = sides.map(|(corner, of_source, of_target)| {
        let ends = [corner, (corner + 1) % 4];
        let corners = |mesh: &Mesh, face: usize, middle: Weights| {
            let face = mesh.faces()[face];
            [weights(face, ends[0]), weights(face, ends[1]), middle]
        };
        Piece::part(
            (of_target as u32, corners(&target, of_target, in_target[of_target])),
            (of_source as u32, corners(&source, of_source, in_source[of_source])),
        )
    });
    Arc::new(Pair::from_pieces(source, target, pieces).unwrap())
}

/// The position in the source layout of a point of the target layout, computed from the pieces.
fn position(pair: &Pair, direction: Direction, uv: Point) -> Option<Point> {
    pair.pieces().find_map(|piece| {
        let [target, source] = piece.uv(pair.target(), pair.source());
        let ([a, b, c], from) = match direction {
            Direction::Forward => (target, source),
            Direction::Reverse => (source, target),
        };
        let area = |p: Point, q: Point, r: Point| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let all = area(a, b, c);
        let weights = [area(uv, b, c) / all, area(a, uv, c) / all, area(a, b, uv) / all];
        let is_inside = weights.iter().all(|&weight| weight >= -1e-9);
        is_inside.then(|| [0, 1].map(|axis| (0..3).map(|k| weights[k] * from[k][axis]).sum()))
    })
}

#[test]
fn different_diagonals_carry_a_ramp_exactly() {
    let unit = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let on_its_side = [[0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]];
    let inset = [[0.1, 0.2], [0.8, 0.2], [0.8, 0.9], [0.1, 0.9]];
    let shape = [[0.0, 0.0], [1.3, -0.2], [1.0, 1.0], [-0.1, 0.7]];
    let skewed = [[0.15, 0.2], [0.9, 0.1], [0.7, 0.85], [0.1, 0.9]];
    // With the unit square as shape both layouts are affine and the diagonals cross in the centre.
    for (shape, source_uv, target_uv, is_straight) in [
        (unit, inset, on_its_side, true),
        (unit, on_its_side, inset, true),
        (shape, inset, skewed, false),
        (shape, skewed, on_its_side, false),
    ] {
        let pair = diagonals(shape, source_uv, target_uv);
        for (direction, filter) in DIRECTIONS
            .into_iter()
            .flat_map(|direction| Filter::ALL.map(move |filter| (direction, filter)))
        {
            let sizes = [Size::square(250), Size::square(300)];
            let graft = builder(&pair, direction, sizes).filter(filter).gutter_px(0).build();
            let graft = graft.unwrap();
            let Sizes { from, to } = graft.sizes();
            let level = |[u, v]: Point| 20.0 + 130.0 * u + 80.0 * v;
            let values = (0..from.texels()).map(|k| {
                let [x, y] = [k % from.width as usize, k / from.width as usize];
                let scale = [from.width, from.height].map(f64::from);
                level([(x as f64 + 0.5) / scale[0], (y as f64 + 0.5) / scale[1]]).round() as u8
            });
            let ramp = Texels::U8(values.collect());
            let ramp = Texture::new(from, Channels::Grey, Encoding::Srgb, ramp).unwrap();
            let black = Texture::filled(to, Channels::Grey, Encoding::Srgb, Depth::U8, &[0.0]);
            let result = graft.apply(ramp, black.unwrap()).unwrap();
            // Both faces are filled completely, without a hole along the diagonals.
            let is_reached = reached(&graft);
            assert_eq!(graft.map().stats().linked, graft.map().stats().covered);
            let mut compared = 0;
            for (texel, is_reached) in is_reached.into_iter().enumerate() {
                let (x, y) = (texel as u32 % to.width, texel as u32 / to.width);
                let uv = [(x, to.width), (y, to.height)]
                    .map(|(at, count)| (f64::from(at) + 0.5) / f64::from(count));
                let Some(at) = position(&pair, direction, uv) else {
                    assert!(!is_reached, "({x}, {y}) is in no piece");
                    continue;
                };
                assert!(is_reached, "a hole at ({x}, {y})");
                // Near the edge of the square its nearest texel is read, which breaks the ramp.
                let near = [-1.0, 1.0].into_iter().flat_map(|away: f64| {
                    let away = away * 4.5 / f64::from(from.width);
                    [[at[0] + away, at[1]], [at[0], at[1] + away]]
                });
                let back = direction.opposite();
                if near.into_iter().any(|at| position(&pair, back, at).is_none()) {
                    continue;
                }
                compared += 1;
                let found = f64::from(result.get(x, y, 0) * 255.0);
                // The texel nearest to a position is at most half a texel away.
                let allowed = if filter == Filter::Nearest { 1.6 } else { 1.0 };
                let off = (found - level(at)).abs();
                assert!(off <= allowed, "{direction:?}, {filter}, ({x}, {y}): {off}");
                if is_straight {
                    // The diagonals are invisible: one ramp runs across the whole square.
                    let straight = straight(&pair, direction, uv);
                    assert!((level(straight) - level(at)).abs() < 1e-3);
                }
            }
            assert!(compared > 20_000, "{compared}");
        }
    }
}

/// The position of a texel computed from the three corners 0, 1 and 3 of both layouts alone.
fn straight(pair: &Pair, direction: Direction, [u, v]: Point) -> Point {
    let [from, to] = [pair.from(direction), pair.to(direction)]
        .map(|mesh| [0, 1, 3].map(|corner: usize| mesh.uv()[corner].map(f64::from)));
    let [p, q] = [1, 2].map(|k| [to[k][0] - to[0][0], to[k][1] - to[0][1]]);
    let at = [u - to[0][0], v - to[0][1]];
    let determinant = p[0] * q[1] - p[1] * q[0];
    let s = (at[0] * q[1] - at[1] * q[0]) / determinant;
    let t = (p[0] * at[1] - p[1] * at[0]) / determinant;
    [0, 1].map(|k| from[0][k] + s * (from[1][k] - from[0][k]) + t * (from[2][k] - from[0][k]))
}
