//! Semantic segmentation of a head's texture: skin, hair, brows, lips, eyes, mouth, cloth.
//!
//! Captures are not clean: they show collars, hair over the forehead, teeth between the
//! lips. [`Labels`] are a soft segmentation on a coarse grid over the layout, from three
//! kinds of evidence:
//!
//! - the texel's position on the head ([`Anatomy`]): cheeks are skin, the scalp is mostly hair;
//! - the difference of its colour from the face's own skin, sampled on cheeks and nose
//!   (`evidence`);
//! - connectivity: the colour step between it and the cheeks, and whether it is connected to the
//!   region's boundary, as collars are, or to the crown, as hair is (`geodesic`).
//!
//! Labels can be drawn as an image and read back; each has its own colour, [`Label::color`].

mod body;
mod evidence;
mod find;
mod geodesic;
mod head;

use crate::color::Encoding;
use crate::texture::{Channels, Size, Texels, Texture};
pub(crate) use body::{BodyLayout, body_skin};
pub(crate) use head::HeadLayout;
use uvgraft_surface::anatomy::Anatomy;
use uvgraft_surface::mesh::Mesh;

/// What a texel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Label {
    /// Skin, moles and stubble included.
    Skin,
    /// Hair of the head, and beards.
    Hair,
    /// Eyebrows.
    Brow,
    /// Lips.
    Lip,
    /// Eyeballs, including the part visible between the lids.
    Eye,
    /// Teeth, tongue and the inside of the mouth.
    Mouth,
    /// Cloth and background at the neck, and areas where the texture is unknown.
    Cloth,
    /// Anything else: glasses, jewellery.
    Other,
}

impl Label {
    /// All labels, in ascending index order.
    pub const ALL: [Self; 8] = [
        Self::Skin,
        Self::Hair,
        Self::Brow,
        Self::Lip,
        Self::Eye,
        Self::Mouth,
        Self::Cloth,
        Self::Other,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Skin => "skin",
            Self::Hair => "hair",
            Self::Brow => "brow",
            Self::Lip => "lip",
            Self::Eye => "eye",
            Self::Mouth => "mouth",
            Self::Cloth => "cloth",
            Self::Other => "other",
        }
    }

    /// Its colour in label images: sRGB, 0 to 255.
    pub const fn color(self) -> [u8; 3] {
        match self {
            Self::Skin => [240, 190, 150],
            Self::Hair => [90, 60, 30],
            Self::Brow => [150, 110, 0],
            Self::Lip => [220, 40, 90],
            Self::Eye => [60, 120, 240],
            Self::Mouth => [250, 250, 250],
            Self::Cloth => [0, 160, 80],
            Self::Other => [150, 60, 220],
        }
    }

    /// Weight of a change of skin tone: full on skin, half on lips, none elsewhere.
    const fn tone(self) -> f32 {
        match self {
            Self::Skin => 1.0,
            Self::Lip => 0.5,
            _ => 0.0,
        }
    }
}

/// Why a head's texture could not be labelled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LabelError {
    /// The mesh has no head.
    #[error(transparent)]
    Anatomy(#[from] uvgraft_surface::anatomy::AnatomyError),
    /// The mesh has a head, but its face is not transferred.
    #[error("the face is not part of the transfer")]
    Cheeks,
    /// Cheeks and nose show too few colours or too different ones.
    #[error("no skin detected on the cheeks: {0}")]
    Skin(#[from] crate::skin::SkinError),
    /// An image that is not a label image.
    #[error(
        "{:.0} % of the texels have no label colour (must be at most 5 %)",
        .share * 100.0
    )]
    Colors {
        /// Fraction of its texels in other colours, 0 to 1.
        share: f64,
    },
}

/// A skin mask for a body's texture: grey data, 1024 × 1024 texels, 255 for skin. Lips are
/// half; hair, brows, eyes, the inside of the mouth and cloth are 0.
///
/// Skin is what is connected to the face without a colour step, and hands, feet, arms and
/// legs of the same colour that cloth separates from it. Skin-coloured cloth is detected by
/// the step at its edge.
///
/// - `texture`: in the mesh's layout, of any size.
///
/// # Errors
/// [`LabelError::Anatomy`] if the mesh has no head, [`LabelError::Skin`] if neither the
/// face nor the neck has a uniform colour.
pub fn skin_of_body(mesh: &Mesh, texture: &Texture) -> Result<Texture, LabelError> {
    Ok(body_skin(&BodyLayout::new(mesh)?, texture, None)?)
}

/// A head's mesh prepared for labelling several textures in its layout.
#[derive(Debug, Clone)]
pub struct Labeller(HeadLayout);

impl Labeller {
    /// Finds the head and rasterises the layout.
    ///
    /// # Errors
    /// [`LabelError::Anatomy`] if the mesh has no head.
    pub fn new(mesh: &Mesh) -> Result<Self, LabelError> {
        Ok(Self(HeadLayout::new(mesh, &vec![true; mesh.faces().len()])?))
    }

    /// As [`Labeller::new`], for a mesh whose head has been found.
    ///
    /// - `anatomy`: of the same mesh.
    pub fn with_anatomy(mesh: &Mesh, anatomy: Anatomy) -> Self {
        Self(HeadLayout::with_anatomy(mesh, anatomy, &vec![true; mesh.faces().len()]))
    }

    /// Labels a texture, as [`Labels::new`].
    ///
    /// # Errors
    /// [`LabelError::Skin`] if the cheeks have no uniform colour.
    pub fn label(&self, texture: &Texture) -> Result<Labels, LabelError> {
        Labels::find(&self.0, texture)
    }
}

/// A soft segmentation of a layout's texels.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    size: Size,
    /// For each texel its weight for each label, in the order of [`Label::ALL`]; they sum to
    /// about 1.
    weights: Vec<[f32; 8]>,
}

/// Squared distance beyond which a colour of a label image matches no label. Lossy compression and
/// soft brushes stay below.
const FAR: i32 = 60 * 60;

impl Labels {
    /// Labels the texture of a head, or of a body with a head.
    ///
    /// - `texture`: in the mesh's layout, of any size.
    ///
    /// # Errors
    /// [`LabelError::Anatomy`] if the mesh has no head, [`LabelError::Skin`] if the cheeks have no
    /// uniform colour.
    pub fn new(mesh: &Mesh, texture: &Texture) -> Result<Self, LabelError> {
        Labeller::new(mesh)?.label(texture)
    }

    /// Reads a label image: each texel gets the label with the nearest colour; edges are
    /// softened by one texel.
    ///
    /// - `picture`: of any size, in the colours of [`Labels::picture`].
    ///
    /// # Errors
    /// [`LabelError::Colors`] if more than 5 % of its texels have other colours.
    pub fn from_picture(picture: &Texture) -> Result<Self, LabelError> {
        let size = picture.size();
        let mut far = 0_usize;
        let mut weights = Vec::with_capacity(size.texels());
        for y in 0..size.height {
            for x in 0..size.width {
                let at = |k: usize| {
                    let channel = if picture.channels().has_color() { k } else { 0 };
                    let value = picture.get(x, y, channel);
                    let linear = picture.encoding() == Encoding::Linear;
                    let value = if linear { crate::color::srgb_from_linear(value) } else { value };
                    (value * 255.0).clamp(0.0, 255.0) as i32
                };
                let rgb = [at(0), at(1), at(2)];
                let distance = |label: Label| {
                    let color = label.color().map(i32::from);
                    (0..3).map(|k| (rgb[k] - color[k]).pow(2)).sum::<i32>()
                };
                let index = (0..8).min_by_key(|&index| distance(Label::ALL[index])).unwrap_or(0);
                far += usize::from(distance(Label::ALL[index]) > FAR);
                let mut weight = [0.0; 8];
                weight[index] = 1.0;
                weights.push(weight);
            }
        }
        let share = far as f64 / size.texels() as f64;
        if share > 0.05 {
            return Err(LabelError::Colors { share });
        }
        Ok(Self { size, weights }.softened())
    }

    /// Draws the labels as an image: each texel in the colour of its dominant label.
    pub fn picture(&self) -> Texture {
        let texels = self.weights.iter().flat_map(|weights| dominant(weights).color()).collect();
        Texture::new(self.size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
            .expect("the size is that of a texture")
    }

    /// The size of the label grid.
    pub fn size(&self) -> Size {
        self.size
    }

    /// A texel's weight for a label, 0 to 1.
    ///
    /// # Panics
    /// If `x` or `y` is outside the grid.
    pub fn weight(&self, label: Label, x: u32, y: u32) -> f32 {
        assert!(x < self.size.width && y < self.size.height, "no texel {x}, {y}");
        self.weights[(y * self.size.width + x) as usize][label as usize]
    }

    /// The weight for a label of the texel at a UV coordinate, 0 to 1.
    pub fn at_uv(&self, label: Label, uv: [f64; 2]) -> f32 {
        let Size { width, height } = self.size;
        let place = |at: f64, side: u32| ((at * f64::from(side)) as u32).min(side - 1);
        self.weight(label, place(uv[0], width), place(uv[1], height))
    }

    /// Whether any texel is dominated by cloth, which is cut out of the region.
    pub(crate) fn has_cloth(&self) -> bool {
        self.weights.iter().any(|weights| weights[Label::Cloth as usize] > 0.5)
    }

    /// A mask of what stays in the region, white: all but cloth and the texels within `margin`
    /// texels of it.
    pub(crate) fn kept(&self, margin: f64) -> Texture {
        let Size { width, height } = self.size;
        let is_cloth = |texel: usize| self.weights[texel][Label::Cloth as usize] >= 0.5;
        let mut texels = vec![255_u8; self.weights.len()];
        let reach = margin.ceil() as i64;
        let is_at = |x: i64, y: i64| {
            (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y)
        };
        for texel in (0..texels.len()).filter(|&texel| is_cloth(texel)) {
            texels[texel] = 0;
            let (x, y) = ((texel % width as usize) as i64, (texel / width as usize) as i64);
            let at = |dx: i64, dy: i64| ((y + dy) * i64::from(width) + x + dx) as usize;
            let is_inner = [(-1, 0), (1, 0), (0, -1), (0, 1)]
                .into_iter()
                .all(|(dx, dy)| !is_at(x + dx, y + dy) || is_cloth(at(dx, dy)));
            if is_inner {
                continue;
            }
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let is_near = ((dx * dx + dy * dy) as f64) <= margin * margin;
                    if is_near && is_at(x + dx, y + dy) {
                        texels[at(dx, dy)] = 0;
                    }
                }
            }
        }
        Texture::new(self.size, Channels::Grey, Encoding::Data, Texels::U8(texels))
            .expect("the size is that of a texture")
    }

    /// Two channels of data: the weight of a change of skin tone, and the weight with which
    /// texels stay in the region.
    pub(crate) fn controls(&self) -> Texture {
        let level = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let texels = self.weights.iter().flat_map(|weights| {
            let tone: f32 =
                Label::ALL.iter().zip(weights).map(|(label, weight)| label.tone() * weight).sum();
            [level(tone), level(1.0 - weights[Label::Cloth as usize])]
        });
        let texels = Texels::U8(texels.collect());
        Texture::new(self.size, Channels::GreyAlpha, Encoding::Data, texels)
            .expect("the size is that of a texture")
    }

    /// The same with cloth relabelled as [`Label::Other`], so that nothing is cut out of the
    /// region.
    #[must_use]
    pub fn keeping_all(mut self) -> Self {
        for weights in &mut self.weights {
            weights[Label::Other as usize] += std::mem::take(&mut weights[Label::Cloth as usize]);
        }
        self
    }

    /// Blurred with a 3 × 3 binomial filter.
    fn softened(self) -> Self {
        let Size { width, height } = self.size;
        let (width, height) = (width as usize, height as usize);
        let blur = |values: &[[f32; 8]], step: usize, count: usize, at: &dyn Fn(usize) -> usize| {
            (0..values.len())
                .map(|index| {
                    let k = at(index);
                    let before = if k > 0 { index - step } else { index };
                    let after = if k + 1 < count { index + step } else { index };
                    std::array::from_fn(|n| {
                        0.25 * values[before][n] + 0.5 * values[index][n] + 0.25 * values[after][n]
                    })
                })
                .collect::<Vec<[f32; 8]>>()
        };
        let rows = blur(&self.weights, 1, width, &|index| index % width);
        let weights = blur(&rows, width, height, &|index| index / width);
        Self { weights, ..self }
    }
}

fn dominant(weights: &[f32; 8]) -> Label {
    let mut best = 0;
    for index in 1..8 {
        if weights[index] > weights[best] {
            best = index;
        }
    }
    Label::ALL[best]
}
