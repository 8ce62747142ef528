//! The little vector arithmetic that modelling, painting and rendering share.

use std::ops::{Add, Mul, Neg, Sub};

/// A point or direction; which unit and space it is in, its user says.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Vec3 {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

pub(crate) const fn vec3(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    pub fn dot(self, other: Self) -> f32 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// Unit length; what has no length stays as it is.
    pub fn normalized(self) -> Self {
        let length = self.length();
        if length > 0.0 { self * (1.0 / length) } else { self }
    }

    pub fn lerp(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }

    /// The same point with `x` made positive, for shapes that are symmetric left and right.
    pub fn folded(self) -> Self {
        vec3(self.x.abs(), self.y, self.z)
    }

    /// Mirrored left and right.
    pub fn mirrored(self) -> Self {
        vec3(-self.x, self.y, self.z)
    }
}

impl From<[f32; 3]> for Vec3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        vec3(x, y, z)
    }
}

impl From<Vec3> for [f32; 3] {
    fn from(v: Vec3) -> Self {
        [v.x, v.y, v.z]
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f32> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        vec3(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

pub(crate) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 up to `from`, 1 from `to` on, smooth between; `from > to` falls instead.
pub(crate) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height 1 and the given half-width at `exp(-1)`.
pub(crate) fn bell(x: f32, width: f32) -> f32 {
    let t = x / width;
    (-t * t).exp()
}

/// A smooth curve through `(x, value)` knots in rising `x`, flat beyond both ends.
pub(crate) fn curve(knots: &[(f32, f32)], x: f32) -> f32 {
    let after = knots.partition_point(|knot| knot.0 <= x);
    if after == 0 {
        return knots[0].1;
    }
    if after == knots.len() {
        return knots[after - 1].1;
    }
    let (a, b) = (knots[after - 1], knots[after]);
    let slope = |i: usize| {
        let (low, high) = (knots[i.saturating_sub(1)], knots[(i + 1).min(knots.len() - 1)]);
        (high.1 - low.1) / (high.0 - low.0)
    };
    let width = b.0 - a.0;
    let t = (x - a.0) / width;
    let (t2, t3) = (t * t, t * t * t);
    a.1 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + b.1 * (3.0 * t2 - 2.0 * t3)
        + slope(after - 1) * width * (t3 - 2.0 * t2 + t)
        + slope(after) * width * (t3 - t2)
}
