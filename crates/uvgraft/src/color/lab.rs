//! CIELAB in single precision, for statistics of many colours; [`delta_e`](super::delta_e) has its own
//! in double precision.

use super::linear_from_srgb;

/// CIELAB of an sRGB colour as stored.
pub fn lab(rgb: [f32; 3]) -> [f32; 3] {
    lab_by(rgb, linear_from_srgb, root)
}

/// The nonlinearity of CIELAB, of a component relative to white.
fn root(value: f32) -> f32 {
    if value > 0.008_856 { value.cbrt() } else { 7.787 * value + 16.0 / 116.0 }
}

/// As [`lab`] to within 0.003, for many colours: powers and roots come from lookup tables.
pub(crate) struct LabTables {
    linear: Vec<f32>,
    root: Vec<f32>,
}

impl LabTables {
    pub fn new() -> Self {
        const STEPS: usize = 4096;
        let table = |value: fn(f32) -> f32| {
            (0..=STEPS).map(|step| value(step as f32 / STEPS as f32)).collect::<Vec<f32>>()
        };
        Self { linear: table(linear_from_srgb), root: table(root) }
    }

    pub fn of(&self, rgb: [f32; 3]) -> [f32; 3] {
        let look_up = |table: &[f32], value: f32| {
            let at = value.clamp(0.0, 1.0) * (table.len() - 1) as f32;
            let first = (at as usize).min(table.len() - 2);
            table[first] + (table[first + 1] - table[first]) * (at - first as f32)
        };
        lab_by(rgb, |value| look_up(&self.linear, value), |value| look_up(&self.root, value))
    }
}

fn lab_by(rgb: [f32; 3], linear: impl Fn(f32) -> f32, root: impl Fn(f32) -> f32) -> [f32; 3] {
    let [r, g, b] = rgb.map(|value| linear(value.clamp(0.0, 1.0)));
    let x = root((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
    let y = root(0.2126 * r + 0.7152 * g + 0.0722 * b);
    let z = root((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}
