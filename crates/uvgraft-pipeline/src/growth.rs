//! Growing and shrinking regions by no more than their size.

use uvgraft::Selection;
use uvgraft::blend::Growth;

use crate::failure::{Failure, Result};
use crate::length::{Length, Unit};

/// What is less than this share of a region's area is left by mistake. FLAME's head in SMPL-X is 356 mm
/// deep: shrunk by 340 mm it has more than this left, by 350 mm 0.27 %, a few triangles.
const CRUMBS: f64 = 0.01;

/// How much farther a region may grow than anything is: as much as rounding to three digits could add.
const SLACK: f64 = 1.005;

/// A region that was grown or shrunk.
#[derive(Debug)]
pub struct Grown {
    /// The result.
    pub selection: Selection,
    /// A warning if next to nothing is left.
    pub warning: Option<String>,
}

/// Grows a region, or shrinks it.
///
/// - `unit`: of the mesh, for messages; without one they have bare numbers, as `by` has.
///
/// # Errors
/// As bad input, naming the region's size, if nothing is left of the region but parts without a
/// boundary, such as eyeballs, which never shrink, and if everything linked is covered by a length that
/// is greater than the distance of the farthest part. Regions without a boundary cannot change at all.
pub fn grown(selection: &Selection, by: Growth, unit: Option<Unit>) -> Result<Grown> {
    let shown = |length: f64| match unit {
        Some(unit) => Length::measured(length, unit).to_string(),
        None => format!("{length:.4}"),
    };
    let is_growing = match by {
        Growth::Length(by) => by > 0.0,
        Growth::Rings(by) => by > 0,
        _ => true,
    };
    let selected = || selection.grown(by);
    if by == Growth::Length(0.0) || by == Growth::Rings(0) {
        return Ok(Grown { selection: selected(), warning: None });
    }
    let Some(depth) = selection.depth() else {
        return Err(Failure::option("`grow` has no effect: the region has no boundary"));
    };
    if is_growing {
        let reach = selection.reach(&selection.domain().linked());
        if let (Growth::Length(by), Some(reach)) = (by, reach)
            && by > reach * SLACK
        {
            return Err(Failure::option(format!(
                "`grow` must be at most {}, the distance from the region to the farthest linked point; to use \
                 everything linked, leave out `region`",
                shown(reach)
            )));
        }
        return Ok(Grown { selection: selected(), warning: None });
    }
    let selection_left = selected();
    let left = match by {
        Growth::Length(by) if -by >= depth => 0.0,
        _ => selection_left.bounded_area() / selection.bounded_area(),
    };
    if left.is_nan() || left <= 0.0 {
        return Err(Failure::option(format!(
            "`grow` leaves nothing of the region, whose innermost point is {} from its boundary",
            shown(depth)
        )));
    }
    let warning = (left < CRUMBS).then(|| {
        format!(
            "`grow` leaves only {:.2} % of the region, whose innermost point is {} from its boundary",
            100.0 * left,
            shown(depth)
        )
    });
    Ok(Grown { selection: selection_left, warning })
}

#[cfg(test)]
mod tests {
    use uvgraft::blend::Side;
    use uvgraft::{BlendDomain, Direction, Mesh, Pair};

    use super::*;

    const SIDE: u32 = 8;

    /// A sheet of 8 × 8 squares of side 1, of which the inner 6 × 6 are linked, and a tetrahedron beside it,
    /// which has no boundary.
    fn domain() -> BlendDomain {
        let at = |x: u32, y: u32| y * (SIDE + 1) + x;
        let mut positions: Vec<[f32; 3]> = (0..(SIDE + 1) * (SIDE + 1))
            .map(|k| [(k % (SIDE + 1)) as f32, (k / (SIDE + 1)) as f32, 0.0])
            .collect();
        let squares = |from: u32, to: u32| {
            let cells = (from..to).flat_map(move |y| (from..to).map(move |x| (x, y)));
            cells.flat_map(move |(x, y)| {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                [[a, b, d], [a, d, c]]
            })
        };
        let first = positions.len() as u32;
        positions.extend([[20.0, 0.0, 0.0], [21.0, 0.0, 0.0], [20.0, 1.0, 0.0], [20.0, 0.0, 1.0]]);
        let shell =
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|face| face.map(|k| first + k));
        let uv: Vec<[f32; 2]> =
            positions.iter().map(|[x, y, z]| [x / 30.0, (y + z) / 30.0]).collect();
        let mesh = |from, to| {
            let faces: Vec<[u32; 3]> = squares(from, to).chain(shell).collect();
            Mesh::from_triangles(positions.clone(), uv.clone(), &faces, &faces).unwrap()
        };
        let ids: Vec<i64> = (0..positions.len() as i64).collect();
        let pair = Pair::by_vertex_map(mesh(1, SIDE - 1), mesh(0, SIDE), &ids).unwrap();
        BlendDomain::new(pair, Direction::Forward)
    }

    fn said(selection: &Selection, by: Growth) -> String {
        grown(selection, by, Some(Unit::Cm)).unwrap_err().to_string()
    }

    #[test]
    fn shrinking_stops_before_nothing_is_left_but_shells() {
        let linked = domain().linked();
        // The square is 3 deep, found to within a fifth of an edge, where fronts meet.
        for by in [-3.0, -3.5, -900.0, -1e9].map(Growth::Length) {
            let said = said(&linked, by);
            let wanted = "nothing of the region, whose innermost point is 2";
            assert!(said.contains(wanted) && said.contains("mm from its boundary"), "{said}");
        }
        for by in [-4, -1000].map(Growth::Rings) {
            assert!(said(&linked, by).contains("leaves nothing of the region"), "{by:?}");
        }
        // At most a square of 2 × 0.15 of one of 6.
        let depth = linked.depth().unwrap();
        let crumbs = grown(&linked, Growth::Length(-0.95 * depth), Some(Unit::M)).unwrap();
        let warning = crumbs.warning.unwrap();
        assert!(warning.contains("leaves only 0.") && warning.contains("mm from"), "{warning}");
        for by in [Growth::Length(-1.0), Growth::Length(-2.0), Growth::Rings(-1), Growth::Rings(-2)]
        {
            let left = grown(&linked, by, None).unwrap();
            assert_eq!(left.warning, None, "{by:?}");
            assert!(left.selection.bounded_area() < linked.bounded_area(), "{by:?}");
        }
    }

    #[test]
    fn areas_are_those_of_the_sheet_alone() {
        let linked = domain().linked();
        assert!((linked.bounded_area() - 36.0).abs() < 1e-6);
        let inner = grown(&linked, Growth::Length(-0.5), None).unwrap().selection;
        let area = inner.bounded_area();
        // Triangles in corners of the boundary have all of theirs on it.
        assert!((23.5..=25.0).contains(&area), "{area}");
        let depth = linked.depth().unwrap();
        assert!((2.6..=3.0).contains(&depth), "{depth}");
    }

    #[test]
    fn growing_stops_at_what_is_linked() {
        let domain = domain();
        let corner =
            |k: u32| k % (SIDE + 1) <= 3 && k / (SIDE + 1) <= 3 && k < (SIDE + 1) * (SIDE + 1);
        let ids: Vec<u32> = (0..85).filter(|&k| corner(k)).collect();
        let region = domain.vertices(Side::Target, &ids).unwrap();
        let region = region.intersection(&domain.linked()).unwrap();
        // The opposite corner is 4 squares away on both axes, 5.66 by a straight line.
        for by in [6.2, 1e3, 1e9].map(Growth::Length) {
            let said = said(&region, by);
            assert!(said.contains("must be at most 5") && said.contains("`region`"), "{said}");
        }
        for by in
            [Growth::Length(1.0), Growth::Length(5.0), Growth::Rings(1000), Growth::Length(0.0)]
        {
            assert_eq!(grown(&region, by, None).unwrap().warning, None, "{by:?}");
        }
    }

    #[test]
    fn shells_neither_grow_nor_shrink() {
        let domain = domain();
        let shell: Vec<u32> = (81..85).collect();
        let shell = domain.vertices(Side::Target, &shell).unwrap();
        for by in [Growth::Length(-0.1), Growth::Length(0.1), Growth::Rings(-1), Growth::Rings(1)] {
            assert!(said(&shell, by).contains("no boundary"), "{by:?}");
        }
        assert_eq!(shell.bounded_area(), 0.0);
        assert_eq!(shell.depth(), None);
    }
}
