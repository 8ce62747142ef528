//! Faces and bodies to test with: painted ones, and real ones where available.

use std::path::Path;
use std::sync::Arc;

use uvgraft::{BlendOptions, Graft, Pair, Size, Sizes, Texture, Tone};
use uvgraft_figure::Figure;
use uvgraft_image as image;

use super::measure::{Bench, Case, Figures};
use super::{BodyFrame, BodyLook, FaceLook, HeadFrame, Labels, LayoutSpots, frame};
use crate::real;

/// Size of painted faces.
pub const FACE: Size = Size::square(512);
/// Size of bodies.
pub const BODY: Size = Size::square(1024);

/// A face or a body, with its true labels if known.
pub struct Subject {
    /// Name in tables.
    pub name: String,
    /// Its texture.
    pub texture: Texture,
    /// True labels, if it was painted.
    pub truth: Option<Labels>,
    /// For faces, the index of the pair that transfers them.
    pub pair: usize,
}

/// Pairs, landmarks, faces and bodies; real ones where available.
pub fn subjects() -> (Vec<Arc<Pair>>, BodyFrame, Vec<Subject>, Vec<Subject>) {
    let folder = real::folder();
    let (mut pairs, frame, head) = match real::flame_to_smplx() {
        Some(pair) => (vec![pair], BodyFrame::SMPLX, HeadFrame::FLAME),
        None => (vec![frame::figure_pair(&Figure::new())], BodyFrame::FIGURE, HeadFrame::FIGURE),
    };
    let (mut faces, mut bodies) = (Vec::new(), Vec::new());
    if let Some(folder) = &folder {
        pairs.push(hifi3d_pair(folder));
        for (name, file, pair) in [
            ("captured", "flame_face_texture.png", 0),
            ("mean", "flame_mean_texture.jpg", 0),
            ("hifi3d", "hifi3d_face_texture.png", 1),
        ] {
            faces.push(Subject { pair, ..subject(name, read(&folder.join(file))) });
        }
        for (name, file) in [("medium, real", "body_medium.jpg"), ("light, real", "body_light.jpg")]
        {
            let texture = read(&folder.join(file));
            let smaller =
                texture.resized(BODY, uvgraft::Filter::Lanczos3, uvgraft::Averaging::Encoded);
            bodies.push(subject(name, smaller.expect("memory for a texture")));
        }
    }
    let layout = LayoutSpots::new(pairs[0].source(), FACE);
    for look in FaceLook::all() {
        let painted = look.paint(pairs[0].source(), &head, &layout);
        let truth = Some(painted.truth);
        faces.push(Subject { truth, ..subject(look.name, painted.texture) });
    }
    let layout = LayoutSpots::new(pairs[0].target(), BODY);
    for look in BodyLook::all() {
        let painted = look.paint(pairs[0].target(), &frame, &layout);
        let truth = Some(painted.truth);
        bodies.push(Subject { truth, ..subject(look.name, painted.texture) });
    }
    (pairs, frame, faces, bodies)
}

fn subject(name: &str, texture: Texture) -> Subject {
    Subject { name: name.to_owned(), texture, truth: None, pair: 0 }
}

/// FLAME with HiFi3D's layout: the same triangles in the same order, but other UVs.
fn hifi3d_pair(folder: &Path) -> Arc<Pair> {
    let mesh = |name: &str| uvgraft_io::obj::read(folder.join(name)).expect("a sound mesh");
    let ids = uvgraft_io::vertex_map::read(folder.join("smplx_flame_vertex_ids.npy"));
    let pair = Pair::by_vertex_map(
        mesh("flame_hifi3d_uv.obj"),
        mesh("smplx_addon.obj"),
        &ids.expect("a sound vertex map"),
    );
    Arc::new(pair.expect("a head that is part of the body"))
}

/// A transfer of a face to a body.
#[derive(Debug)]
pub struct Outcome {
    /// The face laid over without blending.
    pub paste: Texture,
    /// The face blended in.
    pub result: Texture,
    /// Measurements of the blended result.
    pub figures: Figures,
}

/// Runs the transfer as users do, and measures it.
pub fn transfer(
    pair: &Arc<Pair>,
    bench: &Bench,
    face: &Subject,
    transferred: Option<&Labels>,
    body: &Subject,
    tone: Tone,
) -> Outcome {
    let sizes = Sizes { from: face.texture.size(), to: BODY };
    let plain = Graft::builder(Arc::clone(pair), sizes).build().expect("sound sizes");
    let paste = plain.apply(&face.texture, &body.texture).expect("textures of these sizes");
    let options = BlendOptions::default().feather(0.01).membrane().tone(tone);
    let graft = Graft::builder(Arc::clone(pair), sizes).blend(options).build().expect("a region");
    let toning = graft.toning(&face.texture, &body.texture, body.texture.format());
    let toning = toning.unwrap_or_default();
    let overlay =
        graft.overlay(&face.texture, body.texture.format()).expect("a texture of that size");
    let overlay = match &toning {
        Some(toning) => overlay.with_tone(toning).expect("found for it"),
        None => overlay,
    };
    let result = overlay.lay(0, body.texture.clone()).expect("a base of that size");
    let narrowed = toning.as_ref().and_then(|toning| toning.narrowed());
    let blend = narrowed.or(graft.blend()).expect("a blend");
    let region = blend.cut().expect("a mesh of that size");
    let figures = bench.measure(&Case {
        face: transferred,
        body: body.truth.as_ref(),
        base: &body.texture,
        paste: &paste,
        result: &result,
        region: &region,
    });
    Outcome { paste, result, figures }
}

fn read(path: &Path) -> Texture {
    image::read(path).expect("a sound image").texture
}
