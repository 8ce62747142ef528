//! Colour spaces by their primaries and white point, and the way from them to those of sRGB.
//!
//! Sources: SMPTE RP 177 for the matrix to XYZ; the linear Bradford adaptation of ICC.1:2022, annex E.

use uvgraft::color::Encoding;

/// What is done about a colour space that a file declares otherwise than by an ICC profile: by gAMA,
/// cHRM and cICP in PNG, by `chromaticities` in EXR.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum DeclaredSpace {
    /// Colours are converted to sRGB, or to its primaries where they are linear.
    #[default]
    Honoured,
    /// Values are read as stored: those of data, and of images in glTF, which says so.
    Ignored,
}

impl From<Encoding> for DeclaredSpace {
    /// Ignored for data, which have no colours.
    fn from(encoding: Encoding) -> Self {
        if encoding == Encoding::Data { Self::Ignored } else { Self::Honoured }
    }
}

/// Rows first.
pub(super) type Matrix = [[f64; 3]; 3];

/// CIE 1931 x and y of primaries and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chromaticities {
    pub(super) red: [f64; 2],
    pub(super) green: [f64; 2],
    pub(super) blue: [f64; 2],
    pub(super) white: [f64; 2],
}

pub(super) const D65: [f64; 2] = [0.3127, 0.3290];

/// Chromaticities that span no colour space.
#[derive(Debug)]
pub(super) struct Degenerate;

/// Entries of a matrix that differ by less from the identity's change no colour by half a level of
/// 8 bits; files round the chromaticities of sRGB to 3 to 5 digits.
const NO_CHANGE: f64 = 1e-3;

/// The cone responses of the Bradford adaptation.
const BRADFORD: Matrix =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

impl Chromaticities {
    /// Those of sRGB, which are those of ITU-R BT.709.
    pub(super) const SRGB: Self =
        Self { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: D65 };

    /// Those that a file declares; those of sRGB if it declares none, or such as span no colour space.
    /// Viewers ignore these: programs exist that write zeros.
    ///
    /// - `declared`: red, green, blue and white.
    pub(super) fn declared(declared: Option<[[f64; 2]; 4]>) -> Self {
        declared
            .map(|[red, green, blue, white]| Self { red, green, blue, white })
            .filter(|declared| declared.to_srgb().is_ok())
            .unwrap_or(Self::SRGB)
    }

    /// The matrix from linear values of this space to linear values of sRGB; `None` if they are the
    /// same.
    ///
    /// White stays white: the white point is adapted as ICC profiles do it.
    pub(super) fn to_srgb(self) -> Result<Option<Matrix>, Degenerate> {
        self.to_srgb_from(self.white)
    }

    /// As [`Chromaticities::to_srgb`], where a colour other than the white point becomes neutral.
    ///
    /// - `neutral`: its CIE 1931 x and y.
    pub(super) fn to_srgb_from(self, neutral: [f64; 2]) -> Result<Option<Matrix>, Degenerate> {
        let xyz = self.to_xyz()?;
        let adapted = product(&adaptation(neutral, Self::SRGB.white)?, &xyz);
        let srgb = inverse(&Self::SRGB.to_xyz()?).ok_or(Degenerate)?;
        let matrix = product(&srgb, &adapted);
        let changes = (0..9).any(|at| {
            let (row, column) = (at / 3, at % 3);
            let identity = f64::from(u8::from(row == column));
            (matrix[row][column] - identity).abs() > NO_CHANGE
        });
        Ok(changes.then_some(matrix))
    }

    /// The luminance of each primary; the sum is 1.
    pub(super) fn luminances(self) -> Result<[f64; 3], Degenerate> {
        self.to_xyz().map(|[_, luminances, _]| luminances)
    }

    /// The matrix to XYZ with a white of luminance 1.
    fn to_xyz(self) -> Result<Matrix, Degenerate> {
        let Self { red, green, blue, white } = self;
        let columns = [red, green, blue].map(|[x, y]| [x, y, 1.0 - x - y]);
        let primaries = transposed(&columns);
        let white = xyz_of(white)?;
        let scales = applied(&inverse(&primaries).ok_or(Degenerate)?, white);
        // White is a sum of all primaries. Chromaticities of cameras may lie outside of what is
        // visible, but never so.
        if !scales.iter().all(|scale| scale.is_finite() && *scale > 0.0) {
            return Err(Degenerate);
        }
        Ok(primaries.map(|row| std::array::from_fn(|column| row[column] * scales[column])))
    }
}

/// XYZ of luminance 1.
fn xyz_of([x, y]: [f64; 2]) -> Result<[f64; 3], Degenerate> {
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    if xyz.iter().all(|value| value.is_finite() && *value >= 0.0) {
        Ok(xyz)
    } else {
        Err(Degenerate)
    }
}

fn adaptation(from: [f64; 2], to: [f64; 2]) -> Result<Matrix, Degenerate> {
    let [from, to] = [from, to].map(xyz_of);
    let (from, to) = (applied(&BRADFORD, from?), applied(&BRADFORD, to?));
    if from.iter().any(|response| *response <= 0.0) {
        return Err(Degenerate);
    }
    let scaled = std::array::from_fn(|row| BRADFORD[row].map(|value| value * to[row] / from[row]));
    Ok(product(&inverse(&BRADFORD).ok_or(Degenerate)?, &scaled))
}

pub(super) fn applied(matrix: &Matrix, [a, b, c]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[x, y, z]| x * a + y * b + z * c)
}

fn transposed(matrix: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}

fn product(left: &Matrix, right: &Matrix) -> Matrix {
    let columns = transposed(right).map(|column| applied(left, column));
    transposed(&columns)
}

/// `None` if a matrix is singular, or nearly so: its rows are of the order of 1.
fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let [a, b, c] = *matrix;
    let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant: f64 = a.iter().zip(cofactors[0]).map(|(x, y)| x * y).sum();
    (determinant.abs() > 1e-6)
        .then(|| transposed(&cofactors.map(|row| row.map(|value| value / determinant))))
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[cfg(test)]
mod tests {
    use super::*;

    const REC_2020: Chromaticities = Chromaticities {
        red: [0.708, 0.292],
        green: [0.170, 0.797],
        blue: [0.131, 0.046],
        white: D65,
    };

    fn near(found: [f64; 3], wanted: [f64; 3]) -> bool {
        found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-3)
    }

    #[test]
    fn the_luminances_of_bt_709_are_the_published_ones() {
        assert!(near(Chromaticities::SRGB.luminances().unwrap(), [0.2126, 0.7152, 0.0722]));
    }

    #[test]
    fn the_matrix_from_bt_2020_is_that_of_bt_2087() {
        let matrix = REC_2020.to_srgb().unwrap().unwrap();
        assert!(near(matrix[0], [1.6605, -0.5876, -0.0728]), "{matrix:?}");
        assert!(near(matrix[1], [-0.1246, 1.1329, -0.0083]), "{matrix:?}");
        assert!(near(matrix[2], [-0.0182, -0.1006, 1.1187]), "{matrix:?}");
    }

    #[test]
    fn white_stays_white_from_any_white_point() {
        for white in [[0.3457, 0.3585], [0.32168, 0.33767], [1.0 / 3.0, 1.0 / 3.0]] {
            let matrix = Chromaticities { white, ..REC_2020 }.to_srgb().unwrap().unwrap();
            assert!(near(applied(&matrix, [1.0; 3]), [1.0; 3]));
        }
    }

    #[test]
    fn xyz_with_a_neutral_of_d65_is_not_adapted() {
        let xyz = Chromaticities {
            red: [1.0, 0.0],
            green: [0.0, 1.0],
            blue: [0.0, 0.0],
            white: [1.0 / 3.0, 1.0 / 3.0],
        };
        // IEC 61966-2-1, with more digits.
        let matrix = xyz.to_srgb_from(D65).unwrap().unwrap();
        assert!(near(matrix[0], [3.2410, -1.5374, -0.4986]), "{matrix:?}");
        assert!(near(matrix[1], [-0.9692, 1.8760, 0.0416]), "{matrix:?}");
        assert!(near(matrix[2], [0.0556, -0.2040, 1.0570]), "{matrix:?}");
    }

    #[test]
    fn rounded_srgb_is_no_change() {
        let rounded = Chromaticities { white: [0.31270, 0.32900], ..Chromaticities::SRGB };
        assert!(rounded.to_srgb().unwrap().is_none());
        let close = Chromaticities { red: [0.6401, 0.3299], ..Chromaticities::SRGB };
        assert!(close.to_srgb().unwrap().is_none());
    }

    #[test]
    fn degenerate_chromaticities_are_refused() {
        let srgb = Chromaticities::SRGB;
        for degenerate in [
            Chromaticities { blue: srgb.red, ..srgb },
            Chromaticities { blue: [0.47, 0.465], ..srgb },
            Chromaticities { white: [0.3, 0.0], ..srgb },
            Chromaticities { white: [0.8, 0.1], ..srgb },
            Chromaticities { red: [f64::NAN, 0.3], ..srgb },
            Chromaticities { green: [f64::INFINITY, 0.3], ..srgb },
            Chromaticities { red: [0.0; 2], green: [0.0; 2], blue: [0.0; 2], white: [0.0; 2] },
        ] {
            assert!(degenerate.to_srgb().is_err(), "{degenerate:?}");
        }
    }
}
