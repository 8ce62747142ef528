//! The colours of a mouth, with soft shading: light comes in from the front only.

use std::f32::consts::TAU;

use uvgraft::easing::{bell, mix, smoothstep};
use uvgraft::{Size, Texture};

use super::piece::Chart;
use super::rim::Rim;
use super::teeth::{LOWER_MM, ROWS, UPPER_MM};
use crate::Avatar;
use crate::atlas::ChartRect;
use crate::paint::texel::{Color, blend, put, srgb};

const MUCOSA: Color = [0.50, 0.20, 0.19];
const GUM: Color = [0.74, 0.44, 0.43];
const ENAMEL: Color = [0.94, 0.91, 0.85];
const NECK_OF_TOOTH: Color = [0.88, 0.81, 0.68];
const TONGUE: Color = [0.76, 0.43, 0.42];

fn shade(color: Color, light: f32) -> Color {
    // In the dark, the remaining light has been reflected by red walls.
    let tint = [1.0, 1.0 - 0.22 * (1.0 - light), 1.0 - 0.24 * (1.0 - light)];
    std::array::from_fn(|k| color[k] * light * tint[k])
}

/// Colours of the texture at the vertices of the rim, in sRGB.
pub(super) fn rim_colors(avatar: &Avatar, rim: &Rim, texture: &Texture) -> Vec<Color> {
    let mut uv = vec![None; avatar.mesh.positions().len()];
    for (face, corners) in avatar.mesh.faces().iter().zip(avatar.mesh.uv_faces()) {
        for (vertex, corner) in face.iter().zip(corners) {
            uv[*vertex as usize].get_or_insert(*corner);
        }
    }
    let Size { width, height } = texture.size();
    let color = |vertex: &u32| {
        let corner = uv[*vertex as usize]?;
        let [u, v] = avatar.mesh.uv()[corner as usize];
        let texel = |at: f32, side: u32| ((at * side as f32).max(0.0) as u32).min(side - 1);
        Some(srgb(texture, texel(u, width), texel(v, height)))
    };
    let found: Vec<Option<Color>> = rim.vertices.iter().map(color).collect();
    found.into_iter().map(|color| color.unwrap_or(MUCOSA)).collect()
}

/// Paints a rectangle of the layout and its gutter.
///
/// - `color`: called with a point of the chart, which is outside `0.0..=1.0` in the gutter.
pub(super) fn paint(texture: &mut Texture, place: &ChartRect, color: impl Fn([f32; 2]) -> Color) {
    let Size { width, height } = texture.size();
    let range = |from: f32, extent: f32, side: u32| {
        let first = ((from - ChartRect::GUTTER) * side as f32).floor().max(0.0) as u32;
        let end = ((from + extent + ChartRect::GUTTER) * side as f32).ceil() as u32;
        first..end.min(side)
    };
    let columns = range(place.left, place.width, width);
    for y in range(place.top, place.height, height) {
        for x in columns.clone() {
            let uv = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
            let color = color(place.at(uv));
            put(texture, x, y, color);
        }
    }
}

/// The colour of a point of a chart.
pub(super) fn color(chart: Chart, [s, t]: [f32; 2], lips: &[Color]) -> Color {
    match chart {
        Chart::Cavity => cavity(s, t, lips),
        Chart::Upper => teeth(s, t, &UPPER_MM, 1.0),
        Chart::Lower => teeth(s, t, &LOWER_MM, 0.86),
        Chart::Tongue => tongue(s, t),
    }
}

/// From the colour of the lips to that of the mucosa, darkening towards the throat.
fn cavity(s: f32, t: f32, lips: &[Color]) -> Color {
    let at = s.rem_euclid(1.0) * lips.len() as f32;
    let [a, b] = [at as usize, at as usize + 1].map(|k| lips[k % lips.len()]);
    let lip = blend(a, b, at.fract());
    // Next to the teeth the walls are gum, to hide where the strips of teeth come out of them.
    let wall = blend(GUM, MUCOSA, smoothstep(0.25, 0.5, t));
    let light = mix(0.72, 0.07, smoothstep(0.18, 0.8, t));
    blend(lip, shade(wall, light), smoothstep(0.0, 0.17, t))
}

/// A strip of teeth: gum down to the edge in the second row, crowns, and the inner side.
fn teeth(s: f32, t: f32, widths: &[f32; 6], light: f32) -> Color {
    let half: f32 = widths.iter().sum();
    let along = (2.0 * s - 1.0).abs() * half;
    let (mut start, mut tooth) = (0.0, 0);
    while tooth + 1 < widths.len() && along > start + widths[tooth] {
        start += widths[tooth];
        tooth += 1;
    }
    // Distance from the nearest gap between two teeth, in millimetres.
    let gap_mm = (along - start).min(start + widths[tooth] - along).abs();
    let back = (along / half).min(1.0);
    let light = light * mix(1.0, 0.34, smoothstep(0.12, 1.0, back));
    let inner = smoothstep(ROWS[4], ROWS[5], t);
    let gum_at = ROWS[1] - 0.012 + 0.02 * bell(gap_mm, 0.8);
    let gum = {
        let pale = bell(t - gum_at, 0.05);
        let root = 0.08 * (1.0 - bell(gap_mm, 1.6));
        blend(GUM, [0.84, 0.58, 0.56], 0.5 * pale + root)
    };
    let crown = ((t - ROWS[1]) / (ROWS[3] - ROWS[1])).clamp(0.0, 1.0);
    let mut enamel = blend(NECK_OF_TOOTH, ENAMEL, smoothstep(0.0, 0.45, crown));
    // Canines are darker, and the edges of incisors are translucent.
    if tooth == 2 {
        enamel = blend(enamel, NECK_OF_TOOTH, 0.35);
    }
    if tooth < 2 {
        enamel = blend(enamel, [0.82, 0.84, 0.86], 0.5 * smoothstep(0.8, 1.0, crown));
    }
    let crack = 1.0 - 0.5 * bell(gap_mm, 0.35) * if t < ROWS[4] { 1.0 } else { 0.4 };
    let enamel = enamel.map(|value| value * crack);
    let outside = blend(gum, enamel, smoothstep(gum_at - 0.012, gum_at + 0.012, t));
    // On the inner side the crowns end and the gum is in the dark.
    let outside = blend(outside, GUM, smoothstep(0.25, 0.45, inner));
    let root = mix(0.6, 1.0, smoothstep(0.0, 0.8 * ROWS[1], t));
    shade(outside, light * root * mix(1.0, 0.3, smoothstep(0.1, 1.0, inner)))
}

/// Rosy, with a fine grain, a darker groove and a dark back.
fn tongue(s: f32, t: f32) -> Color {
    let groove = 0.14 * bell(s - 0.5, 0.05) * smoothstep(0.05, 0.3, t);
    let grain = 0.025 * ((s * 47.0 * TAU).sin() * (t * 53.0 * TAU).sin());
    let sides = mix(0.45, 1.0, smoothstep(0.0, 0.28, s.min(1.0 - s)));
    let light = mix(0.95, 0.16, smoothstep(0.15, 1.0, t)) * sides;
    let front = mix(0.35, 1.0, smoothstep(0.0, 0.14, t));
    shade(TONGUE, light * front * (1.0 - groove + grain))
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Depth, Encoding};

    use super::*;

    #[test]
    fn paint_stays_in_its_rectangle_and_gutter() {
        let size = Size::square(256);
        let mut texture =
            Texture::filled(size, Channels::Rgb, Encoding::Srgb, Depth::U8, &[0.0, 1.0, 0.0])
                .unwrap();
        let place = ChartRect { left: 0.25, top: 0.5, width: 0.25, height: 0.125, turned: true };
        paint(&mut texture, &place, |_| [1.0, 0.0, 0.0]);
        for (y, x) in (0..256).flat_map(|y| (0..256).map(move |x| (y, x))) {
            let inside = (64..128).contains(&x) && (128..160).contains(&y);
            let near = (63..129).contains(&x) && (127..161).contains(&y);
            let is_red = texture.get(x, y, 0) == 1.0;
            assert!(is_red >= inside && is_red <= near, "{x} {y}");
        }
    }

    #[test]
    fn crowns_are_light_between_gums_and_dark_at_the_back() {
        let value = |chart, at| color(chart, at, &[[0.6, 0.3, 0.3]]).iter().sum::<f32>() / 3.0;
        // Inside the first incisor of the upper arch, and a molar.
        let [incisor, molar] = [0.54, 0.97];
        assert!(value(Chart::Upper, [incisor, 0.6]) > 0.8);
        assert!(value(Chart::Upper, [incisor, 0.25]) < 0.6);
        assert!(value(Chart::Upper, [molar, 0.6]) < 0.5);
        assert!(value(Chart::Cavity, [0.3, 1.0]) < 0.05);
        assert_eq!(color(Chart::Cavity, [0.3, 0.0], &[[0.6, 0.3, 0.3]]), [0.6, 0.3, 0.3]);
    }
}
