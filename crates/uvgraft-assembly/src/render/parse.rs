//! Options of pictures as users write them.

use uvgraft_gltf::scene::NamedPose;
use uvgraft_render::Background;

use super::{Aim, PoseOption};

impl PoseOption {
    /// Parses the name of a pose, or the rotation of a bone in degrees, such as `head=1,-2,0.5`.
    ///
    /// # Errors
    /// With what it must be, to follow the option's name.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some((bone, angles)) = text.split_once('=') {
            let wanted = || format!("must be BONE=X,Y,Z in degrees, got {text:?}");
            let angles: Vec<f32> = angles
                .split(',')
                .map(parse_number)
                .collect::<Result<_, _>>()
                .map_err(|_| wanted())?;
            let angles = <[f32; 3]>::try_from(angles).map_err(|_| wanted())?;
            return Ok(Self::Bone(bone.trim().to_owned(), angles));
        }
        NamedPose::named(text).map(Self::Named).ok_or_else(|| {
            let names = NamedPose::ALL.map(NamedPose::name).join(", ");
            format!("must be one of {names}, or BONE=X,Y,Z in degrees")
        })
    }
}

impl Aim {
    /// Parses the name of a bone or a node, or a box given by two corners.
    ///
    /// # Errors
    /// With what it must be, to follow the option's name.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f32>, String> = text.split(',').map(parse_number).collect();
        let Ok(numbers) = numbers else {
            let looks_like_a_box = text.matches(',').count() == 5;
            return if looks_like_a_box || text.trim().is_empty() {
                Err(format!(
                    "must be the name of a bone, or X0,Y0,Z0,X1,Y1,Z1 in metres, got {text:?}"
                ))
            } else {
                Ok(Self::Named(text.trim().to_owned()))
            };
        };
        let Ok(corners) = <[f32; 6]>::try_from(numbers) else {
            return Err(format!("must be six numbers, X0,Y0,Z0,X1,Y1,Z1 in metres, got {text:?}"));
        };
        Ok(Self::between(corners))
    }
}

/// Parses an expression with its weight, such as `blink=0.8`, or without one for a weight of 1.
///
/// # Errors
/// With what the weight must be, to follow the option's name.
pub fn parse_expression(text: &str) -> Result<(String, f32), String> {
    match text.rsplit_once('=') {
        Some((name, weight)) => Ok((name.trim().to_owned(), parse_number(weight)?)),
        None => Ok((text.to_owned(), 1.0)),
    }
}

/// Parses `studio`, `transparent`, or a colour such as `#ff8000`.
///
/// # Errors
/// With what it must be, to follow the option's name.
pub fn parse_background(text: &str) -> Result<Background, String> {
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

/// Parses a finite number.
///
/// # Errors
/// With what it must be, to follow the option's name.
pub fn parse_number(text: &str) -> Result<f32, String> {
    let value = text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("must be a number, got {text:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_taken_apart() {
        let pose = PoseOption::parse;
        assert_eq!(pose("T-Pose"), Ok(PoseOption::Named(NamedPose::TPose)));
        assert_eq!(pose("head=1,-2,.5"), Ok(PoseOption::Bone("head".into(), [1.0, -2.0, 0.5])));
        assert_eq!(parse_expression("a=b=0.5"), Ok(("a=b".into(), 0.5)));
        assert_eq!(parse_expression("blink"), Ok(("blink".into(), 1.0)));
        assert_eq!(parse_background("#ff8000"), Ok(Background::Plain([255, 128, 0])));
        for bad in ["dance", "head=1,2", "head=1,2,nan", "head=1,2,3,4", "="] {
            assert!(pose(bad).is_err(), "{bad}");
        }
        for bad in ["#12345", "#1234567", "#+12345", "red", "#ééé"] {
            assert!(parse_background(bad).is_err(), "{bad}");
        }
        assert!(parse_expression("blink=inf").is_err());
        assert_eq!(Aim::parse(" leftHand "), Ok(Aim::Named("leftHand".into())));
        assert_eq!(Aim::parse("1,2,3,0,4,2"), Ok(Aim::between([1.0, 2.0, 3.0, 0.0, 4.0, 2.0])));
        for bad in ["", "1,2,3", "1,2,x,0,4,2", "1,2,3,0,4,nan"] {
            assert!(Aim::parse(bad).is_err(), "{bad}");
        }
    }
}
