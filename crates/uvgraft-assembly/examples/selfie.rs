//! An avatar and a head texture of a photograph: `cargo run --example selfie -- me.jpg`

use uvgraft_assembly::selfie::Head;
use uvgraft_assembly::{AvatarRequest, Body, SelfieRequest};
use uvgraft_image::{self as image, WriteOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let photo = std::env::args().nth(1).ok_or("usage: selfie PHOTO")?;

    let mut request = AvatarRequest::new(Body::Figure, "me.glb");
    request.photos = vec![photo.clone().into()];
    std::fs::write("me.glb", request.make(&())?.file)?;

    let selfie = SelfieRequest::new(Head::Figure, [photo]).make(&())?;
    let _ = image::write(&selfie.texture().clone().into(), "me.png", &WriteOptions::default())?;
    Ok(())
}
