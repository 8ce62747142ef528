//! Whether a picture was made for a layout, from the picture itself.
//!
//! Two things show it. Where the background of a picture is visible, it lies between the islands of its
//! layout. And across a UV seam the surface goes on, so colours on both sides are alike; in a layout
//! that a picture was not made for, they are those of unrelated places.
//!
//! Nothing here is certain: textures whose islands fill the square and are padded have no background,
//! and captured heads have light of their own on either side of the seam at the back. So what is found
//! is a warning at most, and only where the picture contradicts its layout clearly.

use uvgraft_surface::mesh::{Mesh, bits_of};
use uvgraft_surface::raster::{ScanTriangle, corners_px};

use crate::texture::{Size, Texture};

/// Points of the silhouette along each side of the square.
const GRID: u32 = 96;

/// Most seam edges that are looked at. A body has about 1,000.
const MAX_SEAMS: usize = 1024;

/// How far inside its triangle a seam is sampled, as a share of the distance from the edge to the third
/// corner: enough to be clear of a blurred border.
const INSIDE: f32 = 0.15;

/// The same in texels, a little more than half the diagonal of a texel: the centre of the one that is
/// looked at is inside, too.
const INSIDE_TEXELS: f32 = 0.75;

/// The largest share, that of the centroid.
const DEEPEST: f32 = 1.0 / 3.0;

/// The places of a layout that tell whether a picture was made for it.
#[derive(Debug, Clone)]
pub struct LayoutPoints {
    /// `[GRID²]`, row by row: whether an island covers the point.
    is_covered: Vec<bool>,
    /// Both sides of seam edges.
    seams: Vec<[SeamSide; 2]>,
}

/// A triangle beside a seam, in UV coordinates.
#[derive(Debug, Clone, Copy)]
struct SeamSide {
    edge: [[f32; 2]; 2],
    /// The corner that is not on the seam.
    third: [f32; 2],
}

impl SeamSide {
    /// What is beside a half-edge.
    fn at(mesh: &Mesh, half: u32) -> Self {
        let (face, corner) = (half as usize / 3, half as usize % 3);
        let [a, b, third] = [0, 1, 2].map(|k| mesh.uv_triangle(face)[(corner + k) % 3]);
        Self { edge: [a, b], third }
    }

    /// The texel to look at, as row and column: beside the middle of the edge. `None` if the triangle is
    /// too small for a texel that is inside.
    fn texel(&self, size: Size) -> Option<(u32, u32)> {
        let scale = [size.width as f32, size.height as f32];
        let [a, b, third] =
            [self.edge[0], self.edge[1], self.third].map(|[u, v]| [u * scale[0], v * scale[1]]);
        let [along, up] = [b, third].map(|to| [to[0] - a[0], to[1] - a[1]]);
        let height = (along[0] * up[1] - along[1] * up[0]).abs() / along[0].hypot(along[1]);
        if height.is_nan() || DEEPEST * height < INSIDE_TEXELS {
            return None;
        }
        let share = INSIDE.max(INSIDE_TEXELS / height);
        let [x, y] = [0, 1].map(|k| {
            let middle = (a[k] + b[k]) / 2.0;
            middle + share * (third[k] - middle)
        });
        Some(((y as u32).min(size.height - 1), (x as u32).min(size.width - 1)))
    }
}

impl LayoutPoints {
    /// Finds the places of a layout.
    pub fn new(mesh: &Mesh) -> Self {
        let size = Size::square(GRID);
        let mut is_covered = vec![false; size.texels()];
        let faces = (0..mesh.faces().len()).filter(|&face| !mesh.is_outside(face));
        for triangle in
            faces.filter_map(|face| ScanTriangle::new(corners_px(mesh, face, size), size))
        {
            for (row, columns) in triangle.spans(&(0..GRID)) {
                let row = &mut is_covered[(row * GRID) as usize..][..GRID as usize];
                row[columns.start as usize..columns.end as usize].fill(true);
            }
        }
        let seams = seams(mesh);
        let step = seams.len().div_ceil(MAX_SEAMS).max(1);
        Self { is_covered, seams: seams.into_iter().step_by(step).collect() }
    }
}

/// Both sides of the edges at which two triangles meet that have different UV coordinates there.
///
/// Nearly all edges have the same UV indices on both sides, and are no seams. Only the others are
/// compared by where they are.
fn seams(mesh: &Mesh) -> Vec<[SeamSide; 2]> {
    let mut at_places: Vec<([[u32; 3]; 2], u32)> = uv_borders(mesh)
        .into_iter()
        .filter(|&half| !mesh.is_outside(half as usize / 3))
        .map(|half| {
            let [from, to] = place_bits(mesh, half);
            ([from.min(to), from.max(to)], half)
        })
        .filter(|([from, to], _)| from != to)
        .collect();
    at_places.sort_unstable();
    // Where more than two meet, such as those of sheets that lie on each other, nothing is known.
    let pairs = at_places.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 2);
    let mut pairs: Vec<[u32; 2]> = pairs.map(|group| [group[0].1, group[1].1]).collect();
    pairs.sort_unstable();
    let sides = pairs.into_iter().filter_map(|halves| {
        let [first, mut second] = halves.map(|half| SeamSide::at(mesh, half));
        if place_bits(mesh, halves[0]) != place_bits(mesh, halves[1]) {
            second.edge.reverse();
        }
        (first.edge != second.edge).then_some([first, second])
    });
    sides.collect()
}

/// The half-edges between UV indices that no other half-edge is between; as [`uvgraft_surface::edges::HalfEdge`].
fn uv_borders(mesh: &Mesh) -> Vec<u32> {
    let halves = || {
        let of_face = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        (0..).zip(mesh.uv_faces().iter().flat_map(of_face))
    };
    // Where each half-edge has one in the opposite direction, as many come from an index as go to it,
    // from and to the same others: the differences of their sums are 0. Others are candidates.
    let mut balances = vec![0_u32; mesh.uv().len()];
    let scattered = |index: u32| (index + 1).wrapping_mul(0x9e37_79b9);
    for (_, [from, to]) in halves() {
        let [out, into] = [from, to].map(|index| index as usize);
        balances[out] = balances[out].wrapping_add(scattered(to));
        balances[into] = balances[into].wrapping_sub(scattered(from));
    }
    let is_candidate =
        |(_, ends): &(u32, [u32; 2])| ends.iter().all(|&at| balances[at as usize] != 0);
    let candidates = halves().filter(is_candidate);
    let mut candidates: Vec<([u32; 2], u32)> =
        candidates.map(|(half, [from, to])| ([from.min(to), from.max(to)], half)).collect();
    candidates.sort_unstable();
    let alone = candidates.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 1);
    alone.map(|group| group[0].1).collect()
}

/// The positions of a half-edge's ends, as bits.
fn place_bits(mesh: &Mesh, half: u32) -> [[u32; 3]; 2] {
    let face = mesh.faces()[half as usize / 3];
    [half as usize % 3, (half as usize % 3 + 1) % 3]
        .map(|corner| bits_of(mesh.positions()[face[corner] as usize]))
}

/// How well a picture fits a layout.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayoutFit {
    /// Correlation of the picture's background with what the layout's islands leave free, -1 to 1;
    /// `None` if the picture has no background, or the islands leave nothing free.
    pub silhouette: Option<f64>,
    /// How colours on both sides of seams agree; `None` with few seams, or a picture of one colour.
    pub seams: Option<SeamAgreement>,
}

/// How colours on both sides of seams agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamAgreement {
    /// Number of seam edges that were looked at.
    pub edges: usize,
    /// Mean difference across seams, as a share of that between unrelated places at seams: 0 where
    /// seams are invisible, about 1 in a layout that has nothing to do with the picture.
    pub difference: f64,
    /// Correlation of brightness across seams, -1 to 1.
    pub correlation: f64,
}

// The following were chosen on four heads and two bodies (FLAME, HiFi3D++, SMPL-X and the figure's),
// with textures that were captured, painted, averaged and transferred from one to the other: each in its
// own layout and in the others.
impl SeamAgreement {
    /// Fewer seams than this say nothing: a cube has 7, FLAME 95.
    const FEWEST: usize = 40;
    /// From this many on, as on bodies in several islands, seams are sure to lie all over the surface.
    /// Heads often have a single one, at the back.
    const MANY: usize = 400;

    /// Right bodies have at most 0.11 and at least 0.88 here, wrong ones at least 0.31 and at most 0.84.
    fn is_good(&self) -> bool {
        self.difference <= 0.25 && self.correlation >= 0.85
    }

    /// Right heads have up to 0.76 and down to 0.49, the latter in FLAME's average texture.
    fn is_bad(&self) -> bool {
        if self.edges >= Self::MANY {
            self.difference > 0.4 && self.correlation < 0.7
        } else {
            self.difference > 0.7 && self.correlation < 0.3
        }
    }
}

impl LayoutFit {
    /// Right pictures with a background have at least 0.65, wrong ones at most 0.44 (and 0.58 where two
    /// heads have nearly the same outline).
    const GOOD_SILHOUETTE: f64 = 0.5;

    fn has_good_silhouette(&self) -> bool {
        self.silhouette.is_some_and(|correlation| correlation >= Self::GOOD_SILHOUETTE)
    }

    fn is_good(&self) -> bool {
        self.has_good_silhouette() || self.seams.is_some_and(|seams| seams.is_good())
    }

    /// Whether the picture contradicts the layout.
    fn is_bad(&self) -> bool {
        !self.is_good() && self.seams.is_some_and(|seams| seams.is_bad())
    }

    /// Whether the picture fits the other layout, and this one clearly less.
    fn is_worse_than(&self, other: &Self) -> bool {
        if self.is_good() || !other.is_good() {
            return false;
        }
        let by_silhouette = matches!((self.silhouette, other.silhouette),
            (Some(this), Some(other)) if other >= Self::GOOD_SILHOUETTE && this < other - 0.25);
        let by_seams = matches!((self.seams, other.seams),
            (Some(this), Some(other)) if other.is_good() && this.difference > 0.4);
        by_silhouette || by_seams
    }
}

/// A picture that contradicts its layout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// How it fits the layout that it should have.
    pub fit: LayoutFit,
    /// Whether it fits the layout that it was compared with.
    pub fits_other: bool,
}

impl Misfit {
    /// What is wrong.
    ///
    /// - `picture`, `mesh`, `other`: names of the picture, of the mesh whose layout it should have, and
    ///   of the one whose layout it was compared with.
    pub fn text(&self, picture: &str, mesh: &str, other: &str) -> String {
        let mut text = format!("{picture}: does not look like a texture for the layout of {mesh}");
        if self.fits_other {
            return text + &format!(", but for that of {other}");
        }
        if let Some(seams) = self.fit.seams {
            let difference = 100.0 * seams.difference;
            text += &format!(
                ": colours on both sides of UV seams differ by {difference:.0} % of what unrelated \
                 places do"
            );
        }
        text
    }
}

/// What makes a picture no texture of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NonColorContent {
    /// Transparent on all islands of its layout.
    Transparent,
    /// A normal map.
    Normals,
}

impl NonColorContent {
    /// What is odd.
    ///
    /// - `picture`: its name.
    pub fn text(self, picture: &str) -> String {
        match self {
            Self::Transparent => {
                format!(
                    "{picture}: transparent on all islands of its layout, so nothing of it is seen"
                )
            }
            Self::Normals => format!(
                "{picture}: looks like a normal map, whose directions are kept as colours here; `map` \
                 normal=… turns them"
            ),
        }
    }
}

/// Looks at a picture, as a whole or band by band, at the points of two layouts.
#[derive(Debug)]
pub struct LayoutProbe<'a> {
    layouts: [&'a LayoutPoints; 2],
    size: Size,
    /// Texels to look at, row by row, and where their colours go.
    places: Vec<(u32, u32, u32)>,
    next: usize,
    /// RGB and alpha; NaN where nothing was seen.
    colors: Vec<[f32; 4]>,
}

impl<'a> LayoutProbe<'a> {
    /// - `layouts`: the one that the picture should have, and another that it may have been made for.
    /// - `size`: of the picture.
    pub fn new(layouts: [&'a LayoutPoints; 2], size: Size) -> Self {
        let grid = (0..GRID * GRID).map(|point| {
            let at = |index: u32, side: u32| {
                (((index as f32 + 0.5) / GRID as f32 * side as f32) as u32).min(side - 1)
            };
            Some((at(point / GRID, size.height), at(point % GRID, size.width)))
        });
        let seams = layouts.into_iter().flat_map(|points| points.seams.as_flattened());
        let mut places: Vec<(u32, u32, u32)> = grid
            .chain(seams.map(|side| side.texel(size)))
            .zip(0..)
            .filter_map(|(texel, slot)| texel.map(|(row, column)| (row, column, slot)))
            .collect();
        // The grid is in this order already, which a stable sort uses. In one number, which is faster to
        // compare; sides of textures have 16 bits.
        places.sort_by_key(|&(row, column, slot)| {
            u64::from(row) << 48 | u64::from(column) << 32 | u64::from(slot)
        });
        let slots = (GRID * GRID) as usize + 2 * (layouts[0].seams.len() + layouts[1].seams.len());
        let colors = vec![[f32::NAN; 4]; slots];
        Self { layouts, size, places, next: 0, colors }
    }

    /// The same without the places from a row on.
    #[must_use]
    pub fn above(mut self, row: u32) -> Self {
        self.places.retain(|place| place.0 < row);
        self
    }

    /// Looks at the next rows. Bands come in order; what is beyond the last is not known.
    pub fn look(&mut self, first_row: u32, band: &Texture) {
        let end = first_row + band.size().height;
        let channels = band.channels();
        let last = channels.count() - 1;
        while let Some(&(row, column, slot)) = self.places.get(self.next).filter(|at| at.0 < end) {
            self.next += 1;
            if row < first_row || column >= band.size().width {
                continue;
            }
            let value = |channel: usize| band.get(column, row - first_row, channel);
            let [r, g, b] = if channels.has_color() { [0, 1, 2] } else { [0; 3] }.map(value);
            let alpha = if channels.has_alpha() { value(last) } else { 1.0 };
            self.colors[slot as usize] = [r, g, b, alpha];
        }
    }

    /// How the picture fits both layouts.
    pub fn fits(&self) -> [LayoutFit; 2] {
        let grid = (GRID * GRID) as usize;
        let (points, seams) = self.colors.split_at(grid);
        let background = Background::of(points);
        let first = 2 * self.layouts[0].seams.len();
        let of_layout = |layout: &LayoutPoints, seams: &[[f32; 4]]| LayoutFit {
            silhouette: background.and_then(|background| {
                let seen =
                    points.iter().zip(&layout.is_covered).filter(|(color, _)| is_seen(color));
                correlation(seen.map(|(color, is_covered)| {
                    [background.has(color), !is_covered].map(|is_it| f64::from(u8::from(is_it)))
                }))
            }),
            seams: agreement(seams.as_chunks().0, background),
        };
        // Too small for points beside a seam to be other texels than those across it.
        if self.size.width.min(self.size.height) < 128 {
            return [LayoutFit::default(); 2];
        }
        [of_layout(self.layouts[0], &seams[..first]), of_layout(self.layouts[1], &seams[first..])]
    }

    /// What is odd about what the picture shows on the islands of the layout that it should have.
    pub fn oddity(&self) -> Option<NonColorContent> {
        let covered = self.colors.iter().zip(&self.layouts[0].is_covered);
        let seen = covered.filter(|(color, is_covered)| **is_covered && is_seen(color));
        let seen: Vec<[f32; 4]> = seen.map(|(color, _)| *color).collect();
        let shown = || seen.iter().filter(|color| color[3] > 0.0);
        let count = shown().count();
        if count == 0 {
            return (!seen.is_empty()).then_some(NonColorContent::Transparent);
        }
        // Normals have a length of 1, and are those of the surface itself in the mean: a relief that tilts all
        // of them by 40 degrees has 0.77 upwards. Blue paint may have the length, but not the direction.
        let direction = |&[r, g, b, _]: &[f32; 4]| [r, g, b].map(|value| 2.0 * value - 1.0);
        let is_unit = |[x, y, z]: &[f32; 3]| (0.9..1.1).contains(&(x * x + y * y + z * z).sqrt());
        let units = shown().map(direction).filter(is_unit).count();
        let mean = |k: usize| shown().map(|color| direction(color)[k]).sum::<f32>() / count as f32;
        let is_upright = mean(0).abs().max(mean(1).abs()) < 0.15 && mean(2) > 0.75;
        (is_upright && 10 * units >= 9 * count).then_some(NonColorContent::Normals)
    }

    /// What is wrong with the picture; `None` if it may well be right.
    pub fn misfit(&self) -> Option<Misfit> {
        let [fit, other] = self.fits();
        let fits_other = fit.is_worse_than(&other);
        (fits_other || fit.is_bad()).then_some(Misfit { fit, fits_other })
    }
}

fn is_seen(color: &[f32; 4]) -> bool {
    color.iter().all(|value| !value.is_nan())
}

/// The background of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Background {
    Transparent,
    Black,
    White,
}

impl Background {
    /// What JPEG makes of black and white.
    const NOISE: f32 = 12.0 / 255.0;
    /// Least share of a picture: the figure's body leaves 22 % free, FLAME 10 %.
    const LEAST: f64 = 0.03;

    /// The background of a picture of which some points were seen, if it has one.
    fn of(points: &[[f32; 4]]) -> Option<Self> {
        let seen = || points.iter().filter(|color| is_seen(color));
        let least = Self::LEAST * seen().count() as f64;
        let count = |kind: Self| seen().filter(|color| kind.has(color)).count();
        let [transparent, black, white] = [Self::Transparent, Self::Black, Self::White].map(count);
        let is_enough = |count: usize| count > 0 && count as f64 >= least;
        // Transparency is meant; of black and white there may be some on the islands too.
        match () {
            () if is_enough(transparent) => Some(Self::Transparent),
            () if is_enough(black) && black >= white => Some(Self::Black),
            () if is_enough(white) => Some(Self::White),
            () => None,
        }
    }

    fn has(self, color: &[f32; 4]) -> bool {
        match self {
            Self::Transparent => color[3] <= Self::NOISE,
            Self::Black => color[..3].iter().all(|value| *value <= Self::NOISE),
            Self::White => color[..3].iter().all(|value| *value >= 1.0 - Self::NOISE),
        }
    }
}

/// How the colours on both sides of seams agree.
///
/// - `background`: places that show it are left out, since captures are often black where nothing was
///   seen.
fn agreement(seams: &[[[f32; 4]; 2]], background: Option<Background>) -> Option<SeamAgreement> {
    /// Least mean difference between unrelated places: in a picture of nearly one colour nothing can
    /// disagree.
    const LEAST: f64 = 10.0 / 255.0;
    let seen: Vec<&[[f32; 4]; 2]> = seams
        .iter()
        .filter(|sides| {
            let shows = |color| background.is_some_and(|background| background.has(color));
            sides.iter().all(|color| is_seen(color) && !shows(color))
        })
        .collect();
    let edges = seen.len();
    if edges < SeamAgreement::FEWEST {
        return None;
    }
    let difference = |a: &[f32; 4], b: &[f32; 4]| {
        (0..3).map(|k| f64::from((a[k] - b[k]).abs())).sum::<f64>() / 3.0
    };
    let across = seen.iter().map(|[a, b]| difference(a, b)).sum::<f64>() / edges as f64;
    // Unrelated: half and a quarter of the way round the list, in which neighbours are near each other.
    let unrelated = |shift: usize| {
        let pairs = (0..edges).map(|edge| (seen[edge], seen[(edge + shift) % edges]));
        pairs.map(|(a, b)| difference(&a[0], &b[1])).sum::<f64>() / edges as f64
    };
    let unrelated = (unrelated(edges / 2) + unrelated(edges / 4) + unrelated(edges / 3)) / 3.0;
    if unrelated < LEAST {
        return None;
    }
    let brightness =
        |color: &[f32; 4]| color[..3].iter().map(|value| f64::from(*value)).sum::<f64>();
    let correlation = correlation(seen.iter().map(|sides| [&sides[0], &sides[1]].map(brightness)))?;
    Some(SeamAgreement { edges, difference: across / unrelated, correlation })
}

/// Pearson's correlation; `None` if either does not vary.
fn correlation(pairs: impl Iterator<Item = [f64; 2]>) -> Option<f64> {
    let (mut count, mut sum, mut squares, mut products) = (0.0, [0.0; 2], [0.0; 2], 0.0);
    for [a, b] in pairs {
        count += 1.0;
        sum = [sum[0] + a, sum[1] + b];
        squares = [squares[0] + a * a, squares[1] + b * b];
        products += a * b;
    }
    let variance = [0, 1].map(|k| count * squares[k] - sum[k] * sum[k]);
    let scale = (variance[0] * variance[1]).sqrt();
    (scale > 1e-9).then(|| (count * products - sum[0] * sum[1]) / scale)
}
