//! A head's layout: the position of each texel on the head.

use glam::Vec3;
use uvgraft_surface::anatomy::{Anatomy, AnatomyError, Area};
use uvgraft_surface::mesh::Mesh;

use crate::layout_grid::LayoutGrid;
use crate::texture::Size;

/// Weights of the anatomical areas at each texel.
#[derive(Debug, Clone)]
pub(crate) struct Areas {
    pub cheeks: Vec<f32>,
    pub forehead: Vec<f32>,
    pub nose: Vec<f32>,
    pub jaw: Vec<f32>,
    pub lips: Vec<f32>,
    pub mouth: Vec<f32>,
    pub eyes: Vec<f32>,
    pub sockets: Vec<f32>,
    pub brows: Vec<f32>,
    pub ears: Vec<f32>,
    pub scalp: Vec<f32>,
    pub neck: Vec<f32>,
}

/// The anatomy of a mesh with a head, and a grid over its layout. Computed once per mesh.
#[derive(Debug, Clone)]
pub(crate) struct HeadLayout {
    pub anatomy: Anatomy,
    pub grid: LayoutGrid,
    pub areas: Areas,
    /// Height of each texel above the lowest point of the scalp, in eye distances.
    pub above_nape: Vec<f32>,
    /// Texels of the grid per eye distance along the surface.
    texels_per_eyes: f64,
    /// The texels along the boundary of the transferred part at the neck.
    pub rim: Vec<u32>,
}

/// Number of grid texels that the transferred part should cover. With half as many, IoU of collars
/// is 0.014 less on average, with twice as many 0.011 more. Lips, brows and mouths gain some 0.03
/// either way; why is not known.
const TEXELS: f64 = 220_000.0;
/// Limits of the grid's side, in texels.
const SIDES: [f64; 2] = [384.0, 1024.0];

impl HeadLayout {
    /// Finds the head and rasterises the layout.
    ///
    /// - `is_transferred`: `[faces]`, the triangles whose texels are transferred.
    ///
    /// # Errors
    /// [`AnatomyError`] if the mesh has no head.
    pub fn new(mesh: &Mesh, is_transferred: &[bool]) -> Result<Self, AnatomyError> {
        Ok(Self::with_anatomy(mesh, Anatomy::find(mesh)?, is_transferred))
    }

    /// As [`HeadLayout::new`], for a mesh whose head has been found.
    pub fn with_anatomy(mesh: &Mesh, anatomy: Anatomy, is_transferred: &[bool]) -> Self {
        let side = grid_side(mesh, is_transferred);
        let grid = LayoutGrid::new(mesh, Size::square(side));
        let at = |area: Area| grid.at_texels(mesh, anatomy.area(area));
        let areas = Areas {
            cheeks: at(Area::Cheeks),
            forehead: at(Area::Forehead),
            nose: at(Area::Nose),
            jaw: at(Area::Jaw),
            lips: at(Area::Lips),
            mouth: at(Area::MouthInterior),
            eyes: at(Area::Eyes),
            sockets: at(Area::EyeSockets),
            brows: at(Area::Brows),
            ears: at(Area::Ears),
            scalp: at(Area::Scalp),
            neck: at(Area::Neck),
        };
        let rim = rim(&grid, &areas, is_transferred);
        let frame = anatomy.frame();
        let height =
            mesh.positions().iter().map(|position| frame.local(position.map(f64::from))[1]);
        let height: Vec<f32> = height.map(|height| height as f32).collect();
        let on_scalp = anatomy.area(Area::Scalp).iter().zip(&height);
        let nape = on_scalp.filter(|(scalp, _)| **scalp >= 0.5).map(|(_, height)| *height);
        let nape = nape.fold(f32::INFINITY, f32::min);
        let above_nape = grid.at_texels(mesh, &height).into_iter().map(|at| at - nape).collect();
        let texels_per_eyes = texels_per_unit(mesh, &grid, is_transferred) * frame.unit;
        Self { anatomy, grid, areas, above_nape, texels_per_eyes, rim }
    }

    /// Whether the cheeks are transferred. They aren't if, for example, only a body's hands are.
    pub fn has_cheeks(&self, mesh: &Mesh, is_transferred: &[bool]) -> bool {
        let cheeks = self.anatomy.area(Area::Cheeks);
        let mut faces = mesh.faces().iter().zip(is_transferred).filter(|(_, is)| **is);
        faces.any(|(corners, _)| corners.iter().all(|&vertex| cheeks[vertex as usize] >= 0.5))
    }

    /// Texels per eye distance along the surface, in a texture of the given size.
    pub fn texels_per_unit(&self, size: Size) -> f64 {
        let ratio = size.texels() as f64 / self.grid.size().texels() as f64;
        self.texels_per_eyes * ratio.sqrt()
    }
}

/// Texels per unit of the mesh, averaged over the transferred part.
fn texels_per_unit(mesh: &Mesh, grid: &LayoutGrid, is_transferred: &[bool]) -> f64 {
    let is_in = |&&face: &&u32| is_transferred.get(face as usize).is_some_and(|&is| is);
    let texels = grid.faces().iter().filter(is_in).count();
    let area = |face: usize| {
        let [a, b, c] = mesh.faces()[face]
            .map(|vertex| Vec3::from(mesh.positions()[vertex as usize]).as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    let faces =
        (0..is_transferred.len()).filter(|&face| is_transferred[face] && !mesh.is_outside(face));
    (texels as f64 / faces.map(area).sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
}

fn grid_side(mesh: &Mesh, is_transferred: &[bool]) -> u32 {
    let faces =
        (0..is_transferred.len()).filter(|&face| is_transferred[face] && !mesh.is_outside(face));
    let area = |face: usize| {
        let [a, b, c] = mesh.uv_triangle(face).map(|uv| uv.map(f64::from));
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
    };
    // A face gets as many texels in a body's layout, where it is small, as in its own.
    let share: f64 = faces.map(area).sum::<f64>().clamp(1e-3, 1.0);
    (TEXELS / share).sqrt().clamp(SIDES[0], SIDES[1]).round() as u32
}

/// The texels at the neck next to triangles that are not transferred, or to the mesh's open
/// boundary.
fn rim(grid: &LayoutGrid, areas: &Areas, is_transferred: &[bool]) -> Vec<u32> {
    let is_in = |texel: u32| {
        let face = grid.faces()[texel as usize] as usize;
        is_transferred.get(face).is_some_and(|&is| is)
    };
    let is_rim = |&texel: &u32| {
        if !is_in(texel) || areas.neck[texel as usize] < 0.05 {
            return false;
        }
        let near: Vec<u32> = grid.neighbours(texel).collect();
        // A texel inside an island has four neighbours, and so has one at a UV seam.
        near.len() < 4 || near.iter().any(|&other| !is_in(other))
    };
    (0..grid.size().texels() as u32).filter(is_rim).collect()
}
