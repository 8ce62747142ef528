//! The contact sheet: each photograph with its landmarks and the fitted head, what is known, the
//! texture, and the result from three sides.

use glam::DVec3;
use uvgraft::{
    Averaging, Channels, Depth, Encoding, Filter, Mesh, Size, Texels, Texture, TextureError,
};
use uvgraft_pipeline::{Blame, Result};
use uvgraft_render::{Shading, View, render};
use uvgraft_selfie::depth_map::DepthMap;

use super::fitted::FittedSelfie;
use super::photo::Photo;
use super::window::Bounds;
use crate::drawing::{Pen, Sheet};
use crate::pair_picture::{BACKGROUND, MARGIN};

/// Side of a panel, and the height of the text above it.
const PANEL: u32 = 480;
const CAPTION: u32 = 28;
const COLUMNS: u32 = 4;
const TEXT: [u8; 3] = [236, 238, 242];

/// Sides from which the result is shown, in degrees.
const AZIMUTHS: [f32; 3] = [0.0, 20.0, 35.0];

/// A picture with its caption.
type Panel = (String, Texture);

impl FittedSelfie {
    /// Draws the contact sheet.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn sheet(&self) -> Result<Texture> {
        sheet(self)
    }
}

fn sheet(selfie: &FittedSelfie) -> Result<Texture> {
    let (mut originals, mut fits) = (Vec::new(), Vec::new());
    for (index, photo) in selfie.photos.iter().enumerate() {
        let view = PhotoView::new(photo);
        let name = |what: &str| match selfie.photos.len() {
            1 => what.to_owned(),
            _ => format!("{} {what}", index + 1),
        };
        if index == 0 {
            originals.push((name("photograph"), view.picture(&selfie.pixels[index]).or_work()?));
        }
        fits.push((name("landmarks"), view.landmarks(photo, &selfie.pixels[index])?));
        fits.push((name("fitted head"), view.fitted(selfie, index)?));
    }
    let share = format!("known: {:.0} % of the face", 100.0 * selfie.known_share());
    let known = (share, known(selfie)?);
    let texture = ("texture".to_owned(), panel_of(&selfie.textured.texture).or_work()?);
    let mut results = results(selfie)?;
    let blocks = if let [_] = &*selfie.photos {
        originals.extend(fits);
        originals.push(known);
        results.insert(0, texture);
        vec![originals, results]
    } else {
        originals.extend([known, texture]);
        vec![fits, originals, results]
    };
    arranged(blocks).into_texture()
}

/// Arranges panels in rows; each block begins a row.
fn arranged(blocks: Vec<Vec<Panel>>) -> Sheet {
    let rows: u32 = blocks.iter().map(|block| (block.len() as u32).div_ceil(COLUMNS)).sum();
    let size =
        Size::new(COLUMNS * (PANEL + MARGIN) + MARGIN, rows * (PANEL + CAPTION + MARGIN) + MARGIN);
    let mut sheet = Sheet::new(size, BACKGROUND);
    let mut first_row = 0;
    for block in blocks {
        let rows = (block.len() as u32).div_ceil(COLUMNS);
        for (index, (caption, panel)) in (0u32..).zip(block) {
            let left = MARGIN + index % COLUMNS * (PANEL + MARGIN);
            let top = MARGIN + (first_row + index / COLUMNS) * (PANEL + CAPTION + MARGIN);
            sheet.text(&caption, left, top, 2, TEXT);
            sheet.paste(&panel, left, top + CAPTION);
        }
        first_row += rows;
    }
    sheet
}

/// The square of a photograph that a panel shows.
struct PhotoView {
    /// Its first column and row in the photograph's window, and its side.
    first: [i64; 2],
    side: u32,
}

impl PhotoView {
    fn new(photo: &Photo) -> Self {
        /// Side of the panel, in sides of the face.
        const AROUND: f64 = 1.9;
        let of_window = |&[x, y, z]: &[f64; 3]| {
            let [x, y] = photo.window.point([x, y]);
            [x, y, z]
        };
        let points: Vec<[f64; 3]> = photo.landmarks.points.iter().map(of_window).collect();
        let Bounds { low, high } = Bounds::of(&points);
        let side = (AROUND * (high[0] - low[0]).max(high[1] - low[1])).ceil().max(1.0);
        // Hair needs more room than the neck.
        let shift = [0.0, 0.06 * side];
        let first = [0, 1].map(|k| (0.5 * (low[k] + high[k] - side) - shift[k]).round() as i64);
        Self { first, side: side as u32 }
    }

    /// A position in the photograph as one in the panel.
    fn point(&self, photo: &Photo, at: [f64; 2]) -> [f64; 2] {
        let scale = f64::from(PANEL) / f64::from(self.side);
        let at = photo.window.point(at);
        [0, 1].map(|k| (at[k] - self.first[k] as f64) * scale)
    }

    /// The photograph in the panel.
    fn picture(&self, pixels: &Texture) -> std::result::Result<Texture, TextureError> {
        let size = pixels.size();
        let Texels::U8(values) = pixels.texels() else { unreachable!("windows have 8 bits") };
        let side = i64::from(self.side);
        let mut square = Vec::with_capacity((side * side * 3) as usize);
        for y in self.first[1]..self.first[1] + side {
            for x in self.first[0]..self.first[0] + side {
                let is_inside =
                    (0..size.width.into()).contains(&x) && (0..size.height.into()).contains(&y);
                let at = (y * i64::from(size.width) + x) * 3;
                let color =
                    if is_inside { &values[at as usize..at as usize + 3] } else { &BACKGROUND };
                square.extend_from_slice(color);
            }
        }
        let texels = Texels::U8(square);
        let square = Texture::new(Size::square(self.side), Channels::Rgb, Encoding::Srgb, texels)?;
        panel_of(&square)
    }

    fn landmarks(&self, photo: &Photo, pixels: &Texture) -> Result<Texture> {
        let mut panel = Sheet::new(Size::square(PANEL), BACKGROUND);
        panel.paste(&self.picture(pixels).or_work()?, 0, 0);
        let points = photo.landmarks.points.iter().map(|&[x, y, _]| self.point(photo, [x, y]));
        panel.draw(|canvas| canvas.dots(points, 1.4, [90, 255, 120], 235))?;
        panel.into_texture()
    }

    /// The fitted head's edges over the photograph.
    fn fitted(&self, selfie: &FittedSelfie, index: usize) -> Result<Texture> {
        let (photo, fitted) = (&selfie.photos[index], &selfie.fit.photos[index]);
        let projected: Vec<[f64; 3]> = fitted
            .posed
            .iter()
            .map(|&at| {
                let [x, y, depth] = fitted.camera.project(at);
                let [x, y] = self.point(photo, [x, y]);
                [x, y, depth]
            })
            .collect();
        let mut panel = Sheet::new(Size::square(PANEL), BACKGROUND);
        panel.paste(&self.picture(&selfie.pixels[index]).or_work()?, 0, 0);
        let lines = seen_edges(selfie.head.mesh(), &projected, selfie.head.unit());
        panel.draw(|canvas| {
            let mut edges = canvas.lines();
            lines.iter().for_each(|&ends| edges.add(ends));
            let pen = Pen::flat([120, 220, 255], 110, 0.8);
            canvas.draw(edges, pen);
        })?;
        panel.into_texture()
    }
}

/// The edges of a mesh that nothing hides.
///
/// - `projected`: `[vertices]` in pixels of a panel, with distances.
fn seen_edges(mesh: &Mesh, projected: &[[f64; 3]], unit: f64) -> Vec<[[f64; 2]; 2]> {
    /// How far behind the nearest surface an edge of that surface may be, in eye distances.
    const BEHIND: f64 = 0.08;
    let map = DepthMap::new(Size::square(PANEL), projected, mesh.faces());
    let is_seen = |vertex: u32| {
        let [x, y, depth] = projected[vertex as usize];
        let nearest = f64::from(map.depth(x.floor() as i64, y.floor() as i64));
        depth > 0.0 && nearest.is_finite() && depth - nearest < BEHIND * unit
    };
    let mut lines = Vec::new();
    for polygon in 0..mesh.polygon_count() {
        let corners = mesh.polygon_corners(polygon);
        for (k, corner) in corners.iter().enumerate() {
            let (a, b) = (corner.vertex, corners[(k + 1) % corners.len()].vertex);
            // Most edges are in two polygons, once in each direction.
            if a < b && is_seen(a) && is_seen(b) {
                lines.push([a, b].map(|vertex| {
                    let [x, y, _] = projected[vertex as usize];
                    [x, y]
                }));
            }
        }
    }
    lines
}

/// The texture, darkened where it is not known.
fn known(selfie: &FittedSelfie) -> Result<Texture> {
    let color = panel_of(&selfie.textured.texture).or_work()?;
    let known = panel_of(&selfie.textured.known).or_work()?;
    let (Texels::U8(color), Texels::U8(known)) = (color.into_texels(), known.into_texels()) else {
        unreachable!("panels have 8 bits")
    };
    let texels = color.chunks_exact(3).zip(known.chunks_exact(3)).flat_map(|(color, known)| {
        let share = f32::from(known[0]) / 255.0;
        // Blue is far from any skin.
        let unknown = [30.0, 50.0, 110.0];
        [0, 1, 2].map(|k| (unknown[k] + (f32::from(color[k]) - unknown[k]) * share) as u8)
    });
    let texels = Texels::U8(texels.collect());
    Texture::new(Size::square(PANEL), Channels::Rgb, Encoding::Srgb, texels).or_work()
}

/// A texture of any size as a panel.
fn panel_of(texture: &Texture) -> std::result::Result<Texture, TextureError> {
    let small =
        texture.clone().resized(Size::square(PANEL), Filter::Lanczos3, Averaging::Encoded)?;
    Ok(small.converted(Channels::Rgb, Depth::U8))
}

/// The textured head from each side.
fn results(selfie: &FittedSelfie) -> Result<Vec<Panel>> {
    let frame = selfie.head.anatomy().frame();
    let local = |at: &DVec3| frame.local(at.to_array()).map(|value| value as f32);
    // In eye distances, facing the camera.
    let positions = selfie.fit.shaped.iter().map(local).collect();
    let mesh = selfie.head.mesh().clone().with_positions(positions).or_work()?;
    let shot = |azimuth| {
        let (target, height) = ([0.0, -0.2, -1.0], 5.2);
        let view = View { azimuth, elevation: 0.0, target, height, floor: false };
        let texture = &selfie.textured.texture;
        let picture = render(&mesh, texture, |_| Shading::Matt, &view, Size::square(PANEL));
        (format!("result at {azimuth}\u{b0}"), picture)
    };
    Ok(AZIMUTHS.map(shot).into())
}
