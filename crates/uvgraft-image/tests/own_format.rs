//! A format of another program in one file: QOI, as qoiformat.org describes it, by a codec like those of the crate.

#![expect(clippy::unwrap_used, reason = "a test stops at what should not fail")]

use std::io::Cursor;
use std::ops::Range;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use uvgraft_image::codec::{
    Codec, Conversion, Decode, Encode, RowDecoder, RowEncoder, Sink, Source, StoredHeader,
    check_size,
};
use uvgraft_image::{
    BandDecoder, BandEncoder, DeclaredSpace, EncodeError, Format, Image, ImageError, Loss,
    TextureSpec, WriteOptions, decode, encode,
};

static QOI: Codec = Codec {
    name: "QOI",
    extensions: &["qoi"],
    media_type: "image/qoi",
    is_start: |bytes| bytes.starts_with(b"qoif"),
    depths: &[(Depth::U8, Encoding::Srgb)],
    has_alpha: true,
    is_premultiplied: false,
    is_lossy: false,
    compresses: false,
    max_side: Texture::MAX_SIDE,
    header,
    decode: Decode::Rows(|source, _| Ok(Box::new(Decoder::new(source)?))),
    encode: Encode::Rows(|spec, icc, _| Ok(Box::new(Encoder::new(spec, icc)))),
    segments: None,
    without_metadata: None,
};

const FORMAT: Format = Format::new(&QOI);
const FORMATS: &[Format] = &[Format::PNG, FORMAT];

const INDEX: u8 = 0x00;
const DIFFERENCE: u8 = 0x40;
const LUMA: u8 = 0x80;
const RUN: u8 = 0xc0;
const RGB: u8 = 0xfe;
const RGBA: u8 = 0xff;
const END: [u8; 8] = [0, 0, 0, 0, 0, 0, 0, 1];

/// What texels are told by: the one before, and those met at each of 64 places.
struct Met {
    before: [u8; 4],
    places: [[u8; 4]; 64],
}

impl Met {
    const START: Self = Self { before: [0, 0, 0, 255], places: [[0; 4]; 64] };

    fn place([r, g, b, a]: [u8; 4]) -> usize {
        let sum =
            usize::from(r) * 3 + usize::from(g) * 5 + usize::from(b) * 7 + usize::from(a) * 11;
        sum % 64
    }

    fn meet(&mut self, texel: [u8; 4]) {
        self.before = texel;
        self.places[Self::place(texel)] = texel;
    }
}

fn header(source: &mut dyn Source) -> Result<StoredHeader, ImageError> {
    let [_, _, _, _, w0, w1, w2, w3, h0, h1, h2, h3, channels, _] = bytes(source)?;
    let sides = [[w0, w1, w2, w3], [h0, h1, h2, h3]].map(|side| u32::from_be_bytes(side).into());
    let channels = match channels {
        3 => Channels::Rgb,
        4 => Channels::Rgba,
        found => return Err(ImageError::damaged(FORMAT, format_args!("{found} channels"))),
    };
    let size = check_size(FORMAT, sides.into(), channels, Depth::U8)?;
    Ok(StoredHeader::new(size, channels, Depth::U8))
}

fn bytes<const N: usize>(source: &mut dyn Source) -> Result<[u8; N], ImageError> {
    let mut bytes = [0; N];
    source.read_exact(&mut bytes).map_err(|error| ImageError::from_io(FORMAT, &error))?;
    Ok(bytes)
}

struct Decoder<'a> {
    source: Box<dyn Source + 'a>,
    header: StoredHeader,
    met: Met,
    run: u8,
    rows_left: u32,
}

impl<'a> Decoder<'a> {
    fn new(mut source: Box<dyn Source + 'a>) -> Result<Self, ImageError> {
        let header = header(&mut source)?;
        Ok(Self { source, header, met: Met::START, run: 0, rows_left: header.size.height })
    }

    fn next(&mut self) -> Result<[u8; 4], ImageError> {
        if self.run > 0 {
            self.run -= 1;
            return Ok(self.met.before);
        }
        let [r, g, b, a] = self.met.before;
        let [tag] = bytes(&mut self.source)?;
        let low = tag & 0x3f;
        let texel = match tag {
            RGB => {
                let [r, g, b] = bytes(&mut self.source)?;
                [r, g, b, a]
            }
            RGBA => bytes(&mut self.source)?,
            _ if tag & RUN == RUN => {
                self.run = low;
                self.met.before
            }
            _ if tag & RUN == LUMA => {
                let [both] = bytes(&mut self.source)?;
                let green = low.wrapping_sub(32);
                let other = |before: u8, bits: u8| {
                    before.wrapping_add(green).wrapping_add(bits).wrapping_sub(8)
                };
                [other(r, both >> 4), g.wrapping_add(green), other(b, both & 15), a]
            }
            _ if tag & RUN == DIFFERENCE => {
                let near =
                    |before: u8, shift: u8| before.wrapping_add(low >> shift & 3).wrapping_sub(2);
                [near(r, 4), near(g, 2), near(b, 0), a]
            }
            _ => self.met.places[usize::from(low)],
        };
        self.met.meet(texel);
        Ok(texel)
    }

    /// Decodes rows into values; none of those may be left out.
    fn rows(&mut self, rows: u32, mut put: impl FnMut(&[u8])) -> Result<(), ImageError> {
        let channels = self.header.channels.count();
        for _ in 0..rows as usize * self.header.size.width as usize {
            let texel = self.next()?;
            put(&texel[..channels]);
        }
        self.rows_left -= rows;
        if self.rows_left == 0 && (self.run > 0 || bytes(&mut self.source)? != END) {
            return Err(ImageError::damaged(FORMAT, "more texels than its size"));
        }
        Ok(())
    }
}

impl RowDecoder for Decoder<'_> {
    fn header(&self) -> StoredHeader {
        self.header
    }

    fn icc(&self) -> Option<Vec<u8>> {
        None
    }

    fn skip(&mut self, rows: u32) -> Result<(), ImageError> {
        self.rows(rows, |_| {})
    }

    fn read(&mut self, texels: &mut Texels, places: Range<u32>) -> Result<(), ImageError> {
        let Texels::U8(texels) = texels else { unreachable!("8 bits, as the header says") };
        let mut rest = &mut texels[places.start as usize * self.header.row_values()..];
        self.rows(places.len() as u32, |texel| {
            let (to, after) = std::mem::take(&mut rest).split_at_mut(texel.len());
            to.copy_from_slice(texel);
            rest = after;
        })
    }

    fn read_all(mut self: Box<Self>) -> Result<Texels, ImageError> {
        let mut texels = Vec::new();
        self.rows(self.rows_left, |texel| texels.extend(texel))?;
        Ok(Texels::U8(texels))
    }
}

struct Encoder {
    spec: TextureSpec,
    conversion: Conversion<u8>,
    loses_icc: bool,
    met: Met,
    run: u8,
    /// What is not written yet.
    pending: Vec<u8>,
}

impl Encoder {
    fn new(spec: &TextureSpec, icc: Option<&[u8]>) -> Self {
        let mut pending = b"qoif".to_vec();
        pending.extend([spec.size.width, spec.size.height].map(u32::to_be_bytes).concat());
        pending.extend([if spec.channels.has_alpha() { 4 } else { 3 }, 0]);
        let conversion = Conversion::new(spec, FORMAT, &mut None);
        Self { spec: *spec, conversion, loses_icc: icc.is_some(), met: Met::START, run: 0, pending }
    }

    fn end_run(&mut self) {
        if self.run > 0 {
            self.pending.push(RUN | (self.run - 1));
            self.run = 0;
        }
    }

    fn push(&mut self, texel: [u8; 4]) {
        if texel == self.met.before {
            self.run += 1;
            if self.run == 62 {
                self.end_run();
            }
            return;
        }
        self.end_run();
        let ([r, g, b, a], before) = (texel, self.met.before);
        let [dr, dg, db] = [0, 1, 2].map(|k| texel[k].wrapping_sub(before[k]));
        let near = [dr, dg, db].map(|d| d.wrapping_add(2));
        let [luma_r, luma_b] = [dr, db].map(|d| d.wrapping_sub(dg).wrapping_add(8));
        let place = Met::place(texel);
        if self.met.places[place] == texel {
            self.pending.push(INDEX | place as u8);
        } else if a != before[3] {
            self.pending.extend([RGBA, r, g, b, a]);
        } else if near.iter().all(|&d| d < 4) {
            self.pending.push(DIFFERENCE | near[0] << 4 | near[1] << 2 | near[2]);
        } else if dg.wrapping_add(32) < 64 && luma_r < 16 && luma_b < 16 {
            self.pending.extend([LUMA | dg.wrapping_add(32), luma_r << 4 | luma_b]);
        } else {
            self.pending.extend([RGB, r, g, b]);
        }
        self.met.meet(texel);
    }
}

impl RowEncoder for Encoder {
    fn write(&mut self, texels: &Texels, out: &mut dyn Sink) -> Result<(), EncodeError> {
        let values = self.conversion.apply(texels, 0..texels.len()).into_owned();
        for texel in values.chunks_exact(self.spec.channels.count()) {
            self.push(match *texel {
                [y] => [y, y, y, 255],
                [y, a] => [y, y, y, a],
                [r, g, b] => [r, g, b, 255],
                [r, g, b, a] => [r, g, b, a],
                _ => unreachable!("one to four channels"),
            });
        }
        out.write_all(&self.pending)?;
        self.pending.clear();
        Ok(())
    }

    fn finish(mut self: Box<Self>, out: &mut dyn Sink) -> Result<Vec<Loss>, EncodeError> {
        self.end_run();
        self.pending.extend(END);
        out.write_all(&self.pending)?;
        let icc = self.loses_icc.then_some(Loss::IccProfile { format: FORMAT });
        Ok(icc.into_iter().chain(self.conversion.losses()).collect())
    }
}

/// Flat areas, gradients and noise.
fn texture(channels: Channels) -> Texture {
    let mut random = fastrand::Rng::with_seed(5);
    let size = Size::new(41, 29);
    let mut values = Vec::new();
    for texel in 0..size.texels() {
        values.extend((0..channels.count()).map(|channel| match texel / 400 {
            0 => 77 * (texel / 150 + channel) as u8,
            1 => (texel * (channel + 1)) as u8,
            _ => random.u8(..),
        }));
    }
    Texture::new(size, channels, Encoding::Srgb, Texels::U8(values)).unwrap()
}

fn encoded(image: &Image) -> (Vec<u8>, Vec<Loss>) {
    let mut out = Cursor::new(Vec::new());
    let written = encode(image, FORMAT, &WriteOptions::default(), &mut out).unwrap();
    (out.into_inner(), written.losses)
}

fn decoded(bytes: &[u8]) -> Result<Texture, ImageError> {
    let mut bands = BandDecoder::among(FORMATS, bytes, DeclaredSpace::Honoured)?;
    Ok(bands.next_band(u32::MAX)?.expect("it has rows"))
}

#[test]
fn images_come_back_whole_and_in_bands() {
    for channels in [Channels::Rgb, Channels::Rgba] {
        let texture = texture(channels);
        let (bytes, losses) = encoded(&texture.clone().into());
        assert_eq!(losses, []);
        assert!(bytes.len() < texture.texels().len() * 5 / 4);
        assert_eq!(decoded(&bytes).unwrap(), texture);

        let (options, spec) = (WriteOptions::default(), TextureSpec::from(&texture));
        let mut encoder =
            BandEncoder::new(Cursor::new(Vec::new()), FORMAT, spec, None, &options).unwrap();
        let mut bands = BandDecoder::among(FORMATS, &bytes, DeclaredSpace::Honoured).unwrap();
        assert_eq!((bands.header().format, bands.spec()), (FORMAT, spec));
        while let Some(band) = bands.next_band(7).unwrap() {
            encoder.push(&band).unwrap();
        }
        assert_eq!(encoder.finish().unwrap().1.into_inner(), bytes);
    }
    let grey = decoded(&encoded(&texture(Channels::GreyAlpha).into()).0).unwrap();
    assert_eq!(grey.channels(), Channels::Rgba);
}

#[test]
fn a_texel_of_each_kind_by_hand() {
    let file = [
        b"qoif\0\0\0\x09\0\0\0\x01\x03\0",
        // 10, 20, 30 | -1, 0, +1 | luma +5 with -8 and +7 | both of a run | the first again, by its place | 3 more.
        &[0xfe, 10, 20, 30, 0x5b, 0xa5, 0x0f, 0xc1, ((30 + 100 + 210 + 255 * 11) % 64) as u8, 0xc2]
            [..],
        &END,
    ]
    .concat();
    let [first, second, third] = [[10, 20, 30], [9, 20, 31], [6, 25, 43]];
    let wanted = [first, second, third, third, third, first, first, first, first].concat();
    assert_eq!(decoded(&file).unwrap().texels(), &Texels::U8(wanted));
}

#[test]
fn other_formats_of_the_list_are_read_too_and_none_beside_it() {
    let image = Image::from(texture(Channels::Rgb));
    let mut png = Cursor::new(Vec::new());
    let _ = encode(&image, Format::PNG, &WriteOptions::default(), &mut png).unwrap();
    assert_eq!(decoded(png.get_ref()).unwrap(), image.texture);
    assert_eq!(Format::from_extension("qoi"), None);
    let refused = decode(&encoded(&image).0).unwrap_err().to_string();
    assert!(refused.starts_with("not a supported image (PNG, JPEG, WebP, "), "{refused}");
    let refused = decoded(b"GIF89a").unwrap_err().to_string();
    assert_eq!(refused, "not a supported image (PNG, QOI): starts with \"GIF89a\"");
}

#[test]
fn what_is_lost_and_refused_has_the_name_of_the_format() {
    let image = Image { texture: texture(Channels::Rgb), icc: Some(vec![7; 9]) };
    let (bytes, losses) = encoded(&image);
    assert_eq!(losses, [Loss::IccProfile { format: FORMAT }]);
    assert_eq!(losses[0].to_string(), "ICC profile dropped: QOI cannot store one");
    let mut vast = bytes;
    vast[4..8].copy_from_slice(&100_000u32.to_be_bytes());
    let refused = decoded(&vast).unwrap_err().to_string();
    assert_eq!(refused, "QOI must have at most 32768 texels a side, got 100000×29");
}

#[test]
fn files_cut_short_are_refused_and_damaged_ones_cost_no_panic() {
    let (bytes, _) = encoded(&texture(Channels::Rgba).into());
    for cut in 0..bytes.len() {
        assert!(decoded(&bytes[..cut]).is_err(), "{cut} bytes");
    }
    assert!(
        matches!(decoded(&bytes[..99]), Err(ImageError::Truncated { format }) if format == FORMAT)
    );
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 0x5a;
        let gave_up = matches!(decoded(&changed), Err(ImageError::GaveUp { .. }));
        assert!(!gave_up, "byte {at}");
    }
}
