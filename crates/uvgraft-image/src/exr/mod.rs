//! OpenEXR, through the `exr` crate.

mod colors;
mod encode;
mod subsampled;
mod upsampling;

use std::io::Cursor;

use ::exr::error::Error;
use ::exr::image::FlatSamples;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::math::Vec2;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::f16;
use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};

use self::colors::Colors;
use self::encode::RowEncoder;
use super::codec::{Codec, Decode, Decoded, Encode, Source};
use super::convert::unpremultiply;
use super::header::{MAX_RATIO, MAX_UNBACKED_BYTES, StoredHeader, check_bytes, check_size};
use super::{DeclaredSpace, Format, ImageError};

impl Format {
    /// Float in linear light, alpha, lossless; no ICC profile.
    pub const EXR: Self = Self::new(&CODEC);
}

const FORMAT: Format = Format::EXR;

static CODEC: Codec = Codec {
    name: "EXR",
    extensions: &["exr"],
    media_type: "image/x-exr",
    is_start: |bytes| bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]),
    depths: &[(Depth::F32, Encoding::Linear)],
    has_alpha: true,
    is_premultiplied: true,
    is_lossy: false,
    compresses: true,
    max_side: Texture::MAX_SIDE,
    header,
    decode: Decode::Whole(decode),
    encode: Encode::Rows(|spec, icc, options| Ok(Box::new(RowEncoder::new(spec, icc, options)?))),
    segments: None,
    without_metadata: None,
};

/// The channel names of a texture in the file, in the order of the texture.
fn names(channels: Channels) -> &'static [&'static str] {
    match channels {
        Channels::Grey => &["Y"],
        Channels::GreyAlpha => &["Y", "A"],
        Channels::Rgb => &["R", "G", "B"],
        Channels::Rgba => &["R", "G", "B", "A"],
    }
}

/// The channels of luminance/chroma images, in the order of R, G and B.
const CHROMA: [&str; 3] = ["RY", "Y", "BY"];
const CHROMA_ALPHA: [&str; 4] = ["RY", "Y", "BY", "A"];

/// The mapping from the channels and the data window of a file to a texture.
struct ChannelLayout {
    header: StoredHeader,
    /// For each channel of the texture, its index in the file.
    sources: Vec<usize>,
    colors: Colors,
    /// The data window, which programs crop to the non-black part.
    stored: Size,
    /// Its corner, relative to that of the display window.
    offset: [i64; 2],
    /// Bytes of all channels of the data window, also of those that are not used.
    stored_bytes: u64,
}

fn header(reader: &mut dyn Source) -> Result<StoredHeader, ImageError> {
    let meta = MetaData::read_from_buffered(reader, false).map_err(from_exr)?;
    Ok(layout(&meta.headers)?.header)
}

/// Checks the first layer, which is the one read.
fn layout(headers: &[Header]) -> Result<ChannelLayout, ImageError> {
    let wanted = "supported are layers with the channels R, G, B or Y, with or without A";
    let unsupported = |found| ImageError::Unsupported { format: FORMAT, found, wanted };
    let header = headers.first().ok_or_else(|| ImageError::damaged(FORMAT, "no layers"))?;
    if header.deep {
        return Err(unsupported("deep data".to_owned()));
    }
    let list = &header.channels.list;
    let place = |name: &&str| list.iter().position(|channel| channel.name.eq(name));
    let (channels, sources, is_luminance_chroma) = [
        (Channels::Rgba, names(Channels::Rgba)),
        (Channels::Rgb, names(Channels::Rgb)),
        (Channels::Rgba, &CHROMA_ALPHA),
        (Channels::Rgb, &CHROMA),
        (Channels::GreyAlpha, names(Channels::GreyAlpha)),
        (Channels::Grey, names(Channels::Grey)),
    ]
    .into_iter()
    .find_map(|(channels, names)| {
        let sources: Option<Vec<_>> = names.iter().map(place).collect();
        Some((channels, sources?, names.starts_with(&CHROMA)))
    })
    // A single channel is greyscale, whatever its name: a height, a mask.
    .or_else(|| (list.len() == 1).then(|| (Channels::Grey, vec![0], false)))
    .ok_or_else(|| {
        let found = list.iter().take(8).map(|channel| channel.name.to_string());
        unsupported(format!("channels {}", found.collect::<Vec<_>>().join(", ")))
    })?;
    for channel in sources.iter().map(|&source| &list[source]) {
        if channel.sample_type == SampleType::U32 {
            return Err(unsupported(format!("integer channel {}", channel.name)));
        }
    }
    subsampled::check(headers)?;
    let (data, display) = (header.data_window(), header.shared_attributes.display_window);
    let sides = |size: Vec2<usize>| (size.0 as u64, size.1 as u64);
    let size = check_size(FORMAT, sides(display.size), channels, Depth::F32)?;
    let texel_bytes = list.iter().map(|channel| channel.sample_type.bytes_per_sample() as u64);
    let texel_bytes = texel_bytes.sum();
    let stored = check_bytes(FORMAT, sides(data.size), texel_bytes)?;
    let stored_bytes = stored.texels() as u64 * texel_bytes;
    let offset = [
        i64::from(data.position.0) - i64::from(display.position.0),
        i64::from(data.position.1) - i64::from(display.position.1),
    ];
    let primaries = colors::primaries(header.shared_attributes.chromaticities);
    let neutral = colors::neutral(&primaries, header.own_attributes.adopted_neutral);
    let block_rows = match header.blocks {
        BlockDescription::ScanLines => header.compression.scan_lines_per_block(),
        BlockDescription::Tiles(tiles) => tiles.tile_size.height(),
    };
    let block_bytes =
        stored_bytes / u64::from(stored.height) * (block_rows as u64).min(stored.height.into());
    // Channels are decoded separately, as floats, and then interleaved.
    let planes = 2 * size.texels().max(stored.texels()) as u64 * channels.count() as u64 * 4;
    let header = StoredHeader {
        // Those that are not used are decoded, too, from blocks that may have all rows.
        scratch_bytes: planes.max(stored_bytes + 2 * block_bytes),
        ..StoredHeader::new(size, channels, Depth::F32)
    };
    let colors = Colors { primaries, neutral, is_luminance_chroma };
    Ok(ChannelLayout { header, sources, colors, stored, offset, stored_bytes })
}

fn decode(bytes: &[u8], space: DeclaredSpace) -> Result<Decoded, ImageError> {
    let mut rest = bytes;
    let meta = MetaData::read_from_buffered(&mut rest, false).map_err(from_exr)?;
    let layout = layout(&meta.headers)?;
    check_stored(&layout, bytes.len() as u64)?;
    let mut values = if subsampled::any(&meta.headers) {
        let planes = subsampled::read(&meta, bytes, rest, &layout.sources)?;
        let mut values = vec![0.0; layout.header.values()];
        for (channel, samples) in planes.iter().enumerate() {
            place(samples, &layout, channel, &mut values, |value| value);
        }
        values
    } else {
        decode_full(bytes, &layout)?
    };
    let header = layout.header;
    layout.colors.apply(&mut values, header.channels, space == DeclaredSpace::Honoured);
    if header.channels.has_alpha() {
        unpremultiply(&mut values, header.channels);
    }
    Ok(Decoded { header, texels: Texels::F32(values), icc: None })
}

/// Checks the channels that are stored against the length of the file, as the texture is checked when a
/// file is opened: a channel costs 20 bytes of a header, whatever the size of the image is.
fn check_stored(layout: &ChannelLayout, file: u64) -> Result<(), ImageError> {
    let least = layout.stored_bytes / MAX_RATIO;
    if layout.stored_bytes > MAX_UNBACKED_BYTES && file < least {
        let size = layout.header.size;
        return Err(ImageError::Unbacked { format: FORMAT, size, found: file, least });
    }
    Ok(())
}

/// The values of a file without subsampled channels, as stored.
fn decode_full(bytes: &[u8], layout: &ChannelLayout) -> Result<Vec<f32>, ImageError> {
    let image = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(from_exr)?;
    let mut values = vec![0.0; layout.header.values()];
    for (channel, &source) in layout.sources.iter().enumerate() {
        match &image.layer_data.channel_data.list[source].sample_data {
            FlatSamples::F16(samples) => {
                place(samples, layout, channel, &mut values, f16::to_f32);
            }
            FlatSamples::F32(samples) => {
                place(samples, layout, channel, &mut values, |value| value);
            }
            FlatSamples::U32(_) => {
                return Err(ImageError::damaged(FORMAT, "the values do not match the header"));
            }
        }
    }
    Ok(values)
}

/// Writes a channel's samples into its values, where the data window overlaps the texture.
fn place<S: Copy>(
    samples: &[S],
    layout: &ChannelLayout,
    channel: usize,
    values: &mut [f32],
    to_float: impl Fn(S) -> f32,
) {
    let count = layout.header.channels.count();
    let [left, top] = layout.offset;
    let width = layout.header.size.width as usize;
    let skipped = usize::try_from(-left).unwrap_or(0);
    let indent = usize::try_from(left).unwrap_or(0).min(width);
    for (y, row) in samples.chunks_exact(layout.stored.width as usize).enumerate() {
        let Ok(y) = usize::try_from(y as i64 + top) else { continue };
        if y >= layout.header.size.height as usize {
            break;
        }
        let visible = &row[skipped.min(row.len())..];
        let texels = values[channel..].iter_mut().step_by(count).skip(y * width + indent);
        for (value, &sample) in texels.take(width - indent).zip(visible) {
            *value = to_float(sample);
        }
    }
}

fn from_exr(error: Error) -> ImageError {
    match error {
        // The crate's error for the end of a file.
        Error::Invalid(reason) if reason == "reference to missing bytes" => {
            ImageError::Truncated { format: FORMAT }
        }
        Error::NotSupported(reason) => ImageError::Unsupported {
            format: FORMAT,
            found: format!("{reason}"),
            wanted: "convert it to ZIP compression first",
        },
        Error::Io(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}
