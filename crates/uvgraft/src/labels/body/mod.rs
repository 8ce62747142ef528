//! Which texels of a body's texture are skin.
//!
//! Colours alone cannot say: there are shirts in every tone of skin. But skin is connected: it is what one reaches from
//! the face without crossing a step of colour (`steps`, `grow`). Hands, feet, arms and legs that cloth keeps apart
//! from it are skin where their colour agrees closely; what touches skin across a step is cloth whatever its colour
//! (`decide`).

mod decide;
mod grow;
mod steps;

use crate::anatomy::{Anatomy, AnatomyError, Area};
use crate::color::Encoding;
use crate::layout_grid::{GridColors, LayoutGrid, NONE};
use crate::mesh::Mesh;
use crate::skin::{SkinError, SkinModel};
use crate::texture::{Channels, Size, Texels, Texture};
use crate::threads::map_indices;

use decide::Decision;
use steps::Steps;

/// The side of the grid.
const SIDE: u32 = 1024;
/// Colours that a model of skin is made of, at most.
const MOST_COLORS: usize = 3000;

/// The areas of a body that say where skin is and where it is not.
#[derive(Debug, Clone)]
struct Areas {
    /// Cheeks, nose and forehead.
    face: Vec<f32>,
    cheeks: Vec<f32>,
    neck: Vec<f32>,
    hands: Vec<f32>,
    feet: Vec<f32>,
    ears: Vec<f32>,
    scalp: Vec<f32>,
    lips: Vec<f32>,
    mouth: Vec<f32>,
    eyes: Vec<f32>,
    sockets: Vec<f32>,
    brows: Vec<f32>,
}

/// A body mesh and the grid over its whole layout. Made once for a mesh.
#[derive(Debug, Clone)]
pub(crate) struct BodyLayout {
    grid: LayoutGrid,
    areas: Areas,
    /// How far each texel is to the left of the plane of symmetry, in eye distances.
    leftness: Vec<f32>,
    /// How many texels there are.
    covered: usize,
}

impl BodyLayout {
    /// Finds the head, hands and feet.
    ///
    /// # Errors
    /// [`AnatomyError`] if the mesh has no head.
    pub fn new(mesh: &Mesh) -> Result<Self, AnatomyError> {
        let anatomy = Anatomy::find(mesh)?;
        let grid = LayoutGrid::new(mesh, Size::square(SIDE));
        let at = |area: Area| grid.at_texels(mesh, anatomy.area(area));
        let faces = [Area::Cheeks, Area::Nose, Area::Forehead].map(|area| anatomy.area(area));
        let vertices = mesh.positions().len();
        let face: Vec<f32> = (0..vertices)
            .map(|vertex| faces.iter().map(|area| area[vertex]).fold(0.0, f32::max))
            .collect();
        let areas = Areas {
            face: grid.at_texels(mesh, &face),
            cheeks: at(Area::Cheeks),
            neck: at(Area::Neck),
            hands: at(Area::Hands),
            feet: at(Area::Feet),
            ears: at(Area::Ears),
            scalp: at(Area::Scalp),
            lips: at(Area::Lips),
            mouth: at(Area::MouthInterior),
            eyes: at(Area::Eyes),
            sockets: at(Area::EyeSockets),
            brows: at(Area::Brows),
        };
        let frame = anatomy.frame();
        let left = mesh.positions().iter().map(|at| frame.local(at.map(f64::from))[0] as f32);
        let leftness = grid.at_texels(mesh, &left.collect::<Vec<_>>());
        let covered = grid.faces().iter().filter(|&&face| face != NONE).count();
        Ok(Self { grid, areas, leftness, covered })
    }

    /// Whether a texel is of the face or an ear, whose features have edges of their own.
    fn is_feature(&self, texel: usize) -> bool {
        let Areas { face, ears, lips, mouth, eyes, sockets, brows, .. } = &self.areas;
        [face, ears, lips, mouth, eyes, sockets, brows].iter().any(|area| area[texel] > 0.02)
    }

    /// Whether a texel is of the head, where labels of its own apply.
    fn is_detail(&self, texel: usize) -> bool {
        let Areas { lips, mouth, eyes, sockets, brows, scalp, .. } = &self.areas;
        [lips, mouth, eyes, sockets, brows, scalp].iter().any(|area| area[texel] > 0.1)
    }
}

/// How far each texel of the grid is skin of the body: grey data at the grid's size.
///
/// # Errors
/// [`SkinError`] if neither the face nor the neck is of one colour.
pub(crate) fn body_skin(body: &BodyLayout, base: &Texture) -> Result<Texture, SkinError> {
    let colors = GridColors::new(base, &body.grid);
    let steps = Steps::new(body, &colors);
    let decision = Decision::new(body, &colors, &steps)?;
    let weights = decision.weights();
    let texels = map_indices(weights.len(), |texel| (weights[texel] * 255.0 + 0.5) as u8);
    Ok(Texture::new(body.grid.size(), Channels::Grey, Encoding::Data, Texels::U8(texels))
        .expect("the size is that of a grid"))
}

/// The skin that an area shows.
fn skin_of(area: &[f32], colors: &GridColors) -> Result<SkinModel, SkinError> {
    let is_in = |&texel: &usize| area[texel] >= 0.5 && colors.known[texel] >= 0.5;
    let all: Vec<usize> = (0..area.len()).filter(is_in).collect();
    SkinModel::new(&some_colors(&all, colors), &[])
}

fn some_colors(texels: &[usize], colors: &GridColors) -> Vec<[f32; 3]> {
    let step = texels.len().div_ceil(MOST_COLORS).max(1);
    texels.iter().step_by(step).map(|&texel| colors.rgb[texel]).collect()
}
