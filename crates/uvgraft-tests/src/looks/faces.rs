//! Painted faces: captures of people who do not exist, in the layout of a head mesh.

use uvgraft::Mesh;
use uvgraft::easing::{bell, smoothstep};

use super::face_look::{Beard, Collar, FaceLook, HairColor};
use super::features::{glasses_cover, lash_cover, lip_cover};
use super::frame::Piece;
use super::noise::Point;
use super::skin::{Dye, blend, cloth, linear, scaled};
use super::{Color, HeadFrame, Label, LayoutSpots, Painted, SkinTone, Spot};

impl FaceLook {
    /// Short brown hair; no beard, glasses or collar.
    pub const fn new(name: &'static str, skin: SkinTone) -> Self {
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

    /// Faces that together cover all difficult cases.
    pub fn all() -> Vec<Self> {
        let (white, black) = ([0.93, 0.935, 0.95], [0.055, 0.055, 0.065]);
        let blue = [0.25, 0.42, 0.70];
        let new = Self::new;
        let mut looks = vec![
            new("very light, white collar", SkinTone::VERY_LIGHT)
                .hair(HairColor::Blond)
                .collar(Collar::plain(white)),
            new("light, beige collar", SkinTone::LIGHT).collar(Collar::plain([0.80, 0.68, 0.56])),
            new("olive, striped collar", SkinTone::OLIVE).hair(HairColor::Black).collar(Collar {
                dye: Dye::Striped(blue, white),
                height: 0.25,
                unevenness: 0.9,
            }),
            new("medium, polo neck", SkinTone::MEDIUM).collar(Collar::plain(black).cut(1.0, 0.2)),
            new("brown, no collar", SkinTone::BROWN).hair(HairColor::Black),
            new("dark, ragged white collar", SkinTone::DARK)
                .hair(HairColor::Black)
                .collar(Collar::plain(white).cut(0.2, 1.4)),
            new("very dark, black collar", SkinTone::VERY_DARK)
                .hair(HairColor::Bald)
                .collar(Collar::plain(black)),
            new("reddish, beard", SkinTone::REDDISH).hair(HairColor::Grey),
            new("blue", SkinTone::BLUE).hair(HairColor::Black),
            new("grey capture", SkinTone::GREY)
                .hair(HairColor::Black)
                .collar(Collar::plain([0.3; 3])),
            new("light, lit from beside", SkinTone::LIGHT).hair(HairColor::Blond),
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

    /// The same face with other hair.
    #[must_use]
    pub const fn hair(self, hair: HairColor) -> Self {
        Self { hair, ..self }
    }

    /// The same face with a collar.
    #[must_use]
    pub const fn collar(self, collar: Collar) -> Self {
        Self { collar: Some(collar), ..self }
    }

    /// Paints the face in the layout of a head.
    ///
    /// - `layout`: the layout of `mesh`.
    pub fn paint(&self, mesh: &Mesh, frame: &HeadFrame, layout: &LayoutSpots) -> Painted {
        let pieces = frame.pieces(mesh);
        layout.paint(|spot| {
            let p = frame.local(spot.position);
            let (color, label) = self.at(frame, pieces[spot.face as usize], p, spot);
            (self.captured(p, color), label)
        })
    }

    /// Applies the baked light and, for a greyscale capture, drops the colours.
    pub(super) fn captured(&self, p: Point, color: Color) -> Color {
        let color = scaled(color, (self.light_ramp * p[0] / 16.0).exp2());
        if !self.skin.is_grey() {
            return color;
        }
        [0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]; 3]
    }

    /// Linear light and label of a point. Lips, brows, beard, lashes, hair, collar and glasses are
    /// laid over lit skin in this order; a layer that covers more than half sets the label.
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
        lay(self.lip(frame, p), lip_cover(frame, p), Label::Lip);
        let brow = self.brow_cover(frame, p);
        lay(self.strands(p, 0.6), brow, Label::Brow);
        let (beard, is_hair) = self.beard_cover(frame, p);
        lay(self.whiskers(p), beard, if is_hair { Label::Hair } else { Label::Skin });
        lay(linear([0.06, 0.04, 0.035]), lash_cover(frame, p), Label::Other);
        if self.hair != HairColor::Bald {
            lay(self.strands(p, 0.0), self.hair_cover(frame, p), Label::Hair);
        }
        if let Some(collar) = &self.collar {
            let above = collar.above(frame, p, self.seed);
            // The shadow that the collar casts.
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
}
