//! Images of a file that is passed on, without what they tell beside their picture.

use std::borrow::Cow;
use std::collections::BTreeSet;

use serde::Deserialize;
use uvgraft_image::without_metadata;

use crate::container::Glb;
use crate::scene::document::{Buffer, BufferView, Image};
use crate::scene::error::SceneError;

/// Where a file has its images.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Places {
    buffers: Vec<Buffer>,
    buffer_views: Vec<BufferView>,
    images: Vec<Image>,
}

/// The same GLB, with images that end earlier in their places, so that nothing else moves.
///
/// Images that are none of PNG, JPEG and WebP, or damaged, stay as they are.
pub(super) fn removed(mut bytes: Cow<'_, [u8]>) -> Result<Cow<'_, [u8]>, SceneError> {
    let glb = Glb::read(&bytes)?;
    let places: Places = serde_json::from_slice(glb.json)?;
    let Some(binary) =
        glb.binary.filter(|_| places.buffers.first().is_some_and(|it| it.uri.is_none()))
    else {
        return Ok(bytes);
    };
    // The chunk is a part of the file.
    let (start, length) = (binary.as_ptr().addr() - bytes.as_ptr().addr(), binary.len() as u64);
    let views = places.images.iter().filter_map(|image| {
        let view = places.buffer_views.get(image.buffer_view? as usize)?;
        let end = view.byte_offset.checked_add(view.byte_length)?;
        (view.buffer == 0 && end <= length).then_some((view.byte_offset as usize, end as usize))
    });
    // Each once, however many images have it.
    let views: BTreeSet<(usize, usize)> = views.collect();
    for (from, to) in views {
        let place = start + from..start + to;
        let Some(bare) = without_metadata(&bytes[place.clone()]) else { continue };
        // An orientation is stated in fewer bytes than it was.
        if bare.len() <= place.len() && bytes[place.clone()] != bare {
            let (image, rest) = bytes.to_mut()[place].split_at_mut(bare.len());
            image.copy_from_slice(&bare);
            rest.fill(0);
        }
    }
    Ok(bytes)
}
