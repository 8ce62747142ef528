//! A large texture assembled from photographs at their own resolution, so that it has detail down
//! to single texels.

use uvgraft::{Channels, Depth, Encoding, Size, Texels, Texture};

use crate::downloads::photograph;

/// The photographs that patches are cut from.
pub const NAMES: [&str; 8] =
    ["astronaut", "coffee", "chelsea", "motorcycle_left", "ihc", "gravel", "grass", "brick"];

/// Side of a patch, in texels.
const PATCH: u32 = 300;

/// Patches of all photographs side by side, always the same for a size; 8-bit RGB. `None`, with a
/// message, if the photographs have not been fetched.
///
/// # Panics
/// If a photograph is smaller than a patch.
pub fn mosaic(size: Size) -> Option<Texture> {
    let photographs: Option<Vec<Texture>> = NAMES
        .into_iter()
        .map(|name| Some(photograph(name)?.converted(Channels::Rgb, Depth::U8)))
        .collect();
    let photographs = photographs?;
    let mut rng = fastrand::Rng::with_seed(1);
    let mut values = vec![0; size.texels() * 3];
    let mut next = 0;
    for top in (0..size.height).step_by(PATCH as usize) {
        for left in (0..size.width).step_by(PATCH as usize) {
            let photograph = &photographs[next % photographs.len()];
            next += 1;
            let Texels::U8(from) = photograph.texels() else { unreachable!("converted") };
            let of = photograph.size();
            let x = rng.u32(0..=of.width - PATCH) as usize;
            let y = rng.u32(0..=of.height - PATCH) as usize;
            let width = PATCH.min(size.width - left) as usize;
            for row in 0..PATCH.min(size.height - top) as usize {
                let source = ((y + row) * of.width as usize + x) * 3;
                let target = ((top as usize + row) * size.width as usize + left as usize) * 3;
                values[target..target + width * 3].copy_from_slice(&from[source..][..width * 3]);
            }
        }
        // Stagger the photographs from row to row.
        next += 3;
    }
    let texture = Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(values));
    Some(texture.expect("as many values as texels ask for"))
}
