use std::path::Path;
use uvgraft::*;
use uvgraft_avatar::render::{View, render};
// pair out height ty tex...
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let pair = uvgraft_io::pair_file::read(Path::new(&a[1])).unwrap().pair;
    let mesh = pair.target();
    let (mut lo, mut hi) = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in mesh.positions() {
        for k in 0..3 {
            lo[k] = lo[k].min(p[k]);
            hi[k] = hi[k].max(p[k]);
        }
    }
    println!("{lo:?} {hi:?}");
    let h: f32 = a[3].parse().unwrap();
    let down: f32 = a[4].parse().unwrap();
    let s = 560u32;
    let mut strip = vec![0u8; (s * s * 3 * 3) as usize * (a.len() - 5)];
    let w = (s * 3) as usize;
    for (row, t) in a[5..].iter().enumerate() {
        let tex = uvgraft_io::image::read(Path::new(t)).unwrap().texture;
        for (col, az) in [0.0f32, 40.0, 110.0].into_iter().enumerate() {
            let view = View {
                azimuth: az,
                elevation: 2.0,
                target: [0.0, hi[1] - down, (lo[2] + hi[2]) * 0.5],
                height: h,
                floor: false,
            };
            let img = render(mesh, &tex, &view, Size::square(s));
            let Texels::U8(v) = img.texels() else { panic!() };
            for y in 0..s as usize {
                let o = ((row * s as usize + y) * w + col * s as usize) * 3;
                strip[o..o + s as usize * 3]
                    .copy_from_slice(&v[y * s as usize * 3..(y + 1) * s as usize * 3]);
            }
        }
    }
    let t = Texture::new(
        Size::new(w as u32, s * (a.len() - 5) as u32),
        Channels::Rgb,
        Encoding::Srgb,
        Texels::U8(strip),
    )
    .unwrap();
    let _ = uvgraft_io::image::write(&t.into(), Path::new(&a[2]), &Default::default()).unwrap();
}
