//! Who is photographed: a head with its texture, and what each texel shows.

use std::path::Path;

use uvgraft::{Anatomy, Mesh, Size, Texture};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_image as image;
use uvgraft_io::obj;

use crate::looks::{Collar, FaceLook, HeadFrame, Label, LayoutSpots, SkinTone, Spot};
use crate::real;

/// What a texel or a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Content {
    /// Skin, lips, brows, lashes and eyes: what a face's texture may have.
    Face,
    /// Hair of the head.
    Hair,
    /// A collar or clothes.
    Cloth,
    /// The rims of glasses.
    Glasses,
    /// Anything behind the head.
    Background,
}

/// A head to photograph.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Name in tables.
    pub name: String,
    /// The head, in metres, which looks along +Z with Y up.
    pub head: Mesh,
    /// Its texture: RGB, 8-bit sRGB.
    pub texture: Texture,
    /// `[texels]`: what each shows.
    pub content: Vec<Content>,
    /// `[texels]`: where each is on the head; `None` outside the layout.
    pub spots: Vec<Option<Spot>>,
    /// `[texels]`: whether each is on an eyeball, where that is known.
    pub is_eye: Vec<bool>,
    /// Shoulders and clothes, and their texture.
    pub body: Option<(Mesh, Texture)>,
    /// The point between the eyes, in the mesh's unit.
    pub middle: [f64; 3],
}

/// The distance between the eyes of heads without a known unit, in metres.
pub(super) const EYES: f64 = 0.063;

/// Heads and faces of the test data.
const REAL: [[&str; 2]; 3] = [
    ["flame_head_template.obj", "flame_face_texture.png"],
    ["flame_head_template.obj", "flame_mean_texture.jpg"],
    ["hifi3d_head.obj", "hifi3d_face_texture.png"],
];

/// Size of the body's texture.
const BODY: Size = Size::square(1024);

impl Subject {
    /// The built-in figure.
    ///
    /// # Panics
    /// Never: the figure's meshes have their parts.
    pub fn figure(size: Size) -> Self {
        let figure = Figure::new();
        let texture = paint_head(&figure, size);
        let layout = LayoutSpots::new(&figure.head, size);
        let is_hair = is_of_material(&figure.head, "hair");
        let content = (0..).zip(layout.spots()).map(|(texel, spot)| {
            let Some(spot) = spot else { return Content::Background };
            let [x, y, z] = HeadFrame::FIGURE.local(spot.position);
            let at = [texel % size.width, texel / size.width];
            let green = texture.get(at[0], at[1], 1);
            // Hair is painted onto the skin too, beside and above the face.
            let beside = x.abs() > 6.2 || y > 3.4 || z < -2.0;
            let is_hair = is_hair[spot.face as usize] || (beside && green < 0.4);
            if is_hair { Content::Hair } else { Content::Face }
        });
        let content = content.collect();
        Self::of_figure("figure", figure, texture, content, &layout)
    }

    /// The figure's mesh with a painted face. Other than the figure's own, its looks vary: a fringe,
    /// a collar, glasses.
    pub fn painted(look: &FaceLook, size: Size) -> Self {
        let figure = Figure::new();
        let layout = LayoutSpots::new(&figure.head, size);
        let painted = look.paint(&figure.head, &HeadFrame::FIGURE, &layout);
        let bare = FaceLook { glasses: false, ..*look };
        let bare = bare.paint(&figure.head, &HeadFrame::FIGURE, &layout).truth;
        let labels = painted.truth.of_texels.iter().zip(bare.of_texels).zip(layout.spots());
        let content = labels.map(|((&label, bare), spot)| match (label, bare) {
            _ if spot.is_none() => Content::Background,
            (Label::Hair, _) => Content::Hair,
            (Label::Cloth, _) => Content::Cloth,
            (Label::Other, bare) if bare != Label::Other => Content::Glasses,
            _ => Content::Face,
        });
        let content = content.collect();
        Self::of_figure(look.name, figure, painted.texture, content, &layout)
    }

    /// Subjects that together have what must not get into a texture.
    pub fn dressed(size: Size) -> Vec<Self> {
        let plain = FaceLook::new("bare", SkinTone::LIGHT);
        let white = [0.93, 0.935, 0.95];
        let looks = [
            FaceLook { name: "fringe", fringe: true, ..plain },
            FaceLook { name: "glasses", glasses: true, ..plain },
            FaceLook { name: "collar", ..plain }.collar(Collar::plain(white).cut(0.6, 0.5)),
        ];
        looks.iter().map(|look| Self::painted(look, size)).collect()
    }

    /// A head with nothing around it, its eyes 63 mm apart around the origin, whatever its unit and
    /// directions. It is all face.
    ///
    /// - `anatomy`: of the head.
    ///
    /// # Panics
    /// If a position is not finite.
    pub fn alone(name: &str, head: &Mesh, anatomy: &Anatomy, texture: Texture) -> Self {
        let place = |position: &[f32; 3]| {
            anatomy.frame().local(position.map(f64::from)).map(|value| (value * EYES) as f32)
        };
        let positions = head.positions().iter().map(place).collect();
        let texels = texture.size().texels();
        Self {
            name: name.to_owned(),
            head: head.clone().with_positions(positions).expect("as many finite vertices"),
            texture,
            content: vec![Content::Face; texels],
            spots: vec![None; texels],
            is_eye: vec![false; texels],
            body: None,
            middle: [0.0; 3],
        }
    }

    /// Faces of other people: painted ones on the figure, and real ones if `UVGRAFT_DATA` names a
    /// folder with them.
    ///
    /// # Panics
    /// If files in that folder are not what they should be.
    pub fn others() -> Vec<Self> {
        const PAINTED: Size = Size::square(512);
        let figure = Self::figure(PAINTED);
        let mut found: Vec<Self> =
            FaceLook::all().iter().map(|look| Self::painted(look, PAINTED)).collect();
        found.insert(0, figure);
        let real = |folder: &Path, [mesh, texture]: [&str; 2]| {
            let mesh = obj::read(folder.join(mesh)).expect("a mesh");
            let picture = image::read(folder.join(texture)).expect("a texture").texture;
            let anatomy = Anatomy::find(&mesh).expect("a head");
            Self::alone(texture, &mesh, &anatomy, picture)
        };
        if let Some(folder) = real::folder() {
            found.extend(REAL.map(|files| real(&folder, files)));
        }
        found
    }

    fn of_figure(
        name: &str,
        figure: Figure,
        texture: Texture,
        content: Vec<Content>,
        layout: &LayoutSpots,
    ) -> Self {
        let clothes = figure.body.only_parts(|part| part.object == "body");
        let clothes = clothes.expect("a figure with a body");
        let painted = paint_body(&figure, BODY);
        let of_eyes = is_of_material(&figure.head, "eye");
        let is_eye = |spot: &Option<Spot>| spot.is_some_and(|spot| of_eyes[spot.face as usize]);
        Self {
            name: name.to_owned(),
            head: figure.head,
            texture,
            content,
            spots: layout.spots().to_vec(),
            is_eye: layout.spots().iter().map(is_eye).collect(),
            body: Some((clothes, painted)),
            middle: HeadFrame::FIGURE.origin.map(f64::from),
        }
    }
}

/// For each triangle whether it is of a material.
fn is_of_material(mesh: &Mesh, material: &str) -> Vec<bool> {
    let mut of_faces = vec![false; mesh.faces().len()];
    for part in mesh.parts().iter().filter(|part| part.material == material) {
        for polygon in part.polygons.clone() {
            of_faces[mesh.polygon(polygon as usize)].fill(true);
        }
    }
    of_faces
}
