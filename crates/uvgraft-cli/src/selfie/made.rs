//! From photographs to a fitted head and its texture.

use std::sync::Arc;

use glam::DVec3;
use uvgraft::{Area, Mesh, Size, Texture};
use uvgraft_avatar::body::{BodyModel, Shape};
use uvgraft_selfie::landmarks::FaceNetworks;
use uvgraft_selfie::{
    Fit, Head, HeadError, ModelSpace, PhotoLandmarks, Pixels, SelfieTexture, TextureOptions,
    textured,
};

use super::frames::Frames;
use super::networks;
use super::options::PhotoArgs;
use super::photo::Photo;
use super::tracked;
use crate::failure::{OrBadInput, bad_input, warn};

/// A head fitted to photographs, and its texture.
pub(crate) struct Selfie {
    pub(crate) head: Head,
    pub(crate) photos: Vec<Photo>,
    /// The pixels around the face in each photograph: 8-bit RGB.
    pub(super) pixels: Vec<Texture>,
    /// In pixels of whole photographs.
    pub(crate) fit: Fit,
    pub(crate) made: SelfieTexture,
}

/// The head to fit.
pub(crate) struct GivenHead<'a> {
    pub(crate) mesh: Mesh,
    /// What to call it in messages.
    pub(crate) name: &'a str,
    /// The model that it is of, for its shapes and expressions, and for the parameters of tracked videos.
    pub(crate) flame: Option<&'a BodyModel>,
}

/// Number of pixels that are kept of all photographs together.
const MOST_PIXELS: usize = 64_000_000;

impl Selfie {
    /// - `size`: of the texture.
    ///
    /// # Errors
    /// As bad input if networks were not imported, if the mesh has no head, and for photographs
    /// that are of no use.
    pub(crate) fn new(
        given: GivenHead<'_>,
        frames: &Frames,
        args: &PhotoArgs,
        size: Size,
    ) -> anyhow::Result<Self> {
        let networks = networks::load()?;
        let GivenHead { mesh, name, flame } = given;
        let texture = args.head_texture(&mesh)?;
        let (head, photos) = rayon::join(
            || {
                let of_drawings = networks.clone();
                let detect = move |drawing: &Texture| networks::of_drawing(&of_drawings, drawing);
                Head::new(mesh, texture.as_ref(), networks.canonical(), Arc::new(detect))
            },
            || read(frames, &networks, args),
        );
        let head = head.map_err(|error| no_head(name, &error))?;
        let space = flame.map(|model| model_space(model, head.mesh())).transpose()?.flatten();
        let head = match space {
            Some(space) => head.with_model(space),
            None => head,
        };
        let (photos, pixels) = photos?;
        let fit = fitted(&head, &photos, &pixels, flame)?.ok_or_else(|| {
            bad_input(format!("{name}: its head does not fit the face in the photographs"))
        })?;
        let windows =
            photos.iter().zip(&fit.photos).map(|(photo, fitted)| photo.window.fitted(fitted));
        let of_windows = Fit { shaped: fit.shaped.clone(), photos: windows.collect() };
        let mut options = TextureOptions::default();
        (options.size, options.relight) = (size, args.relight());
        let made = textured(&head, &of_windows, &pixels, &options).or_bad_input()?;
        Ok(Self { head, photos, pixels, fit, made })
    }

    /// The mesh with the fitted shape.
    pub(crate) fn shaped_mesh(&self) -> anyhow::Result<Mesh> {
        let positions = self.fit.shaped.iter().map(|at| at.as_vec3().to_array()).collect();
        Ok(self.head.mesh().clone().with_positions(positions)?)
    }

    /// The share of the face's surface that the photographs show, 0 to 1.
    pub(crate) fn known_share(&self) -> f64 {
        const FACE: [Area; 7] = [
            Area::Cheeks,
            Area::Forehead,
            Area::Nose,
            Area::Jaw,
            Area::Lips,
            Area::EyeSockets,
            Area::Brows,
        ];
        let (mesh, known) = (self.head.mesh(), &self.made.known);
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
    args: &PhotoArgs,
) -> anyhow::Result<(Vec<Photo>, Vec<Texture>)> {
    let most = MOST_PIXELS / frames.iter().count().max(1);
    let photos = frames.iter().map(|frame| Photo::read(frame, networks, args, most));
    if let Frames::Files(_) = frames {
        return photos.collect();
    }
    let (mut usable, mut refused) = (Vec::new(), Vec::new());
    for photo in photos {
        match photo {
            Ok(photo) => usable.push(photo),
            Err(error) => refused.push(error),
        }
    }
    if usable.is_empty()
        && let Some(error) = refused.pop()
    {
        return Err(error);
    }
    refused.iter().for_each(|error| warn(format_args!("frame left out: {error:#}")));
    Ok(usable.into_iter().unzip())
}

/// The fit by a tracker's parameters where they are known, and else by landmarks.
fn fitted(
    head: &Head,
    photos: &[Photo],
    pixels: &[Texture],
    flame: Option<&BodyModel>,
) -> anyhow::Result<Option<Fit>> {
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
fn model_space(model: &BodyModel, mesh: &Mesh) -> anyhow::Result<Option<ModelSpace>> {
    /// Numbers of coefficients: what 468 landmarks can tell, most of all.
    const SHAPES: usize = 60;
    const EXPRESSIONS: usize = 40;
    /// A difference that is rounding, in metres.
    const SAME: f32 = 1e-4;
    let positions = |shape: &Shape| {
        let shaped = model.shaped(shape).or_bad_input()?;
        let wide = |at: &[f32; 3]| glam::Vec3::from(*at).as_dvec3();
        anyhow::Ok(shaped.positions().iter().map(wide).collect::<Vec<DVec3>>())
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
        anyhow::Ok(moved.into_iter().zip(&rest).map(|(at, rest)| at - rest).collect())
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
        shapes: shapes.collect::<anyhow::Result<_>>()?,
        expressions: expressions.collect::<anyhow::Result<_>>()?,
    }))
}

fn no_head(name: &str, error: &HeadError) -> anyhow::Error {
    bad_input(format!("{name}: the mesh must have a head with a face: {error}"))
}
