//! Landmarks painted as dots, through the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use crate::bench::Bench;
use uvgraft::Mesh;
use uvgraft_io::obj;

/// A bump of `n * n` quads, turned about the vertical axis and moved, with its layout in a part of the
/// unit square.
fn bump(n: u32, turn: f32, moved: f32, scale: f32) -> Mesh {
    let count = n + 1;
    let plane: Vec<[f32; 2]> =
        (0..count * count).map(|k| [k % count, k / count].map(|at| at as f32 / n as f32)).collect();
    let place = |&[u, v]: &[f32; 2]| {
        let (x, y) = (u - 0.5, 0.7 * (0.5 - v));
        let z = 0.3 * (-8.0 * (x * x + 2.0 * y * y)).exp() + 0.1 * x;
        let (sin, cos) = turn.sin_cos();
        [cos * x + sin * z + moved, y, cos * z - sin * x]
    };
    let positions = plane.iter().map(place).collect();
    let uv = plane.iter().map(|uv| uv.map(|value| 0.05 + scale * value)).collect();
    let faces: Vec<[u32; 3]> = (0..n * n)
        .map(|k| k / n * count + k % n)
        .flat_map(|k| [[k, k + count, k + 1], [k + 1, k + count, k + count + 1]])
        .collect();
    Mesh::from_triangles(positions, uv, &faces, &faces).unwrap()
}

const COLORS: [[u8; 3]; 5] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [255, 0, 255]];

/// Places of the layout at which dots are painted.
const PLACES: [[f32; 2]; 5] = [[0.1, 0.1], [0.9, 0.2], [0.5, 0.5], [0.2, 0.8], [0.7, 0.9]];

/// Paints round dots of three texels' radius at places of a layout from 0.05 with this scale.
fn paint(bench: &Bench, name: &str, scale: f32, dots: &[([u8; 3], [f32; 2])]) {
    let dots = dots.to_vec();
    bench.draw(name, (256, 256), move |x, y| {
        let at = |value: f32| (0.05 + scale * value) * 256.0;
        let is_near = |place: [f32; 2]| {
            (x as f32 + 0.5 - at(place[0])).hypot(y as f32 + 0.5 - at(place[1])) < 3.0
        };
        match dots.iter().find(|dot| is_near(dot.1)) {
            Some(([r, g, b], _)) => [*r, *g, *b, 255],
            None => [0; 4],
        }
    });
}

fn all_dots() -> Vec<([u8; 3], [f32; 2])> {
    COLORS.into_iter().zip(PLACES).collect()
}

fn bench() -> Bench {
    let bench = Bench::new();
    obj::save(&bump(20, 0.0, 0.0, 0.9), bench.path("a.obj")).unwrap();
    obj::save(&bump(27, 2.0, 3.0, 0.6), bench.path("b.obj")).unwrap();
    paint(&bench, "a.png", 0.9, &all_dots());
    paint(&bench, "b.png", 0.6, &all_dots());
    bench
}

const PAIR: &str = "pair a.obj b.obj --by surface -o new.uvpair";

#[test]
fn dots_align_meshes_that_nothing_else_does() {
    let bench = bench();
    bench.refuse(PAIR, &["be given landmarks"]);
    let report = bench.succeed(&format!("{PAIR} --landmarks a.png b.png --registered r.obj"));
    assert!(report.starts_with("linked by surfaces, aligned by landmarks: "), "{report}");
    // The turned and moved bump is back in its place.
    let registered = obj::read(bench.path("r.obj")).unwrap();
    let wanted = bump(27, 0.0, 0.0, 0.6);
    let off =
        |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
    let mut distances: Vec<f32> =
        registered.positions().iter().zip(wanted.positions()).map(off).collect();
    distances.sort_by(f32::total_cmp);
    let median = distances[distances.len() / 2];
    assert!(median < 0.01, "{median}");
}

#[test]
fn dots_that_do_not_pair_up_are_refused() {
    let bench = bench();
    let dots = all_dots();
    paint(&bench, "fewer.png", 0.6, &dots[..4]);
    let twice = [&dots[..], &[(COLORS[0], [0.5, 0.2])]].concat();
    paint(&bench, "twice.png", 0.6, &twice);
    let mut outside = dots.clone();
    outside[2].1 = [1.4, 1.4];
    paint(&bench, "outside.png", 0.6, &outside);
    bench.paint("plain.png", (32, 32), uvgraft::Channels::Rgb, &[255, 255, 255]);
    bench.write("ids.txt", "0\n1\n2\n");
    for (landmarks, wanted) in [
        (
            "a.png fewer.png",
            &["the dot #ff00ff at ", " of the source image has no dot of its colour"][..],
        ),
        ("fewer.png a.png", &["the dot #ff00ff at ", " of the target image has no dot"]),
        ("a.png twice.png", &["twice.png: dots must have different colours, got #ff0000 at"]),
        (
            "a.png outside.png",
            &["outside.png: the dot #0000ff at (227, 227) must be on a UV island"],
        ),
        ("a.png plain.png", &["plain.png: the image must have dots"]),
        (
            "a.png ids.txt",
            &["two images or two lists of vertices, but a.png is an image and ids.txt"],
        ),
        ("ids.txt b.png", &["but b.png is an image and ids.txt is not"]),
        ("a.png none.png", &["none.png"]),
    ] {
        bench.refuse(&format!("{PAIR} --landmarks {landmarks}"), wanted);
    }
    paint(&bench, "two_a.png", 0.9, &dots[..2]);
    paint(&bench, "two_b.png", 0.6, &dots[..2]);
    let two = format!("{PAIR} --landmarks two_a.png two_b.png");
    bench.refuse(&two, &["landmarks must be at least 3 pairs"]);
}
