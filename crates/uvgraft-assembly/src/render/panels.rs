//! Pictures side by side.

use uvgraft::{Size, Texels, Texture};
use uvgraft_pipeline::{Blame, Result};

/// The size of some pictures of one size side by side; of one if there are none.
pub(super) fn size(panel: Size, count: usize) -> Size {
    Size::new(panel.width * count.max(1) as u32, panel.height)
}

/// Pictures of one size with 8 bits and the same channels, from left to right.
pub(super) fn joined(mut panels: Vec<Texture>) -> Result<Texture> {
    let [first, _, ..] = &*panels else { return Ok(panels.remove(0)) };
    let whole = size(first.size(), panels.len());
    let (channels, encoding) = (first.channels(), first.encoding());
    let width = first.size().width as usize * channels.count();
    let mut values = Vec::with_capacity(whole.texels() * channels.count());
    for row in 0..whole.height as usize {
        for panel in &panels {
            let Texels::U8(own) = panel.texels() else { continue };
            values.extend_from_slice(&own[row * width..][..width]);
        }
    }
    Texture::new(whole, channels, encoding, Texels::U8(values)).or_work()
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding};

    use super::*;

    #[test]
    fn rows_of_all_pictures_follow_each_other() {
        let picture = |values: &[u8]| {
            let texels = Texels::U8(values.to_vec());
            Texture::new(Size::new(1, 2), Channels::Grey, Encoding::Srgb, texels).unwrap()
        };
        let both = joined(vec![picture(&[1, 2]), picture(&[3, 4])]).unwrap();
        assert_eq!(both.size(), Size::new(2, 2));
        assert_eq!(both.texels(), &Texels::U8(vec![1, 3, 2, 4]));
        assert_eq!(joined(vec![picture(&[5, 6])]).unwrap(), picture(&[5, 6]));
    }
}
