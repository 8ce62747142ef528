//! Avatars in WebAssembly: a module that calls nothing outside, for a page or for Node.
//!
//! `cargo build -p uvgraft-assembly --example web --no-default-features --target wasm32-unknown-unknown`
//!
//! JavaScript copies a photograph and the file of face networks into memory that `allocate` returns,
//! calls `avatar`, and reads the answer: see `scripts/run-web.mjs`.

use std::io::Cursor;

use uvgraft::{Encoding, Size};
use uvgraft_assembly::selfie::{Head, Networks};
use uvgraft_assembly::{AvatarRequest, Body, Failure, Input, Result, SelfieRequest};
use uvgraft_figure::{Figure, paint_body, paint_head};
use uvgraft_image::{self as image, Format, WriteOptions};
use uvgraft_pipeline::{BaseSource, Blame};

/// Bytes, or a message if there are none.
#[repr(C)]
pub struct Answer {
    is_ok: u32,
    bytes: *const u8,
    len: usize,
}

/// Memory for a file. It is never freed: a page makes a few avatars.
#[expect(unsafe_code, reason = "the name is what JavaScript calls")]
#[unsafe(no_mangle)]
pub extern "C" fn allocate(len: usize) -> *mut u8 {
    vec![0_u8; len].leak().as_mut_ptr()
}

/// The figure's GLB, with its painted face.
///
/// - `side`: of the textures, in texels.
#[expect(unsafe_code, reason = "the name is what JavaScript calls")]
#[unsafe(no_mangle)]
pub extern "C" fn figure(side: u32) -> *const Answer {
    answer(of_figure(Size::square(side)))
}

/// The figure's GLB, with the face of a photograph.
///
/// - `photo`, `networks`: the bytes of files, in memory from [`allocate`].
///
/// # Safety
/// The pointers must be from [`allocate`], with lengths that are not greater than what was asked for.
#[expect(unsafe_code, reason = "JavaScript hands over bytes as addresses")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn avatar(
    photo: *const u8,
    photo_len: usize,
    networks: *const u8,
    networks_len: usize,
) -> *const Answer {
    // SAFETY: by the contract of this function.
    let [photo, networks] = [(photo, photo_len), (networks, networks_len)]
        .map(|(bytes, len)| unsafe { std::slice::from_raw_parts(bytes, len) });
    answer(of_photo(photo, networks))
}

/// The texture of the figure's head from a photograph, as PNG.
///
/// - `side`: of the texture, in texels.
/// - `photo`, `networks`: as for [`avatar`].
///
/// # Safety
/// As for [`avatar`].
#[expect(unsafe_code, reason = "JavaScript hands over bytes as addresses")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfie(
    side: u32,
    photo: *const u8,
    photo_len: usize,
    networks: *const u8,
    networks_len: usize,
) -> *const Answer {
    // SAFETY: by the contract of this function.
    let [photo, networks] = [(photo, photo_len), (networks, networks_len)]
        .map(|(bytes, len)| unsafe { std::slice::from_raw_parts(bytes, len) });
    answer(texture_of_photo(Size::square(side), photo, networks))
}

fn answer(result: Result<Vec<u8>>) -> *const Answer {
    let (is_ok, bytes) = match result {
        Ok(bytes) => (1, bytes),
        Err(failure) => (0, failure.to_string().into_bytes()),
    };
    let bytes = bytes.leak();
    Box::leak(Box::new(Answer { is_ok, bytes: bytes.as_ptr(), len: bytes.len() }))
}

fn of_figure(size: Size) -> Result<Vec<u8>> {
    let figure = Figure::new();
    let mut request = AvatarRequest::new(Body::Figure, "figure.glb");
    request.face = Some(png("face.png", paint_head(&figure, size))?);
    request.onto = Some(BaseSource::Image(png("body.png", paint_body(&figure, size))?));
    Ok(request.make(&())?.file)
}

fn of_photo(photo: &[u8], networks: &[u8]) -> Result<Vec<u8>> {
    let mut request = AvatarRequest::new(Body::Figure, "me.glb");
    request.photos = vec![Input::bytes("photo", photo)];
    request.photo_options.networks = Networks::File(Input::bytes("networks", networks));
    Ok(request.make(&())?.file)
}

fn texture_of_photo(size: Size, photo: &[u8], networks: &[u8]) -> Result<Vec<u8>> {
    let mut request = SelfieRequest::new(Head::Figure, [Input::bytes("photo", photo)]);
    request.size = size;
    request.photo_options.networks = Networks::File(Input::bytes("networks", networks));
    encoded(request.make(&())?.texture().clone())
}

fn png(name: &str, texture: uvgraft::Texture) -> Result<Input> {
    Ok(Input::bytes(name, encoded(texture)?))
}

fn encoded(texture: uvgraft::Texture) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    let texture = texture.encoded_as(Encoding::Srgb);
    image::encode(&texture.into(), Format::PNG, &WriteOptions::default(), &mut out)
        .map(drop)
        .or_work()
        .map_err(|failure: Failure| failure.context("cannot encode a texture"))?;
    Ok(out.into_inner())
}
