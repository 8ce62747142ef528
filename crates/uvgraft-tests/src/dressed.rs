//! Heads and bodies that wear something: hair, glasses, hats, scarves and clothes, each of separate
//! components beside those of the mesh.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use uvgraft::{Anatomy, HeadFrame, Mesh};

/// What is worn. Shapes are laid around the head's own size; lengths are distances between the eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extra {
    /// A cap of hair with a fringe, down to the neck behind.
    Cap,
    /// A tail behind the head.
    PonyTail,
    /// A lock beside either cheek.
    Locks,
    /// Four hundred narrow open quads that hang around the skull.
    Cards,
    /// A curtain around back and sides, down to the shoulder blades.
    LongHair,
    /// A shell over half of the brow that is swept to one side.
    SideSwept,
    /// Two balls of hair on the head, as large as the distance between the eyes.
    Buns,
    /// Thin rims, a bridge and temples.
    Glasses,
    /// Two panes before the eyes.
    Lenses,
    /// A dome with a brim.
    Hat,
    /// A cloth around the face, closed under the chin, down to the shoulders.
    Headscarf,
    /// A shell around everything below the neck.
    Clothes,
    /// A collar that stands up to the mouth.
    Collar,
    /// A shell before the lower face.
    Beard,
    /// Two spheres below the ears.
    Earrings,
    /// Two cones above the brow.
    Horns,
}

impl Extra {
    /// All of them.
    pub const ALL: [Self; 16] = [
        Self::Cap,
        Self::PonyTail,
        Self::Locks,
        Self::Cards,
        Self::LongHair,
        Self::SideSwept,
        Self::Buns,
        Self::Glasses,
        Self::Lenses,
        Self::Hat,
        Self::Headscarf,
        Self::Clothes,
        Self::Collar,
        Self::Beard,
        Self::Earrings,
        Self::Horns,
    ];
}

/// A mesh with extras after its own vertices and faces.
///
/// # Panics
/// If the mesh has no face.
pub fn dressed(mesh: &Mesh, extras: &[Extra]) -> Mesh {
    let anatomy = Anatomy::find(mesh).expect("a mesh with a face");
    let mut wardrobe = Wardrobe::new(mesh, *anatomy.frame());
    extras.iter().for_each(|&extra| wardrobe.add(extra));
    wardrobe.mesh()
}

struct Wardrobe<'a> {
    mesh: &'a Mesh,
    frame: HeadFrame,
    /// Of the head: an ellipsoid about the skull.
    center: DVec3,
    radii: DVec3,
    local: Vec<DVec3>,
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
    uv_faces: Vec<[u32; 3]>,
}

impl<'a> Wardrobe<'a> {
    fn new(mesh: &'a Mesh, frame: HeadFrame) -> Self {
        let place = |at: &[f32; 3]| DVec3::from(frame.local(at.map(f64::from)));
        let local: Vec<DVec3> = mesh.positions().iter().map(place).collect();
        let skull = local.iter().filter(|at| at.x.abs() < 1.6 && (-1.0..3.0).contains(&at.y));
        let skull = skull.filter(|at| at.z > -4.0 && at.z < 0.45);
        let (low, high) = skull.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &at| {
            (low.min(at), high.max(at))
        });
        let (center, radii) = ((low + high) / 2.0, (high - low) / 2.0);
        Self {
            mesh,
            frame,
            center: center.with_x(0.0).with_y(high.y - 1.25 * radii.y),
            radii: radii.with_y(1.25 * radii.y),
            local,
            positions: mesh.positions().to_vec(),
            uv: mesh.uv().to_vec(),
            faces: mesh.faces().to_vec(),
            uv_faces: mesh.uv_faces().to_vec(),
        }
    }

    fn mesh(self) -> Mesh {
        Mesh::from_triangles(self.positions, self.uv, &self.faces, &self.uv_faces)
            .expect("a sound mesh")
    }

    /// Rows of quads over `u` and `v` from 0 to 1; those whose centre `keeps` refuses are left out.
    fn grid(
        &mut self,
        [columns, rows]: [u32; 2],
        place: impl Fn(f64, f64) -> DVec3,
        keeps: impl Fn(DVec3) -> bool,
    ) {
        let (first, first_uv) = (self.positions.len() as u32, self.uv.len() as u32);
        for column in 0..=columns {
            for row in 0..=rows {
                let [u, v] =
                    [f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows)];
                let at = self.frame.world(place(u, v).to_array());
                self.positions.push(at.map(|value| value as f32));
                self.uv.push([u as f32, v as f32]);
            }
        }
        for column in 0..columns {
            for row in 0..rows {
                let middle = place(
                    (f64::from(column) + 0.5) / f64::from(columns),
                    (f64::from(row) + 0.5) / f64::from(rows),
                );
                if !keeps(middle) {
                    continue;
                }
                let at = |c: u32, r: u32| (column + c) * (rows + 1) + row + r;
                let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                for triangle in [[a, b, c], [a, c, d]] {
                    self.faces.push(triangle.map(|point| point + first));
                    self.uv_faces.push(triangle.map(|point| point + first_uv));
                }
            }
        }
    }

    /// The ellipsoid's place at an azimuth (0 in front, to the person's left) and a polar angle.
    fn around(&self, scale: f64, azimuth: f64, polar: f64) -> DVec3 {
        let direction =
            DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos());
        self.center + self.radii * scale * direction
    }

    fn tube(&mut self, ends: [DVec3; 2], radii: [f64; 2]) {
        let along = (ends[1] - ends[0]).normalize();
        let across = along.any_orthogonal_vector().normalize();
        let third = along.cross(across);
        self.grid(
            [12, 8],
            |u, v| {
                let (sin, cos) = (TAU * u).sin_cos();
                let radius = radii[0] + (radii[1] - radii[0]) * v;
                ends[0].lerp(ends[1], v) + (across * cos + third * sin) * radius
            },
            |_| true,
        );
    }

    fn sphere(&mut self, center: DVec3, radius: f64) {
        self.grid(
            [16, 12],
            |u, v| {
                let ((sin, cos), (across, up)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
                center + radius * DVec3::new(across * sin, up, across * cos)
            },
            |_| true,
        );
    }

    /// A copy of the mesh's faces whose centres are `wanted`, moved outwards.
    fn shell(&mut self, distance: f64, wanted: impl Fn(DVec3) -> bool) {
        let mut normals = vec![DVec3::ZERO; self.local.len()];
        for face in self.mesh.faces() {
            let [a, b, c] = face.map(|vertex| self.local[vertex as usize]);
            face.iter().for_each(|&vertex| normals[vertex as usize] += (b - a).cross(c - a));
        }
        let first = self.positions.len() as u32;
        for (&at, normal) in self.local.iter().zip(normals) {
            let place = at + normal.normalize_or_zero() * distance;
            self.positions.push(self.frame.world(place.to_array()).map(|value| value as f32));
        }
        let uv_faces = self.mesh.uv_faces();
        for (face, uv_face) in self.mesh.faces().iter().zip(uv_faces) {
            let middle = face.map(|vertex| self.local[vertex as usize]).iter().sum::<DVec3>() / 3.0;
            if wanted(middle) {
                self.faces.push(face.map(|vertex| vertex + first));
                self.uv_faces.push(*uv_face);
            }
        }
    }

    fn add(&mut self, extra: Extra) {
        match extra {
            Extra::Cap => self.cap(),
            Extra::PonyTail => {
                let start = self.around(1.1, PI, 0.35 * PI);
                self.tube([start, start + DVec3::new(0.0, -4.5, -0.7)], [0.5, 0.15]);
            }
            Extra::Locks => {
                for side in [-1.0, 1.0] {
                    let start = self.around(1.12, side * 1.2, 0.42 * PI);
                    self.tube([start, start + DVec3::new(0.0, -4.0, 0.3)], [0.28, 0.05]);
                }
            }
            Extra::Cards => self.cards(),
            Extra::LongHair => self.long_hair(),
            Extra::SideSwept => self.side_swept(),
            Extra::Buns => {
                for side in [-1.0, 1.0] {
                    let at = self.around(1.3, side * 1.57, 0.2 * PI);
                    self.sphere(at, 0.55);
                }
            }
            Extra::Glasses => self.glasses(),
            Extra::Lenses => {
                for side in [-1.0, 1.0] {
                    let center = DVec3::new(side * 0.5, -0.05, 0.62);
                    let place =
                        |u: f64, v: f64| center + DVec3::new(0.8 * (u - 0.5), 0.6 * (v - 0.5), 0.0);
                    self.grid([6, 6], place, |_| true);
                }
            }
            Extra::Hat => self.hat(),
            Extra::Headscarf => self.headscarf(),
            Extra::Clothes => self.shell(0.15, |at| at.y < -3.2),
            Extra::Collar => {
                let (center, radii) = (self.center, self.radii);
                let place = |u: f64, v: f64| {
                    let (sin, cos) = (TAU * u).sin_cos();
                    DVec3::new(1.5 * radii.x * sin, -1.3 - 1.8 * v, center.z + 1.4 * radii.z * cos)
                };
                self.grid([32, 8], place, |_| true);
            }
            Extra::Beard => self.shell(0.13, |at| {
                let is_mouth = DVec2::new(at.x / 0.5, (at.y + 1.13) / 0.3).length() < 1.0;
                (-2.1..-0.85).contains(&at.y) && at.z > -0.9 && !is_mouth
            }),
            Extra::Earrings => {
                for side in [-1.0, 1.0] {
                    self.sphere(DVec3::new(side * (self.radii.x + 0.1), -1.0, -1.2), 0.2);
                }
            }
            Extra::Horns => {
                for side in [-1.0, 1.0] {
                    let start = self.around(0.95, side * 0.5, 0.22 * PI);
                    self.tube([start, start + DVec3::new(0.3 * side, 1.5, 0.5)], [0.3, 0.01]);
                }
            }
        }
    }

    fn cap(&mut self) {
        let (center, radii) = (self.center, self.radii);
        let place = |u: f64, v: f64| {
            let azimuth = TAU * u;
            let end = if azimuth.cos() > 0.3 { 0.36 } else { 0.62 };
            let polar = (0.01 + v) / 1.01 * end * PI;
            let direction =
                DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos());
            center + radii * 1.15 * direction
        };
        self.grid([48, 16], place, |_| true);
    }

    fn cards(&mut self) {
        let mut random = fastrand::Rng::with_seed(7);
        let center = self.center;
        for index in 0..400 {
            let azimuth = TAU * random.f64();
            let end = if azimuth.cos() > 0.4 { 0.3 } else { 0.5 };
            let polar = end * PI * random.f64().sqrt();
            let scale = 1.06 + 0.06 * f64::from(index % 3);
            let [from, to] =
                [0.0, 0.14].map(|further| self.around(scale, azimuth, polar + further * PI));
            let across = (to - from).cross(from - center).normalize();
            let lean = 0.06 * (random.f64() - 0.5);
            let place = |u: f64, v: f64| {
                from.lerp(to, v) + across * (0.3 * (u - 0.5)) + (from - center) * (lean * v)
            };
            self.grid([1, 3], place, |_| true);
        }
    }

    fn long_hair(&mut self) {
        let (center, radii) = (self.center, self.radii);
        let place = |u: f64, v: f64| {
            // Open in front by 100 degrees.
            let azimuth = PI + (u - 0.5) * TAU * 0.72;
            let polar = (v * 2.0).min(1.0) * 0.5 * PI;
            let below = (v * 2.0 - 1.0).max(0.0) * 5.0;
            let direction =
                DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos());
            center + radii * 1.15 * direction - DVec3::Y * below
        };
        self.grid([40, 30], place, |_| true);
    }

    fn side_swept(&mut self) {
        let (center, radii) = (self.center, self.radii);
        let place = |u: f64, v: f64| {
            let azimuth = TAU * u;
            let front = azimuth.cos() > 0.2;
            let end = match front {
                true if azimuth.sin() > -0.2 => 0.55,
                true => 0.25,
                false => 0.6,
            };
            let polar = (0.01 + v) / 1.01 * end * PI;
            let direction =
                DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos());
            let bulge = 1.12 + 0.12 * (azimuth - 1.0).cos();
            center + radii * bulge * direction
        };
        self.grid([48, 16], place, |_| true);
    }

    fn glasses(&mut self) {
        for side in [-1.0, 1.0] {
            let center = DVec3::new(side * 0.5, -0.05, 0.6);
            let place = |u: f64, v: f64| {
                let ((sin, cos), (out, up)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
                let radius = 0.36 + 0.03 * up;
                center + DVec3::new(radius * sin, radius * cos, 0.03 * out)
            };
            self.grid([24, 6], place, |_| true);
            let outer = DVec3::new(side * 0.88, 0.0, 0.6);
            let ear = DVec3::new(side * (self.radii.x + 0.05), 0.0, -1.3);
            self.tube([outer, ear], [0.03, 0.03]);
        }
        self.tube([DVec3::new(-0.14, 0.0, 0.6), DVec3::new(0.14, 0.0, 0.6)], [0.03, 0.03]);
    }

    fn hat(&mut self) {
        let (center, radii) = (self.center, self.radii);
        let brow = 0.75;
        let dome = |u: f64, v: f64| {
            let (sin, cos) = (TAU * u).sin_cos();
            let [radius, height] =
                if v < 0.3 { [v / 0.3, 1.0] } else { [1.0, 1.0 - (v - 0.3) / 0.7] };
            let top = center.y + radii.y + 0.5;
            let scale = 1.08 * radius.max(0.01);
            DVec3::new(
                radii.x * scale * sin,
                brow + (top - brow) * height,
                center.z + radii.z * scale * cos,
            )
        };
        self.grid([40, 12], dome, |_| true);
        let brim = |u: f64, v: f64| {
            let (sin, cos) = (TAU * u).sin_cos();
            let scale = 1.08 + 0.7 * v;
            DVec3::new(radii.x * scale * sin, brow - 0.1 * v, center.z + radii.z * scale * cos)
        };
        self.grid([40, 5], brim, |_| true);
    }

    fn headscarf(&mut self) {
        let (center, radii) = (self.center, self.radii);
        let place = |u: f64, v: f64| {
            let azimuth = TAU * u;
            let polar = (v * 1.6).min(1.0) * 0.5 * PI;
            let below = (v * 1.6 - 1.0).max(0.0) / 0.6;
            let direction = DVec3::new(
                polar.sin().max(0.01) * azimuth.sin(),
                polar.cos(),
                polar.sin().max(0.01) * azimuth.cos(),
            );
            let wide = 1.15 + 0.5 * below * below;
            center + radii * wide * direction - DVec3::Y * (below * 3.2)
        };
        let is_off_the_face = |at: DVec3| {
            at.z < center.z || DVec2::new(at.x / 0.95, (at.y + 0.55) / 1.35).length() > 1.0
        };
        self.grid([64, 40], place, is_off_the_face);
    }
}
