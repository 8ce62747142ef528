//! Painted bodies, with or without clothes, each with its own face.

use uvgraft::Mesh;
use uvgraft::easing::{bell, mix, smoothstep};

use super::frame::Piece;
use super::noise::{Point, fractal};
use super::skin::{Dye, blend, cloth, linear, scaled, sparse_hairs};
use super::{BodyFrame, Color, FaceLook, HairColor, Label, LayoutSpots, Painted, SkinTone, Spot};

/// The clothes of a painted body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clothing {
    /// A shirt, and where its sleeves end: 0 at the shoulder, 1 at the wrist.
    pub shirt: Option<(Dye, f32)>,
    /// Trousers, and where their legs end: 0 at the crotch, 1 at the ankles.
    pub trousers: Option<(Dye, f32)>,
}

/// The appearance of a painted body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyLook {
    /// The name in tables.
    pub name: &'static str,
    /// The face painted on the body.
    pub face: FaceLook,
    /// The clothes.
    pub clothing: Clothing,
    /// Density of hairs on arms, legs and chest: 0 for none, 1 for many.
    pub hairiness: f32,
}

const JEANS: Color = [0.17, 0.22, 0.33];

impl BodyLook {
    /// A body without clothes.
    pub const fn new(name: &'static str, skin: SkinTone) -> Self {
        let clothing = Clothing { shirt: None, trousers: None };
        Self { name, face: FaceLook::new(name, skin), clothing, hairiness: 0.0 }
    }

    /// Bodies that together cover all difficult cases.
    pub fn all() -> Vec<Self> {
        let new = Self::new;
        let shorts = |color| Some((Dye::Plain(color), 0.35));
        let mut looks = vec![
            new("very light", SkinTone::VERY_LIGHT),
            new("medium", SkinTone::MEDIUM).dressed(None, shorts([0.30, 0.34, 0.36])),
            new("dark", SkinTone::DARK),
            new("reddish", SkinTone::REDDISH).dressed(None, shorts([0.12, 0.13, 0.16])),
            new("hairy", SkinTone::LIGHT).dressed(None, shorts([0.24, 0.27, 0.22])),
            new("beige shirt", SkinTone::LIGHT)
                .dressed(Some((Dye::Plain([0.79, 0.67, 0.56]), 0.4)), shorts([0.22, 0.22, 0.25])),
            new("pink shirt", SkinTone::VERY_LIGHT)
                .dressed(Some((Dye::Plain([0.90, 0.70, 0.68]), 0.35)), shorts(JEANS)),
            new("brown shirt", SkinTone::BROWN)
                .dressed(Some((Dye::Plain([0.47, 0.335, 0.245]), 0.4)), shorts([0.5, 0.47, 0.4])),
            new("long sleeves", SkinTone::MEDIUM).dressed(
                Some((Dye::Striped([0.16, 0.2, 0.33], [0.9, 0.89, 0.86]), 0.97)),
                Some((Dye::Plain(JEANS), 0.97)),
            ),
        ];
        looks[4].hairiness = 1.0;
        (0..).zip(&mut looks).for_each(|(number, look)| {
            look.face.seed = 5000 + 100 * number;
            let hairs = [HairColor::Black, HairColor::Brown, HairColor::Blond];
            look.face.hair = hairs[number as usize % 3];
        });
        looks
    }

    const fn dressed(self, shirt: Option<(Dye, f32)>, trousers: Option<(Dye, f32)>) -> Self {
        Self { clothing: Clothing { shirt, trousers }, ..self }
    }

    /// Paints the body in its layout.
    ///
    /// - `layout`: the layout of `mesh`.
    pub fn paint(&self, mesh: &Mesh, frame: &BodyFrame, layout: &LayoutSpots) -> Painted {
        let pieces = frame.head.pieces(mesh);
        layout.paint(|spot| {
            let p = frame.head.local(spot.position);
            let (color, label) = self.at(frame, pieces[spot.face as usize], p, spot);
            (self.face.captured(p, color), label)
        })
    }

    fn at(&self, frame: &BodyFrame, piece: Piece, p: Point, spot: &Spot) -> (Color, Label) {
        let seed = self.face.seed;
        if piece == Piece::Shoe {
            return (
                cloth(Dye::Plain([0.55, 0.2, 0.17]), p, spot.normal, seed + 200),
                Label::Cloth,
            );
        }
        for (dye, above) in self.worn(frame, p).into_iter().flatten() {
            if above < 0.0 {
                // The hem is folded over.
                let hem = 1.0 - 0.28 * bell(above + 1.6, 0.12) - 0.2 * bell(above, 0.12);
                return (scaled(cloth(dye, p, spot.normal, seed + 200), hem), Label::Cloth);
            }
        }
        let height = p[1] + frame.rim[1] * (p[2] + 4.0) - frame.rim[0];
        let below = smoothstep(4.0, -6.0, height);
        let (face, label) = if below < 1.0 {
            self.face.at(&frame.head, piece, p, spot)
        } else {
            ([0.0; 3], Label::Skin)
        };
        let color =
            if below > 0.0 { blend(face, self.skin(frame, p, spot.normal), below) } else { face };
        let near = self.worn(frame, p).into_iter().flatten().map(|(_, above)| above);
        let shade =
            near.fold(0.0, |shade: f32, above| shade.max(0.35 * smoothstep(1.0, 0.0, above)));
        (scaled(color, 1.0 - shade), label)
    }

    /// The garments near a point, with its distance beyond each one's edge in centimetres, negative
    /// inside.
    fn worn(&self, frame: &BodyFrame, p: Point) -> [Option<(Dye, f32)>; 2] {
        let along = frame.along_arm(p);
        let [waist, crotch, _, ankle] = frame.heights;
        let length = |at: f32| {
            let [a, b] = frame.arm;
            at * ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt()
        };
        let shirt = self.clothing.shirt.map(|(dye, sleeve)| {
            let bow = 0.13 * p[0] * p[0];
            let front = frame.chest[1] - 0.8 + bow;
            let back = frame.rim[0] + frame.rim[1] * 12.0 - 2.5 + bow;
            let neckline = p[1] - mix(front, back, smoothstep(-7.0, -13.0, p[2]));
            let edge = match along {
                Some(along) => length(along - sleeve),
                None => neckline.max(waist - 8.0 - p[1]),
            };
            (dye, edge)
        });
        let trousers = self.clothing.trousers.map(|(dye, leg)| {
            let end = mix(crotch, ankle, leg);
            let edge = if along.is_some() { 99.0 } else { (p[1] - waist + 4.0).max(end - p[1]) };
            (dye, edge)
        });
        [shirt, trousers]
    }

    /// Skin below the neck: paler on the chest, redder at joints, hands and feet.
    fn skin(&self, frame: &BodyFrame, p: Point, normal: [f32; 3]) -> Color {
        let along = frame.along_arm(p);
        let [_, _, knee, ankle] = frame.heights;
        let hand = along.map_or(0.0, |along| smoothstep(0.95, 1.1, along));
        let elbow =
            along.map_or(0.0, |along| bell(along - 0.5, 0.06) * smoothstep(0.0, -0.6, normal[2]));
        let foot = smoothstep(ankle + 4.0, ankle - 4.0, p[1]);
        let knees = bell(p[1] - knee, 4.0) * smoothstep(0.2, 0.8, normal[2]);
        let flush = 0.7 * hand + 0.6 * elbow + 0.6 * foot + 0.4 * knees - 0.35;
        let color = self.face.skin.at(p, flush, self.face.seed);
        let armpit = along.map_or(0.0, |along| smoothstep(0.18, 0.0, along))
            * smoothstep(-0.2, -0.8, normal[1]);
        let mound = bell(p[0].abs() - 9.0, 6.0)
            * bell(p[1] - frame.chest[1] + 14.0, 3.0)
            * smoothstep(0.3, -0.5, normal[1]);
        let light =
            0.90 + 0.10 * normal[1].max(-0.8) + 0.07 * normal[2] - 0.35 * armpit - 0.25 * mound
                + 0.05 * fractal(p, 12.0, self.face.seed + 301);
        let color = scaled(color, light * 1.05);
        if self.hairiness <= 0.0 {
            return color;
        }
        let chest = bell(p[0], 9.0)
            * bell(p[1] - frame.chest[1] + 4.0, 9.0)
            * smoothstep(0.0, 0.5, normal[2]);
        let forearm = along.map_or(0.0, |along| smoothstep(0.35, 0.6, along)) * (1.0 - hand);
        let leg = smoothstep(knee + 25.0, knee, p[1]) * (1.0 - foot);
        let directions = if along.is_some() { [p[1] + p[2], p[0]] } else { [p[0] + p[2], p[1]] };
        let density = self.hairiness * chest.max(forearm).max(leg);
        let hairs = sparse_hairs(p, directions, density, self.face.seed + 302);
        blend(color, linear([0.16, 0.11, 0.08]), 0.7 * hairs)
    }
}
