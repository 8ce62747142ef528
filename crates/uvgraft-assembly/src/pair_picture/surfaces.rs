//! Both surfaces of a pair that was linked by registration, each in its own shape.
//!
//! The registered target lies on the source by construction, and so do its colours: whether an eye
//! got the colours of an eye shows only on the target as it is.

use glam::{DMat4, DVec3};
use uvgraft::correspond::surface::SurfaceReport;
use uvgraft::{Anatomy, Direction, Mesh, Size, Texture};
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{Blame, Result};
use uvgraft_render::{Bounds, Shading, View, render};

use super::{CAPTION, FAINT_TEXT, MARGIN, PANEL, TEXT, UNLINKED, by_place, color_linked};
use crate::drawing::Sheet;

/// Height of the views with their captions.
pub(super) const HEIGHT: u32 = CAPTION + VIEW + MARGIN;

/// Views of a surface, by their azimuths.
const AZIMUTHS: [f32; 2] = [0.0, 50.0];
const VIEW: u32 = (PANEL - MARGIN) / AZIMUTHS.len() as u32;

/// Draws the surfaces below the layouts.
pub(super) fn draw(file: &PairFile, report: &SurfaceReport, picture: &mut Sheet) -> Result<()> {
    let stage = Stage::new(file.pair.source());
    let alignment = DMat4::from_cols_array_2d(&report.alignment).transpose();
    let top = picture.size().height - HEIGHT;
    for (index, (direction, placed, title)) in (0u32..).zip([
        (Direction::Reverse, DMat4::IDENTITY, "the source's surface"),
        (Direction::Forward, alignment, "the target's surface, in its own shape"),
    ]) {
        let left = MARGIN + index * (PANEL + MARGIN);
        picture.text(title, left, top, 2, TEXT);
        let hint = "features must have the same colours on both; grey is not linked";
        picture.text(hint, left, top + 28, 1, FAINT_TEXT);
        let mesh = stage.placed(file.pair.to(direction), placed)?;
        let texture = texture(file, direction)?;
        for (column, azimuth) in (0..).zip(AZIMUTHS) {
            let view = View { azimuth, ..stage.view };
            let shot = render(&mesh, &texture, |_| Shading::Matt, &view, Size::square(VIEW));
            picture.paste(&shot, left + column * (VIEW + MARGIN), top + CAPTION);
        }
    }
    Ok(())
}

/// Where the surfaces stand, and how they are looked at.
struct Stage {
    from_source: DMat4,
    view: View,
}

impl Stage {
    /// A head faces the camera. Anything else is shown as it is.
    fn new(source: &Mesh) -> Self {
        /// A head with its neck, in distances between the eyes.
        const HEAD: View = View {
            azimuth: 0.0,
            elevation: 0.0,
            target: [0.0, -0.3, -1.0],
            height: 5.6,
            floor: false,
        };
        if let Ok(head) = Anatomy::find(source) {
            let frame = head.frame();
            let origin = DVec3::from(frame.local([0.0; 3]));
            let axis = |k: usize| {
                let mut unit = [0.0; 3];
                unit[k] = 1.0;
                (DVec3::from(frame.local(unit)) - origin).extend(0.0)
            };
            let from_source = DMat4::from_cols(axis(0), axis(1), axis(2), origin.extend(1.0));
            return Self { from_source, view: HEAD };
        }
        let bounds = Bounds::of(source.positions().iter().copied());
        let (target, height) = bounds.map_or(([0.0; 3], 1.0), |b| (b.center(), 2.1 * b.radius()));
        let view = View { target, height, ..HEAD };
        Self { from_source: DMat4::IDENTITY, view }
    }

    /// A mesh on the stage.
    ///
    /// - `placed`: takes it into the source's place.
    fn placed(&self, mesh: &Mesh, placed: DMat4) -> Result<Mesh> {
        let matrix = self.from_source * placed;
        let at = |&point: &[f32; 3]| {
            let point = glam::Vec3::from(point).as_dvec3();
            matrix.transform_point3(point).as_vec3().to_array()
        };
        let positions = mesh.positions().iter().map(at).collect();
        mesh.clone().with_positions(positions).or_work()
    }
}

/// A texture with the colours of places.
fn texture(file: &PairFile, direction: Direction) -> Result<Texture> {
    // Hides the borders of islands from the renderer's filter.
    const GUTTER_PX: u32 = 8;
    let mut picture = Sheet::new(Size::square(2 * PANEL), UNLINKED);
    color_linked(file, direction, GUTTER_PX, &mut picture, |here, there| {
        by_place(direction, here, there)
    });
    picture.into_texture()
}
