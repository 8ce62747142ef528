//! Visibility of the boundary of a transferred face, on a body with another skin.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;

use uvgraft::blend::{BlendDomain, BlendOptions, Growth, Tone};
use uvgraft::{
    Channels, Direction, Encoding, Filter, Graft, MapOptions, Mesh, SamplingMap, Size, Sizes,
    Texels, Texture,
};
use uvgraft_metrics::seams::{Offset, SeamOptions, SeamReport, measure};
use uvgraft_tests::real;

const SIZE: Size = Size::square(2048);

/// Skin with spots of a few millimetres and shades of a few centimetres, continuous across UV
/// seams.
fn skin(mesh: &Mesh, color: [f64; 3]) -> Texture {
    let map = SamplingMap::of_layout(mesh, SIZE, &MapOptions::default());
    let mut values = vec![32_768_u16; SIZE.texels() * 3];
    for row in 0..SIZE.height {
        for run in map.row(row) {
            let face = map.patches()[run.patch as usize].face as usize;
            let [a, b, c] = mesh.uv_triangle(face).map(|[u, v]| {
                [f64::from(u) * f64::from(SIZE.width), f64::from(v) * f64::from(SIZE.height)]
            });
            let corners = mesh.faces()[face].map(|vertex| mesh.positions()[vertex as usize]);
            let determinant = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            for x in run.x..run.x + run.len {
                let at = [f64::from(x) + 0.5 - a[0], f64::from(row) + 0.5 - a[1]];
                let s = (at[0] * (c[1] - a[1]) - (c[0] - a[0]) * at[1]) / determinant;
                let t = ((b[0] - a[0]) * at[1] - at[0] * (b[1] - a[1])) / determinant;
                // Extrapolates into the gutter, not far beyond the edge.
                let (s, t) = (s.clamp(-0.2, 1.2), t.clamp(-0.2, 1.2));
                let place = [0, 1, 2].map(|axis| {
                    let [p, q, r] = corners.map(|corner| f64::from(corner[axis]));
                    p + (q - p) * s + (r - p) * t
                });
                let [x3, y3, z3] = place;
                let spots = ((x3 * 900.0).sin() * (y3 * 1100.0).sin() * (z3 * 1000.0).sin()) * 0.02;
                let shade = ((x3 * 60.0).sin() + (y3 * 50.0).cos() + (z3 * 70.0).sin()) * 0.02;
                let texel = (row * SIZE.width + x) as usize * 3;
                for (value, color) in values[texel..texel + 3].iter_mut().zip(color) {
                    *value =
                        ((color * (1.0 + spots + shade)).clamp(0.0, 1.0) * 65535.0).round() as u16;
                }
            }
        }
    }
    Texture::new(SIZE, Channels::Rgb, Encoding::Srgb, Texels::U16(values)).unwrap()
}

/// Visibility of the boundary and the UV seams of a face transferred onto a body; the seams are those
/// of the whole body.
struct Seen {
    /// At one texel from the edge.
    near: SeamReport,
    /// At three millimetres.
    far: SeamReport,
    result: Texture,
}

fn seen(domain: &BlendDomain, face: &Texture, body: &Texture, options: BlendOptions) -> Seen {
    // Excludes the photograph's collar.
    let region = domain.linked().grown(Growth::Length(-0.075));
    let graft = Graft::builder(Arc::clone(domain.pair()), Sizes { from: face.size(), to: SIZE })
        .filter(Filter::Bilinear)
        .region(region)
        .blend(options)
        .build()
        .unwrap();
    let result = graft.apply(face, body).unwrap();
    let cut = graft.blend().unwrap().cut().unwrap();
    let [near, far] = [Offset::Texels(1.0), Offset::Distance(0.003)].map(|offset| {
        let options = SeamOptions::default().offset(offset);
        measure(&cut.mesh, &result, &cut.inside, &options).unwrap()
    });
    Seen { near, far, result }
}

#[test]
fn the_boundary_is_invisible() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let folder = real::folder().unwrap();
    let face = uvgraft_image::read(folder.join("flame_face_texture.png")).unwrap().texture;
    let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
    let plain = BlendOptions::default();
    let feather = plain.feather(0.01);
    let membrane = feather.membrane();
    // Dark, light, and of another hue.
    for color in [[0.36, 0.24, 0.18], [0.93, 0.80, 0.72], [0.45, 0.55, 0.62]] {
        let body = skin(pair.target(), color);
        let hard = seen(&domain, &face, &body, plain).near.rim.delta_e.unwrap();
        assert!(hard.median > 5.0 && hard.p95 > 8.0, "{color:?} hard: {hard:?}");
        // A feather spreads the step that it hides.
        let soft = seen(&domain, &face, &body, feather);
        let of_feather = soft.far.rim.delta_e.unwrap();
        let toned = seen(&domain, &face, &body, membrane);
        let (near, far) = (toned.near.rim.delta_e.unwrap(), toned.far.rim.delta_e.unwrap());
        assert!(near.median < 1.0 && near.p95 < 3.0, "{color:?} membrane: {near:?}");
        // At that distance spots and pores of both sides contribute, and the rest of the collar at
        // the nape.
        assert!(far.median < 1.5, "{color:?} membrane at 3 mm: {far:?}");
        assert!(far.p95 < 0.7 * of_feather.p95, "{color:?}: {far:?}, feathered {of_feather:?}");

        // Here the body gives way: skin around the boundary, which is all that this body has.
        let source = seen(&domain, &face, &body, membrane.tone(Tone::Source));
        let near = source.near.rim.delta_e.unwrap();
        assert!(near.median < 1.0 && near.p95 < 3.0, "{color:?} the body's skin: {near:?}");
        assert_ne!(source.result, toned.result);
    }
}

#[test]
fn no_seam_comes_from_blending() {
    let Some(pair) = real::flame_to_smplx() else { return };
    let domain = BlendDomain::new(Arc::clone(&pair), Direction::Forward);
    // Both are painted without a seam, so anything visible beyond their own seams comes from the
    // blend.
    let face = skin(pair.source(), [0.85, 0.66, 0.56]);
    let body = skin(pair.target(), [0.42, 0.28, 0.2]);
    let none = vec![false; pair.target().faces().len()];
    let of = |texture: &Texture| {
        let report = measure(pair.target(), texture, &none, &SeamOptions::default()).unwrap();
        report.uv_seams.delta_e.unwrap()
    };
    // Lighter skin has the greater contrast, so a body that takes on its tone is compared with
    // that.
    let like_face = skin(pair.target(), [0.85, 0.66, 0.56]);
    for (tone, own) in [(Tone::Base, of(&body)), (Tone::Source, of(&like_face))] {
        let options = BlendOptions::default().feather(0.01).membrane().tone(tone);
        let found = seen(&domain, &face, &body, options).near;
        let steps = found.uv_seams.delta_e.unwrap();
        // A twentieth of the smallest visible difference, as an allowance for filtering.
        assert!(
            steps.median <= own.median + 0.05 && steps.p95 <= own.p95 + 0.05,
            "{tone:?}: {steps:?}, the body's own {own:?}"
        );
        let rim = found.rim.delta_e.unwrap();
        assert!(rim.median < 1.0 && rim.p95 < 3.0, "{tone:?}: {rim:?}");
    }
}
