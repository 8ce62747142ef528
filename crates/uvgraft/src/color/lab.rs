//! CIELAB in single precision, for statistics of many colours. That of [`delta_e`](super::delta_e) is in
//! double precision and from another implementation, with which a test compares this one.

use super::linear_from_srgb;

/// CIELAB of an sRGB colour as stored.
pub fn lab(rgb: [f32; 3]) -> [f32; 3] {
    lab_by(rgb, linear_from_srgb, root)
}

/// The CIE 1976 colour difference of two colours in CIELAB.
pub fn lab_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
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

#[cfg(test)]
mod tests {
    use palette::white_point::D65;
    use palette::{FromColor, Lab, Srgb};

    use super::*;

    #[test]
    fn agrees_with_palette() {
        for index in 0..9 * 9 * 9 {
            let rgb = [index % 9, index / 9 % 9, index / 81].map(|step| step as f32 / 8.0);
            let [red, green, blue] = rgb.map(f64::from);
            let wanted = Lab::<D65, f64>::from_color(Srgb::new(red, green, blue));
            let wanted = [wanted.l, wanted.a, wanted.b].map(|value| value as f32);
            // Matrices to XYZ differ in the fourth decimal.
            assert!(lab_distance(lab(rgb), wanted) < 0.05, "{rgb:?}: {:?} {wanted:?}", lab(rgb));
            assert!(lab_distance(lab(rgb), LabTables::new().of(rgb)) < 0.01, "{rgb:?}");
        }
    }
}
