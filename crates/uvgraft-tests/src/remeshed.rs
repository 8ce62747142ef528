//! The surface of a mesh with other triangles and another layout.

use std::collections::BTreeSet;

use glam::DVec3;
use uvgraft::Mesh;

/// Triangles whose points are means of another mesh's vertices.
#[derive(Debug, Clone)]
pub struct Remeshed {
    triangles: Vec<[u32; 3]>,
    /// For each point, up to three vertices of the original with equal weights.
    origins: Vec<Vec<u32>>,
}

impl Remeshed {
    /// The triangles of a mesh as they are.
    pub fn new(mesh: &Mesh) -> Self {
        let origins = (0..mesh.positions().len() as u32).map(|vertex| vec![vertex]).collect();
        Self { triangles: mesh.faces().to_vec(), origins }
    }

    /// A point in the centre of each triangle, joined across the edges: no edge is kept but open ones.
    ///
    /// # Panics
    /// If it was divided before.
    pub fn turned(mut self) -> Self {
        let first = self.origins.len() as u32;
        let mut sides: Vec<([u32; 2], usize, bool)> = Vec::new();
        for (index, points) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], index, a < b));
            }
            self.origins
                .push(points.iter().flat_map(|&at| self.origins[at as usize].clone()).collect());
        }
        assert!(
            self.origins.iter().all(|origin| origin.len() <= 3),
            "centres of original triangles"
        );
        sides.sort_unstable();
        let mut triangles = Vec::new();
        for group in sides.chunk_by(|one, other| one.0 == other.0) {
            let center = |index: usize| first + index as u32;
            match group {
                // The second one runs from the lower to the higher point.
                &[([a, b], left, false), (_, right, true)]
                | &[([a, b], right, true), (_, left, false)] => {
                    triangles.push([a, center(left), center(right)].map(|at| at));
                    triangles.push([b, center(right), center(left)].map(|at| at));
                }
                _ => triangles.extend(group.iter().map(|&([a, b], index, ascends)| {
                    if ascends { [a, b, center(index)] } else { [b, a, center(index)] }
                })),
            }
        }
        for triangle in &mut triangles {
            triangle.rotate_left(1);
        }
        Self { triangles, origins: self.origins }
    }

    /// Four triangles for each.
    ///
    /// # Panics
    /// If it was divided before.
    pub fn divided(mut self) -> Self {
        let mut middles = std::collections::HashMap::new();
        let mut triangles = Vec::with_capacity(self.triangles.len() * 4);
        for &points in &self.triangles {
            let middle = [0, 1, 2].map(|k| {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    let ends = [a, b].map(|at| self.origins[at as usize].clone());
                    self.origins.push(ends.concat());
                    self.origins.len() as u32 - 1
                })
            });
            for k in 0..3 {
                triangles.push([points[k], middle[k], middle[(k + 2) % 3]]);
            }
            triangles.push(middle);
        }
        assert!(self.origins.iter().all(|origin| origin.len() <= 3), "middles of original edges");
        Self { triangles, origins: self.origins }
    }

    /// Fewer triangles: points are joined to a neighbour, in random order, where the surface stays
    /// flat enough.
    ///
    /// - `keep`: about the share of points to keep.
    pub fn decimated(self, original: &Mesh, keep: f64, seed: u64) -> Self {
        const FLAT: f64 = 0.93;
        let points = self.places(original);
        let mut triangles = self.triangles.clone();
        let mut around = vec![BTreeSet::new(); points.len()];
        for (index, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&at| _ = around[at as usize].insert(index));
        }
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        fastrand::Rng::with_seed(seed).shuffle(&mut order);
        let mut left = ((1.0 - keep) * points.len() as f64) as usize;
        let normal = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|at| points[at as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        for point in order {
            if left == 0 {
                break;
            }
            let fan: Vec<usize> = around[point as usize].iter().copied().collect();
            let ring = |at: u32, around: &[BTreeSet<usize>], triangles: &[[u32; 3]]| {
                let all = around[at as usize].iter().flat_map(|&index| triangles[index]);
                all.filter(|&other| other != at).collect::<BTreeSet<u32>>()
            };
            let own = ring(point, &around, &triangles);
            let is_inside = own.len() == fan.len() && fan.len() >= 3;
            let fits = |&to: &u32| {
                let common = ring(to, &around, &triangles).intersection(&own).count();
                common == 2
                    && fan.iter().all(|&index| {
                        let corners = triangles[index];
                        let moved = corners.map(|at| if at == point { to } else { at });
                        corners.contains(&to) || normal(moved).dot(normal(corners)) > FLAT
                    })
            };
            let Some(to) = own.iter().copied().filter(|_| is_inside).find(fits) else { continue };
            for index in fan {
                if triangles[index].contains(&to) {
                    for at in triangles[index] {
                        around[at as usize].remove(&index);
                    }
                    triangles[index] = [u32::MAX; 3];
                } else {
                    triangles[index] = triangles[index].map(|at| if at == point { to } else { at });
                    around[to as usize].insert(index);
                }
            }
            around[point as usize].clear();
            left -= 1;
        }
        triangles.retain(|corners| corners[0] != u32::MAX);
        let mut renumbered = vec![u32::MAX; points.len()];
        let mut origins = Vec::new();
        for at in triangles.as_flattened_mut() {
            let new = &mut renumbered[*at as usize];
            if *new == u32::MAX {
                *new = origins.len() as u32;
                origins.push(self.origins[*at as usize].clone());
            }
            *at = *new;
        }
        Self { triangles, origins }
    }

    /// Where the points lie on the original, or on a mesh with the original's vertices elsewhere.
    pub fn places(&self, original: &Mesh) -> Vec<DVec3> {
        let at = |&vertex: &u32| glam::Vec3::from(original.positions()[vertex as usize]).as_dvec3();
        let mean = |origin: &Vec<u32>| origin.iter().map(at).sum::<DVec3>() / origin.len() as f64;
        self.origins.iter().map(mean).collect()
    }

    /// The mesh, in a layout in which every triangle is an island.
    ///
    /// # Panics
    /// Never: the triangles are those of a sound mesh.
    pub fn mesh(&self, original: &Mesh) -> Mesh {
        let across = (self.triangles.len() as f32 / 2.0).sqrt().ceil();
        let mut uv = Vec::with_capacity(self.triangles.len() * 3);
        for index in 0..self.triangles.len() {
            let cell = index as u32 / 2;
            let (column, row) = (cell % across as u32, cell / across as u32);
            let corners = if index % 2 == 0 {
                [[0.05, 0.05], [0.85, 0.05], [0.05, 0.85]]
            } else {
                [[0.95, 0.95], [0.15, 0.95], [0.95, 0.15]]
            };
            uv.extend(
                corners.map(|[x, y]| [(column as f32 + x) / across, (row as f32 + y) / across]),
            );
        }
        let positions =
            self.places(original).into_iter().map(|at| at.as_vec3().to_array()).collect();
        let uv_faces: Vec<[u32; 3]> =
            (0..self.triangles.len() as u32).map(|face| [0, 1, 2].map(|k| 3 * face + k)).collect();
        Mesh::from_triangles(positions, uv, &self.triangles, &uv_faces).expect("a sound mesh")
    }
}
