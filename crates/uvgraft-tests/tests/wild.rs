//! The demo's figure as compressed by other programs, compared with the plain file.

#![expect(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::path::Path;

use uvgraft::{Size, Texture};
use uvgraft_figure::{Figure, paint_body};
use uvgraft_gltf::glb::{AvatarMaterial, EmbeddedFormat, EmbeddedImage, Export, write};
use uvgraft_gltf::scene::{PoseRequest, Scene, whole};
use uvgraft_metrics::{Colors, ssim};
use uvgraft_render::{Bounds, Perspective, RenderOptions, Renderer};
use uvgraft_tests::gltf_transform::GltfTransform;

const SIZE: Size = Size::new(300, 400);
/// Draco keeps 14 bits per position in the body's box, a ninth of a millimetre; WebP has quality 80.
const MIN_SSIM: f64 = 0.99;

/// The figure in the middle of its wave, and its head.
fn pictures(path: &Path) -> Vec<Texture> {
    let scene = Scene::load(path).unwrap();
    let renderer = Renderer::for_scene(&scene);
    let clip = scene.clips().iter().position(|clip| clip.name == "wave");
    let posing = PoseRequest { clip: clip.map(|clip| (clip, 1.0)), ..PoseRequest::default() };
    let drawn = scene.pose(&posing).unwrap();
    let all = drawn.iter().flat_map(|piece| piece.positions.iter().copied());
    let around = scene.extent("head", &posing).unwrap();
    let options = RenderOptions { floor: Some(0.0), ..RenderOptions::default() };
    [Bounds::of(all), Bounds::of(around.points)]
        .map(|bounds| {
            let camera = Perspective::framing(&bounds.unwrap(), 20.0, 7.0, 24.0, 0.75, 1.0);
            renderer.render(&drawn, &camera, &options, SIZE)
        })
        .to_vec()
}

#[test]
fn compressed_files_look_like_plain_ones() {
    let Some(program) = GltfTransform::find() else { return };
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.glb");
    let color = paint_body(&Figure::new(), Size::square(1024));
    let color = EmbeddedImage::encode(color, EmbeddedFormat::Png, 90).unwrap();
    let file =
        write(&Figure::new().avatar(), &AvatarMaterial::new(color), &Export::default()).unwrap();
    std::fs::write(&plain, file.bytes).unwrap();
    let wanted = pictures(&plain);
    for (command, name) in [
        ("draco", "draco.glb"),
        ("meshopt", "meshopt.glb"),
        ("webp", "webp.glb"),
        ("copy", "copy.gltf"),
    ] {
        let path = folder.path().join(name);
        program.run(command, &plain, &path);
        // The file, and its form for embedding in a page.
        let page = folder.path().join(format!("{name}.page.glb"));
        std::fs::write(&page, whole(&path).unwrap()).unwrap();
        for path in [path, page] {
            for (ours, theirs) in wanted.iter().zip(pictures(&path)) {
                let [ours, theirs] = [ours.clone(), theirs].map(|t| Colors::new(t).unwrap());
                let likeness = ssim(&ours, &theirs, None).unwrap();
                assert!(likeness >= MIN_SSIM, "{}: SSIM {likeness}", path.display());
            }
        }
    }
}
