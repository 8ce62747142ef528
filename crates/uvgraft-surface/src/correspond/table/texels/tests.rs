use super::*;

const ISLANDS: [fn([f32; 2]) -> [f32; 2]; 2] = [
    |[s, t]| [0.02 + 0.8 * s, 0.1 + 0.8 * t],
    // Turned by half a turn, far from where it would continue.
    |[s, t]| [0.98 - 0.8 * (s - 0.5), 0.9 - 0.8 * t],
];

/// A sheet of `side²` squares, whose positions are `(s, t, 0)` in the unit square, with another layout
/// for each half.
fn sheet(side: u32, islands: [fn([f32; 2]) -> [f32; 2]; 2]) -> Mesh {
    let at = |k: u32| k as f32 / side as f32;
    let all = (0..=side).flat_map(|y| (0..=side).map(move |x| [x, y]));
    let positions: Vec<[f32; 3]> = all.map(|[x, y]| [at(x), at(y), 0.0]).collect();
    let count = positions.len() as u32;
    let uv = islands.iter().flat_map(|island| positions.iter().map(|&[s, t, _]| island([s, t])));
    let (mut faces, mut uv_faces) = (Vec::new(), Vec::new());
    for y in 0..side {
        for x in 0..side {
            let [a, b] = [y * (side + 1) + x, (y + 1) * (side + 1) + x];
            for face in [[a, a + 1, b + 1], [a, b + 1, b]] {
                faces.push(face);
                uv_faces
                    .push(face.map(|vertex| if 2 * x < side { vertex } else { vertex + count }));
            }
        }
    }
    Mesh::from_triangles(positions.clone(), uv.collect(), &faces, &uv_faces).unwrap()
}

const WHOLE: fn([f32; 2]) -> [f32; 2] = |[s, t]| [0.04 + 0.9 * s, 0.06 + 0.9 * t];

/// The source positions of a grid over a sheet with the layout [`WHOLE`].
fn grid(size: Size) -> Vec<[f32; 2]> {
    let position = |texel: usize| {
        let [x, y] = [texel % size.width as usize, texel / size.width as usize];
        let s = ((x as f32 + 0.5) / size.width as f32 - 0.04) / 0.9;
        let t = ((y as f32 + 0.5) / size.height as f32 - 0.06) / 0.9;
        let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
        if inside { ISLANDS[usize::from(s >= 0.5)]([s, t]) } else { [f32::NAN; 2] }
    };
    (0..size.texels()).map(position).collect()
}

#[test]
fn equal_triangles_give_a_vertex_map() {
    let (source, target) = (sheet(16, ISLANDS), sheet(16, [WHOLE; 2]));
    for size in [Size::new(64, 96), Size::square(200)] {
        let (table, counts) =
            VertexTable::from_texels(&source, &target, size, &grid(size)).unwrap();
        assert_eq!(table.vertex_map(), Some((0..17 * 17).collect()), "{size}: {counts:?}");
        assert_eq!((counts.fitted, counts.across_seams), (512, 0));
    }
}

#[test]
fn other_triangles_give_points_between_and_none_across_the_seam() {
    // No edge of these 11 columns lies on the seam.
    let (source, target) = (sheet(16, ISLANDS), sheet(11, [WHOLE; 2]));
    let size = Size::square(192);
    let (table, counts) = VertexTable::from_texels(&source, &target, size, &grid(size)).unwrap();
    assert_eq!((counts.across_seams, counts.fitted), (22, 220));
    let mut known = 0;
    for (point, wanted) in table.points().iter().zip(target.positions()) {
        let Some(point) = point else { continue };
        known += 1;
        let corners = point.vertices.map(|vertex| source.positions()[vertex as usize]);
        let corners = corners.map(|corner| corner.map(f64::from));
        let found = mixed(&corners, point.weights);
        let off = (0..2).map(|k| (found[k] - f64::from(wanted[k])).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{found:?}, not {wanted:?}");
    }
    // The vertices at both sides of the seam have triangles beside those across it.
    assert_eq!(known, 144);
}

#[test]
fn small_triangles_take_their_vertices_from_others() {
    let (source, target) = (sheet(16, ISLANDS), sheet(16, [WHOLE; 2]));
    // About three texels in each square.
    let size = Size::square(30);
    let (table, counts) = VertexTable::from_texels(&source, &target, size, &grid(size)).unwrap();
    assert!(counts.too_few_texels > 250, "{counts:?}");
    let wrong = table.points().iter().enumerate().filter(|(vertex, point)| {
        point.is_some_and(|point| point.vertex() != Some(*vertex as u32))
    });
    assert_eq!(wrong.count(), 0);
    assert!(table.count() > 150, "{}", table.count());
}

#[test]
fn texels_of_several_triangles_are_not_used() {
    // Both halves in one place: neither can be told from the grid.
    let source = sheet(16, ISLANDS);
    let shared: [fn([f32; 2]) -> [f32; 2]; 2] = [WHOLE, |[s, t]| WHOLE([s - 0.5, t])];
    let target = sheet(16, shared);
    let size = Size::square(128);
    let found = VertexTable::from_texels(&source, &target, size, &grid(size));
    assert_eq!(found.unwrap_err(), TableError::Nothing { vertices: 289 });
}

#[test]
fn grids_that_are_nonsense_are_no_panic() {
    let (source, target) = (sheet(4, ISLANDS), sheet(3, [WHOLE; 2]));
    let size = Size::square(24);
    let table = |grid: &[[f32; 2]]| VertexTable::from_texels(&source, &target, size, grid);
    let short = table(&[[0.5; 2]; 5]).unwrap_err().to_string();
    assert_eq!(short, "there must be 576 positions, one for each texel, got 5");
    assert!(table(&vec![[0.5; 2]; 576]).is_err());
    let mut random = fastrand::Rng::with_seed(4);
    for _ in 0..300 {
        let mut grid = grid(size);
        for _ in 0..random.usize(1..300) {
            let wild = [f32::NAN, f32::INFINITY, 3e38, -3e38, 0.0, random.f32(), 1e-40, -7.5];
            grid[random.usize(0..576)] = [0, 1].map(|_| wild[random.usize(0..8)]);
        }
        if let Ok((table, _)) = table(&grid) {
            for point in table.points().iter().flatten() {
                assert!((point.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{point:?}");
            }
        }
    }
    let none = VertexTable::from_texels(&source, &target, Size::new(0, 7), &[]);
    assert!(none.is_err());
}
