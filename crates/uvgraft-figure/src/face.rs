//! Paints the face: the head's texture.

use glam::{Vec3, vec3};
use uvgraft::easing::{bell, mix, smoothstep};
use uvgraft::{Size, Texture};
use uvgraft_avatar::paint::noise::{noise2, random};

use super::Figure;
use super::bake::{Color, Spot, bake, blend, scaled};
use super::complexion::{HAIR, ear, eye, flushed, freckles, hair, hair_cover, skin};
use super::head_shape::{
    EYE, EYE_LEVEL, LID_WIDTH, LIP_WIDTH, MOUTH_Y, lip_bottom, lip_line, lip_top, lower_lid,
    upper_lid,
};
use super::surface::{PartKind, Side};
use crate::curve::curve;
use crate::symmetry::Symmetry as _;

const BACKGROUND: Color = [0.42, 0.31, 0.26];

/// Paints the figure's face, hair, ears and eyes in the head's UV layout, as 8-bit sRGB.
///
/// Details are as small as a few tenths of a millimetre, which a texture of 4096² resolves. The
/// result is deterministic.
///
/// # Panics
/// If `size` has no texels or a side longer than [`Texture::MAX_SIDE`].
pub fn paint_head(figure: &Figure, size: Size) -> Texture {
    bake(&figure.head, &figure.head_parts, size, BACKGROUND, color)
}

fn color(spot: &Spot) -> Color {
    let p = spot.position - vec3(0.0, EYE_LEVEL, 0.0);
    match spot.part.kind {
        PartKind::Eye => eye(p, if spot.part.side == Side::Left { 1.0 } else { -1.0 }),
        PartKind::Ear => ear(p),
        PartKind::Hair => hair(p),
        _ => face(p, spot.normal),
    }
}

fn face(p: Vec3, normal: Vec3) -> Color {
    let cover = hair_cover(p);
    if cover >= 1.0 {
        return scaled(hair(p), 0.75);
    }
    let mut color = skin(p + vec3(0.0, EYE_LEVEL, 0.0));
    if p.z > 1.5 && p.y > -12.5 {
        color = complexion(color, p);
        color = hollows(color, p, normal);
        color = eye_region(color, p);
        color = brow(color, p);
        if p.y < -5.5 {
            color = mouth(color, p);
        }
    }
    if cover > 0.0 { blend(color, scaled(hair(p), 0.8), cover) } else { color }
}

/// Blush, freckles and slow changes of tone over the face.
fn complexion(mut color: Color, p: Vec3) -> Color {
    let x = p.x.abs();
    let cheek = bell(x - 4.2, 2.0) * bell(p.y + 3.6, 1.7);
    let nose = bell(x, 1.2) * bell(p.y + 3.8, 1.2) * smoothstep(8.5, 9.8, p.z);
    let chin = bell(x, 1.6) * bell(p.y + 10.2, 1.2);
    color = flushed(color, 0.34 * cheek + 0.30 * nose + 0.14 * chin);
    let forehead = smoothstep(2.5, 5.0, p.y);
    color = blend(color, [0.92, 0.74, 0.62], 0.25 * forehead);
    let density = 0.62 * bell(x - 2.9, 2.4) * bell(p.y + 2.6, 1.3)
        + 0.45 * bell(x, 1.0) * bell(p.y + 2.2, 1.5);
    // Freckles are placed in the frontal plane and would be stretched where the face turns away.
    let density = density * smoothstep(4.2, 6.0, p.z);
    blend(color, [0.64, 0.40, 0.28], 0.45 * freckles(p, density))
}

/// Shade where little light arrives: nostrils, beside the nose, under the lip.
fn hollows(mut color: Color, p: Vec3, normal: Vec3) -> Color {
    let q = p.folded();
    if (-6.0..-3.0).contains(&p.y) && p.z > 6.5 {
        let nostril = q - vec3(0.55, -4.72, 9.1);
        let nostril = vec3(nostril.x / 0.36, nostril.y / 0.34, nostril.z / 0.5).length();
        let below = smoothstep(0.25, -0.2, normal.y);
        color = blend(color, [0.20, 0.07, 0.06], smoothstep(1.15, 0.7, nostril) * below);
        let wing = ((q.x - 1.12).powi(2) / 0.6 + (p.y + 4.15).powi(2) / 0.52).sqrt();
        let crease =
            bell(wing - 0.98, 0.16) * smoothstep(1.25, 1.6, q.x) * smoothstep(9.3, 8.6, p.z);
        color = blend(color, [0.56, 0.27, 0.22], 0.5 * crease);
    }
    let smile_line = bell(q.x - mix(1.9, 3.0, (-4.4 - p.y) / 2.6), 0.22)
        * smoothstep(-4.2, -5.0, p.y)
        * smoothstep(-7.2, -6.2, p.y);
    let under_lip = bell(p.x, 1.1) * bell(p.y + 8.55, 0.3);
    color = blend(color, [0.66, 0.38, 0.31], 0.13 * smile_line + 0.26 * under_lip);
    let beneath = smoothstep(-0.35, -0.9, normal.y) * smoothstep(-9.5, -11.0, p.y);
    scaled(color, 1.0 - 0.12 * beneath)
}

/// Lids with their fold, lashes, and the shade around the eye.
///
/// Layers are blended from bottom to top: socket and bag, the fold above the upper lid, the wet
/// edge, the lash line and single lashes. All are functions of `above` and `below`, the heights
/// over the upper and under the lower lid's edge.
fn eye_region(mut color: Color, p: Vec3) -> Color {
    let dx = p.x.abs() - EYE.x;
    if dx.abs() > 2.3 || p.y.abs() > 2.2 || p.z < 4.5 {
        return color;
    }
    let inside = smoothstep(2.2, 1.2, dx.abs());
    let socket = bell(dx, 1.9) * bell(p.y - 0.35, 0.9);
    color = blend(color, [0.64, 0.40, 0.35], 0.28 * socket);
    let bag = bell(dx + 0.2, 1.3) * bell(p.y + 1.15, 0.25);
    color = blend(color, [0.62, 0.42, 0.42], 0.16 * bag);

    let x = dx.clamp(-LID_WIDTH, LID_WIDTH);
    let above = p.y - upper_lid(x);
    let below = lower_lid(x) - p.y;
    let span = 1.0 - (dx.abs() - LID_WIDTH).max(0.0) / 0.2;
    let span = span.clamp(0.0, 1.0);
    let fold = above - 0.30 * (1.0 - 0.5 * (x / LID_WIDTH).powi(2));
    color = blend(color, [0.40, 0.20, 0.17], 0.5 * bell(fold, 0.05) * inside * span);
    color = blend(color, [0.58, 0.34, 0.30], 0.35 * bell(fold - 0.08, 0.14) * inside * span);
    // The wet edge of the lids and the corner of the eye.
    let rim = smoothstep(0.03, -0.02, above.max(below));
    color = blend(color, [0.82, 0.50, 0.45], 0.85 * rim * span);
    // Lashes grow from a dark line that is thicker outwards.
    let outwards = (x / LID_WIDTH + 1.0) * 0.5;
    let width = mix(0.05, 0.13, outwards);
    let line = smoothstep(-0.14, -0.06, above) * smoothstep(width, width * 0.5, above);
    let line = line * smoothstep(-1.5, -1.2, dx) * span;
    color = blend(color, [0.07, 0.045, 0.04], 0.95 * line);
    if above > 0.0 && above < 0.6 {
        let length = mix(0.16, 0.46, outwards);
        let root = dx - above * mix(-0.3, 0.75, outwards);
        let lash = lash_at(root, 0.085, above / length, 81);
        color = blend(
            color,
            [0.07, 0.045, 0.04],
            0.9 * lash * smoothstep(-1.4, -1.0, root) * smoothstep(2.0, 1.75, dx),
        );
    }
    if below > -0.05 && below < 0.3 {
        let root = dx - below * mix(-0.5, 0.9, outwards);
        let lash = lash_at(root, 0.13, below / 0.2, 82);
        let line = bell(below - 0.01, 0.035) * 0.35;
        color = blend(color, [0.16, 0.09, 0.07], (0.55 * lash).max(line) * span);
    }
    color
}

/// Coverage by lashes with roots `spacing` apart; `t` runs from root to tip.
fn lash_at(root: f32, spacing: f32, t: f32, seed: u32) -> f32 {
    if root.abs() > LID_WIDTH + 0.12 {
        return 0.0;
    }
    let number = (root / spacing).floor();
    let length = 0.65 + 0.35 * random(number as i32, 0, 0, seed);
    let t = t / length;
    let offset = (root / spacing - number - 0.5).abs() * 2.0;
    smoothstep(0.9 * (1.0 - t).max(0.0), 0.35 * (1.0 - t).max(0.0), offset)
        * smoothstep(1.0, 0.85, t)
}

fn brow(color: Color, p: Vec3) -> Color {
    let x = p.x.abs();
    if !(1.0..6.2).contains(&x) || !(0.9..3.6).contains(&p.y) {
        return color;
    }
    let middle = curve(&[(1.3, 1.72), (2.4, 2.05), (3.9, 2.42), (4.8, 2.22), (5.6, 1.62)], x);
    let half = curve(&[(1.2, 0.24), (1.7, 0.40), (3.2, 0.38), (4.4, 0.26), (5.7, 0.04)], x);
    let off = p.y - middle;
    // Hairs lean outwards: upwards at the inner end, downwards at the tail.
    let lean = mix(0.4, 2.2, smoothstep(1.2, 3.4, x)) * if off > 0.0 { 1.0 } else { 0.75 };
    let strand = noise2((x - off * lean) * 17.0, off * 2.0 + x, 83) * 0.6
        + noise2((x - off * lean) * 36.0, off * 3.0, 84) * 0.4;
    let body = 1.0 - (off / half).abs() + 0.5 * strand;
    let ends = smoothstep(1.15, 1.75, x + 0.2 * strand) * smoothstep(5.75, 5.0, x);
    let cover = smoothstep(0.0, 0.5, body) * ends;
    blend(color, scaled(HAIR, 0.72 + 0.3 * strand), 0.9 * cover)
}

fn mouth(mut color: Color, p: Vec3) -> Color {
    if p.x.abs() > 3.2 || (p.y - MOUTH_Y).abs() > 1.6 {
        return color;
    }
    let x = p.x.clamp(-LIP_WIDTH, LIP_WIDTH);
    let (top, line, bottom) = (lip_top(x), lip_line(x), lip_bottom(x));
    let corner = smoothstep(LIP_WIDTH + 0.25, LIP_WIDTH - 0.15, p.x.abs());
    let inside = smoothstep(0.06, -0.08, p.y - top) * smoothstep(-0.06, 0.1, p.y - bottom) * corner;
    let creases = noise2(p.x * 11.0 + 0.6 * p.x * (p.y - line), p.y * 0.8, 85) * 0.6
        + noise2(p.x * 27.0, p.y * 3.0, 86) * 0.4;
    let upper = p.y > line;
    let mut lip: Color = if upper { [0.70, 0.375, 0.355] } else { [0.79, 0.45, 0.42] };
    let t = if upper {
        (p.y - line) / (top - line).max(0.05)
    } else {
        (line - p.y) / (line - bottom).max(0.05)
    };
    lip = scaled(lip, 1.0 + 0.06 * creases - 0.14 * smoothstep(0.4, 0.0, t));
    if !upper {
        let gloss = bell(t - 0.42, 0.2) * bell(p.x, 1.0);
        lip = blend(lip, [0.93, 0.68, 0.63], (0.5 * gloss * (0.8 + 0.5 * creases)).clamp(0.0, 1.0));
    }
    color = blend(color, lip, 0.92 * inside);
    // A light edge above the upper lip, and the line between the lips.
    let edge = bell(p.y - top - 0.12, 0.09) * smoothstep(2.0, 0.8, p.x.abs());
    color = blend(color, [0.95, 0.77, 0.68], 0.3 * edge);
    let seam = smoothstep(0.085, 0.03, (p.y - line).abs()) * smoothstep(2.75, 2.3, p.x.abs());
    color = blend(color, [0.26, 0.08, 0.08], 0.85 * seam);
    let dimple = bell(p.x.abs() - LIP_WIDTH - 0.06, 0.16) * bell(p.y - lip_line(LIP_WIDTH), 0.14);
    color = blend(color, [0.50, 0.25, 0.21], 0.5 * dimple);
    // The inside of the mouth.
    blend(
        color,
        [0.22, 0.06, 0.06],
        smoothstep(7.6, 6.9, p.z) * smoothstep(2.3, 2.0, p.x.abs()) * corner,
    )
}
