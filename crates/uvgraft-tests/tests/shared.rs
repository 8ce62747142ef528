//! Prepared objects can be stored anywhere and shared by several threads at once.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::{Arc, LazyLock};
use std::thread;

use uvgraft::blend::Side;
use uvgraft::{
    BlendDomain, BlendOptions, Channels, Content, Direction, Encoding, Filter, FitOptions, Graft,
    GraftBuilder, NormalOptions, Overlap, Overlay, Pair, Prefer, Size, Sizes, Texels, Texture,
};
use uvgraft_tests::synthetic;

const FROM: Size = Size::new(200, 260);
const TO: Size = Size::new(330, 290);

static PAIR: LazyLock<Arc<Pair>> = LazyLock::new(synthetic::pair);
/// A pair whose meshes have an actual shape, which blends require.
static CHARTS: LazyLock<Arc<Pair>> = LazyLock::new(synthetic::turned_charts);
static GRAFT: LazyLock<Graft> = LazyLock::new(|| blended(FROM).build().unwrap());

fn builder(from: Size) -> GraftBuilder {
    Graft::builder(Arc::clone(&PAIR), Sizes { from, to: TO })
}

/// The upper left half of a surface, with a membrane.
fn blended(from: Size) -> GraftBuilder {
    let domain = BlendDomain::new(Arc::clone(&CHARTS), Direction::Forward);
    let half = (0..64 * 64).map(|k| if k % 64 + k / 64 < 64 { 255 } else { 0 });
    let half = Texels::U8(half.collect());
    let half = Texture::new(Size::square(64), Channels::Grey, Encoding::Data, half).unwrap();
    Graft::builder(Arc::clone(&CHARTS), Sizes { from, to: TO })
        .region(domain.painted(Side::Target, &half).unwrap())
        .blend(BlendOptions::default().feather(0.1).membrane())
}

/// The results of four simultaneous threads.
fn at_once<R: Send>(find: impl Fn(u64) -> R + Sync) -> Vec<R> {
    thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|seed| {
                scope.spawn({
                    let find = &find;
                    move || find(seed)
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

#[test]
fn a_static_graft_is_applied_by_four_threads() {
    let carried = |graft: &Graft, seed| {
        let (texture, base) = (synthetic::detailed(FROM, seed), synthetic::detailed(TO, seed + 9));
        graft.apply(texture, base).unwrap()
    };
    let alone: Vec<Texture> =
        (0..4).map(|seed| carried(&blended(FROM).build().unwrap(), seed)).collect();
    assert!(alone[0] != alone[1]);
    assert!(at_once(|seed| carried(&GRAFT, seed)) == alone);
    // A clone behaves the same.
    assert!(at_once(|seed| carried(&GRAFT.clone(), seed)) == alone);
}

#[test]
fn an_overlay_is_laid_over_bands_by_four_threads() {
    let (texture, base) = (synthetic::detailed(FROM, 1), synthetic::detailed(TO, 2));
    let toning = GRAFT.toning(&texture, &base, base.format()).unwrap().unwrap();
    let sampled = GRAFT.overlay(&texture, base.format()).unwrap().with_tone(&toning).unwrap();
    let plain = builder(FROM).build().unwrap();
    let options = FitOptions::default().max_steps(3);
    let solved = plain.fit(&texture, base.format(), &options, &mut |_| {}).unwrap().overlay;
    // It outlives the graft that made it.
    drop(plain);
    let check = |overlay: &Overlay| {
        let whole = overlay.lay(0, base.clone()).unwrap();
        let bands = at_once(|quarter| {
            let height = TO.height.div_ceil(4);
            let first = quarter as u32 * height;
            let rows = first..(first + height).min(TO.height);
            overlay.lay(first, base.rows(rows.clone())).unwrap() == whole.rows(rows)
        });
        assert_eq!(bands, [true; 4]);
    };
    check(&sampled);
    check(&solved);
}

#[test]
fn fits_and_matrices_are_shared_by_threads() {
    let graft = builder(FROM).filter(Filter::Bilinear).build().unwrap();
    let base = synthetic::detailed(TO, 3);
    let fitted = |graft: &Graft, seed| {
        let options = FitOptions::default().max_steps(3);
        let fitted =
            graft.fit(synthetic::detailed(FROM, seed), base.format(), &options, &mut |_| {});
        fitted.unwrap().overlay.lay(0, base.clone()).unwrap()
    };
    let alone: Vec<Texture> = (0..4)
        .map(|seed| fitted(&builder(FROM).filter(Filter::Bilinear).build().unwrap(), seed))
        .collect();
    assert!(at_once(|seed| fitted(&graft, seed)) == alone);

    let operator = graft.operator();
    let column = |seed: u64| {
        let mut rng = fastrand::Rng::with_seed(seed);
        let values: Vec<f32> = (0..TO.texels()).map(|_| rng.f32()).collect();
        let back = operator.apply_transposed(1, &values);
        (operator.apply(1, &back), back)
    };
    let alone: Vec<_> = (0..4).map(column).collect();
    assert!(at_once(column) == alone);
}

#[test]
fn another_texture_size_gives_what_a_new_graft_gives() {
    let other = Size::new(512, 300);
    let builders: [fn(Size) -> GraftBuilder; 4] = [
        |from| builder(from).filter(Filter::CatmullRom).gutter_px(5),
        |from| builder(from).prefer(Prefer::Left).overlap(Overlap::Average),
        blended,
        |from| builder(from).content(Content::Data),
    ];
    let base = synthetic::detailed(TO, 4);
    for make in builders {
        let resized = make(FROM).build().unwrap().with_texture_size(other).unwrap();
        let fresh = make(other).build().unwrap();
        assert_eq!(resized.sizes(), fresh.sizes());
        assert_eq!(resized.texture_rows(), fresh.texture_rows());
        assert!(resized.mask() == fresh.mask());
        let texture = synthetic::detailed(other, 5);
        let [a, b] = [&resized, &fresh].map(|graft| graft.apply(&texture, &base).unwrap());
        assert!(a == b);
        assert!(resized.apply(synthetic::detailed(FROM, 5), &base).is_err());
    }
    // A fit prepared for one size must not be reused for another.
    let graft = builder(FROM).build().unwrap();
    let fitted = |graft: &Graft, from| {
        let options = FitOptions::default().max_steps(2);
        let texture = synthetic::detailed(from, 6);
        let fitted = graft.fit(texture, base.format(), &options, &mut |_| {}).unwrap();
        fitted.overlay.lay(0, base.clone()).unwrap()
    };
    let before = fitted(&graft, FROM);
    assert!(
        fitted(&graft.with_texture_size(other).unwrap(), other)
            == fitted(&builder(other).build().unwrap(), other)
    );
    assert!(fitted(&graft, FROM) == before);
    // Normals, too.
    let turned = |graft: Graft| graft.apply(synthetic::detailed(other, 7), &base).unwrap();
    let of_normals = |from| {
        let builder = Graft::builder(Arc::clone(&CHARTS), Sizes { from, to: TO });
        builder.content(Content::Normals(NormalOptions::default())).build().unwrap()
    };
    assert!(
        turned(of_normals(FROM).with_texture_size(other).unwrap()) == turned(of_normals(other))
    );
}
