//! From photographs to a fitted head and its texture.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use uvgraft::{Area, Mesh, Size, Texture, threads};
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_pipeline::{Blame, Failure, Fault, Observer, Result};
use uvgraft_selfie::landmarks::FaceNetworks;
use uvgraft_selfie::{
    Fit, Head, HeadError, ModelSpace, PhotoLandmarks, Pixels, SelfieTexture, TextureOptions,
    textured,
};

use super::frames::Frames;
use super::networks;
use super::photo::Photo;
use super::request::PhotoOptions;
use super::tracked;

/// A head fitted to photographs, and its texture.
pub struct FittedSelfie {
    /// What to call the head.
    pub(super) name: String,
    pub(crate) head: Head,
    pub(crate) photos: Vec<Photo>,
    /// The pixels around the face in each photograph: 8-bit RGB.
    pub(super) pixels: Vec<Texture>,
    /// In pixels of whole photographs.
    pub(crate) fit: Fit,
    pub(crate) textured: SelfieTexture,
}

/// The head to fit.
pub(crate) struct GivenHead {
    pub(crate) mesh: Mesh,
    /// What to call it in messages.
    pub(crate) name: String,
    /// The model that it is of, for its shapes and expressions, and for the parameters of tracked videos.
    pub(crate) flame: Option<BodyModel>,
}

/// Number of pixels that are kept of all photographs together.
const MOST_PIXELS: usize = 64_000_000;

impl FittedSelfie {
    /// - `size`: of the texture.
    ///
    /// # Errors
    /// As bad input if networks were not imported, if the mesh has no head, and for photographs
    /// that are of no use.
    pub(crate) fn new(
        given: GivenHead,
        frames: &Frames,
        options: &PhotoOptions,
        size: Size,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let networks = networks::load(&options.networks)?;
        let GivenHead { mesh, name, flame } = given;
        let texture = options.usual_texture(&mesh)?;
        let is_refused = Arc::new(AtomicBool::new(false));
        let (photos, head) = threads::join(
            || {
                let photos = read(frames, &networks, options, observer);
                is_refused.store(photos.is_err(), Ordering::Relaxed);
                photos
            },
            || {
                let (of_drawings, is_refused) = (networks.clone(), Arc::clone(&is_refused));
                // Without photographs, the head is not needed, and nobody should wait for it.
                let detect = move |drawing: &Texture| {
                    if is_refused.load(Ordering::Relaxed) {
                        return None;
                    }
                    networks::of_drawing(&of_drawings, drawing)
                };
                Head::new(mesh, texture.as_ref(), networks.canonical(), Arc::new(detect))
            },
        );
        let (photos, pixels) = photos?;
        let head = head.map_err(|error| no_head(&name, &error))?;
        let space =
            flame.as_ref().map(|model| model_space(model, head.mesh())).transpose()?.flatten();
        let head = match space {
            Some(space) => head.with_model(space),
            None => head,
        };
        observer.begin("fitting the head to the photographs")?;
        let fit = fitted(&head, &photos, &pixels, flame.as_ref())?.ok_or_else(|| {
            Failure::input(format!("{name}: its head does not fit the face in the photographs"))
        })?;
        let windows =
            photos.iter().zip(&fit.photos).map(|(photo, fitted)| photo.window.fitted(fitted));
        let of_windows = Fit { shaped: fit.shaped.clone(), photos: windows.collect() };
        observer.begin("making the texture")?;
        let mut texturing = TextureOptions::default();
        (texturing.size, texturing.relight) = (size, options.relight);
        let textured = textured(&head, &of_windows, &pixels, &texturing).or_input()?;
        Ok(Self { name, head, photos, pixels, fit, textured })
    }

    /// The texture, in the head's UV layout.
    pub fn texture(&self) -> &Texture {
        &self.textured.texture
    }

    /// What the photographs show of the texture: grey, white where a texel is known fully.
    pub fn known(&self) -> &Texture {
        &self.textured.known
    }

    /// What to call the first photograph in messages.
    pub(crate) fn first_photo(&self) -> &Path {
        self.photos.first().map_or(Path::new(""), |photo| &photo.name)
    }

    /// The mesh with the fitted shape.
    ///
    /// # Errors
    /// If a position is not finite.
    pub fn shaped_mesh(&self) -> Result<Mesh> {
        let positions = self.fit.shaped.iter().map(|at| at.as_vec3().to_array()).collect();
        self.head.mesh().clone().with_positions(positions).or_work()
    }

    /// The share of the face's surface that the photographs show, 0 to 1.
    pub fn known_share(&self) -> f64 {
        const FACE: [Area; 7] = [
            Area::Cheeks,
            Area::Forehead,
            Area::Nose,
            Area::Jaw,
            Area::Lips,
            Area::EyeSockets,
            Area::Brows,
        ];
        let (mesh, known) = (self.head.mesh(), &self.textured.known);
        let of_vertex = |vertex: u32| {
            let weight = |area| self.head.anatomy().area(area)[vertex as usize];
            FACE.into_iter().map(weight).fold(0.0, f32::max)
        };
        let size = known.size();
        let (mut seen, mut total) = (0.0, 0.0);
        for (face, corners) in mesh.faces().iter().enumerate() {
            let weight = corners.iter().map(|&vertex| of_vertex(vertex)).fold(1.0, f32::min);
            let [a, b, c] =
                corners.map(|vertex| glam::Vec3::from(mesh.positions()[vertex as usize]));
            let area = f64::from((b - a).cross(c - a).length() * weight);
            let uv = mesh.uv_triangle(face);
            let at = |axis: usize, side: u32| {
                let middle = (uv[0][axis] + uv[1][axis] + uv[2][axis]) / 3.0;
                ((middle * side as f32) as u32).min(side - 1)
            };
            total += area;
            seen += area * f64::from(known.get(at(0, size.width), at(1, size.height), 0));
        }
        if total > 0.0 { seen / total } else { 0.0 }
    }
}

/// Reads photographs one after the other, because only a part of each is kept.
fn read(
    frames: &Frames,
    networks: &FaceNetworks,
    options: &PhotoOptions,
    observer: &dyn Observer,
) -> Result<(Vec<Photo>, Vec<Texture>)> {
    let most = MOST_PIXELS / frames.iter().count().max(1);
    let photos = frames.iter().map(|frame| {
        observer.begin("finding the face")?;
        Photo::read(frame, networks, options, most, observer)
    });
    if let Frames::Files(_) = frames {
        return photos.collect();
    }
    let (mut usable, mut refused) = (Vec::new(), Vec::new());
    for photo in photos {
        match photo {
            Ok(photo) => usable.push(photo),
            Err(error) if error.fault() == Fault::Cancelled => return Err(error),
            Err(error) => refused.push(error),
        }
    }
    if usable.is_empty()
        && let Some(error) = refused.pop()
    {
        return Err(error);
    }
    refused.iter().for_each(|error| observer.warn(format_args!("frame left out: {error}")));
    Ok(usable.into_iter().unzip())
}

/// The fit by a tracker's parameters where they are known, and else by landmarks.
fn fitted(
    head: &Head,
    photos: &[Photo],
    pixels: &[Texture],
    flame: Option<&BodyModel>,
) -> Result<Option<Fit>> {
    if let Some(model) = flame
        && let Some(fit) = tracked::fit(head, model, photos)?
    {
        return Ok(Some(fit));
    }
    let landmarks: Vec<PhotoLandmarks> = photos.iter().map(Photo::centered).collect();
    let pixels: Vec<Pixels<'_>> =
        photos.iter().zip(pixels).map(|(photo, pixels)| photo.centered_pixels(pixels)).collect();
    Ok(Fit::new(head, &landmarks, &pixels).map(|fit| {
        let photos = photos.iter().zip(fit.photos);
        let photos = photos.map(|(photo, fitted)| photo.uncentered(fitted)).collect();
        Fit { photos, ..fit }
    }))
}

/// The first shapes and expressions of a model; `None` if the mesh is not the model at rest.
fn model_space(model: &BodyModel, mesh: &Mesh) -> Result<Option<ModelSpace>> {
    /// Numbers of coefficients: what 468 landmarks can tell, most of all.
    const SHAPES: usize = 60;
    const EXPRESSIONS: usize = 40;
    /// A difference that is rounding, in metres.
    const SAME: f32 = 1e-4;
    let positions = |shape: &Shape| {
        let shaped = model.shaped(shape).or_input()?;
        let wide = |at: &[f32; 3]| glam::Vec3::from(*at).as_dvec3();
        Ok::<_, Failure>(shaped.positions().iter().map(wide).collect::<Vec<DVec3>>())
    };
    let rest = positions(&Shape::default())?;
    let is_same =
        |(at, rest): (&[f32; 3], &DVec3)| glam::Vec3::from(*at).distance(rest.as_vec3()) < SAME;
    let given = mesh.positions();
    if given.len() != rest.len() || !given.iter().zip(&rest).all(is_same) {
        return Ok(None);
    }
    let moved = |shape: &Shape| {
        let moved = positions(shape)?;
        Ok::<_, Failure>(moved.into_iter().zip(&rest).map(|(at, rest)| at - rest).collect())
    };
    let only = |index: usize| {
        let mut coefficients = vec![0.0; index + 1];
        coefficients[index] = 1.0;
        coefficients
    };
    let shapes = (0..model.betas().min(SHAPES))
        .map(|index| moved(&Shape { betas: only(index), ..Shape::default() }));
    let expressions = (0..model.expressions().min(EXPRESSIONS))
        .map(|index| moved(&Shape { expression: only(index), ..Shape::default() }));
    Ok(Some(ModelSpace {
        shapes: shapes.collect::<Result<_>>()?,
        expressions: expressions.collect::<Result<_>>()?,
    }))
}

fn no_head(name: &str, error: &HeadError) -> Failure {
    Failure::input(format!("{name}: the mesh must have a head with a face: {error}"))
}
