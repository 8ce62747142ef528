//! Meshes linked by connectivity alone.

use uvgraft::correspond::topology::{TopologyError, TopologyReport};
use uvgraft::correspond::{By, FindOptions, Method, MethodFailure, find};
use uvgraft::{Corner, Extent, Mesh, Pair, Piece};
use uvgraft_tests::real;
use uvgraft_tests::shuffled::Shuffled;

fn by(by: By) -> FindOptions {
    let mut options = FindOptions::default();
    options.by = by;
    options
}

/// The pieces of a pair of shuffled meshes of triangles, in terms of the original ones, sorted.
fn original(pair: &Pair, source: &Shuffled, target: &Shuffled) -> Vec<(u32, u32, [u8; 3])> {
    let mut pieces: Vec<(u32, u32, [u8; 3])> = pair
        .pieces()
        .map(|Piece { target: to, source: from, extent }| {
            let Extent::Whole(corners) = extent else { panic!("a part") };
            let (to, to_first) = target.polygons[to as usize];
            let (from, from_first) = source.polygons[from as usize];
            let mut back = [0; 3];
            for k in 0..3 {
                let corner = (usize::from(corners[k]) + from_first) % 3;
                back[(k + to_first) % 3] = corner as u8;
            }
            (to as u32, from as u32, back)
        })
        .collect();
    pieces.sort_unstable();
    pieces
}

fn links(pair: &Pair) -> Vec<(u32, u32, [u8; 3])> {
    let mut pieces: Vec<(u32, u32, [u8; 3])> = pair
        .pieces()
        .map(|piece| {
            let Extent::Whole(corners) = piece.extent else { panic!("a part") };
            (piece.target, piece.source, corners)
        })
        .collect();
    pieces.sort_unstable();
    pieces
}

#[test]
fn a_shuffled_head_is_found_in_a_shuffled_body() {
    let Some(pair) = real::flame_to_smplx() else { return };
    for seed in 0..6 {
        let source = Shuffled::new(pair.source(), seed);
        let target = Shuffled::new(pair.target(), seed + 100);
        let found = find(source.mesh.clone(), target.mesh.clone(), &by(By::Topology)).unwrap();
        assert_eq!(original(&found.pair, &source, &target), links(&pair));
        // The other way round.
        let found = find(target.mesh.clone(), source.mesh.clone(), &by(By::Any)).unwrap();
        assert_eq!(found.pair.piece_count(), pair.piece_count());
        assert!(matches!(found.method, Method::Topology(report) if !report.is_mirrored));
    }
}

/// A mesh of polygons, with the place of each vertex as its layout.
fn polygon_mesh(positions: Vec<[f32; 3]>, polygons: &[Vec<u32>]) -> Mesh {
    let uv = positions.iter().map(|&[x, y, z]| [x + 0.3 * z, y - 0.2 * z].map(|at| 0.5 + 0.1 * at));
    let corners: Vec<Corner> =
        polygons.iter().flatten().map(|&vertex| Corner { vertex, uv: vertex }).collect();
    let sizes: Vec<u32> = polygons.iter().map(|polygon| polygon.len() as u32).collect();
    let uv = uv.collect();
    Mesh::from_polygons(positions, uv, &corners, &sizes).expect("a sound mesh")
}

fn polygons(mesh: &Mesh) -> Vec<Vec<u32>> {
    let ring = |polygon| mesh.polygon_corners(polygon).iter().map(|at| at.vertex).collect();
    (0..mesh.polygon_count()).map(ring).collect()
}

/// A sheet of quads, bent differently everywhere, without the polygons for which `is_hole` holds.
fn sheet(n: u32, is_hole: impl Fn(u32) -> bool) -> Mesh {
    let count = n + 1;
    let place = |k: u32| {
        let [x, y] = [k % count, k / count].map(|at| at as f32 / n as f32 * 2.0 - 1.0);
        [x + 0.04 * (5.0 * y).sin(), y, 0.3 * (1.3 * x + 0.4).sin() * (0.9 * y - 0.2).cos()]
    };
    let quads: Vec<Vec<u32>> = (0..n * n)
        .filter(|&quad| !is_hole(quad))
        .map(|quad| quad / n * count + quad % n)
        .map(|k| vec![k, k + 1, k + count + 1, k + count])
        .collect();
    polygon_mesh((0..count * count).map(place).collect(), &quads)
}

/// A sheet with holes at random places, so that its connectivity tells places apart.
fn holed(seed: u64) -> Mesh {
    let mut random = fastrand::Rng::with_seed(seed);
    let holes: Vec<u32> = (0..12).map(|_| random.u32(0..24 * 24)).collect();
    sheet(24, |quad| holes.contains(&quad))
}

/// The original vertex of each shuffled one.
fn back(shuffled: &Shuffled) -> Vec<u32> {
    let mut back = vec![0; shuffled.vertices.len()];
    for (old, &new) in shuffled.vertices.iter().enumerate() {
        back[new as usize] = old as u32;
    }
    back
}

/// Number of whole pieces, all of which must put source vertices on their target vertices.
fn right_pieces(
    pair: &Pair,
    source: &Shuffled,
    target: &Shuffled,
    target_of: impl Fn(u32) -> u32,
) -> usize {
    let (from, to) = (back(source), back(target));
    let mut count = 0;
    for piece in pair.pieces() {
        let Extent::Whole(corners) = piece.extent else { continue };
        for k in 0..3 {
            let target = pair.target().faces()[piece.target as usize][k];
            let source = pair.source().faces()[piece.source as usize][usize::from(corners[k])];
            assert_eq!(to[target as usize], target_of(from[source as usize]));
        }
        count += 1;
    }
    count
}

fn topology(report: &Method) -> &TopologyReport {
    let Method::Topology(report) = report else { panic!("{report:?}") };
    report
}

#[test]
fn quads_are_found_in_their_triangulations() {
    for seed in 0..4 {
        let quads = holed(seed);
        let mut random = fastrand::Rng::with_seed(seed + 50);
        let triangles: Vec<Vec<u32>> = polygons(&quads)
            .into_iter()
            .flat_map(|mut quad| {
                quad.rotate_left(random.usize(0..2));
                [vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]]
            })
            .collect();
        let triangles = polygon_mesh(quads.positions().to_vec(), &triangles);
        let count = triangles.faces().len();
        let [source, target] = [Shuffled::new(&quads, seed), Shuffled::new(&triangles, seed + 100)];
        for (a, b) in [(&source, &target), (&target, &source)] {
            let found = find(a.mesh.clone(), b.mesh.clone(), &by(By::Topology)).unwrap();
            assert_eq!(right_pieces(&found.pair, a, b, |vertex| vertex), count, "{seed}");
            assert!(!topology(&found.method).is_mirrored);
        }
    }
}

#[test]
fn both_sides_of_a_sheet_are_linked_to_themselves() {
    let quads = holed(3);
    let above: Vec<Vec<u32>> = polygons(&quads)
        .into_iter()
        .flat_map(|quad| [vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]])
        .collect();
    let below = above.iter().map(|triangle| triangle.iter().rev().copied().collect());
    let both: Vec<Vec<u32>> = above.iter().cloned().chain(below).collect();
    let sheet = polygon_mesh(quads.positions().to_vec(), &both);
    for seed in 0..4 {
        let [source, target] = [seed, seed + 100].map(|seed| Shuffled::new(&sheet, seed));
        let pair = find(source.mesh.clone(), target.mesh.clone(), &by(By::Topology)).unwrap().pair;
        let found = original(&pair, &source, &target);
        assert_eq!(found.len(), both.len(), "{seed}");
        assert!(found.iter().all(|&(to, from, _)| to == from), "{seed}");
    }
}

#[test]
fn edited_meshes_match_elsewhere() {
    for seed in 0..4 {
        let original = holed(seed);
        let mut random = fastrand::Rng::with_seed(seed + 9);
        let mut rings = polygons(&original);
        let mut positions = original.positions().to_vec();
        // A few polygons are gone, a few have a vertex more on a side, and something is new.
        (0..8).for_each(|_| drop(rings.swap_remove(random.usize(0..rings.len()))));
        for _ in 0..4 {
            let ring = random.usize(0..rings.len());
            let [a, b] = [rings[ring][0], rings[ring][1]].map(|at| positions[at as usize]);
            positions.push([0, 1, 2].map(|k| f32::midpoint(a[k], b[k])));
            let new = positions.len() as u32 - 1;
            rings[ring].insert(1, new);
        }
        let first = positions.len() as u32;
        positions.extend([[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 1.0, 0.5]]);
        rings.push(vec![first, first + 1, first + 2]);
        let edited = polygon_mesh(positions, &rings);
        let [source, target] = [Shuffled::new(&edited, seed), Shuffled::new(&original, seed + 100)];
        for (a, b) in [(&source, &target), (&target, &source)] {
            let found = find(a.mesh.clone(), b.mesh.clone(), &by(By::Topology)).unwrap();
            let right = right_pieces(&found.pair, a, b, |vertex| vertex);
            let least = 2 * (rings.len() - 1 - 4 * 4);
            assert!(right >= least, "{seed}: {right} of {least}");
            let report = topology(&found.method);
            assert!(report.matched < report.of, "{report:?}");
        }
    }
}

#[test]
fn windings_tell_mirror_images_apart() {
    for seed in 0..4 {
        let mesh = holed(seed);
        // The same polygons seen from behind, as some exporters write them.
        let turned: Vec<Vec<u32>> = polygons(&mesh)
            .into_iter()
            .map(|mut ring| {
                ring.reverse();
                ring
            })
            .collect();
        let turned = polygon_mesh(mesh.positions().to_vec(), &turned);
        let [source, target] = [Shuffled::new(&mesh, seed), Shuffled::new(&turned, seed + 100)];
        let found = find(source.mesh.clone(), target.mesh.clone(), &by(By::Topology)).unwrap();
        let count = mesh.faces().len();
        assert_eq!(right_pieces(&found.pair, &source, &target, |vertex| vertex), count);
        assert!(topology(&found.method).is_mirrored);
    }
}

/// Several meshes as one.
fn together(meshes: &[Mesh]) -> Mesh {
    let (mut positions, mut rings) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        rings.extend(
            polygons(mesh)
                .into_iter()
                .map(|ring| ring.into_iter().map(|vertex| vertex + first).collect::<Vec<u32>>()),
        );
    }
    polygon_mesh(positions, &rings)
}

fn moved(mesh: &Mesh, place: impl Fn([f32; 3]) -> [f32; 3]) -> Mesh {
    mesh.clone()
        .with_positions(mesh.positions().iter().map(|&at| place(at)).collect())
        .expect("as many")
}

#[test]
fn equal_components_and_symmetric_sheets_are_reported_apart_by_positions() {
    let sheet = sheet(9, |_| false);
    let eye = |x: f32| moved(&icosphere(2), move |at| [at[0] * 0.4 + x, at[1] * 0.4, at[2] * 0.4]);
    for seed in 0..4 {
        let with_eyes = together(&[holed(seed), eye(-4.0), eye(4.0)]);
        // A regular grid, whose connectivity has eight symmetries, and one with two equal spheres,
        // which have a hundred and twenty each.
        for mesh in [&sheet, &with_eyes] {
            let [source, target] = [Shuffled::new(mesh, seed), Shuffled::new(mesh, seed + 100)];
            // Somebody else's shape of the same mesh, somewhere else.
            let other =
                moved(&target.mesh, |[x, y, z]| [1.1 * x + 0.03 * y + 7.0, 1.1 * y, 1.2 * z]);
            let found = find(source.mesh.clone(), other, &by(By::Topology)).unwrap();
            let right = right_pieces(&found.pair, &source, &target, |vertex| vertex);
            assert_eq!(right, mesh.faces().len(), "{seed}");
            let report = topology(&found.method);
            assert!(report.chosen_by_position > 0 && !report.is_mirrored, "{report:?}");
        }
    }
}

/// A subdivided icosahedron of radius 1.
fn icosphere(rounds: u32) -> Mesh {
    let golden = f32::midpoint(1.0, 5.0_f32.sqrt());
    let mut points: Vec<[f32; 3]> = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let distance = |a: u32, b: u32, points: &[[f32; 3]]| -> f32 {
        (0..3).map(|k| (points[a as usize][k] - points[b as usize][k]).powi(2)).sum()
    };
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for (a, b, c) in
        (0..12).flat_map(|a| (0..12).flat_map(move |b| (0..12).map(move |c| (a, b, c))))
    {
        let is_face =
            [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| p != q && distance(p, q, &points) < 4.1);
        let [p, q, r] = [a, b, c].map(|at: u32| glam::Vec3::from(points[at as usize]));
        if is_face && a < b && a < c && p.dot(q.cross(r)) > 0.0 {
            rings.push(vec![a, b, c]);
        }
    }
    for _ in 0..rounds {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::new();
        for ring in &rings {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push(
                        [0, 1, 2]
                            .map(|k| f32::midpoint(points[a as usize][k], points[b as usize][k])),
                    );
                    points.len() as u32 - 1
                })
            };
            let [a, b, c] = [ring[0], ring[1], ring[2]];
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([vec![a, ab, ca], vec![ab, b, bc], vec![ca, bc, c], vec![ab, bc, ca]]);
        }
        rings = finer;
    }
    let unit = |at: [f32; 3]| glam::Vec3::from(at).normalize().to_array();
    polygon_mesh(points.into_iter().map(unit).collect(), &rings)
}

/// A cube of `n * n` quads a side, welded.
fn cube(n: i32) -> Mesh {
    let mut index = std::collections::BTreeMap::new();
    let mut rings = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let at = |i: i32, j: i32| {
                    let mut at = [0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, i, j);
                    at
                };
                let mut ring = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if side == 0 {
                    ring.reverse();
                }
                rings.push(ring);
            }
        }
    }
    for at in rings.as_flattened() {
        let next = index.len() as u32;
        index.entry(*at).or_insert(next);
    }
    let mut positions = vec![[0.0; 3]; index.len()];
    for (at, &vertex) in &index {
        positions[vertex as usize] = at.map(|value| value as f32 * 2.0 / n as f32 - 1.0);
    }
    let rings: Vec<Vec<u32>> =
        rings.iter().map(|ring| ring.map(|at| index[&at]).to_vec()).collect();
    polygon_mesh(positions, &rings)
}

/// A torus of quads, which look alike everywhere.
fn torus([around, across]: [u32; 2]) -> Mesh {
    let place = |k: u32| {
        let turn = |at: u32, of: u32| (at as f32 / of as f32 * std::f32::consts::TAU).sin_cos();
        let ([a, b], [c, d]) = (turn(k / across, around).into(), turn(k % across, across).into());
        [(3.0 + d) * b, (3.0 + d) * a, c]
    };
    let quad = |k: u32| {
        let at = |i: u32, j: u32| (k / across + i) % around * across + (k % across + j) % across;
        vec![at(0, 0), at(1, 0), at(1, 1), at(0, 1)]
    };
    let all = 0..around * across;
    polygon_mesh(all.clone().map(place).collect(), &all.map(quad).collect::<Vec<_>>())
}

#[test]
fn meshes_that_look_alike_everywhere_are_found_where_they_are() {
    // Each of 2400 quads fits on any other, in four ways.
    let mesh = torus([60, 40]);
    let (a, b) = (Shuffled::new(&mesh, 1), Shuffled::new(&mesh, 2));
    let found = find(a.mesh.clone(), b.mesh.clone(), &by(By::Topology)).unwrap();
    assert_eq!(right_pieces(&found.pair, &a, &b, |vertex| vertex), 4800);
    // Elsewhere, the search ends at its limit.
    let shaken = |at: f32| 2.0 * at + 0.01 * (997.0 * at).sin();
    let other = moved(&b.mesh, |[x, y, z]| [-y, x, z].map(shaken));
    let error = find(a.mesh, other, &by(By::Topology)).unwrap_err();
    let [MethodFailure::Topology(TopologyError::TooManyWays { steps, .. })] = error.0[..] else {
        panic!("{error}")
    };
    assert!(steps < 2_000_000, "{steps}");
}

#[test]
fn thousands_of_equal_components_are_found_where_they_are() {
    let sheet = sheet(2, |_| false);
    let place = |k: u32| [k % 40, k / 40].map(|at| 3.0 * at as f32);
    let cards: Vec<Mesh> = (0..1200)
        .map(|k| moved(&sheet, |[x, y, z]| [x + place(k)[0], y + place(k)[1], z]))
        .collect();
    let mesh = together(&cards);
    let (a, b) = (Shuffled::new(&mesh, 1), Shuffled::new(&mesh, 2));
    let found = find(a.mesh.clone(), b.mesh.clone(), &by(By::Topology)).unwrap();
    let Method::Topology(report) = found.method else { panic!("not by topology") };
    assert_eq!((report.matched, report.components_left_out), (4800, 0));
    assert_eq!(right_pieces(&found.pair, &a, &b, |vertex| vertex), found.pair.piece_count());
}

#[test]
fn impossible_pairs_are_refused_with_a_reason() {
    for (source, target) in [(icosphere(3), cube(10)), (cube(10), icosphere(3))] {
        for seed in 0..3 {
            let [source, target] =
                [Shuffled::new(&source, seed).mesh, Shuffled::new(&target, seed).mesh];
            let error = find(source, target, &by(By::Topology)).unwrap_err().to_string();
            assert!(
                error.contains("the connectivity of one mesh must be found in the other"),
                "{error}"
            );
            assert!(error.contains("polygons are connected alike"), "{error}");
        }
    }
}

/// The mesh with a vertex added in the middle of a share of its quads.
fn poked(mesh: &Mesh, share: f32, seed: u64) -> Mesh {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut positions = mesh.positions().to_vec();
    let mut rings = Vec::new();
    for ring in polygons(mesh) {
        if random.f32() >= share {
            rings.push(ring);
            continue;
        }
        let centre = positions.len() as u32;
        let sum = |k: usize| ring.iter().map(|&at| positions[at as usize][k]).sum::<f32>();
        let middle = [0, 1, 2].map(|k| sum(k) / ring.len() as f32);
        positions.push(middle);
        rings.extend((0..ring.len()).map(|k| vec![ring[k], ring[(k + 1) % ring.len()], centre]));
    }
    polygon_mesh(positions, &rings)
}

/// The place of a piece's corners on a mesh.
fn places(mesh: &Mesh, face: u32, corners: [[f64; 3]; 3]) -> [glam::DVec3; 3] {
    let at = mesh.faces()[face as usize]
        .map(|vertex| glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3());
    corners.map(|weights| (0..3).map(|k| at[k] * weights[k]).sum())
}

#[test]
fn quads_with_an_added_centre_are_linked_in_parts() {
    for seed in 0..4 {
        let quads = holed(seed);
        let triangles: Vec<Vec<u32>> = polygons(&quads)
            .into_iter()
            .flat_map(|quad| [vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]])
            .collect();
        let triangles = polygon_mesh(quads.positions().to_vec(), &triangles);
        for (share, whole) in [(1.0, &quads), (0.1, &quads), (1.0, &triangles)] {
            let poked = poked(&quads, share, seed);
            let added = poked.positions().len() - quads.positions().len();
            let [a, b] = [Shuffled::new(whole, seed).mesh, Shuffled::new(&poked, seed + 100).mesh];
            for (source, target) in [(&a, &b), (&b, &a)] {
                let found = find(source.clone(), target.clone(), &by(By::Topology)).unwrap();
                assert_eq!(topology(&found.method).with_added_centre, added, "{share} {seed}");
                let (mut linked, mut area) = (vec![false; target.faces().len()], 0.0);
                for piece in found.pair.pieces() {
                    linked[piece.target as usize] = true;
                    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                    let [to, from] = match piece.extent {
                        Extent::Whole(corners) => [unit, corners.map(|k| unit[usize::from(k)])],
                        Extent::Part { target, source } => [target, source],
                    };
                    let to = places(found.pair.target(), piece.target, to);
                    let from = places(found.pair.source(), piece.source, from);
                    // The middle of a diagonal is not quite that of a bent quad.
                    assert!((0..3).all(|k| to[k].distance(from[k]) < 0.01), "{to:?} {from:?}");
                    area += (to[1] - to[0]).cross(to[2] - to[0]).length() / 2.0;
                }
                assert!(linked.iter().all(|linked| *linked), "{share} {seed}");
                let whole: f64 = (0..target.faces().len() as u32)
                    .map(|face| {
                        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                        let [p, q, r] = places(found.pair.target(), face, unit);
                        (q - p).cross(r - p).length() / 2.0
                    })
                    .sum();
                assert!((area / whole - 1.0).abs() < 1e-3, "{area} of {whole}");
            }
        }
    }
}
