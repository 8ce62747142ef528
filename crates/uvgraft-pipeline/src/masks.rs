//! Masks that are not what they are taken for: of another shape than the textures that they are laid over, or
//! of a single value.

use uvgraft::{Direction, Size, Texture};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, Format, Header};

use crate::failure::{Failure, Result};
use crate::transfer::Transfer;

/// What a mask shows everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Uniform {
    Black,
    White,
}

impl Uniform {
    /// The value that all texels of a mask have; `None` for any other mask. NaN is black.
    pub(crate) fn of(mask: &Texture) -> Option<Self> {
        let Size { width, height } = mask.size();
        let colors = 0..if mask.channels().has_color() { 3 } else { 1 };
        let is =
            |x: u32, y: u32, is: fn(f32) -> bool| colors.clone().all(|k| is(mask.get(x, y, k)));
        let everywhere =
            |wanted: fn(f32) -> bool| (0..height).all(|y| (0..width).all(|x| is(x, y, wanted)));
        if everywhere(|value| value.is_nan() || value <= 0.0) {
            Some(Self::Black)
        } else if everywhere(|value| value >= 1.0) {
            Some(Self::White)
        } else {
            None
        }
    }
}

/// The names and sizes of the images among the options that are read as masks or labels, by the
/// layout that they are in.
#[derive(Debug, Default)]
pub(crate) struct MaskSizes {
    /// Over the textures that are transferred.
    textures: Vec<(String, Size)>,
    /// Over the base.
    base: Vec<(String, Size)>,
}

impl MaskSizes {
    /// Checks the aspect ratios of what is laid over a texture.
    ///
    /// # Errors
    /// As bad input, with the first that differs.
    pub(crate) fn check_texture(&self, size: Size) -> Result<()> {
        check(&self.textures, "the texture", size)
    }

    /// Checks the aspect ratios of what is laid over the base.
    ///
    /// - `image`: the base as it is stored, whatever the size of the result; a colour has no shape.
    ///
    /// # Errors
    /// As bad input, with the first that differs.
    pub(crate) fn check_base(&self, image: Option<Header>) -> Result<()> {
        image.map_or(Ok(()), |image| check(&self.base, "the base", image.size))
    }
}

fn check(images: &[(String, Size)], what: &str, wanted: Size) -> Result<()> {
    match images.iter().find(|(_, found)| !found.has_aspect_ratio_of(wanted)) {
        None => Ok(()),
        Some((name, found)) => Err(Failure::input(format!(
            "{name}: must have the aspect ratio of {what}, which is {wanted}, got {found}"
        ))),
    }
}

impl Transfer {
    /// The images among the options that are laid over textures. Those that cannot be read are left to
    /// whoever reads them, and so are pipes, which can be read only once.
    pub(crate) fn mask_sizes(&self) -> MaskSizes {
        let sized = |input: &Input| {
            let is_lasting = input.path().is_none_or(std::path::Path::is_file);
            let header = is_lasting.then(|| image::read_header(input).ok()).flatten()?;
            Some((input.to_string(), header.size))
        };
        let mut mask_sizes = MaskSizes::default();
        let blending = self.blending.as_ref();
        mask_sizes.textures.extend(blending.and_then(|it| it.labels.as_ref()).and_then(sized));
        mask_sizes.base.extend(blending.and_then(|it| it.skin.as_ref()).and_then(sized));
        for part in self.region.include.iter().chain(&self.region.exclude) {
            if Format::from_path(part.input.name()).is_some() {
                let is_source = part.side == uvgraft::Side::Source;
                let is_read = is_source == (self.direction == Direction::Forward);
                let side = if is_read { &mut mask_sizes.textures } else { &mut mask_sizes.base };
                side.extend(sized(&part.input));
            }
        }
        mask_sizes
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Texels};

    use super::*;

    #[test]
    fn only_masks_of_one_extreme_are_uniform() {
        let of = |values: &[u8], channels| {
            let size = Size::new((values.len() / channels) as u32, 1);
            let channels = if channels == 1 { Channels::Grey } else { Channels::Rgba };
            let texels = Texels::U8(values.to_vec());
            Uniform::of(&Texture::new(size, channels, Encoding::Srgb, texels).unwrap())
        };
        assert_eq!(of(&[0, 0, 0], 1), Some(Uniform::Black));
        assert_eq!(of(&[255, 255], 1), Some(Uniform::White));
        assert_eq!(of(&[0, 1], 1), None);
        assert_eq!(of(&[255, 254], 1), None);
        assert_eq!(of(&[128, 128], 1), None);
        // Alpha does not count.
        assert_eq!(of(&[255, 255, 255, 0], 4), Some(Uniform::White));
        let nan = Texture::new(
            Size::square(1),
            Channels::Grey,
            Encoding::Linear,
            Texels::F32(vec![f32::NAN]),
        );
        assert_eq!(Uniform::of(&nan.unwrap()), Some(Uniform::Black));
    }

    #[test]
    fn aspect_ratios_may_differ_by_rounding() {
        let masks = [("a.png".to_owned(), Size::new(100, 51))];
        check(&masks, "the base", Size::new(1000, 505)).unwrap();
        let said = check(&masks, "the base", Size::square(100)).unwrap_err().to_string();
        assert!(said.starts_with("a.png: must have the aspect ratio of the base"), "{said}");
    }
}
