//! Pictures, distortions and masks for the metrics' reference values, from integer arithmetic
//! alone.
//!
//! `fixtures/pictures.py` repeats the arithmetic, so no picture needs to be stored.

use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_metrics::Mask;

use crate::downloads;

/// A picture by its name in the fixtures; `None`, with a message, for a photograph that has not
/// been fetched.
///
/// # Panics
/// If the name is unknown.
pub fn picture(name: &str) -> Option<Texture> {
    Some(match name {
        "gradients" => paint(Size::new(96, 80), |x, y, channel| {
            let (across, down) = (x * 255 / 95, y * 255 / 79);
            [across, down, (across + down) / 2][channel as usize]
        }),
        "shapes" => paint(Size::new(131, 117), |x, y, channel| {
            let within = |dx: i64, dy: i64, radius: i64| dx * dx + dy * dy < radius * radius;
            let value = if within(x - 30, y - 80, 20) {
                230 - 90 * channel
            } else if within(2 * x - 131, 2 * y - 117, 60) {
                90 + 60 * channel
            } else if (x * x / 256 + y / 8) % 2 == 0 {
                200 - 30 * channel
            } else {
                40 + 20 * channel
            };
            value + hashed(x, y, channel, 1) % 24
        }),
        "cells" => paint(Size::new(96, 80), |x, y, channel| {
            hashed(x / 6, y / 6, channel, 2) % 200 + hashed(x, y, channel, 3) % 56
        }),
        "astronaut" | "chelsea" | "coffee" => return downloads::photograph(name),
        _ => panic!("no picture is called {name}"),
    })
}

/// A picture with a distortion applied, by its name in the fixtures.
///
/// # Panics
/// If the name is unknown, or the picture is not 8-bit RGB.
pub fn distorted(picture: &Texture, name: &str) -> Texture {
    let size = picture.size();
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let Texels::U8(values) = picture.texels() else { panic!("8-bit pictures only") };
    assert_eq!(picture.channels(), Channels::Rgb);
    let at =
        |x: i64, y: i64, channel: i64| i64::from(values[((y * width + x) * 3 + channel) as usize]);
    let near = |x: i64, y: i64, channel| at(x.clamp(0, width - 1), y.clamp(0, height - 1), channel);
    paint(size, |x, y, channel| match name {
        "levels" => at(x, y, channel) / 16 * 17,
        "shift" => at((x - 3).rem_euclid(width), (y - 2).rem_euclid(height), channel),
        "blur" => {
            let window = (0..9).map(|k| near(x + k % 3 - 1, y + k / 3 - 1, channel));
            (window.sum::<i64>() + 4) / 9
        }
        "noise" => at(x, y, channel) + hashed(x, y, channel, 4) % 33 - 16,
        _ => panic!("no distortion is called {name}"),
    })
}

/// A mask by its name in the fixtures.
///
/// # Panics
/// If the name is unknown.
pub fn mask(size: Size, name: &str) -> Mask {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let radius = width.min(height) * 7 / 10;
    let texture = paint(size, |x, y, _| {
        let (dx, dy) = (2 * x + 1 - width, 2 * y + 1 - height);
        let selected = match name {
            "disc" => dx * dx + dy * dy <= radius * radius,
            "stripes" => (x + 2 * y) / 16 % 2 == 0,
            _ => panic!("no mask is called {name}"),
        };
        if selected { 255 } else { 0 }
    });
    Mask::from_texture(&texture).expect("masks that select something")
}

/// An 8-bit picture given by a function of column, row and channel, clamped.
fn paint(size: Size, value: impl Fn(i64, i64, i64) -> i64) -> Texture {
    let (width, count) = (i64::from(size.width), size.texels() as i64 * 3);
    let values = (0..count)
        .map(|index| (index / 3 % width, index / 3 / width, index % 3))
        .map(|(x, y, channel)| value(x, y, channel).clamp(0, 255) as u8)
        .collect();
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values)).expect("as many values")
}

/// A 32-bit hash of position, channel and seed, without a visible pattern.
pub(crate) fn hashed(x: i64, y: i64, channel: i64, seed: u32) -> i64 {
    let mut value = (x as u32)
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add((y as u32).wrapping_mul(0x85eb_ca77))
        .wrapping_add((channel as u32).wrapping_mul(0xc2b2_ae3d))
        .wrapping_add(seed.wrapping_mul(0x27d4_eb2f));
    value = (value ^ value >> 15).wrapping_mul(0x2c1b_3c6d);
    value = (value ^ value >> 12).wrapping_mul(0x297a_2d39);
    i64::from(value ^ value >> 15)
}
