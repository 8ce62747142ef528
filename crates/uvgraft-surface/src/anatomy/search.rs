//! Locates the head: by its eyeballs, or else by its symmetry and the profile of its face.

use glam::DVec3;

use super::AnatomyError;
use super::eyes::{EyePair, SphereFit, balls, pairs};
use super::frame::HeadFrame;
use super::points::{MIN_POINTS, Points};
use super::profile::{FaceFit, Section};
use super::relief::Relief;
use super::symmetry::{MIN_MIRRORED, planes};
use crate::directions::direction;

/// A detected head.
pub(super) struct Head {
    pub frame: HeadFrame,
    pub eyes: Eyes,
    /// The depth map of the skin.
    pub relief: Relief,
}

/// Eyes in the head's coordinates.
pub(super) struct Eyes {
    /// The centres of the left and right eye.
    pub centers: [DVec3; 2],
    /// `None` if no eyeballs were detected.
    pub radius: Option<f64>,
    /// Whether each component is part of an eyeball.
    pub components: Vec<bool>,
    /// The component of the face's skin.
    pub skin: u32,
}

/// Largest accepted deviations from the profile of a face, with and without known eyes. Origin not
/// recorded.
const LARGEST_DEVIATION: f64 = 0.26;
const LARGEST_DEVIATION_WITHOUT_EYES: f64 = 0.085;

/// Orientations whose deviations differ by less are both looked at. Origin not recorded.
const ALIKE: f64 = 0.1;
/// How much further a nose must protrude for its orientation to be taken in spite of the profile.
/// Origin not recorded.
const CLEARER: f64 = 1.5;

/// Why no face was found where nothing resembles one.
const NO_PROFILE: &str = "no part of the outline matches the profile of a face";

/// The surface in which a face is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Within {
    All,
    /// A component alone: beside the skin, a mesh may have hair, glasses and clothes.
    One(u32),
}

impl Within {
    fn has(self, component: u32) -> bool {
        match self {
            Self::All => true,
            Self::One(one) => component == one,
        }
    }
}

/// A head, and how much its profile deviates from that of a face.
type Candidate = (f64, Head);

/// Locates the head by the pair of eyeballs whose profile fits best, or by symmetry if no pair fits:
/// in the whole mesh, and in each component that may be the skin.
pub(super) fn head(points: &Points) -> Result<Head, AnatomyError> {
    let pairs = pairs(points);
    let by_eyes = |within: Within| {
        let found = pairs.iter().filter_map(|pair| by_eyes(points, pair, within));
        found.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let whole = by_eyes(Within::All);
    let skins = skins(points);
    let alone = || skins.iter().filter_map(|&skin| by_eyes(Within::One(skin)));
    let alone = alone().min_by(|a, b| a.0.total_cmp(&b.0));
    // Where the eyes are is known, so the rest of the mesh says only which way is up.
    if let Some(head) = better(whole, alone, |whole, _| whole) {
        return Ok(head);
    }
    let whole = by_symmetry(points, Within::All);
    let alone = skins.iter().filter_map(|&skin| by_symmetry(points, Within::One(skin)).ok());
    let alone = alone.min_by(|a, b| a.0.total_cmp(&b.0));
    let (whole, error) = match whole {
        Ok(whole) => (Some(whole), None),
        Err(error) => (None, Some(error)),
    };
    better(whole, alone, |_, alone| alone)
        .ok_or_else(|| error.unwrap_or(AnatomyError::NoFace { reason: NO_PROFILE }))
}

/// The head of the whole mesh, or that of a component alone where the two differ: a face's profile
/// under hair or above a collar is taken for its own upside down.
///
/// - `choose`: takes one of them where they do not differ.
fn better(
    whole: Option<Candidate>,
    alone: Option<Candidate>,
    choose: impl Fn(Head, Head) -> Head,
) -> Option<Head> {
    /// How much more a face in a component alone may deviate: whole outlines that were wrong deviated
    /// by at least 1.1 times as much.
    const PREFERRED: f64 = 1.5;
    match (whole, alone) {
        (Some((deviation, whole)), Some((other, alone))) => {
            let is_same = whole.eyes.skin == alone.eyes.skin && whole.frame.is_near(&alone.frame);
            Some(if is_same {
                choose(whole, alone)
            } else if other < PREFERRED * deviation {
                alone
            } else {
                whole
            })
        }
        (whole, alone) => whole.or(alone).map(|(_, head)| head),
    }
}

/// The components that may be a head's skin, those with most points, if there is more than one beside
/// spheres.
fn skins(points: &Points) -> Vec<u32> {
    /// Hair may have more points than skin, but rarely in as many components.
    const MOST: usize = 6;
    let mut counts = vec![0usize; points.component_count];
    points.component.iter().for_each(|&component| counts[component as usize] += 1);
    for ball in balls(points) {
        counts[ball.component as usize] = 0;
    }
    let mut skins: Vec<u32> = (0..points.component_count as u32).collect();
    skins.retain(|&skin| counts[skin as usize] > 0);
    if skins.len() < 2 {
        return Vec::new();
    }
    skins.retain(|&skin| counts[skin as usize] >= MIN_POINTS);
    skins.sort_by_key(|&skin| std::cmp::Reverse(counts[skin as usize]));
    skins.truncate(MOST);
    skins
}

/// The head around a pair of spheres: the plane between them must cut the mesh in the profile
/// of a face. Returns the deviation from that profile with the head.
fn by_eyes(points: &Points, pair: &EyePair, within: Within) -> Option<Candidate> {
    let [a, b] = pair.spheres;
    let unit = b.center.distance(a.center);
    let normal = direction(b.center - a.center)?;
    let origin = a.center.lerp_monotonic(b.center, 0.5);
    let [first, other] =
        Section::new(points, |component| within.has(component), origin, normal, 4.0 * unit)
            .around_eyes(unit);
    let head = |found: &FaceFit| {
        if found.deviation > LARGEST_DEVIATION {
            return None;
        }
        let frame = HeadFrame::new(origin, found.up, found.forward, unit)?;
        let radius = 0.5 * (a.radius + b.radius) / unit;
        let mut centers = [frame.to_local(a.center), frame.to_local(b.center)];
        centers.sort_by(|a, b| b.x.total_cmp(&a.x));
        let is_eye = eye_components(points, &frame, centers, radius);
        let (relief, skin) = skin_relief(points, &frame, &is_eye, within)?;
        let nose = check(&relief, 0.06).ok()?;
        let eyes = Eyes { centers, radius: Some(radius), components: is_eye, skin };
        Some((nose, Head { frame, eyes, relief }))
    };
    let upright = head(&first);
    // Profiles of flat faces and of hair are alike upside down; noses are not.
    let is_likely = upright.is_none() || other.deviation < first.deviation + ALIKE;
    let turned = if is_likely { head(&other) } else { None };
    match (upright, turned) {
        (Some((nose, _)), Some((turned_nose, turned))) if turned_nose > CLEARER * nose => {
            Some((other.deviation, turned))
        }
        (Some((_, upright)), _) => Some((first.deviation, upright)),
        (None, turned) => turned.map(|(_, turned)| (other.deviation, turned)),
    }
}

/// The head of a mesh without eyeballs: the best match of a face's profile in any symmetry
/// plane that passes the checks of the depth map.
fn by_symmetry(points: &Points, within: Within) -> Result<Candidate, AnatomyError> {
    let planes = planes(points, |component| within.has(component));
    let mirrored = planes.first().map_or(0.0, |plane| plane.mirrored);
    if mirrored < MIN_MIRRORED {
        return Err(AnatomyError::NoSymmetry { found: mirrored, needed: MIN_MIRRORED });
    }
    let mut fits: Vec<FaceFit> = planes
        .iter()
        .filter(|plane| plane.mirrored >= MIN_MIRRORED)
        .flat_map(|plane| {
            Section::new(
                points,
                |component| within.has(component),
                plane.point,
                plane.normal,
                f64::INFINITY,
            )
            .anywhere()
        })
        .filter(|found| found.deviation < LARGEST_DEVIATION_WITHOUT_EYES)
        .collect();
    fits.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
    let mut reason = NO_PROFILE;
    for found in fits {
        match without_eyes(points, &found, within) {
            Ok(head) => return Ok((found.deviation, head)),
            Err(why) => reason = why,
        }
    }
    Err(AnatomyError::NoFace { reason })
}

/// Refines a matched profile to a head. Bulges at the eyes, if there are any, correct
/// origin and unit, which the profile alone determines only roughly.
fn without_eyes(points: &Points, found: &FaceFit, within: Within) -> Result<Head, &'static str> {
    let nothing = vec![false; points.component_count];
    let mut frame = HeadFrame::new(found.origin, found.up, found.forward, found.unit)
        .ok_or("the outline is a single point")?;
    let mut radius = None;
    let (relief, _) = skin_relief(points, &frame, &nothing, within)
        .ok_or("there is no surface where the face should be")?;
    let bulge = bulge(&relief).filter(|(center, _)| (center.x - 0.5).abs() < 0.06);
    if let Some((center, size)) = bulge {
        // The symmetry plane is more reliable than the centres of two small spheres.
        let origin = frame.world([0.0, center.y, center.z]);
        radius = Some(size / (2.0 * center.x));
        frame = HeadFrame { origin, unit: frame.unit * 2.0 * center.x, ..frame };
    }
    let (relief, skin) = skin_relief(points, &frame, &nothing, within)
        .ok_or("there is no surface where the face should be")?;
    check(&relief, 0.25)?;
    let centers = [0.5, -0.5].map(|x| DVec3::new(x, 0.0, 0.0));
    let eyes = Eyes { centers, radius, components: nothing, skin };
    Ok(Head { frame, eyes, relief })
}

/// Centre and radius of the left eye's bulge, averaged with the mirrored right one:
/// eyeballs joined to the skin, or closed lids. Fits spheres to discs of the depth map
/// around a grid of positions, and takes the pair with the least error.
fn bulge(relief: &Relief) -> Option<(DVec3, f64)> {
    let sphere = |x: f64, y: f64| {
        let places = relief.within([x, y], 0.065);
        let mut fit = SphereFit::new(DVec3::new(x, y, 0.0));
        places.iter().for_each(|&point| fit.add(point));
        let sphere = fit.sphere().filter(|_| places.len() > 20)?;
        let errors = places.iter().map(|&p| (p.distance(sphere.center) - sphere.radius).abs());
        let error = errors.sum::<f64>() / places.len() as f64;
        let is_behind = places.iter().all(|point| point.z > sphere.center.z);
        // An eye faces forward, the slopes of brow and lid do not.
        let is_near = (sphere.center.x - x).hypot(sphere.center.y - y) < 0.06;
        let is_eye = error < 0.006 && is_behind && is_near && (0.12..0.26).contains(&sphere.radius);
        is_eye.then_some((error, sphere))
    };
    let places = (0..56).map(|k| [0.41 + 0.03 * f64::from(k % 7), 0.03 * f64::from(k / 7 - 5)]);
    let found = places.filter_map(|[x, y]| {
        let ((error, left), (other, right)) = (sphere(x, y)?, sphere(-x, y)?);
        let mirrored = right.center.with_x(-right.center.x);
        let unlike = left.center.distance(mirrored) + (left.radius - right.radius).abs();
        let center = left.center.lerp_monotonic(mirrored, 0.5);
        (unlike < 0.08).then_some((error + other, (center, 0.5 * (left.radius + right.radius))))
    });
    found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, bulge)| bulge)
}

/// Whether each component lies entirely within one of the eyes, such as the parts of an eyeball.
fn eye_components(
    points: &Points,
    frame: &HeadFrame,
    centers: [DVec3; 2],
    radius: f64,
) -> Vec<bool> {
    let mut is_eye = vec![true; points.component_count];
    for (&position, &component) in points.positions.iter().zip(&points.component) {
        if is_eye[component as usize] {
            let local = frame.to_local(position);
            let distance = centers.iter().map(|&c| local.distance(c)).fold(9.0, f64::min);
            is_eye[component as usize] = distance < 1.25 * radius;
        }
    }
    is_eye
}

/// The depth map of the face's skin, and the skin's component.
fn skin_relief(
    points: &Points,
    frame: &HeadFrame,
    is_eye: &[bool],
    within: Within,
) -> Option<(Relief, u32)> {
    let at: Vec<DVec3> = points.positions.iter().map(|&p| frame.to_local(p)).collect();
    let is_wanted = |component: u32| !is_eye[component as usize] && within.has(component);
    let all = Relief::new(points, &at, is_wanted);
    let skin = all.skin(points.component_count)?;
    if all.is_all(skin) {
        return Some((all, skin));
    }
    Some((Relief::new(points, &at, |component| component == skin), skin))
}

/// Checks that a depth map is that of a face, and returns how far its nose protrudes.
///
/// - `nose`: least protrusion of the nose from the cheeks, in distances between the eyes.
fn check(relief: &Relief, nose: f64) -> Result<f64, &'static str> {
    if relief.coverage() < 0.7 {
        return Err("the face has large holes");
    }
    if relief.asymmetry() > 0.14 {
        return Err("the two sides of the face differ");
    }
    let column = relief.column(0.0, [-1.0, -0.2]);
    let tip = column.into_iter().reduce(|a, b| if b[1] > a[1] { b } else { a });
    let tip = tip.ok_or("no nose")?;
    let [height, depth] = tip;
    let beside = relief.both(0.5, height).ok_or("no cheeks")?;
    if depth - beside < nose {
        return Err("no nose protrudes between the cheeks");
    }
    let [inner, outer] = [relief.both(0.3, -0.4), relief.both(1.0, -0.4)];
    if outer.unwrap_or(-2.0) > inner.unwrap_or(0.0) {
        return Err("the cheeks do not recede to the sides");
    }
    Ok(depth - beside)
}
