//! Benchmarks of the renderer: pictures of the built-in figure, and a further frame of a clip.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use uvgraft::Size;
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::glb::{self, AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export};
use uvgraft_gltf::scene::{PoseRequest, PosedPrimitive, Scene};
use uvgraft_render::{Bounds, Perspective, RenderOptions, Renderer};

/// The figure with a painted texture, as `uvgraft render` reads it.
fn scene() -> Scene {
    let figure = Figure::new();
    let texture = paint_body(&figure, Size::square(2048));
    let picture = EmbeddedImage::encode(texture, EmbeddedFormat::Png, 90).expect("a sound texture");
    let materials = [AvatarMaterial::new(picture)];
    let file = glb::write(&figure.avatar(), &materials, &Export::default());
    Scene::read(&file.expect("a sound avatar").bytes).expect("a sound file")
}

/// A camera that shows everything above a height.
fn camera(drawn: &[PosedPrimitive], above: f32, size: Size) -> Perspective {
    let points = drawn.iter().flat_map(|piece| piece.positions.iter().copied());
    let bounds = Bounds::of(points.filter(|p| p[1] > above)).expect("a figure");
    let aspect = size.width as f32 / size.height as f32;
    Perspective::framing(&bounds, 20.0, 7.0, 24.0, aspect, 1.0)
}

fn pictures(criterion: &mut Criterion) {
    let scene = scene();
    let renderer = Renderer::for_scene(&scene);
    let drawn = scene.pose(&PoseRequest::default()).expect("a sound pose");
    let floor = RenderOptions { floor: Some(0.0), ..RenderOptions::default() };
    let bare = RenderOptions::default();
    let thumbnail = RenderOptions { samples: 2, ..bare };

    let mut group = criterion.benchmark_group("picture");
    group.sample_size(10);
    for (name, above, options, size) in [
        ("head, 1024 x 1024", 1.48, &bare, Size::square(1024)),
        ("body, 768 x 1024", f32::MIN, &floor, Size::new(768, 1024)),
        ("thumbnail, 256 x 256", 1.48, &thumbnail, Size::square(256)),
    ] {
        let camera = camera(&drawn, above, size);
        group.throughput(Throughput::Elements(size.texels() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| renderer.render(&drawn, &camera, options, size));
        });
    }

    // A further frame: the textures are prepared, everything else changes with the pose.
    let size = Size::new(300, 450);
    let camera = camera(&drawn, f32::MIN, size);
    let clip = scene.clips().iter().position(|clip| clip.name == "walk").expect("a clip");
    let mut frames = (0..25_u8).cycle();
    group.throughput(Throughput::Elements(size.texels() as u64));
    group.bench_function("further frame of a clip, 300 x 450", |bencher| {
        bencher.iter(|| {
            let seconds = frames.next().map_or(0.0, |frame| f32::from(frame) / 25.0);
            let request = PoseRequest { clip: Some((clip, seconds)), ..PoseRequest::default() };
            let drawn = scene.pose(&request).expect("a sound pose");
            renderer.render(&drawn, &camera, &floor, size)
        });
    });
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
