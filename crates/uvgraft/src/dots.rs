//! Landmarks painted as dots: one image for each of two layouts, in which dots of the same colour are
//! the same place.

use std::collections::HashMap;
use std::fmt;

use glam::{DVec3, Vec3};
use uvgraft_surface::correspond::table::UvLocator;
use uvgraft_surface::mesh::Mesh;

use crate::texture::{Size, Texture};

/// Maximum number of dots of an image: a picture is no image of dots.
pub const MAX_DOTS: usize = 256;

/// Largest difference in a channel of colours that are the same: less than what lossy formats make of
/// a colour, and much less than a difference that people see at once.
const SAME: u8 = 12;

/// A texel of an opaque image differs from the background by more than this in some channel. Lossy
/// formats change texels next to dots by less.
const FROM_BACKGROUND: u8 = 32;

/// A colour, 8 bits for each channel; shown as `#rrggbb`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DotColor(pub [u8; 3]);

impl DotColor {
    /// Whether two colours are taken to be the same one.
    pub fn is_same(self, other: Self) -> bool {
        self.difference(other) <= SAME
    }

    /// The largest difference in a channel.
    fn difference(self, other: Self) -> u8 {
        (0..3).map(|k| self.0[k].abs_diff(other.0[k])).fold(0, u8::max)
    }
}

impl fmt::Display for DotColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// A dot of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Its most frequent colour.
    pub color: DotColor,
    /// Its centre, the mean of its texels' centres, origin at the top left.
    pub centre_px: [f64; 2],
    /// Number of its texels.
    pub texels: usize,
}

/// Why dots are not landmarks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DotsError {
    /// An image of one colour, or without opaque texels.
    #[error("the image must have dots, got one colour")]
    Nothing,
    /// More than [`MAX_DOTS`].
    #[error(
        "the image must have at most {MAX_DOTS} dots on a transparent background, or on one of a single \
         colour; got more"
    )]
    TooMany,
    /// Two dots of one colour.
    #[error(
        "dots must have different colours, got {color} at {} and at {}",
        shown(.at[0]),
        shown(.at[1])
    )]
    Repeated {
        /// Their colour.
        color: DotColor,
        /// Their centres, in texels.
        at: [[f64; 2]; 2],
    },
    /// A dot beside the UV islands.
    #[error("the dot {color} at {} must be on a UV island of the mesh", shown(*.at))]
    OffIslands {
        /// Its colour.
        color: DotColor,
        /// Its centre, in texels.
        at: [f64; 2],
    },
    /// A dot without a partner.
    #[error("the dot {color} at {} of the {side} image has no dot of its colour in the other", shown(*.at))]
    Alone {
        /// `"source"` or `"target"`.
        side: &'static str,
        /// Its colour.
        color: DotColor,
        /// Its centre, in texels.
        at: [f64; 2],
    },
}

/// The texel at a place.
fn shown(at: [f64; 2]) -> String {
    let [x, y] = at.map(f64::floor);
    format!("({x}, {y})")
}

/// The dots of an image, in the order of their first texel, row by row.
///
/// Background is what is more than half transparent. In an image without transparent texels, it is the
/// most frequent colour, and all colours close to it. Each connected part of the rest is a dot; its
/// colour is the most frequent one in it, so that soft edges don't matter. Dots must not touch.
///
/// # Errors
/// [`DotsError::Nothing`], [`DotsError::TooMany`], and [`DotsError::Repeated`] for two dots of one
/// colour.
pub fn find(image: &Texture) -> Result<Vec<Dot>, DotsError> {
    let Size { width, height } = image.size();
    let (width, height) = (width as usize, height as usize);
    let colors: Vec<Option<DotColor>> = colors(image);
    let mut is_left: Vec<bool> = colors.iter().map(Option::is_some).collect();
    let mut dots: Vec<Dot> = Vec::new();
    let mut queue = Vec::new();
    for first in 0..colors.len() {
        if !std::mem::take(&mut is_left[first]) {
            continue;
        }
        if dots.len() == MAX_DOTS {
            return Err(DotsError::TooMany);
        }
        let mut counts: HashMap<DotColor, usize> = HashMap::new();
        let (mut sum, mut texels) = ([0.0; 2], 0);
        queue.push(first);
        while let Some(texel) = queue.pop() {
            let (x, y) = (texel % width, texel / width);
            if let Some(color) = colors[texel] {
                *counts.entry(color).or_default() += 1;
            }
            sum = [sum[0] + x as f64 + 0.5, sum[1] + y as f64 + 0.5];
            texels += 1;
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let next = row * width + column;
                    if std::mem::take(&mut is_left[next]) {
                        queue.push(next);
                    }
                }
            }
        }
        let color = most_frequent(&counts).ok_or(DotsError::Nothing)?;
        let centre_px = sum.map(|sum| sum / texels as f64);
        if let Some(same) = dots.iter().find(|dot| dot.color.is_same(color)) {
            return Err(DotsError::Repeated { color, at: [same.centre_px, centre_px] });
        }
        dots.push(Dot { color, centre_px, texels });
    }
    if dots.is_empty() { Err(DotsError::Nothing) } else { Ok(dots) }
}

/// The colour of each texel, `None` for background.
fn colors(image: &Texture) -> Vec<Option<DotColor>> {
    let Size { width, height } = image.size();
    let channels = image.channels();
    let count = channels.count();
    let byte = |x, y, channel| (image.get(x, y, channel).clamp(0.0, 1.0) * 255.0).round() as u8;
    let color = |x, y| match channels.has_color() {
        true => DotColor([0, 1, 2].map(|channel| byte(x, y, channel))),
        false => DotColor([byte(x, y, 0); 3]),
    };
    let is_clear = |x, y| channels.has_alpha() && byte(x, y, count - 1) < 128;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut colors: Vec<Option<DotColor>> =
        places.map(|(x, y)| (!is_clear(x, y)).then(|| color(x, y))).collect();
    if colors.iter().all(Option::is_some) {
        let mut counts = HashMap::new();
        colors.iter().flatten().for_each(|&color| *counts.entry(color).or_default() += 1);
        let background = most_frequent(&counts);
        let is_background = |color: DotColor| {
            background.is_some_and(|background| color.difference(background) <= FROM_BACKGROUND)
        };
        colors.iter_mut().for_each(|color| *color = color.filter(|&color| !is_background(color)));
    }
    colors
}

/// The colour that counts most; of several the lowest, so that it depends on no order.
fn most_frequent(counts: &HashMap<DotColor, usize>) -> Option<DotColor> {
    let ordered = |(&color, &count): (&DotColor, &usize)| (count, std::cmp::Reverse(color));
    counts.iter().map(ordered).max().map(|(_, std::cmp::Reverse(color))| color)
}

/// The dots of two images that have the same colour, in the order of the source's.
///
/// # Errors
/// [`DotsError::Alone`] for a colour in only one of them.
pub fn matched(source: &[Dot], target: &[Dot]) -> Result<Vec<[Dot; 2]>, DotsError> {
    let partner = |dot: &Dot, others: &[Dot], side| {
        // Dots of one image differ, but two may be close to a third.
        let same = others.iter().filter(|other| other.color.is_same(dot.color));
        let nearest = same.min_by_key(|other| other.color.difference(dot.color));
        let (color, at) = (dot.color, dot.centre_px);
        nearest.copied().ok_or(DotsError::Alone { side, color, at })
    };
    for dot in target {
        partner(dot, source, "target")?;
    }
    source.iter().map(|dot| Ok([*dot, partner(dot, target, "source")?])).collect()
}

/// Where dots lie on a mesh's surface, given the size of their image, which is laid over the unit
/// square of the mesh's layout. Where triangles overlap, it is the one that comes first.
///
/// # Errors
/// [`DotsError::OffIslands`] for a dot whose centre is on no triangle.
pub fn places(
    dots: impl IntoIterator<Item = Dot>,
    size: Size,
    mesh: &Mesh,
) -> Result<Vec<[f32; 3]>, DotsError> {
    let locator = UvLocator::new(mesh);
    let sides = [size.width, size.height].map(f64::from);
    let place = |dot: Dot| {
        let uv = [0, 1].map(|k| dot.centre_px[k] / sides[k]);
        // A texel beside an island is still on it, as painted.
        let found = locator.locate(uv, 1.0 / sides[0].max(sides[1]));
        let found = found.ok_or(DotsError::OffIslands { color: dot.color, at: dot.centre_px })?;
        let corners = mesh.faces()[found.face as usize]
            .map(|vertex| Vec3::from(mesh.positions()[vertex as usize]).as_dvec3());
        let at: DVec3 = (0..3).map(|k| corners[k] * found.weights[k]).sum();
        Ok(at.as_vec3().to_array())
    };
    dots.into_iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;
    use crate::texture::{Channels, Texels};

    const RED: [u8; 3] = [230, 20, 20];
    const BLUE: [u8; 3] = [20, 20, 230];

    /// An image with square dots of `side` texels at these texels, with edges half as strong.
    fn image(alpha: bool, dots: &[([u8; 3], [u32; 2])]) -> Texture {
        const SIDE: u32 = 40;
        let texel = |k: u32| {
            let [x, y] = [k % SIDE, k / SIDE];
            let off = |at: [u32; 2]| x.abs_diff(at[0]).max(y.abs_diff(at[1]));
            let near = dots.iter().map(|&(color, at)| (off(at), color)).min().unwrap();
            let (share, color) = match near {
                (0..=2, color) => (255, color),
                (3, color) => (110, color),
                (_, _) => (0, [250; 3]),
            };
            if alpha {
                [color[0], color[1], color[2], share as u8]
            } else {
                let mix = |k: usize| (u32::from(color[k]) * share + 250 * (255 - share)) / 255;
                [mix(0) as u8, mix(1) as u8, mix(2) as u8, 255]
            }
        };
        let channels = if alpha { Channels::Rgba } else { Channels::Rgb };
        let count = channels.count();
        let texels = (0..SIDE * SIDE).flat_map(|k| texel(k).into_iter().take(count)).collect();
        Texture::new(Size::square(SIDE), channels, Encoding::Srgb, Texels::U8(texels)).unwrap()
    }

    #[test]
    fn dots_are_found_on_either_background() {
        for alpha in [false, true] {
            let dots = find(&image(alpha, &[(RED, [10, 12]), (BLUE, [30, 5])])).unwrap();
            let found: Vec<_> = dots.iter().map(|dot| (dot.color.0, dot.centre_px)).collect();
            assert_eq!(found, [(BLUE, [30.5, 5.5]), (RED, [10.5, 12.5])], "{alpha}");
            assert_eq!(dots[0].texels, if alpha { 25 } else { 49 });
        }
    }

    #[test]
    fn images_that_are_not_of_dots_are_refused() {
        let repeated = find(&image(true, &[(RED, [10, 10]), (RED, [20, 20])])).unwrap_err();
        let wanted = "dots must have different colours, got #e61414 at (10, 10) and at (20, 20)";
        assert_eq!(repeated.to_string(), wanted);
        let plain = Texels::U8([9, 9, 9].repeat(16));
        let plain = Texture::new(Size::square(4), Channels::Rgb, Encoding::Srgb, plain).unwrap();
        assert_eq!(find(&plain), Err(DotsError::Nothing));
        let clear = Texels::U8([9, 9, 9, 0].repeat(16));
        let clear = Texture::new(Size::square(4), Channels::Rgba, Encoding::Srgb, clear).unwrap();
        assert_eq!(find(&clear), Err(DotsError::Nothing));
        // Every second texel of every second row is a dot of a colour of its own.
        let texels = (0..64 * 64_u32).flat_map(|k| {
            let (x, y) = (k % 64 / 2, k / 64 / 2);
            let is_dot = k % 2 == 0 && k / 64 % 2 == 0;
            [x as u8 * 8, y as u8 * 8, (x * y) as u8, u8::from(is_dot) * 255]
        });
        let many = Texels::U8(texels.collect());
        let many = Texture::new(Size::square(64), Channels::Rgba, Encoding::Srgb, many).unwrap();
        assert!(matches!(find(&many), Err(DotsError::TooMany | DotsError::Repeated { .. })));
    }

    #[test]
    fn dots_of_the_same_colour_belong_together() {
        let dot = |color, x| Dot { color: DotColor(color), centre_px: [x, 1.0], texels: 9 };
        let source = [dot(RED, 1.0), dot(BLUE, 2.0)];
        let target = [dot([20, 26, 224], 3.0), dot(RED, 4.0)];
        let pairs = matched(&source, &target).unwrap();
        let xs: Vec<_> = pairs.iter().map(|pair| pair.map(|dot| dot.centre_px[0])).collect();
        assert_eq!(xs, [[1.0, 4.0], [2.0, 3.0]]);
        let error = matched(&source, &target[..1]).unwrap_err().to_string();
        let wanted = "the dot #e61414 at (1, 1) of the source image has no dot of its colour in the \
                      other";
        assert_eq!(error, wanted);
        let error = matched(&source[..1], &target).unwrap_err().to_string();
        assert!(error.starts_with("the dot #141ae0 at (3, 1) of the target image"), "{error}");
    }

    #[test]
    fn dots_are_places_on_the_mesh() {
        let positions = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 4.0, 8.0]];
        let uv = vec![[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]];
        let mesh = Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let dot = |centre_px| Dot { color: DotColor(RED), centre_px, texels: 1 };
        let size = Size::new(80, 40);
        let found = places([dot([20.0, 10.0]), dot([40.0, 15.0])], size, &mesh).unwrap();
        assert_eq!(found[0], [0.0; 3]);
        for k in 0..3 {
            assert!((found[1][k] - [1.0, 1.0, 2.0][k]).abs() < 1e-6, "{found:?}");
        }
        let error = places([dot([60.0, 30.0])], size, &mesh).unwrap_err().to_string();
        assert_eq!(error, "the dot #e61414 at (60, 30) must be on a UV island of the mesh");
    }
}
