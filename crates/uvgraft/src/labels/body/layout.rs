//! A body's layout: the position of each texel on the body.

use uvgraft_surface::anatomy::{Anatomy, AnatomyError, Area};
use uvgraft_surface::edges::Edges;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::threads::map_indices;

use super::shells::Contacts;
use super::taps::Taps;
use crate::layout_grid::{LayoutGrid, NONE};
use crate::texture::Size;

/// The side of the grid, in texels.
const SIDE: u32 = 1024;

/// Shells closer than this are in contact, in distances between the eyes: 2 cm.
const CONTACT: f64 = 0.32;

/// Weights of a texel of the head for the areas that are labelled separately.
#[derive(Debug, Clone, Copy)]
pub(super) struct Detail {
    pub lips: f32,
    pub mouth: f32,
    pub eyes: f32,
    pub sockets: f32,
    pub brows: f32,
    pub scalp: f32,
}

/// Properties of a texel, as bit flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Bits(u8);

impl Bits {
    const COVERED: u8 = 1;
    const INNER: u8 = 2;
    const FEATURE: u8 = 4;
    const DETAIL: u8 = 8;
    const LEFT: u8 = 16;
    const CONTACT: u8 = 32;

    /// Whether a triangle covers it.
    pub fn is_covered(self) -> bool {
        self.0 & Self::COVERED != 0
    }

    /// Whether it may be skin: covered, and neither eye nor inside the mouth.
    pub fn is_outer(self) -> bool {
        self.0 & (Self::COVERED | Self::INNER) == Self::COVERED
    }

    /// Whether it belongs to the face or an ear, whose features produce colour edges.
    pub fn is_feature(self) -> bool {
        self.0 & Self::FEATURE != 0
    }

    /// Whether it has a [`Detail`].
    pub fn is_detail(self) -> bool {
        self.0 & Self::DETAIL != 0
    }

    /// Whether another shell is in contact with it.
    pub fn is_contact(self) -> bool {
        self.0 & Self::CONTACT != 0
    }

    /// Whether it is on the left half of the body.
    pub fn is_left(self) -> bool {
        self.0 & Self::LEFT != 0
    }
}

/// A grid over the whole layout of a body mesh, with its anatomy. Computed once per mesh.
#[derive(Debug, Clone)]
pub(crate) struct BodyLayout {
    pub(super) grid: LayoutGrid,
    pub(super) bits: Vec<Bits>,
    pub(super) contacts: Contacts,
    /// Number of covered texels.
    pub(super) covered: usize,
    /// The texels of cheeks, nose and forehead.
    pub(super) face: Vec<u32>,
    pub(super) cheeks: Vec<u32>,
    pub(super) neck: Vec<u32>,
    pub(super) hands: Vec<u32>,
    pub(super) feet: Vec<u32>,
    pub(super) details: Vec<(u32, Detail)>,
    /// Filter taps along rows and along columns.
    pub(super) taps: [Taps; 2],
}

/// The areas that are rasterised, in the order of [`Row::add`].
const AREAS: [Area; 13] = [
    Area::Cheeks,
    Area::Nose,
    Area::Forehead,
    Area::Neck,
    Area::Hands,
    Area::Feet,
    Area::Ears,
    Area::Lips,
    Area::MouthInterior,
    Area::Eyes,
    Area::EyeSockets,
    Area::Brows,
    Area::Scalp,
];

impl BodyLayout {
    /// Finds the head, hands and feet, and rasterises the layout.
    ///
    /// # Errors
    /// [`AnatomyError`] if the mesh has no head.
    pub fn new(mesh: &Mesh) -> Result<Self, AnatomyError> {
        Ok(Self::with_anatomy(mesh, &Anatomy::find(mesh)?))
    }

    /// As [`BodyLayout::new`], for a mesh whose anatomy is known.
    ///
    /// Rows are processed in parallel, each with its own lists, and concatenated in order.
    pub fn with_anatomy(mesh: &Mesh, anatomy: &Anatomy) -> Self {
        let edges = Edges::new(mesh);
        let grid = LayoutGrid::with_edges(mesh, &edges, Size::square(SIDE));
        let contacts = Contacts::new(mesh, &edges, &grid, CONTACT * anatomy.frame().unit);
        let areas = AREAS.map(|area| anatomy.area(area));
        // Most triangles of a body belong to no area.
        let has_any: Vec<bool> = map_indices(mesh.faces().len(), |face| {
            let corners = mesh.faces()[face];
            areas.iter().any(|area| corners.iter().any(|&corner| area[corner as usize] > 0.0))
        });
        let frame = anatomy.frame();
        let left = mesh.positions().iter().map(|at| frame.local(at.map(f64::from))[0] as f32);
        let left: Vec<f32> = left.collect();
        let width = grid.size().width as usize;
        let rows = map_indices(grid.size().height as usize, |y| {
            let mut row = Row::default();
            for texel in y * width..(y + 1) * width {
                let face = grid.faces()[texel];
                let mut bits = 0;
                if face != NONE {
                    bits = Bits::COVERED;
                    if contacts.has(texel as u32) {
                        bits |= Bits::CONTACT;
                    }
                    if grid.at_texel(mesh, &left, texel) > 0.0 {
                        bits |= Bits::LEFT;
                    }
                    if has_any[face as usize] {
                        let values = areas.map(|area| grid.at_texel(mesh, area, texel));
                        bits |= row.add(texel as u32, values);
                    }
                }
                row.bits.push(Bits(bits));
            }
            row
        });
        let mut all = Row::default();
        for row in rows {
            all.bits.extend(row.bits);
            all.details.extend(row.details);
            for (all, list) in all.lists.iter_mut().zip(row.lists) {
                all.extend(list);
            }
        }
        let covered = all.bits.iter().filter(|bits| bits.is_covered()).count();
        let [face, cheeks, neck, hands, feet] = all.lists;
        let (bits, details) = (all.bits, all.details);
        let taps = [0, 1].map(|axis| Taps::new(&grid, axis));
        Self { grid, bits, contacts, covered, face, cheeks, neck, hands, feet, details, taps }
    }
}

/// The properties of a row of texels.
#[derive(Default)]
struct Row {
    bits: Vec<Bits>,
    lists: [Vec<u32>; 5],
    details: Vec<(u32, Detail)>,
}

impl Row {
    /// Adds a texel to the lists of its areas; returns its flags.
    ///
    /// - `values`: the texel's weights for [`AREAS`].
    fn add(&mut self, texel: u32, values: [f32; 13]) -> u8 {
        let [
            cheeks,
            nose,
            forehead,
            neck,
            hands,
            feet,
            ears,
            lips,
            mouth,
            eyes,
            sockets,
            brows,
            scalp,
        ] = values;
        let face = cheeks.max(nose).max(forehead);
        for (list, area) in self.lists.iter_mut().zip([face, cheeks, neck, hands, feet]) {
            if area >= 0.5 {
                list.push(texel);
            }
        }
        let features = [face, ears, lips, mouth, eyes, sockets, brows];
        let mut bits = 0;
        if eyes.max(mouth) >= 0.5 {
            bits |= Bits::INNER;
        }
        if features.into_iter().any(|area| area > 0.02) {
            bits |= Bits::FEATURE;
        }
        if [lips, mouth, eyes, sockets, brows, scalp].into_iter().any(|area| area > 0.1) {
            bits |= Bits::DETAIL;
            self.details.push((texel, Detail { lips, mouth, eyes, sockets, brows, scalp }));
        }
        bits
    }
}
