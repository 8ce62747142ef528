//! Areas of eyes and mouths that a texture lacks: behind the lids, and between closed lips.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::ops::Range;
use std::sync::Arc;

use uvgraft::{
    Anatomy, Area, BlendOptions, Channels, Depth, Direction, Encoding, Graft, MapOptions, Overlap,
    Prefer, SamplingMap, Size, Sizes, Texels, Texture,
};
use uvgraft_tests::real;

const SKIN: [u8; 3] = [200, 150, 120];

fn rgb(size: Size, color: impl Fn(u32, u32) -> [u8; 3]) -> Texture {
    let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let texels = Texels::U8(places.flat_map(|(x, y)| color(x, y)).collect());
    Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap()
}

/// Rows and columns of the runs of selected target triangles.
fn runs_of(graft: &Graft, is_wanted: impl Fn(u32) -> bool) -> Vec<(u32, Range<u32>)> {
    let map = graft.map();
    let rows = (0..map.size().height).flat_map(|y| map.row(y).iter().map(move |run| (y, run)));
    let wanted = rows.filter(|(_, run)| is_wanted(map.patches()[run.patch as usize].face));
    wanted.map(|(y, run)| (y, run.x..run.x + run.len)).collect()
}

/// Texels behind the lids, unknown in a capture, show through neither of two eyes that share a
/// disc.
#[test]
fn eyes_show_nothing_of_what_is_beside_them_in_a_capture() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let size = Size::square(512);
    let mesh = pair.from(Direction::Forward);
    let map = SamplingMap::of_layout(mesh, size, &MapOptions::with_gutter(0));
    let mut is_known = vec![false; size.texels()];
    for y in 0..size.height {
        for run in map.row(y) {
            let first = (y * size.width + run.x) as usize;
            is_known[first..first + run.len as usize].fill(true);
        }
    }
    // Cyan around the islands and two texels into them.
    let face = rgb(size, |x, y| {
        let is_inner = [(-2, 0), (2, 0), (0, -2), (0, 2), (0, 0)].into_iter().all(|(dx, dy)| {
            let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            x < 512 && y < 512 && is_known[(y * 512 + x) as usize]
        });
        if is_inner { SKIN } else { [0, 255, 255] }
    });
    let body = Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.75, 0.55, 0.45]);
    let body = body.unwrap();
    let target = pair.to(Direction::Forward);
    let anatomy = Anatomy::find(target).unwrap();
    let eyes = anatomy.area(Area::Eyes);
    let is_eye =
        |face: u32| target.faces()[face as usize].iter().all(|&at| eyes[at as usize] >= 0.5);
    for prefer in [Prefer::First, Prefer::Left, Prefer::Right] {
        for overlap in [Overlap::First, Overlap::Average] {
            let graft = Graft::builder(Arc::clone(&pair), Sizes { from: size, to: size })
                .prefer(prefer)
                .overlap(overlap)
                .blend(BlendOptions::default().membrane())
                .build()
                .unwrap();
            let found = graft.apply(&face, &body).unwrap();
            let (mut seen, mut cyan) = (0, 0);
            for (y, columns) in runs_of(&graft, is_eye) {
                for x in columns {
                    seen += 1;
                    cyan += u32::from(found.get(x, y, 2) > found.get(x, y, 0));
                }
            }
            assert!(seen > 500, "{seen} texels of eyes");
            // A few remain at the edge of the disc of an eye's back, which is a dozen texels wide.
            assert!(cyan * 200 < seen, "{prefer:?}, {overlap:?}: {cyan} of {seen} texels");
        }
    }
}

/// The slit of a closed mouth is an open circle in the other layout; detail along the slit would
/// become shards across the circle.
#[test]
fn the_inside_of_a_mouth_has_no_shards() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let size = Size::square(1024);
    // Columns of two tones twenty levels apart: lips have detail, too.
    let body = rgb(size, |x, _| if x % 4 < 2 { SKIN } else { SKIN.map(|level| level - 20) });
    let head = rgb(size, |_, _| SKIN);
    let target = pair.to(Direction::Reverse);
    let anatomy = Anatomy::find(target).unwrap();
    let inside = anatomy.area(Area::MouthInterior);
    let is_inside =
        |face: u32| target.faces()[face as usize].iter().all(|&at| inside[at as usize] >= 0.9);
    let builder = || {
        Graft::builder(Arc::clone(&pair), Sizes { from: size, to: size })
            .direction(Direction::Reverse)
    };
    let steep = |graft: &Graft| {
        let found = graft.apply(&body, &head).unwrap();
        let (mut steep, mut all) = (0, 0);
        for (y, columns) in runs_of(graft, is_inside) {
            for x in columns.skip(1) {
                let step = found.get(x, y, 0) - found.get(x - 1, y, 0);
                all += 1;
                steep += u32::from(step.abs() > 3.0 / 255.0);
            }
        }
        f64::from(steep) / f64::from(all)
    };
    let [plain, blended] = [
        builder().build().unwrap(),
        builder().blend(BlendOptions::default().membrane()).build().unwrap(),
    ]
    .map(|graft| steep(&graft));
    assert!(plain > 0.1 && blended < 0.02, "{plain:.3} of the texels, {blended:.3} blended");
}
