//! Meshes and textures from seeded generators.

use std::sync::Arc;

use uvgraft::{Channels, Encoding, Mesh, Pair, Size, Texels, Texture};

/// Squares along one side of the sheet.
const SHEET: u32 = 20;
/// Triangles per eye.
const EYE: u32 = 24;

/// A pair with everything that makes pairs difficult, like a head and a body.
///
/// - A warped sheet: one island in the target, two in the source.
/// - Two eyes: separate discs in the source, on top of each other in the target, the second with a
///   slightly bumpier outline.
/// - Unlinked faces in the target: a strip next to the sheet and one joined to it.
/// - Vertices in another order, faces that start at other corners, every fifth wound the other way.
pub fn pair() -> Arc<Pair> {
    let mut source = Builder::default();
    let mut target = Builder::default();
    let mut rng = fastrand::Rng::with_seed(7);
    let across = SHEET + 1;
    let jitter: Vec<[f64; 2]> = (0..across * across)
        .map(|_| [rng.f64() - 0.5, rng.f64() - 0.5].map(|value| value * 0.4 / f64::from(SHEET)))
        .collect();
    let jittered = |column: u32, row: u32| {
        let [x, y] = [column, row].map(|k| f64::from(k) / f64::from(SHEET));
        let inside = (1..SHEET).contains(&column) && (1..SHEET).contains(&row);
        let shift = if inside { jitter[(row * across + column) as usize] } else { [0.0; 2] };
        [x + shift[0], y + shift[1]]
    };
    let half = SHEET / 2;
    for (row, column) in (0..SHEET).flat_map(|row| (0..SHEET).map(move |column| (row, column))) {
        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[dx, dy]| [column + dx, row + dy]);
        let vertices = ring.map(|[x, y]| y * across + x);
        // The source is cut down the centre line; the right half lies on its side.
        let source_uv = ring.map(|[x, y]| {
            let [s, t] = jittered(x, y);
            if column < half {
                [0.04 + 0.8 * s, 0.05 + 0.5 * t]
            } else {
                [0.95 - 0.45 * t, 0.97 - 0.4 * (s - 0.5) - 0.3 * s * (1.0 - t) * 0.1]
            }
        });
        let target_uv = ring.map(|[x, y]| {
            let (s, t) = (f64::from(x) / f64::from(SHEET), f64::from(y) / f64::from(SHEET));
            let (s, t) = (s * s * 0.6 + s * 0.4, t + 0.04 * (s * 9.0).sin());
            [0.06 + 0.5 * s + 0.03 * (t * 7.0).cos(), 0.1 + 0.5 * t]
        });
        source.quad(vertices, source_uv);
        target.quad(vertices, target_uv);
    }
    let mut next = across * across;
    for eye in 0..2 {
        let rim = |k: u32, bumps: f64| {
            let angle = f64::from(k % EYE) / f64::from(EYE) * std::f64::consts::TAU;
            let radius = 0.5 + bumps * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            [angle.cos() * radius, angle.sin() * radius]
        };
        let place = |at: [f64; 2], centre: [f64; 2], size: f64| {
            [centre[0] + at[0] * size, centre[1] + at[1] * size]
        };
        let source_centre = [0.62, 0.15 + 0.22 * f64::from(eye)];
        for k in 0..EYE {
            let vertices = [next + EYE, next + k, next + (k + 1) % EYE];
            let bumps = 0.004 * f64::from(eye);
            let source_uv = [[0.0; 2], rim(k, 0.0), rim(k + 1, 0.0)];
            let target_uv = [[0.0; 2], rim(k, bumps), rim(k + 1, bumps)];
            source.triangle(vertices, source_uv.map(|at| place(at, source_centre, 0.18)));
            target.triangle(vertices, target_uv.map(|at| place(at, [0.8, 0.2], 0.2)));
        }
        next += EYE + 1;
    }
    let linked_vertices = next;
    // A separate strip, and one that continues the sheet at its lower edge.
    for k in 0..SHEET {
        let x = 0.05 + 0.9 * f64::from(k) / f64::from(SHEET);
        let width = 0.9 / f64::from(SHEET);
        let vertices = [next, next + 1, next + 2, next + 3];
        target.quad(vertices, [[x, 0.8], [x + width, 0.8], [x + width, 0.95], [x, 0.95]]);
        next += 4;
    }
    let bottom = |column: u32| target.uv_of(SHEET * across + column);
    let joined: Vec<_> = (0..SHEET)
        .map(|column| {
            let (left, right) = (bottom(column), bottom(column + 1));
            [left, right, [right[0], right[1] + 0.05], [left[0], left[1] + 0.05]]
        })
        .collect();
    for (column, uv) in (0..SHEET).zip(joined) {
        let first = SHEET * across + column;
        target.quad([first, first + 1, next + 1, next], uv);
        next += 2;
    }

    // Other indices for the target's vertices, other first corners and windings for its faces.
    let renumber = |vertex: u32| (vertex * 7 + 3) % next;
    assert!(!next.is_multiple_of(7), "multiplying by 7 must be a permutation");
    let vertex_map: Vec<i64> =
        (0..linked_vertices).map(|vertex| i64::from(renumber(vertex))).collect();
    target.disguise(renumber, next);
    let pair = Pair::by_vertex_map(source.build(linked_vertices), target.build(next), &vertex_map);
    Arc::new(pair.expect("a sound pair"))
}

/// A pair of about `triangles` triangles that covers much of its layouts: six bent sheets, side by
/// side in the target, rotated and reordered in the source. Vertices and faces are shuffled, the
/// worst case for caches.
pub fn sheets(triangles: usize) -> Arc<Pair> {
    const SHEETS: u32 = 6;
    let side = ((triangles as f64 / f64::from(SHEETS * 2)).sqrt().round() as u32).max(1);
    let (across, count) = (side + 1, SHEETS * (side + 1) * (side + 1));
    let mut rng = fastrand::Rng::with_seed(21);
    // Maps into cell `place` of a layout with three columns and two rows.
    let bent = |place: u32, [s, t]: [f64; 2]| {
        let (s, t) = (s + 0.03 * (t * 8.0).sin(), t + 0.02 * (s * 11.0).cos());
        let (column, row) = (f64::from(place % 3), f64::from(place / 3));
        [(column + 0.06 + 0.88 * s) / 3.0, (row + 0.06 + 0.88 * t) / 2.0].map(|value| value as f32)
    };
    let (mut source_uv, mut target_uv, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for sheet in 0..SHEETS {
        let first = sheet * across * across;
        for (row, column) in
            (0..across).flat_map(|row| (0..across).map(move |column| (row, column)))
        {
            let [s, t] = [column, row].map(|k| f64::from(k) / f64::from(side));
            target_uv.push(bent(sheet, [s, t]));
            source_uv.push(bent((sheet * 5 + 2) % SHEETS, [1.0 - t, s]));
            if row < side && column < side {
                let corner = first + row * across + column;
                let ring = [corner, corner + 1, corner + across + 1, corner + across];
                faces.extend([[0, 1, 2], [0, 2, 3]].map(|face| face.map(|k: usize| ring[k])));
            }
        }
    }
    let mut numbers: Vec<u32> = (0..count).collect();
    rng.shuffle(&mut numbers);
    let mut shuffled_uv = vec![[0.0; 2]; count as usize];
    for (&number, uv) in numbers.iter().zip(target_uv) {
        shuffled_uv[number as usize] = uv;
    }
    let build = |uv: Vec<[f32; 2]>, faces: &[[u32; 3]]| {
        let positions = (0..count).map(|vertex| [vertex as f32, 0.0, 0.0]).collect();
        Mesh::from_triangles(positions, uv, faces, faces).expect("a sound mesh")
    };
    rng.shuffle(&mut faces);
    let source = build(source_uv, &faces);
    for face in &mut faces {
        *face = face.map(|vertex| numbers[vertex as usize]);
    }
    rng.shuffle(&mut faces);
    let target = build(shuffled_uv, &faces);
    let vertex_map: Vec<i64> = numbers.into_iter().map(i64::from).collect();
    Arc::new(Pair::by_vertex_map(source, target, &vertex_map).expect("a sound pair"))
}

/// A mesh of one square that fills the texture except for a margin of `inset`.
pub fn square(inset: f32) -> Mesh {
    let (low, high) = (inset, 1.0 - inset);
    let uv = vec![[low, low], [high, low], [high, high], [low, high]];
    let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let faces = [[0, 1, 2], [0, 2, 3]];
    Mesh::from_triangles(positions, uv, &faces, &faces).expect("a sound mesh")
}

/// An opaque 8-bit RGB picture with detail at all scales down to the single texel, like a
/// photograph: noise in octaves, and shapes with hard edges.
pub fn detailed(size: Size, seed: u64) -> Texture {
    let mut values = vec![128.0f32; size.texels() * 3];
    let width = size.width as usize;
    for (octave, cell) in [256, 128, 64, 32, 16, 8, 4, 2, 1].into_iter().enumerate() {
        let mut rng = fastrand::Rng::with_seed(seed * 1000 + octave as u64);
        let columns = width / cell + 2;
        let knots: Vec<[f32; 3]> = (0..columns * (size.height as usize / cell + 2))
            .map(|_| std::array::from_fn(|_| rng.f32() - 0.5))
            .collect();
        // Photographs have about equal contrast at every scale, less at the lens's resolution
        // limit.
        let contrast = if cell == 1 { 8.0 } else { 40.0 };
        for (y, row) in values.chunks_exact_mut(width * 3).enumerate() {
            let (knot_y, t) = (y / cell, (y % cell) as f32 / cell as f32);
            for (x, texel) in row.chunks_exact_mut(3).enumerate() {
                let (knot_x, s) = (x / cell, (x % cell) as f32 / cell as f32);
                let knot = |dx, dy| knots[(knot_y + dy) * columns + knot_x + dx];
                let corners = [knot(0, 0), knot(1, 0), knot(0, 1), knot(1, 1)];
                for (channel, value) in texel.iter_mut().enumerate() {
                    let [a, b, c, d] = corners.map(|corner| corner[channel]);
                    let (top, bottom) = (a + (b - a) * s, c + (d - c) * s);
                    *value += (top + (bottom - top) * t) * contrast;
                }
            }
        }
    }
    // Discs brighter or darker than their surroundings, with edges one texel wide.
    let mut rng = fastrand::Rng::with_seed(seed);
    for _ in 0..size.texels() / 40_000 {
        let centre = [rng.f32() * size.width as f32, rng.f32() * size.height as f32];
        let radius = 4.0 + 60.0 * rng.f32() * rng.f32();
        let shift = (rng.f32() - 0.5) * 90.0;
        let range = |at: f32, end: u32| {
            (at - radius - 1.0).max(0.0) as usize..((at + radius + 1.0) as usize).min(end as usize)
        };
        for y in range(centre[1], size.height) {
            for x in range(centre[0], size.width) {
                let distance = (x as f32 + 0.5 - centre[0]).hypot(y as f32 + 0.5 - centre[1]);
                let inside = (radius - distance + 0.5).clamp(0.0, 1.0);
                for value in &mut values[(y * width + x) * 3..][..3] {
                    *value += shift * inside;
                }
            }
        }
    }
    let texels = Texels::U8(values.into_iter().map(|value| value.round() as u8).collect());
    Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).expect("a sound texture")
}

/// Triangles whose corners each have their own UV coordinate.
#[derive(Default)]
struct Builder {
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
    uv_faces: Vec<[u32; 3]>,
}

impl Builder {
    fn quad(&mut self, vertices: [u32; 4], uv: [[f64; 2]; 4]) {
        self.triangle([0, 1, 2].map(|k| vertices[k]), [0, 1, 2].map(|k| uv[k]));
        self.triangle([0, 2, 3].map(|k| vertices[k]), [0, 2, 3].map(|k| uv[k]));
    }

    fn triangle(&mut self, vertices: [u32; 3], uv: [[f64; 2]; 3]) {
        let first = self.uv.len() as u32;
        self.uv.extend(uv.map(|coordinate| coordinate.map(|value| value as f32)));
        self.faces.push(vertices);
        self.uv_faces.push([first, first + 1, first + 2]);
    }

    /// The UV coordinate of one of a vertex's corners.
    fn uv_of(&self, vertex: u32) -> [f64; 2] {
        let corner = self.faces.as_flattened().iter().position(|&other| other == vertex);
        let corner = corner.expect("a vertex that a face uses");
        self.uv[self.uv_faces.as_flattened()[corner] as usize].map(f64::from)
    }

    fn disguise(&mut self, renumber: impl Fn(u32) -> u32, vertices: u32) {
        assert!(self.faces.as_flattened().iter().all(|&vertex| vertex < vertices));
        for (index, (face, uv)) in self.faces.iter_mut().zip(&mut self.uv_faces).enumerate() {
            *face = face.map(&renumber);
            face.rotate_left(index % 3);
            uv.rotate_left(index % 3);
            if index % 5 == 0 {
                face.swap(1, 2);
                uv.swap(1, 2);
            }
        }
    }

    fn build(self, vertices: u32) -> Mesh {
        self.build_at((0..vertices).map(|vertex| [vertex as f32, 0.0, 0.0]).collect())
    }

    fn build_at(self, positions: Vec<[f32; 3]>) -> Mesh {
        Mesh::from_triangles(positions, self.uv, &self.faces, &self.uv_faces).expect("a sound mesh")
    }
}

/// A pair of a curved surface in nine charts: upright in the target, rotated by various angles in
/// the source, every second one mirrored. Both meshes have the same vertices at the same positions.
pub fn turned_charts() -> Arc<Pair> {
    /// Charts along one side, and squares along one side of each.
    const CHARTS: u32 = 3;
    const SQUARES: u32 = 8;
    let across = CHARTS * SQUARES + 1;
    let positions: Vec<[f32; 3]> = (0..across * across)
        .map(|vertex| {
            let [s, t] = [vertex % across, vertex / across]
                .map(|k| f64::from(k) / f64::from(across - 1) - 0.5);
            let height = 0.3 * (s * 5.0).sin() * (t * 4.0).cos() - 0.4 * (s * s + t * t);
            // `t` grows downwards in both layouts.
            [s as f32, -t as f32, height as f32]
        })
        .collect();
    let mut source = Builder::default();
    let mut target = Builder::default();
    let cell = |chart: u32, [x, y]: [f64; 2]| {
        let (column, row) = (f64::from(chart % CHARTS), f64::from(chart / CHARTS));
        [column + 0.5 + x, row + 0.5 + y].map(|value| value / f64::from(CHARTS))
    };
    for chart in 0..CHARTS * CHARTS {
        let (sin, cos) = (f64::from(chart) * 0.7 + 0.35).sin_cos();
        for (row, column) in
            (0..SQUARES).flat_map(|row| (0..SQUARES).map(move |column| (row, column)))
        {
            let ring = [[0, 0], [0, 1], [1, 1], [1, 0]].map(|[dx, dy]| [column + dx, row + dy]);
            let [left, top] = [chart % CHARTS, chart / CHARTS].map(|k| k * SQUARES);
            let vertices = ring.map(|[x, y]| (top + y) * across + left + x);
            let local = ring.map(|at| at.map(|k| f64::from(k) / f64::from(SQUARES) - 0.5));
            target.quad(vertices, local.map(|at| cell(chart, at.map(|value| value * 0.85))));
            let turned = local.map(|[x, y]| {
                let x = if chart % 2 == 1 { -x } else { x };
                [cos * x - sin * y, sin * x + cos * y].map(|value| value * 0.62)
            });
            source.quad(vertices, turned.map(|at| cell((chart * 2 + 5) % (CHARTS * CHARTS), at)));
        }
    }
    let vertex_map: Vec<i64> = (0..i64::from(across * across)).collect();
    let source = source.build_at(positions.clone());
    let pair = Pair::by_vertex_map(source, target.build_at(positions), &vertex_map);
    Arc::new(pair.expect("a sound pair"))
}

/// A mesh with other positions and, if `rewind`, all faces wound the other way.
pub fn posed(mesh: &Mesh, rewind: bool, place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let positions = mesh
        .positions()
        .iter()
        .map(|position| place(position.map(f64::from)).map(|value| value as f32))
        .collect();
    let wound = |faces: &[[u32; 3]]| -> Vec<[u32; 3]> {
        faces.iter().map(|&[a, b, c]| if rewind { [a, c, b] } else { [a, b, c] }).collect()
    };
    let (faces, uv_faces) = (wound(mesh.faces()), wound(mesh.uv_faces()));
    Mesh::from_triangles(positions, mesh.uv().to_vec(), &faces, &uv_faces).expect("a sound mesh")
}
