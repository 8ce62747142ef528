//! Writes meshes as OBJ text.

use std::io::{self, Write};
use std::path::Path;

use uvgraft::mesh::Mesh;

use uvgraft_files::output::write_atomically;

/// Writes a mesh as OBJ: vertices, texture coordinates with `v` upwards, and the original polygons,
/// under the names of their parts.
///
/// Numbers have as many digits as needed to read back the same 32-bit value. That holds for `v` too
/// unless it is closer to 0 than 2⁻³⁰, where a difference of 2⁻⁵⁴ may remain. Line breaks in names
/// become `_`.
///
/// # Errors
/// Those of `out`.
pub fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    for [x, y, z] in mesh.positions() {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for &[u, v] in mesh.uv() {
        writeln!(out, "vt {u} {}", flipped(v))?;
    }
    let mut parts = mesh.parts().iter().peekable();
    let mut names = [""; 3];
    for polygon in 0..mesh.polygon_count() {
        while let Some(part) = parts.next_if(|part| part.polygons.start as usize <= polygon) {
            let wanted = [part.object.as_str(), &part.group, &part.material];
            for ((keyword, name), wanted) in ["o", "g", "usemtl"].iter().zip(&mut names).zip(wanted)
            {
                if *name != wanted {
                    *name = wanted;
                    writeln!(out, "{keyword} {}", one_line(wanted))?;
                }
            }
        }
        out.write_all(b"f")?;
        for corner in mesh.polygon_corners(polygon) {
            // Indices count from 1, in 64 bits so that the last one cannot overflow.
            write!(out, " {}/{}", u64::from(corner.vertex) + 1, u64::from(corner.uv) + 1)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Writes a mesh to an OBJ file atomically; see [`write()`].
///
/// # Errors
/// Those of creating, writing and renaming the file; an existing file is then unchanged.
pub fn save(mesh: &Mesh, path: impl AsRef<Path>) -> io::Result<()> {
    write_atomically(path.as_ref(), |out| write(mesh, out))
}

/// `1 - v`, rounded to the fewest decimals from which the reader's flip restores `v`.
fn flipped(v: f32) -> f64 {
    let up = 1.0 - f64::from(v);
    // With at most 15 decimals both sides of the division are exact, so the quotient is the number
    // obtained by parsing those decimals, and prints as them.
    (0..=15)
        .map(|decimals| 10_f64.powi(decimals))
        .map(|scale| (up * scale).round() / scale)
        .find(|rounded| (1.0 - rounded) as f32 == v)
        .unwrap_or(up)
}

/// A name on a single line: without line breaks, and without a backslash at its end that would
/// continue the line.
fn one_line(name: &str) -> String {
    let mut name = name.replace(['\n', '\r'], "_");
    if name.ends_with('\\') {
        name.pop();
        name.push('_');
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flipping_takes_no_more_decimals_than_it_needs() {
        assert_eq!(flipped(0.0), 1.0);
        assert_eq!(flipped(1.0), 0.0);
        assert_eq!(flipped(0.25), 0.75);
        assert_eq!(flipped((1.0 - 0.456_444_f64) as f32), 0.456_444);
        assert_eq!(flipped(-2.5), 3.5);
        let mut random = fastrand::Rng::with_seed(4);
        for _ in 0..100_000 {
            let v = (random.f32() * 0.5_f32.powi(random.i32(-3..30))).max(0.5_f32.powi(30));
            let text = flipped(v).to_string();
            assert_eq!((1.0 - text.parse::<f64>().unwrap()) as f32, v, "{text}");
        }
    }
}
