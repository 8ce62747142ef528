//! Parsers of option values.

use uvgraft_assembly::render::{Aim, PoseOption};
use uvgraft_gltf::scene::NamedPose;
use uvgraft_render::Background;

/// An expression and its weight.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weight(pub String, pub f32);

pub(super) fn pose(text: &str) -> Result<PoseOption, String> {
    if let Some((bone, angles)) = text.split_once('=') {
        let wanted = || format!("must be BONE=X,Y,Z in degrees, got {text:?}");
        let angles: Vec<f32> =
            angles.split(',').map(finite).collect::<Result<_, _>>().map_err(|_| wanted())?;
        let angles = <[f32; 3]>::try_from(angles).map_err(|_| wanted())?;
        return Ok(PoseOption::Bone(bone.trim().to_owned(), angles));
    }
    NamedPose::named(text).map(PoseOption::Named).ok_or_else(|| {
        let names = NamedPose::ALL.map(NamedPose::name).join(", ");
        format!("must be one of {names}, or BONE=X,Y,Z in degrees")
    })
}

/// The name of a bone, or a box given by two corners.
pub(crate) fn aim(text: &str) -> Result<Aim, String> {
    let numbers: Result<Vec<f32>, String> = text.split(',').map(finite).collect();
    let Ok(numbers) = numbers else {
        let looks_like_a_box = text.matches(',').count() == 5;
        return if looks_like_a_box || text.trim().is_empty() {
            Err(format!("must be the name of a bone, or X0,Y0,Z0,X1,Y1,Z1 in metres, got {text:?}"))
        } else {
            Ok(Aim::Named(text.trim().to_owned()))
        };
    };
    let Ok([x0, y0, z0, x1, y1, z1]) = <[f32; 6]>::try_from(numbers) else {
        return Err(format!("must be six numbers, X0,Y0,Z0,X1,Y1,Z1 in metres, got {text:?}"));
    };
    Ok(Aim::between([x0, y0, z0, x1, y1, z1]))
}

pub(super) fn weight(text: &str) -> Result<Weight, String> {
    match text.rsplit_once('=') {
        Some((name, weight)) => Ok(Weight(name.trim().to_owned(), finite(weight)?)),
        None => Ok(Weight(text.to_owned(), 1.0)),
    }
}

pub(super) fn finite(text: &str) -> Result<f32, String> {
    let value = text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("must be a number, got {text:?}"))
}

pub(super) fn rate(text: &str) -> Result<f32, String> {
    within(text, 0.1, 240.0).map_err(|_| "must be 0.1 to 240 frames per second".to_owned())
}

fn within(text: &str, least: f32, most: f32) -> Result<f32, String> {
    let value = finite(text)?;
    let sound = (least..=most).contains(&value);
    if sound { Ok(value) } else { Err(format!("must be {least} to {most}")) }
}

pub(super) fn elevation(text: &str) -> Result<f32, String> {
    within(text, -89.0, 89.0)
}

pub(super) fn field_of_view(text: &str) -> Result<f32, String> {
    within(text, 1.0, 120.0)
}

pub(super) fn zoom(text: &str) -> Result<f32, String> {
    within(text, 0.1, 50.0)
}

pub(super) fn seconds(text: &str) -> Result<f32, String> {
    within(text, 0.0, f32::MAX).map_err(|_| "must be at least 0 seconds".to_owned())
}

pub(super) fn turntable(text: &str) -> Result<u16, String> {
    let count = text.parse().ok().filter(|count| (2..=3600).contains(count));
    count.ok_or_else(|| "must be 2 to 3600 frames; put the avatar before this option".to_owned())
}

pub(super) fn background(text: &str) -> Result<Background, String> {
    let wanted = || "must be studio, transparent, or a colour such as #ff8000".to_owned();
    match text {
        "studio" => return Ok(Background::Studio),
        "transparent" => return Ok(Background::Transparent),
        _ => {}
    }
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6).ok_or_else(wanted)?;
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(wanted());
    }
    let color = u32::from_str_radix(digits, 16).map_err(|_| wanted())?;
    let [_, r, g, b] = color.to_be_bytes();
    Ok(Background::Plain([r, g, b]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_taken_apart() {
        assert_eq!(pose("T-Pose"), Ok(PoseOption::Named(NamedPose::TPose)));
        assert_eq!(pose("head=1,-2,.5"), Ok(PoseOption::Bone("head".into(), [1.0, -2.0, 0.5])));
        assert_eq!(weight("a=b=0.5"), Ok(Weight("a=b".into(), 0.5)));
        assert_eq!(weight("blink"), Ok(Weight("blink".into(), 1.0)));
        assert_eq!(background("#ff8000"), Ok(Background::Plain([255, 128, 0])));
        for bad in ["dance", "head=1,2", "head=1,2,nan", "head=1,2,3,4", "="] {
            assert!(pose(bad).is_err(), "{bad}");
        }
        for bad in ["#12345", "#1234567", "#+12345", "red", "#ééé"] {
            assert!(background(bad).is_err(), "{bad}");
        }
        assert!(weight("blink=inf").is_err() && rate("0").is_err());
        assert_eq!((elevation("-89"), zoom("0.1")), (Ok(-89.0), Ok(0.1)));
        assert!(elevation("90").is_err() && field_of_view("0").is_err() && zoom("0").is_err());
        assert!(seconds("-1").is_err() && seconds("1e9").is_ok());
    }
}
