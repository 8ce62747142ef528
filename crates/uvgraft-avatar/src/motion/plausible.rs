//! What a motion of a person cannot be, with its likely cause: other units, another axis up, or a
//! wrong frame rate.

use std::fmt::{self, Display};

use glam::Vec3;
use uvgraft::Choice;
use uvgraft::statistics::median;

use super::Motion;
use super::up::{Posture, UpAxis};

/// Something implausible about a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Doubt {
    /// The hips move faster than people do.
    Speed {
        /// The largest speed, in metres per second.
        m_per_s: f32,
        /// When, in seconds.
        at_s: f64,
        /// The unit that the height of the hips suggests.
        unit: Option<&'static str>,
    },
    /// The hips are far above or below the origin.
    Height {
        /// The median height, in metres.
        height_m: f32,
        /// The unit that it suggests.
        unit: Option<&'static str>,
    },
    /// The body is upside down most of the time.
    UpsideDown {
        /// The axis that was taken to point up.
        up: UpAxis,
        /// The one with which the body is upright.
        upright: UpAxis,
    },
    /// Motions are hardly ever recorded at this rate.
    Rate {
        /// Frames a second.
        found: f64,
    },
}

/// Interval over which speeds are measured, in seconds: a step, so that one bad frame counts less.
const SPEED_S: f64 = 0.5;
/// Above the fastest sprints, 12.4 m/s. A walk in centimetres has about 130 m/s, in inches 50.
const MAX_M_PER_S: f32 = 15.0;
/// Hips of people who stand are at 0.7 to 1.1 m, or some metres higher or lower than the camera or
/// the start. In inches they are at 28 and more.
const MAX_HEIGHT_M: f32 = 20.0;
/// Below, a motion is a sequence of pictures; above are no systems for bodies, most have 24 to 240.
const RATES: std::ops::RangeInclusive<f64> = 5.0..=500.0;
/// The mean cosine between the spine and the vertical of a body that is upside down; somersaults and
/// people who bend over are above 0 on average.
const UPSIDE_DOWN: f32 = -0.4;
/// Units in which the hips of a standing person are at these heights.
const UNITS: [(&str, [f32; 2]); 3] =
    [("inches", [25.0, 45.0]), ("centimetres", [60.0, 120.0]), ("millimetres", [600.0, 1200.0])];

impl Motion {
    /// What is implausible about it, if anything.
    ///
    /// - `up`: the axis that is taken to point up.
    pub fn doubts(&self, up: UpAxis) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        let height_m = self.median_height(up);
        let unit = UNITS.into_iter().find(|(_, [least, most])| {
            let height = height_m.abs();
            *least <= height && height <= *most
        });
        let unit = unit.map(|(name, _)| name);
        let is_rate_odd =
            !self.is_rate_assumed() && !RATES.contains(&self.rate()) && self.frames() > 1;
        let (m_per_s, at_s) = self.largest_speed();
        // A wrong rate explains speeds too.
        if m_per_s > MAX_M_PER_S && (unit.is_some() || !is_rate_odd) {
            doubts.push(Doubt::Speed { m_per_s, at_s, unit });
        } else if height_m.abs() > MAX_HEIGHT_M {
            doubts.push(Doubt::Height { height_m, unit });
        }
        let posture = Posture::of(self);
        if posture.uprightness(up) < UPSIDE_DOWN && !posture.is_on_hands(up) {
            doubts.push(Doubt::UpsideDown { up, upright: opposite(up) });
        }
        if is_rate_odd {
            doubts.push(Doubt::Rate { found: self.rate() });
        }
        doubts
    }

    /// The largest speed of the hips up to rounding, in metres per second, and when first, in seconds.
    fn largest_speed(&self) -> (f32, f64) {
        let last = self.frames() - 1;
        let step = ((SPEED_S * self.rate()).round() as usize).clamp(1, last.max(1));
        let seconds = step as f64 / self.rate();
        let speeds = (step..=last).map(|frame| {
            let [from, to] = [frame - step, frame].map(|at| Vec3::from(self.translation(at)));
            (from.distance(to) / seconds as f32, (frame - step) as f64 / self.rate())
        });
        speeds.fold((0.0, 0.0), |most, found| if found.0 > most.0 * 1.001 { found } else { most })
    }

    fn median_height(&self, up: UpAxis) -> f32 {
        let height = |frame| (up.upright() * Vec3::from(self.translation(frame))).y;
        median((0..self.frames()).map(height)).unwrap_or_default()
    }
}

const fn opposite(up: UpAxis) -> UpAxis {
    match up {
        UpAxis::Y => UpAxis::MinusY,
        UpAxis::MinusY => UpAxis::Y,
        UpAxis::Z => UpAxis::MinusZ,
        UpAxis::MinusZ => UpAxis::Z,
    }
}

impl Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNKNOWN: &str = "centimetres, inches or millimetres";
        match *self {
            Self::Speed { m_per_s, at_s, unit } => write!(
                f,
                "the hips move at {m_per_s:.0} m/s at {at_s:.1} s; translations must be in metres: \
                 are they in {}?",
                unit.unwrap_or(UNKNOWN)
            ),
            Self::Height { height_m, unit } => write!(
                f,
                "the hips are at a height of {height_m:.0} m; translations must be in metres: are \
                 they in {}?",
                unit.unwrap_or(UNKNOWN)
            ),
            Self::UpsideDown { up, upright } => write!(
                f,
                "the body is upside down with {} up; use `up` {}?",
                up.name().to_uppercase(),
                upright.name()
            ),
            Self::Rate { found } => write!(
                f,
                "recorded at {found} frames per second, which is hardly possible; is the frame rate \
                 wrong?"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;

    const FRAMES: usize = 60;

    /// A body that stands upright and walks at 1.2 m/s, in another unit and with some axis up.
    fn motion(scale: f32, up: UpAxis, change: &dyn Fn(&mut NamedArrays)) -> Motion {
        let axes = up.upright().inverse();
        let root = axes.to_scaled_axis().to_array();
        let mut poses = vec![0.0; FRAMES * 66];
        poses.chunks_mut(66).for_each(|row| row[..3].copy_from_slice(&root));
        let place = |frame: usize| axes * Vec3::new(0.0, 0.93, 0.04 * frame as f32) * scale;
        let places = (0..FRAMES).flat_map(|frame| place(frame).to_array()).collect();
        let mut arrays = NamedArrays::new();
        arrays.insert("poses", NumericArray::new_f32(vec![FRAMES, 66], poses).unwrap());
        arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        arrays.insert("fps", NumericArray::new_f64(vec![], vec![30.0]).unwrap());
        change(&mut arrays);
        Motion::from_arrays(&arrays).unwrap()
    }

    fn said(motion: &Motion, up: UpAxis) -> Vec<String> {
        motion.doubts(up).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn units_are_reported_by_speed_and_height() {
        for up in [UpAxis::Y, UpAxis::Z, UpAxis::MinusY] {
            assert_eq!(motion(1.0, up, &|_| {}).doubts(up), []);
            // Sprinting.
            assert_eq!(motion(10.0, up, &|_| {}).doubts(up), []);
        }
        for (scale, unit, speed) in
            [(39.37, "inches", 47), (100.0, "centimetres", 120), (1000.0, "millimetres", 1200)]
        {
            let wanted = format!(
                "the hips move at {speed} m/s at 0.0 s; translations must be in metres: are they in \
                 {unit}?"
            );
            assert_eq!(said(&motion(scale, UpAxis::Z, &|_| {}), UpAxis::Z), [wanted]);
        }
        // Standing still, up to a sway.
        let still = |arrays: &mut NamedArrays| {
            let sway = |frame: usize| [(frame as f32 * 0.2).sin(), 0.5, 94.0];
            let places = (0..FRAMES).flat_map(sway).collect();
            arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        };
        assert_eq!(
            said(&motion(1.0, UpAxis::Z, &still), UpAxis::Z),
            ["the hips are at a height of 94 m; translations must be in metres: are they in \
              centimetres?"]
        );
        // From the start of the walk, so that the height says nothing.
        let relative = |arrays: &mut NamedArrays| {
            let places = (0..FRAMES).flat_map(|frame| [4.0 * frame as f32, 0.0, 0.0]).collect();
            arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        };
        let reported = said(&motion(1.0, UpAxis::Y, &relative), UpAxis::Y);
        assert!(reported[0].ends_with("in centimetres, inches or millimetres?"), "{reported:?}");
        // 40 m away is no doubt.
        let away = |arrays: &mut NamedArrays| {
            let places = (0..FRAMES).flat_map(|_| [40.0, 0.9, -30.0]).collect();
            arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        };
        assert_eq!(motion(1.0, UpAxis::Y, &away).doubts(UpAxis::Y), []);
    }

    #[test]
    fn bodies_upside_down_are_reported() {
        let down = motion(1.0, UpAxis::MinusY, &|_| {});
        assert_eq!(said(&down, UpAxis::Y), ["the body is upside down with Y up; use `up` -y?"]);
        assert_eq!(down.doubts(UpAxis::MinusY), []);
        let reported = said(&motion(1.0, UpAxis::Z, &|_| {}), UpAxis::MinusZ);
        assert_eq!(reported, ["the body is upside down with -Z up; use `up` z?"]);
        // Lying, and bending over.
        for angle in [1.5, -1.5, 1.9] {
            let turn = Quat::from_rotation_x(angle).to_scaled_axis().to_array();
            let lying = |arrays: &mut NamedArrays| {
                let mut poses = vec![0.0; FRAMES * 66];
                poses.chunks_mut(66).for_each(|row| row[..3].copy_from_slice(&turn));
                arrays.insert("poses", NumericArray::new_f32(vec![FRAMES, 66], poses).unwrap());
            };
            assert_eq!(motion(1.0, UpAxis::Y, &lying).doubts(UpAxis::Y), [], "{angle}");
        }
    }

    #[test]
    fn rates_that_no_system_has_are_reported() {
        let at = |rate: f64| {
            let set = |arrays: &mut NamedArrays| {
                arrays.insert("fps", NumericArray::new_f64(vec![], vec![rate]).unwrap());
            };
            motion(1.0, UpAxis::Y, &set).doubts(UpAxis::Y)
        };
        for rate in [1.0, 0.033, 1000.0, 10_000.0] {
            assert_eq!(at(rate), [Doubt::Rate { found: rate }]);
        }
        for rate in [6.0, 12.5, 29.97, 120.0, 250.0] {
            assert_eq!(at(rate), []);
        }
    }

    #[test]
    fn short_motions_are_measured() {
        for frames in 1..4 {
            let short = |arrays: &mut NamedArrays| {
                for (key, columns) in [("poses", 66), ("trans", 3)] {
                    let values = arrays.get(key).unwrap().f32s()[..frames * columns].to_vec();
                    arrays
                        .insert(key, NumericArray::new_f32(vec![frames, columns], values).unwrap());
                }
            };
            assert_eq!(motion(1.0, UpAxis::Y, &short).doubts(UpAxis::Y), []);
            let doubts = motion(100.0, UpAxis::Y, &short).doubts(UpAxis::Y);
            assert_eq!(doubts.len(), 1, "{doubts:?}");
        }
    }
}
