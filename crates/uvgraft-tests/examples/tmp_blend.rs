use std::path::Path;
use std::time::Instant;
use uvgraft::*;
use uvgraft_io::image;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let pair = uvgraft_io::pair_file::read(Path::new(&a[1])).unwrap().pair;
    let face = image::read(Path::new(&a[2])).unwrap().texture;
    let size: u32 = a[4].parse().unwrap();
    let base = if a[3].starts_with('#') {
        let v: Vec<f32> = (0..3)
            .map(|k| u8::from_str_radix(&a[3][1 + 2 * k..3 + 2 * k], 16).unwrap() as f32 / 255.0)
            .collect();
        Texture::filled(Size::square(size), Channels::Rgb, Encoding::Srgb, Depth::U8, &v).unwrap()
    } else {
        image::read(Path::new(&a[3])).unwrap().texture
    };
    let time =
        |name: &str, t: Instant| println!("{name:<20} {:.1} ms", t.elapsed().as_secs_f64() * 1e3);
    let t = Instant::now();
    let ground = Ground::new(&pair, Direction::Forward);
    time("ground", t);
    let t = Instant::now();
    let blend = Blend::new(
        &ground,
        &ground.grown(
            &ground.linked(),
            uvgraft::blend::Growth::Length(a.get(8).map_or(0.0, |v| v.parse().unwrap())),
        ),
        BlendOptions {
            feather: a[5].parse().unwrap(),
            membrane: (a[6] == "m").then_some(Tone::Base),
        },
    )
    .unwrap();
    time("blend", t);
    let t = Instant::now();
    let transfer = Transfer::new(
        &pair,
        Direction::Forward,
        face.size(),
        base.size(),
        &TransferOptions { filter: Filter::Bilinear, ..Default::default() },
    );
    time("transfer", t);
    let t = Instant::now();
    let at = blend.on(transfer.map());
    time("on map", t);
    for _ in 0..5 {
        let t = Instant::now();
        let toning = blend.toning(&face, &base, Encoding::Srgb);
        time("toning", t);
        let s = face.clone();
        let b = base.clone();
        let t = Instant::now();
        let plain = transfer.apply(s, b).unwrap();
        time("plain", t);
        drop(plain);
        let s = face.clone();
        let b = base.clone();
        let t = Instant::now();
        let overlay = transfer.overlay(s, base.format()).unwrap().blended(&at, toning.as_ref());
        time("overlay", t);
        let t = Instant::now();
        let out = overlay.lay(0, b).unwrap();
        time("lay", t);
        image::write(&out.into(), Path::new(&a[7]), &Default::default()).unwrap();
    }
    image::write(
        &at.weights(transfer.map()).into(),
        Path::new("/tmp/weights.png"),
        &Default::default(),
    )
    .unwrap();
}
