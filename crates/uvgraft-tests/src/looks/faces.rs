//! Painted faces: captures of people who do not exist, in the layout of a head mesh.

use uvgraft::Mesh;

use super::frame::Piece;
use super::noise::{Point, bell, curve, fractal, mix, noise, smoothstep};
use super::skin::{Dye, blend, cloth, linear, scaled};
use super::{Color, HeadFrame, Label, Layout, Painted, Skin, Spot};

/// The colour of hair and brows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HairColor {
    /// Nearly no colour, with blue gloss.
    Black,
    /// Chestnut.
    Brown,
    /// As light as light skin.
    Blond,
    /// White and dark hairs.
    Grey,
    /// None on the skull; brows are brown.
    Bald,
}

impl HairColor {
    fn color(self) -> Color {
        match self {
            Self::Black => [0.085, 0.075, 0.075],
            Self::Brown | Self::Bald => [0.27, 0.175, 0.115],
            Self::Blond => [0.66, 0.51, 0.33],
            Self::Grey => [0.55, 0.545, 0.54],
        }
    }
}

/// What grows below the nose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beard {
    /// Nothing.
    Shaved,
    /// Dark dots; counts as skin.
    Stubble,
    /// A full beard; counts as hair.
    Full,
}

/// The cloth at the neck.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collar {
    /// How it is dyed.
    pub dye: Dye,
    /// How high it reaches: 0 for a crew neck, 1 for a polo neck.
    pub height: f32,
    /// How far its upper edge goes up and down, in centimetres.
    pub unevenness: f32,
}

impl Collar {
    /// A crew neck of one colour.
    pub const fn plain(color: Color) -> Self {
        Self { dye: Dye::Plain(color), height: 0.0, unevenness: 0.15 }
    }

    /// The same with another height and unevenness.
    #[must_use]
    pub const fn cut(self, height: f32, unevenness: f32) -> Self {
        Self { height, unevenness, ..self }
    }
}

/// Who is painted, and how they were captured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceLook {
    /// The name in tables.
    pub name: &'static str,
    /// The complexion.
    pub skin: Skin,
    /// Hair and brows.
    pub hair: HairColor,
    /// Whether hair falls over the forehead.
    pub fringe: bool,
    /// What grows below the nose.
    pub beard: Beard,
    /// Whether there are glasses.
    pub glasses: bool,
    /// The cloth at the neck.
    pub collar: Option<Collar>,
    /// How much darker the neck is than the face: 0 for what only ambient light does.
    pub neck_shade: f32,
    /// How many times baked light doubles from the right ear to the left.
    pub light_ramp: f32,
    /// Of all noise.
    pub seed: u32,
}

impl FaceLook {
    /// Short brown hair and nothing else.
    pub const fn new(name: &'static str, skin: Skin) -> Self {
        Self {
            name,
            skin,
            hair: HairColor::Brown,
            fringe: false,
            beard: Beard::Shaved,
            glasses: false,
            collar: None,
            neck_shade: 0.15,
            light_ramp: 0.0,
            seed: 1,
        }
    }

    /// Faces that between them have all that is difficult.
    pub fn all() -> Vec<Self> {
        let (white, black) = ([0.93, 0.935, 0.95], [0.055, 0.055, 0.065]);
        let blue = [0.25, 0.42, 0.70];
        let new = Self::new;
        let mut looks = vec![
            new("very light, white collar", Skin::VERY_LIGHT)
                .hair(HairColor::Blond)
                .collar(Collar::plain(white)),
            new("light, beige collar", Skin::LIGHT).collar(Collar::plain([0.80, 0.68, 0.56])),
            new("olive, striped collar", Skin::OLIVE).hair(HairColor::Black).collar(Collar {
                dye: Dye::Striped(blue, white),
                height: 0.25,
                unevenness: 0.9,
            }),
            new("medium, polo neck", Skin::MEDIUM).collar(Collar::plain(black).cut(1.0, 0.2)),
            new("brown, no collar", Skin::BROWN).hair(HairColor::Black),
            new("dark, ragged white collar", Skin::DARK)
                .hair(HairColor::Black)
                .collar(Collar::plain(white).cut(0.2, 1.4)),
            new("very dark, black collar", Skin::VERY_DARK)
                .hair(HairColor::Bald)
                .collar(Collar::plain(black)),
            new("reddish, beard", Skin::REDDISH).hair(HairColor::Grey),
            new("blue", Skin::BLUE).hair(HairColor::Black),
            new("grey capture", Skin::GREY).hair(HairColor::Black).collar(Collar::plain([0.3; 3])),
            new("light, lit from beside", Skin::LIGHT).hair(HairColor::Blond),
        ];
        looks[2].fringe = true;
        looks[3].beard = Beard::Stubble;
        looks[3].neck_shade = 0.4;
        looks[4].glasses = true;
        looks[7].beard = Beard::Full;
        looks[10].light_ramp = 1.2;
        looks[10].neck_shade = 0.5;
        (0..).zip(&mut looks).for_each(|(seed, look)| look.seed = 100 * seed);
        looks
    }

    /// The same with other hair.
    #[must_use]
    pub const fn hair(self, hair: HairColor) -> Self {
        Self { hair, ..self }
    }

    /// The same with a collar.
    #[must_use]
    pub const fn collar(self, collar: Collar) -> Self {
        Self { collar: Some(collar), ..self }
    }

    /// Paints the face in the layout of a head.
    ///
    /// - `layout`: of `mesh`.
    pub fn paint(&self, mesh: &Mesh, frame: &HeadFrame, layout: &Layout) -> Painted {
        let pieces = frame.pieces(mesh);
        layout.paint(|spot| {
            let p = frame.local(spot.position);
            let (color, label) = self.at(frame, pieces[spot.face as usize], p, spot);
            (self.captured(p, color), label)
        })
    }

    /// Baked light, and a camera that may see no colours.
    pub(super) fn captured(&self, p: Point, color: Color) -> Color {
        let color = scaled(color, (self.light_ramp * p[0] / 16.0).exp2());
        if !self.skin.is_grey() {
            return color;
        }
        [0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]; 3]
    }

    /// Linear light and label of a place.
    pub(super) fn at(
        &self,
        frame: &HeadFrame,
        piece: Piece,
        p: Point,
        spot: &Spot,
    ) -> (Color, Label) {
        match piece {
            Piece::Eyeball => return (self.eye(frame, p), Label::Eye),
            Piece::HairShell if self.hair != HairColor::Bald => {
                return (self.strands(p, 0.0), Label::Hair);
            }
            _ => {}
        }
        if frame.is_in_eye(p, 0.93) {
            return (linear([0.25, 0.12, 0.10]), Label::Other);
        }
        if let Some(mouth) = self.mouth_inside(frame, p) {
            return (mouth, Label::Mouth);
        }
        let mut color = self.lit_skin(frame, p, spot.normal);
        let mut label = Label::Skin;
        let mut lay = |over: Color, cover: f32, what: Label| {
            color = blend(color, over, cover);
            if cover > 0.5 {
                label = what;
            }
        };
        lay(self.lip(frame, p), lip_cover(frame, p), Label::BrowLip);
        let brow = self.brow_cover(frame, p);
        lay(self.strands(p, 0.6), brow, Label::BrowLip);
        let (beard, is_hair) = self.beard_cover(frame, p);
        lay(self.whiskers(p), beard, if is_hair { Label::Hair } else { Label::Skin });
        lay(linear([0.06, 0.04, 0.035]), lash_cover(frame, p), Label::Other);
        if self.hair != HairColor::Bald {
            lay(self.strands(p, 0.0), self.hair_cover(frame, p), Label::Hair);
        }
        if let Some(collar) = &self.collar {
            let above = collar.above(frame, p, self.seed);
            // The shadow that it casts.
            let shade = 0.45 * smoothstep(0.9, 0.0, above);
            lay([0.0; 3], if above > 0.0 { shade } else { 0.0 }, Label::Skin);
            let seam = 1.0 - 0.3 * bell(above + 0.8, 0.1);
            let cloth = scaled(cloth(collar.dye, p, spot.normal, self.seed + 9), seam);
            lay(cloth, smoothstep(0.03, -0.03, above), Label::Cloth);
        }
        if self.glasses {
            let gloss = 0.03 * smoothstep(0.2, 0.6, spot.normal[1]);
            lay([0.012 + gloss; 3], glasses_cover(frame, p), Label::Other);
        }
        (color, label)
    }

    /// Skin with blood, hollows, shine.
    fn lit_skin(&self, frame: &HeadFrame, p: Point, normal: [f32; 3]) -> Color {
        let (x, y, z) = (p[0].abs(), p[1], p[2]);
        let front = smoothstep(-3.5, 0.0, z);
        let [nose_y, nose_z] = frame.nose;
        let cheek = bell(x - 4.2, 2.7) * bell(y - nose_y - 0.1, 2.6) * front;
        let nose = bell(x, 1.3) * bell(y - nose_y, 1.2) * smoothstep(nose_z - 2.5, nose_z, z);
        let chin = bell(x, 1.8) * bell(y - frame.chin - 1.2, 1.2) * front;
        let ear = smoothstep(7.2, 8.2, x) * smoothstep(3.5, 1.5, y) * smoothstep(-8.0, -5.0, y);
        let flush = 0.9 * cheek + 0.8 * nose + 0.3 * chin + 0.8 * ear
            - 0.35 * smoothstep(frame.chin, frame.chin - 6.0, y);
        let mut color = self.skin.at(p, flush, self.seed);
        let socket = bell(x - frame.eye[0] + 0.5, 2.0) * bell(y - 0.5, 1.2);
        let bag = bell(x - frame.eye[0], 1.5) * bell(y + 1.6, 0.4);
        let wing = bell(x - 1.75, 0.35) * bell(y - nose_y + 0.7, 0.9) * smoothstep(0.5, 2.0, z);
        let nostril =
            bell(x - 0.7, 0.38) * bell(y - nose_y + 1.0, 0.32) * smoothstep(-0.1, -0.5, normal[1]);
        let under_lip = bell(x, 1.5) * bell(y - frame.lips[2] + 0.6, 0.45) * front;
        let under_chin =
            smoothstep(0.1, -0.7, normal[1]) * smoothstep(frame.chin + 3.0, frame.chin, y);
        let neck = smoothstep(frame.chin + 1.0, frame.chin - 2.5, y);
        let behind = smoothstep(-1.0, -13.0, z) * smoothstep(5.0, 0.0, y);
        let hollow = 0.34 * socket
            + 0.15 * bag
            + 0.4 * wing
            + 0.9 * nostril
            + 0.2 * under_lip
            + 0.35 * under_chin
            + self.neck_shade * neck
            + 0.15 * behind;
        let light = 0.92 + 0.08 * normal[1] + 0.08 * normal[2];
        // What reaches hollows went through skin and is redder.
        let dim = (1.0 - hollow).clamp(0.06, 1.0);
        let gain = if self.skin.is_grey() {
            [dim; 3]
        } else {
            [dim.powf(0.85), dim, dim * dim.powf(0.06)]
        };
        color = [0, 1, 2].map(|k| color[k] * gain[k] * light);
        let gloss =
            0.16 * bell(x, 0.5) * bell(y - nose_y - 0.3, 0.8) * smoothstep(nose_z - 1.5, nose_z, z)
                + 0.09 * bell(x - 1.0, 2.2) * bell(y - 0.65 * frame.hairline, 1.2) * front
                + 0.035 * bell(x - 4.6, 1.4) * bell(y + 1.9, 0.9) * front;
        // Oil shines as brightly on dark skin, but less of it is blurred below the surface.
        let rough = 1.0 + 0.6 * fractal(p, 0.5, self.seed + 51);
        let rough = rough * (0.3 + 0.7 * self.skin.0[1]);
        color.map(|value| value + gloss * rough)
    }

    fn eye(&self, frame: &HeadFrame, p: Point) -> Color {
        let q = [p[0].abs() - frame.eye[0], p[1] - frame.eye[1], p[2] - frame.eye[2]];
        let across = q[0].hypot(q[1]) / frame.eye_radius;
        let side = p[0].signum();
        let veins =
            smoothstep(0.8, 1.0, 1.0 - noise([q[0] * 5.0, q[1] * 7.0, side], self.seed + 61).abs());
        let mut color = blend(
            linear([0.86, 0.83, 0.80]),
            linear([0.75, 0.50, 0.45]),
            0.35 * veins * smoothstep(0.5, 0.9, across),
        );
        color = scaled(color, 1.0 - 0.3 * smoothstep(0.0, 0.6, q[1]));
        if q[2] > 0.0 {
            let angle = q[1].atan2(q[0]);
            let fibres = noise([angle * 9.0, across * 6.0, side], self.seed + 62);
            let iris = scaled(linear([0.33, 0.22, 0.13]), 1.0 + 0.5 * fibres);
            color = blend(color, iris, smoothstep(0.49, 0.45, across));
            color = blend(color, [0.004; 3], smoothstep(0.21, 0.18, across));
            let glint = (q[0] * side + 0.25).hypot(q[1] - 0.25) / frame.eye_radius;
            color = blend(color, [0.85; 3], smoothstep(0.11, 0.08, glint));
        }
        blend(color, linear([0.45, 0.2, 0.17]), smoothstep(0.3, -0.3, q[2]))
    }

    fn mouth_inside(&self, frame: &HeadFrame, p: Point) -> Option<Color> {
        let x = p[0] / frame.mouth_width;
        let [top, middle, bottom] = frame.lips;
        let depth = frame.mouth_depth - 1.2 * x * x;
        // Below the lower lip's border the chin begins, in front of the mouth's floor.
        let depth = if p[1] < bottom + 0.2 { depth - 0.9 } else { depth };
        if x.abs() > 1.0 || !(bottom - 0.7..top).contains(&p[1]) || p[2] > depth || p[2] < -1.0 {
            return None;
        }
        let gap = smoothstep(0.06, 0.02, (p[0] / 0.75 - (p[0] / 0.75).floor() - 0.5).abs());
        let tooth = smoothstep(middle - 0.75, middle - 0.6, p[1]) * (1.0 - 0.75 * gap);
        Some(blend(linear([0.20, 0.06, 0.06]), linear([0.80, 0.76, 0.68]), tooth))
    }

    fn lip(&self, frame: &HeadFrame, p: Point) -> Color {
        let skin = linear(self.skin.0);
        let red = [skin[0] * 0.80, skin[1] * 0.44, skin[2] * 0.50];
        let red = if self.skin.is_grey() { scaled(skin, 0.5) } else { red };
        let creases = noise([p[0] * 5.0, p[1] * 0.8, 0.0], self.seed + 71);
        let upper = if p[1] > frame.lips[1] { 0.85 } else { 1.05 };
        let line = 1.0 - 0.75 * bell(p[1] - lip_line(frame, p), 0.12);
        scaled(red, upper * line * (1.0 + 0.14 * creases))
    }

    /// Hair with its strands; brows and beards vary less.
    fn strands(&self, p: Point, calm: f32) -> Color {
        let q = [p[0], p[1] - 7.0, p[2] + 9.0];
        let around = q[0].atan2(q[2]) + 0.25 * noise(p.map(|value| value * 0.25), self.seed + 80);
        let polar = q[0].hypot(q[2]).atan2(q[1]);
        let strand = 0.5 * noise([around * 26.0, polar * 1.5, 0.0], self.seed + 81)
            + 0.5 * noise([around * 60.0, polar * 3.0, 0.0], self.seed + 82);
        let lock = noise([around * 7.0, polar, 0.0], self.seed + 83);
        let gloss = bell(polar - 0.8 - 0.1 * lock, 0.25) * (1.0 - calm);
        let light = 0.8 + 0.45 * strand + 0.25 * lock + 0.55 * gloss;
        let base = linear(self.hair.color());
        let spread = if self.hair == HairColor::Grey { 0.5 * strand } else { 0.0 };
        scaled(base, (light + spread).max(0.15))
    }

    /// Short hairs that hang down.
    fn whiskers(&self, p: Point) -> Color {
        let curl = 0.4 * noise(p, self.seed + 92);
        let strand = noise([p[0] * 5.0 + curl, p[1] * 1.1, p[2] * 5.0], self.seed + 93);
        let finer = noise([p[0] * 11.0 + curl, p[1] * 2.4, p[2] * 11.0], self.seed + 94);
        let light = 0.75 + 0.3 * strand + 0.3 * finer + 0.15 * fractal(p, 2.0, self.seed + 95);
        scaled(linear(self.hair.color()), light.max(0.15))
    }

    fn hair_cover(&self, frame: &HeadFrame, p: Point) -> f32 {
        let around = p[0].abs().atan2(p[2] + 7.2);
        let top = frame.hairline;
        let fringe = if self.fringe { 0.48 * top } else { top };
        let line = curve(
            &[
                (0.0, fringe),
                (0.6, fringe - 0.3),
                (0.95, mix(fringe, 3.2, 0.6)),
                (1.12, 0.5),
                (1.22, -2.6),
                (1.45, -2.0),
                (1.52, 2.6),
                (1.95, 2.2),
                (2.05, -3.0),
                (2.5, -7.5),
                (3.2, -9.0),
            ],
            around,
        );
        let ragged = 0.45 * noise([around * 9.0, 0.0, 0.0], self.seed + 84)
            + 0.35 * noise([around * 40.0, p[1] * 0.4, 0.0], self.seed + 85);
        let ragged = ragged * if self.fringe { 1.8 } else { 1.0 };
        // Ears are free.
        let ear = smoothstep(8.0, 8.2, p[0].abs()) * smoothstep(4.2, 3.9, p[1]);
        smoothstep(-0.35, 0.35, p[1] - line + ragged) * (1.0 - ear)
    }

    fn brow_cover(&self, frame: &HeadFrame, p: Point) -> f32 {
        let x = p[0].abs() - frame.eye[0] + 3.2;
        if !(1.0..6.2).contains(&x) || p[2] < -3.5 {
            return 0.0;
        }
        let arch = curve(&[(1.2, -0.25), (2.4, 0.0), (3.9, 0.3), (4.8, 0.15), (5.7, -0.5)], x);
        let half = curve(&[(1.2, 0.30), (1.8, 0.48), (3.4, 0.42), (4.6, 0.28), (5.8, 0.04)], x);
        let off = p[1] - frame.brow - arch;
        let strand = noise([(x - off * 1.2) * 8.0, off * 2.0, 0.0], self.seed + 86);
        let body = 1.0 - (off / half).abs() + 0.45 * strand;
        0.92 * smoothstep(0.0, 0.55, body) * smoothstep(1.1, 1.7, x) * smoothstep(5.9, 5.2, x)
    }

    /// Coverage, and whether that is hair or skin with dots.
    fn beard_cover(&self, frame: &HeadFrame, p: Point) -> (f32, bool) {
        if self.beard == Beard::Shaved {
            return (0.0, false);
        }
        let x = p[0].abs();
        let under = frame.lips[0] + 0.9 - 0.04 * (x - 2.0).powi(2);
        let sideburn = smoothstep(-2.2, -4.2, p[2]) * smoothstep(-7.0, -5.5, p[2]);
        let upper = mix(under - 0.25 * (x - 2.0).max(0.0), -1.0, sideburn);
        let ragged = 0.5 * noise(p, self.seed + 87)
            + 0.3 * noise(p.map(|value| value * 3.0), self.seed + 88);
        let below = smoothstep(0.3, -0.4, p[1] - upper + ragged)
            * smoothstep(frame.chin - 3.4, frame.chin - 2.4, p[1] + ragged)
            * smoothstep(-7.2, -6.0, p[2]);
        let below = below * (1.0 - lip_cover(frame, p));
        let dots = noise(p.map(|value| value * 7.0), self.seed + 89);
        match self.beard {
            Beard::Full => (below * (0.94 + 0.06 * dots), true),
            _ => (below * (0.24 + 0.16 * dots), false),
        }
    }
}

impl Collar {
    /// How far a place is above the collar's upper edge, in centimetres.
    fn above(&self, frame: &HeadFrame, p: Point, seed: u32) -> f32 {
        let [slope, crew, polo] = frame.collar;
        let beyond = 0.6 * (p[0].abs() - 4.5).max(0.0) * (1.0 - self.height);
        let around = p[0].atan2(p[2] + 9.0);
        let wave = noise([around * 2.6, 0.0, 0.5], seed + 90)
            + 0.3 * noise([around * 9.0, 0.0, 0.5], seed + 91);
        p[1] + slope * p[2] - beyond - mix(crew, polo, self.height) - self.unevenness * wave
    }
}

fn lip_line(frame: &HeadFrame, p: Point) -> f32 {
    frame.lips[1] + 0.25 * (p[0] / frame.mouth_width).powi(2)
}

fn lip_cover(frame: &HeadFrame, p: Point) -> f32 {
    let x = (p[0] / frame.mouth_width).abs();
    if x > 1.0 || p[2] < -1.0 {
        return 0.0;
    }
    let arch = (1.0 - x * x).max(0.0).powf(0.8);
    let line = lip_line(frame, p);
    let top = line + (frame.lips[0] - frame.lips[1]) * arch - 0.12 * bell(p[0], 0.4);
    let bottom = line + (frame.lips[2] - frame.lips[1]) * arch;
    smoothstep(0.08, -0.08, p[1] - top) * smoothstep(-0.1, 0.1, p[1] - bottom)
}

fn lash_cover(frame: &HeadFrame, p: Point) -> f32 {
    let width = 1.15 * frame.eye_radius;
    let x = (p[0].abs() - frame.eye[0]) / width;
    if x.abs() > 1.0 || p[2] < -0.6 * frame.eye_radius {
        return 0.0;
    }
    let arch = (1.0 - x * x).sqrt();
    let [upper, lower] = frame.lids;
    let line =
        bell(p[1] - upper * arch - 0.05, 0.13) + 0.35 * bell(p[1] - lower * arch + 0.03, 0.08);
    (0.9 * line).min(0.9)
}

/// Round lenses, a bridge, and arms to the ears.
fn glasses_cover(frame: &HeadFrame, p: Point) -> f32 {
    let x = p[0].abs();
    let ring = ((x - frame.eye[0] - 0.1) / 2.55).hypot((p[1] + 0.35) / 2.2) - 1.0;
    let bridge = bell(p[1] - 0.25, 0.22) * smoothstep(0.9, 0.7, x);
    let arm = bell(p[1] - 0.4, 0.24) * smoothstep(5.6, 5.9, x) * smoothstep(-8.5, -8.0, p[2]);
    let front = smoothstep(-3.0, -2.0, p[2]);
    (front * (smoothstep(0.10, 0.06, ring.abs()) + bridge) + arm).min(1.0)
}
