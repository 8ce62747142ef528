//! Blending: properties that hold for any region, texture and layout.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::{Growth, Side};
use uvgraft::{
    Averaging, Blend, BlendDomain, BlendOptions, Channels, Content, Depth, Direction, Encoding,
    Filter, Graft, GraftBuilder, GraftError, Mesh, NormalOptions, Overlap, Overlay, Pair,
    Selection, Size, Sizes, Texels, Texture, Tone, ToneCorrection,
};
use uvgraft_tests::synthetic;

const FORWARD: Direction = Direction::Forward;

/// A square sheet of `side` squares along each side. Its layout is one island, or two if it is cut
/// along the centre line, with the right one upside down; the vertices on the cut may be split in
/// two.
struct Sheet {
    side: u32,
    is_cut: bool,
    is_split: bool,
}

impl Sheet {
    const WHOLE: Self = Self { side: 24, is_cut: false, is_split: false };

    fn mesh(&self, place: impl Fn([f64; 2]) -> [f64; 3]) -> Mesh {
        let Self { side, is_cut, is_split } = *self;
        let (half, across) = (side / 2, side + 1);
        let unit = |k: u32| f64::from(k) / f64::from(side);
        let (mut positions, mut uv) = (Vec::new(), Vec::new());
        for vertex in 0..across * across {
            positions.push(place([vertex % across, vertex / across].map(unit)));
        }
        if is_split {
            positions.extend((0..across).map(|y| place([0.5, unit(y)])));
        }
        let (mut faces, mut uv_faces) = (Vec::new(), Vec::new());
        for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
            let is_right = is_cut && column >= half;
            let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[dx, dy]| [column + dx, row + dy]);
            let vertices = ring.map(|[x, y]| match is_split && is_right && x == half {
                true => across * across + y,
                false => y * across + x,
            });
            let first = uv.len() as u32;
            uv.extend(ring.map(|at| {
                let [s, t] = at.map(unit);
                let at = match (is_cut, is_right) {
                    (false, _) => [0.05 + 0.9 * s, 0.05 + 0.9 * t],
                    (_, false) => [0.03 + 0.9 * s, 0.05 + 0.9 * t],
                    (_, true) => [0.97 - 0.9 * (s - 0.5), 0.95 - 0.9 * t],
                };
                at.map(|value| value as f32)
            }));
            let diagonals = if (row + column) % 2 == 0 {
                [[0, 1, 2], [0, 2, 3]]
            } else {
                [[0, 1, 3], [1, 2, 3]]
            };
            for corners in diagonals {
                faces.push(corners.map(|k: usize| vertices[k]));
                uv_faces.push(corners.map(|k| first + k as u32));
            }
        }
        let positions = positions.iter().map(|at| at.map(|value| value as f32)).collect();
        Mesh::from_triangles(positions, uv, &faces, &uv_faces).unwrap()
    }

    /// The vertices whose position in the sheet satisfies `is_wanted`.
    fn vertices(&self, is_wanted: impl Fn([f64; 2]) -> bool) -> Vec<u32> {
        let across = self.side + 1;
        let unit = |k: u32| f64::from(k) / f64::from(self.side);
        let mut found: Vec<u32> = (0..across * across)
            .filter(|vertex| is_wanted([vertex % across, vertex / across].map(unit)))
            .collect();
        if self.is_split {
            let copies = (0..across).filter(|&y| is_wanted([0.5, unit(y)]));
            found.extend(copies.map(|y| across * across + y));
        }
        found
    }
}

/// A mesh linked to itself.
fn to_itself(mesh: &Mesh) -> Arc<Pair> {
    let map: Vec<i64> = (0..mesh.positions().len() as i64).collect();
    Arc::new(Pair::by_vertex_map(mesh.clone(), mesh.clone(), &map).unwrap())
}

fn flat([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, 0.0]
}

/// A graft of a region, between square textures of one size.
fn blended(region: &Selection, options: BlendOptions, side: u32) -> GraftBuilder {
    let size = Size::square(side);
    Graft::builder(Arc::clone(region.domain().pair()), Sizes { from: size, to: size })
        .region(region.clone())
        .blend(options)
}

/// The weight of the source at each texel.
fn weights(region: &Selection, options: BlendOptions, side: u32) -> Result<Texture, GraftError> {
    Ok(blended(region, options, side).gutter_px(0).build()?.mask())
}

fn toned(overlay: Overlay, toning: Option<&ToneCorrection>) -> Overlay {
    match toning {
        Some(toning) => overlay.with_tone(toning).unwrap(),
        None => overlay,
    }
}

fn bytes(texture: &Texture) -> &[u8] {
    let Texels::U8(values) = texture.texels() else { panic!("8 bits") };
    values
}

fn picture(side: u32, color: impl Fn([f64; 2]) -> [u8; 3]) -> Texture {
    let uv = |k: u32| (f64::from(k) + 0.5) / f64::from(side);
    let values = (0..side * side).flat_map(|k| color([uv(k % side), uv(k / side)])).collect();
    Texture::new(Size::square(side), Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap()
}

fn feathered(feather: f64) -> BlendOptions {
    BlendOptions::default().feather(feather)
}

/// The inverse of smoothstep: the share of the feather that corresponds to a weight.
fn share(weight: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let t: f64 = 0.5 * (low + high);
        if t * t * (3.0 - 2.0 * t) < weight { low = t } else { high = t }
    }
    0.5 * (low + high)
}

/// A texture with every difficulty that its format allows: noise at all scales and partial alpha.
fn noise(size: Size, channels: Channels, depth: Depth, seed: u64) -> Texture {
    let mut rng = fastrand::Rng::with_seed(seed);
    let picture = synthetic::detailed(size, seed);
    let values = (0..size.texels()).flat_map(|k| {
        let at = [k % size.width as usize, k / size.width as usize].map(|at| at as u32);
        let alpha = if rng.u8(..4) == 0 { rng.f32() } else { 1.0 };
        let [r, g, b] = [0, 1, 2].map(|channel| picture.get(at[0], at[1], channel));
        match channels {
            Channels::Grey => vec![g],
            Channels::GreyAlpha => vec![g, alpha],
            Channels::Rgb => vec![r, g, b],
            Channels::Rgba => vec![r, g, b, alpha],
        }
    });
    let floats = Texels::F32(values.collect());
    let encoding = Encoding::Srgb;
    Texture::new(size, channels, encoding, floats).unwrap().converted(channels, depth)
}

/// Whether laying over bands of a given height yields the same rows as the whole.
fn bands_are_rows(overlay: &Overlay, base: &Texture, height: u32) -> bool {
    let whole = overlay.lay(0, base.clone()).unwrap();
    (0..base.size().height).step_by(height as usize).all(|first| {
        let rows = first..(first + height).min(base.size().height);
        overlay.lay(first, base.rows(rows.clone())).unwrap() == whole.rows(rows)
    })
}

#[test]
fn bands_and_threads_do_not_change_the_result() {
    let pair = synthetic::pair();
    let (source_size, size) = (Size::new(201, 170), Size::new(190, 233));
    let mask = picture(64, |[u, v]| [if (u - 0.3).hypot(v - 0.3) < 0.25 { 255 } else { 0 }; 3]);
    let blends = [
        feathered(0.0),
        feathered(3.0),
        feathered(3.0).membrane(),
        feathered(1.0).membrane().tone(Tone::Source),
        feathered(3.0).membrane().match_skin(),
    ];
    let formats = [
        (Channels::Rgb, Channels::Rgb, Depth::U8),
        (Channels::Rgba, Channels::Rgb, Depth::U8),
        (Channels::Rgb, Channels::Rgba, Depth::U16),
        (Channels::GreyAlpha, Channels::Rgb, Depth::F32),
        (Channels::Grey, Channels::Grey, Depth::U8),
    ];
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
            let region = domain.painted(Side::Target, &mask).unwrap();
            let mut results = Vec::new();
            for (index, options) in blends.into_iter().enumerate() {
                let overlap = [Overlap::First, Overlap::Average][index % 2];
                let averaging = [Averaging::Encoded, Averaging::Light][usize::from(index == 2)];
                let skin = picture(50, |[u, _]| [(u * 255.0) as u8; 3]);
                let sizes = Sizes { from: source_size, to: size };
                let builder = Graft::builder(Arc::clone(&pair), sizes)
                    .filter(Filter::Lanczos3)
                    .overlap(overlap)
                    .averaging(averaging)
                    .region(region.clone())
                    .blend(options)
                    .skin(skin);
                let graft = builder.clone().build().unwrap();
                for (of_source, of_base, depth) in formats {
                    let source = noise(source_size, of_source, depth, 5);
                    let base = noise(size, of_base, depth, 6);
                    let overlay = graft.overlay(&source, base.format()).unwrap();
                    // Noise is not skin; then there is no tone, but the rest of the blend applies.
                    let toning = graft.toning(&source, &base, base.format());
                    let overlay = toned(overlay, toning.ok().flatten().as_ref());
                    let whole = overlay.lay(0, base.clone()).unwrap();
                    for height in [1, 7, 64, 100] {
                        assert!(bands_are_rows(&overlay, &base, height), "{options:?} {height}");
                    }
                    results.push(whole);
                }
                let normals = builder.content(Content::Normals(NormalOptions::default()));
                let source = noise(source_size, Channels::Rgb, Depth::U8, 7);
                let base = noise(size, Channels::Rgb, Depth::U8, 8).with_encoding(Encoding::Data);
                let overlay = normals.build().unwrap().overlay(source, base.format()).unwrap();
                let whole = overlay.lay(0, base.clone()).unwrap();
                assert!(bands_are_rows(&overlay, &base, 13), "normals, {options:?}");
                results.push(whole);
            }
            results
        })
    };
    let one = made(1);
    assert!(one == made(3));
}

#[test]
fn distances_are_those_on_a_sphere() {
    // All of a sphere but its poles, which are open boundaries; the region lies south of 45° north.
    let sheet = Sheet { side: 48, ..Sheet::WHOLE };
    let angles = |[s, t]: [f64; 2]| [s * 3.0, 0.2 + t * 2.6];
    let radius = 1e-4;
    let mesh = sheet.mesh(|at| {
        let [longitude, polar] = angles(at);
        let ring = radius * polar.sin();
        [ring * longitude.cos(), ring * longitude.sin(), radius * polar.cos()]
    });
    let pair = to_itself(&mesh);
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let rim = angles([0.0, 0.25])[1];
    let inside = sheet.vertices(|at| at[1] > 0.25 - 1e-9);
    let region = domain.vertices(Side::Source, &inside).unwrap();
    let feather = 1.2 * radius;
    let weights = weights(&region, feathered(feather), 256).unwrap();
    let mut seen = 0;
    for (texel, &weight) in bytes(&weights).iter().enumerate() {
        let v = ((texel / 256) as f64 + 0.5) / 256.0;
        let t = (v - 0.05) / 0.9;
        let u = ((texel % 256) as f64 + 0.5) / 256.0;
        if !(0.06..0.94).contains(&u) || !(0.26..0.99).contains(&t) {
            continue;
        }
        let wanted = radius * (angles([0.0, t])[1] - rim);
        // Rounded weights are a poor measure of distance where they hardly change.
        if (12..244).contains(&weight) {
            let found = share(f64::from(weight) / 255.0) * feather;
            let far = (found - wanted).abs();
            assert!(far < 0.03 * wanted + 0.004 * feather, "{found} {wanted} at {u}, {v}");
            seen += 1;
        }
    }
    assert!(seen > 10_000, "{seen}");
}

#[test]
fn a_painted_outline_is_followed() {
    for (side, unit) in [(24, 1.0), (40, 1e6), (40, 1e-6)] {
        let sheet = Sheet { side, ..Sheet::WHOLE };
        let mesh = sheet.mesh(|[x, y]| [x * unit, y * unit, 0.0]);
        let pair = to_itself(&mesh);
        let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
        let (middle, radius) = ([0.47, 0.52], 0.31);
        let to_middle = |u: f64, v: f64| {
            let [x, y] = [u, v].map(|value| (value - 0.05) / 0.9);
            (x - middle[0]).hypot(y - middle[1])
        };
        let mask = picture(512, |[u, v]| [if to_middle(u, v) < radius { 255 } else { 0 }; 3]);
        let region = domain.painted(Side::Source, &mask).unwrap();
        let feather = 0.15;
        let weights = weights(&region, feathered(feather * unit), 256).unwrap();
        let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0);
        for (texel, &weight) in bytes(&weights).iter().enumerate() {
            let [u, v] = [texel % 256, texel / 256].map(|at| (at as f64 + 0.5) / 256.0);
            if (8..247).contains(&weight) {
                let found = share(f64::from(weight) / 255.0) * feather;
                let far = (found - (radius - to_middle(u, v))).abs() * f64::from(side);
                worst = worst.max(far);
                sum += far;
                count += 1;
            }
        }
        let mean = sum / f64::from(count);
        assert!(count > 5000, "{count}");
        // In units of a square's side.
        assert!(worst < 0.35 && mean < 0.1, "{side}: {worst} {mean}");
    }
}

#[test]
fn island_borders_and_split_vertices_do_not_show() {
    let bent = |[x, y]: [f64; 2]| [x, y, 0.2 * (x * 6.0).sin()];
    let [whole, cut, split] = [(false, false), (true, false), (true, true)]
        .map(|(is_cut, is_split)| Sheet { side: 24, is_cut, is_split });
    let side = 512;
    let [whole_weights, cut_weights, split_weights] = [&whole, &cut, &split].map(|sheet| {
        let pair = to_itself(&sheet.mesh(bent));
        let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
        let inside = sheet.vertices(|[x, y]| (x - 0.45).hypot(y - 0.5) < 0.4);
        let region = domain.vertices(Side::Target, &inside).unwrap();
        weights(&region, feathered(0.3), side).unwrap()
    });
    assert!(cut_weights == split_weights);
    let at = |weights: &Texture, [u, v]: [f64; 2]| {
        let [x, y] = [u, v].map(|value| (value * f64::from(side)) as u32);
        f64::from(weights.get(x, y, 0))
    };
    let mut most = 0.0_f64;
    for k in 0..400 {
        let t = 0.02 + 0.96 * f64::from(k) / 400.0;
        // Texels to the left and to the right of the cut, half a texel or slightly more away from
        // it.
        let away = 0.7 / f64::from(side);
        let v = 0.05 + 0.9 * t;
        let left = at(&cut_weights, [0.48 - away, v]);
        let right = at(&cut_weights, [0.97 - away, 1.0 - v]);
        let both = at(&whole_weights, [0.5, v]);
        most = most.max(both);
        // A texel spans 0.002, more where the sheet is steep; weights grow by up to 1.5 over 0.3.
        assert!((left - right).abs() < 0.03, "{left} {right} at {t}");
        assert!((left - both).abs() < 0.03, "{left} {both} at {t}");
    }
    assert!(most > 0.99);
}

#[test]
fn equal_boundaries_change_nothing_and_the_feather_ends() {
    let sheet = Sheet::WHOLE;
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let inside = sheet.vertices(|[x, y]| (x - 0.5).hypot(y - 0.5) < 0.4);
    let region = domain.vertices(Side::Target, &inside).unwrap();
    let size = Size::square(256);
    // Detail in the centre, one colour at the boundary, where detail would make a difference.
    let detail = synthetic::detailed(size, 3);
    let source = picture(256, |[u, v]| {
        let [x, y] = [u, v].map(|value| (value * 256.0) as u32);
        let is_middle = (u - 0.5).hypot(v - 0.5) < 0.15;
        [0, 1, 2].map(|k| if is_middle { (detail.get(x, y, k) * 255.0) as u8 } else { 160 })
    });
    for membrane in [false, true] {
        let options = if membrane { feathered(0.1).membrane() } else { feathered(0.1) };
        let graft = blended(&region, options, 256).filter(Filter::Nearest).gutter_px(0);
        let graft = graft.build().unwrap();
        let lay = |base: &Texture| graft.apply(&source, base).unwrap();
        let result = lay(&source);
        for (found, wanted) in bytes(&result).iter().zip(bytes(&source)) {
            assert!(found.abs_diff(*wanted) <= 1, "membrane: {membrane}");
        }
        // Where the weight is full, nothing of another base remains; beyond the boundary, all of it
        // does.
        let other = source.clone().into_texels();
        let Texels::U8(mut values) = other else { panic!("8 bits") };
        let weights = graft.mask();
        for (texel, &weight) in values.chunks_exact_mut(3).zip(bytes(&weights)) {
            if weight == 255 {
                texel.fill(9);
            }
        }
        let other = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).unwrap();
        let laid = lay(&other);
        let whole = bytes(&weights).iter().filter(|&&weight| weight == 255).count();
        assert!(whole > 10_000, "{whole}");
        for ((found, wanted), weight) in
            bytes(&laid).chunks(3).zip(bytes(&source).chunks(3)).zip(bytes(&weights))
        {
            if *weight == 0 {
                assert_eq!(found, wanted);
            } else if !membrane {
                // A weight of 255 may stand for 254.5, which leaves less than a level.
                let far = (0..3).map(|k| found[k].abs_diff(wanted[k])).max();
                assert!(far <= Some(1), "{found:?} {wanted:?} {weight}");
            }
        }
    }
}

/// A face on a body of another tone, with hair or a collar along a quarter of the boundary.
#[test]
fn hair_on_a_quarter_of_the_boundary_changes_little_elsewhere() {
    let sheet = Sheet { side: 32, ..Sheet::WHOLE };
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let inside = sheet.vertices(|[x, y]| (x - 0.5).hypot(y - 0.5) < 0.35);
    let region = domain.vertices(Side::Target, &inside).unwrap();
    let side = 256;
    let shade = |[u, v]: [f64; 2]| 1.0 + 0.08 * (u * 5.0).sin() * (v * 4.0).cos();
    let tinted = |rgb: [f64; 3], at| rgb.map(|value| (value * shade(at)) as u8);
    let is_hair = |[u, v]: [f64; 2]| v < 0.5 && (u - 0.5).abs() < 0.5 - v;
    let skin = picture(side, |at| tinted([200.0, 150.0, 130.0], at));
    let hairy = picture(side, |at| match is_hair(at) {
        true => [40, 28, 24],
        false => tinted([200.0, 150.0, 130.0], at),
    });
    let body = picture(side, |at| tinted([150.0, 115.0, 100.0], at));
    let collar = picture(side, |at| match is_hair(at) {
        true => [30, 40, 120],
        false => tinted([150.0, 115.0, 100.0], at),
    });
    let graft = blended(&region, feathered(0.05).membrane(), side).build().unwrap();
    let lay = |source: &Texture, base: &Texture| graft.apply(source, base).unwrap();
    let clean = lay(&skin, &body);
    for (source, base) in [(&hairy, &body), (&skin, &collar)] {
        let result = lay(source, base);
        let mut most = 0;
        for (k, (found, wanted)) in bytes(&result).iter().zip(bytes(&clean)).enumerate() {
            let texel = k / 3;
            let [u, v] = [texel % 256, texel / 256].map(|at| (at as f64 + 0.5) / 256.0);
            if v > 0.55 || (u - 0.5).abs() > 0.6 - v {
                most = most.max(found.abs_diff(*wanted));
            }
        }
        // The tones differ by 50 levels.
        assert!(most <= 3, "{most}");
    }
}

/// Where the weight is 0 the base is kept and where it is full the source is, whatever values the
/// other one holds.
#[test]
fn non_finite_values_stay_on_their_side() {
    let sheet = Sheet::WHOLE;
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let mask = picture(256, |[u, v]| [if (u - 0.5).hypot(v - 0.5) < 0.3 { 255 } else { 0 }; 3]);
    let region = domain.painted(Side::Target, &mask).unwrap();
    let size = Size::square(128);
    let filled = |value| {
        Texture::filled(size, Channels::Rgb, Encoding::Linear, Depth::F32, &[value; 3]).unwrap()
    };
    for membrane in [false, true] {
        let options = if membrane { feathered(0.1).membrane() } else { feathered(0.1) };
        let graft = blended(&region, options, 128).filter(Filter::Nearest).build().unwrap();
        let weights = graft.mask();
        let format = filled(0.5).format();
        let toning = graft.toning(&filled(0.25), &filled(0.5), format).unwrap();
        assert_eq!(toning.is_some(), membrane);
        for wild in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let lay = |source: f32, base: f32| {
                let overlay = graft.overlay(filled(source), format).unwrap();
                toned(overlay, toning.as_ref()).lay(0, filled(base)).unwrap()
            };
            let [over_wild, wild_over] = [lay(0.25, wild), lay(wild, 0.5)];
            let (mut whole, mut nothing) = (0, 0);
            for y in 0..size.height {
                for x in 0..size.width {
                    let [u, v] = [x, y].map(|k| (f64::from(k) + 0.5) / 128.0);
                    let from_middle = (u - 0.5).hypot(v - 0.5);
                    if from_middle < 0.15 {
                        assert_eq!(weights.get(x, y, 0), 1.0);
                        // Nothing of the base remains; with a membrane, the source is twice as
                        // light.
                        let wanted = if membrane { 0.5 } else { 0.25 };
                        let found = over_wild.get(x, y, 1);
                        assert!((found - wanted).abs() < 0.01, "{found} over {wild}");
                        whole += 1;
                    } else if from_middle > 0.31 {
                        assert_eq!(wild_over.get(x, y, 1), 0.5, "{wild} above");
                        nothing += 1;
                    }
                }
            }
            assert!(whole > 500 && nothing > 500);
        }
    }
}

#[test]
fn senseless_options_do_no_harm() {
    let sheet = Sheet { side: 6, ..Sheet::WHOLE };
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let region = domain.vertices(Side::Target, &sheet.vertices(|[x, _]| x < 0.6)).unwrap();
    let hard = weights(&region, feathered(0.0), 32).unwrap();
    for feather in [-1.0, f64::NEG_INFINITY, f64::NAN] {
        for options in [feathered(feather), feathered(feather).membrane()] {
            assert!(weights(&region, options, 32).unwrap() == hard, "{feather}");
        }
    }
    for feather in [1e300, f64::INFINITY] {
        let weights = weights(&region, feathered(feather).membrane(), 32).unwrap();
        assert!(bytes(&weights).iter().all(|&weight| weight == 0));
    }
    for by in [i32::MIN, i32::MAX] {
        let all = Blend::new(&region.grown(Growth::Rings(by)), feathered(0.0));
        assert_eq!(all.is_ok(), by > 0);
    }
    for by in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let _ = Blend::new(&region.grown(Growth::Length(by)), feathered(0.1));
    }
}

/// Of two islands in the same place the last is transparent; the mean has the colour of the first.
#[test]
fn transparent_texels_add_no_color_to_a_mean() {
    let uv = |left: f32| [[left, 0.3], [left + 0.3, 0.3], [left + 0.3, 0.6], [left, 0.6]];
    let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let square = |lefts: [f32; 2]| {
        let uv: Vec<[f32; 2]> = lefts.into_iter().flat_map(uv).collect();
        let positions = (0..8_u8).map(|k| [f32::from(k % 4), f32::from(k), 0.0]).collect();
        Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
    };
    let map: Vec<i64> = (0..8).collect();
    let pair = Arc::new(Pair::by_vertex_map(square([0.1, 0.6]), square([0.3, 0.3]), &map).unwrap());
    let size = Size::square(64);
    let builder = Graft::builder(Arc::clone(&pair), Sizes { from: size, to: size })
        .overlap(Overlap::Average)
        .filter(Filter::Nearest);
    let graft = builder.clone().build().unwrap();
    let values =
        (0..64 * 64).flat_map(|k| if k % 64 < 32 { [200, 100, 50, 255] } else { [0, 0, 0, 0] });
    let source =
        Texture::new(size, Channels::Rgba, Encoding::Srgb, Texels::U8(values.collect())).unwrap();
    let clear = Texture::filled(size, Channels::Rgba, Encoding::Srgb, Depth::U8, &[0.0; 4]);
    let result = graft.apply(&source, clear.unwrap()).unwrap();
    let at = |texture: &Texture| [0, 1, 2, 3].map(|k| (texture.get(28, 28, k) * 255.0).round());
    assert_eq!(at(&result), [200.0, 100.0, 50.0, 128.0]);
    // Blended over a base, it is half of each.
    let blended = builder.blend(feathered(0.0)).build().unwrap();
    let result = blended.apply(source, picture(64, |_| [100; 3])).unwrap();
    assert_eq!(at(&result), [150.0, 100.0, 75.0, 255.0]);
}

/// A grey texture is matched to the base's statistics like one with three equal channels.
#[test]
fn grey_is_matched_as_equal_channels_are() {
    let sheet = Sheet::WHOLE;
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let inside = sheet.vertices(|[x, y]| (x - 0.5).hypot(y - 0.5) < 0.35);
    let region = domain.vertices(Side::Target, &inside).unwrap();
    let size = Size::square(128);
    let noisy = |level: f32, seed| {
        let mut rng = fastrand::Rng::with_seed(seed);
        let values = (0..size.texels()).map(|_| (level + 12.0 * rng.f32()) as u8).collect();
        Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::U8(values)).unwrap()
    };
    let (source, base) = (noisy(180.0, 1), noisy(120.0, 2));
    for membrane in [false, true] {
        let options = feathered(0.05).match_skin();
        let options = if membrane { options.membrane() } else { options };
        let graft = blended(&region, options, 128).build().unwrap();
        let lay = |channels| {
            let [source, base] =
                [&source, &base].map(|it| it.clone().converted(channels, it.depth()));
            graft.apply(source, base).unwrap()
        };
        let (grey, rgb) = (lay(Channels::Grey), lay(Channels::Rgb));
        for (k, &value) in bytes(&grey).iter().enumerate() {
            assert!(value.abs_diff(bytes(&rgb)[3 * k]) <= 1, "{membrane}: {value} at {k}");
        }
    }
}

/// A region is the same whether it is selected as whole triangles or by levels.
#[test]
fn triangles_in_corners_of_the_region_are_kept() {
    let sheet = Sheet { side: 8, ..Sheet::WHOLE };
    let pair = to_itself(&sheet.mesh(flat));
    let domain = BlendDomain::new(Arc::clone(&pair), FORWARD);
    let faces =
        domain.vertices(Side::Target, &sheet.vertices(|[x, y]| x < 0.63 && y < 0.51)).unwrap();
    let white = domain.painted(Side::Target, &picture(16, |_| [255; 3])).unwrap();
    let touched =
        |selection: &Selection| Blend::new(selection, feathered(0.0)).unwrap().touched().to_vec();
    let count =
        |selection: &Selection| touched(selection).iter().filter(|&&touched| touched).count();
    let leveled = faces.intersection(&white).unwrap();
    assert_eq!(count(&leveled), count(&faces));
    assert_eq!(count(&white.difference(&faces).unwrap()), 2 * 8 * 8 - count(&faces));
    for rings in [-2, -1, 1, 2] {
        let [leveled, wanted] = [&leveled, &faces].map(|it| it.grown(Growth::Rings(rings)));
        assert_eq!(touched(&leveled), touched(&wanted), "{rings}");
        let [leveled, wanted] =
            [&leveled, &wanted].map(|it| weights(it, feathered(0.3), 64).unwrap());
        assert!(leveled == wanted, "{rings}");
    }
}
