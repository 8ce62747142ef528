#![allow(missing_docs)]
// shots OUT.png GLB x,y,z dist fov BG W H rows: "az,el[;expr=w]*" ...
use uvgraft::Size;
use uvgraft_avatar::render::{Background, Look, Perspective, Renderer};
use uvgraft_avatar::scene::{Posing, Scene};
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let scene = Scene::read(&std::fs::read(&a[1]).unwrap()).unwrap();
    let renderer = Renderer::of(&scene);
    let f = |t: &str| -> Vec<f32> { t.split(',').map(|x| x.parse().unwrap()).collect() };
    let t = f(&a[2]);
    let d: f32 = a[3].parse().unwrap();
    let fov: f32 = a[4].parse().unwrap();
    let (w, h): (u32, u32) = (a[6].parse().unwrap(), a[7].parse().unwrap());
    let mut cells = Vec::new();
    for shot in &a[8..] {
        let mut parts = shot.split(';');
        let view = f(parts.next().unwrap());
        let weights = parts
            .map(|p| {
                let (n, w) = p.split_once('=').unwrap();
                (n.to_owned(), w.parse().unwrap())
            })
            .collect();
        let (az, el) = (view[0].to_radians(), view[1].to_radians());
        let eye =
            [t[0] + d * el.cos() * az.sin(), t[1] + d * el.sin(), t[2] + d * el.cos() * az.cos()];
        let cam = Perspective {
            eye,
            target: [t[0], t[1], t[2]],
            up: [0.0, 1.0, 0.0],
            fov_y: fov,
            near: 0.01,
            far: 50.0,
        };
        let mut look = Look::default();
        if a[5] == "m" {
            look.background = Background::Plain([255, 0, 255]);
        }
        let pose = scene.pose(&Posing { weights, ..Posing::default() }).unwrap();
        cells.push(renderer.render(&pose, &cam, &look, Size::new(w, h)));
    }
    for (k, c) in cells.into_iter().enumerate() {
        let path = std::path::PathBuf::from(format!("{}.{k}.png", a[0]));
        uvgraft_io::image::write(&c.into(), &path, &uvgraft_io::image::WriteOptions::default())
            .unwrap();
    }
}
