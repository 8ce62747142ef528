//! Small pictures and masks for unit tests of the metrics.

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Size, Texels, Texture};

use super::{Colors, Mask};

/// Colours from 8-bit RGB values.
pub(super) fn colors((width, height): (u32, u32), values: &[u8]) -> Colors {
    let size = Size::new(width, height);
    let texels = Texels::U8(values.to_vec());
    Colors::new(Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap()).unwrap()
}

/// Random colours, deterministic for each seed.
pub(super) fn noise((width, height): (u32, u32), seed: u64) -> Colors {
    let mut random = fastrand::Rng::with_seed(seed);
    let values: Vec<u8> = (0..width * height * 3).map(|_| random.u8(..)).collect();
    colors((width, height), &values)
}

/// The texels for which `selected(x, y)` is true.
pub(super) fn mask((width, height): (u32, u32), selected: impl Fn(u32, u32) -> bool) -> Mask {
    let values: Vec<u8> = (0..width * height)
        .map(|index| if selected(index % width, index / width) { 255 } else { 0 })
        .collect();
    let size = Size::new(width, height);
    let texels = Texels::U8(values);
    Mask::from_texture(&Texture::new(size, Channels::Grey, Encoding::Data, texels).unwrap())
        .unwrap()
}
