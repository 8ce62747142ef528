//! Transfers further maps of a face onto a body, and into the head's own layout if it keeps that.

use std::sync::Arc;

use uvgraft::{
    Averaging, Blend, Content, Direction, Filter, Graft, NormalOptions, NormalY, Pair, Prefer,
    Size, Sizes, Texture, ToneCorrection,
};
use uvgraft_pipeline::{Blame, Observer, Result, toned};

use super::layout::HeadLayout;

/// The prepared transfer of a face's colours, reused for its other maps.
pub(super) struct MapTransfer<'a> {
    pub(super) pair: Arc<Pair>,
    pub(super) blend: Arc<Blend>,
    pub(super) toning: Option<ToneCorrection>,
    pub(super) head: Option<HeadLayout>,
    /// The interpolation filter, if set.
    pub(super) filter: Option<Filter>,
    pub(super) gutter_px: u32,
    pub(super) prefer: Prefer,
    /// The longest side allowed for textures.
    pub(super) preset: Option<u32>,
    pub(super) observer: &'a dyn Observer,
}

/// A map in the layouts of an avatar.
pub(super) struct TransferredMap {
    pub(super) body: Texture,
    pub(super) head: Option<Texture>,
}

impl MapTransfer<'_> {
    /// Transfers a map other than the albedo onto a base of the same role. Areas excluded from the
    /// colours are excluded from it too.
    ///
    /// - `face`: the map of the head, if there is one; otherwise the base is unchanged.
    pub(super) fn transfer(
        &self,
        face: Option<Texture>,
        base: Texture,
        content: Content,
    ) -> Result<TransferredMap> {
        let Some(face) = face else {
            let size = self.limited(base.size());
            let head = self.head.as_ref().map(|_| self.beneath(&base, None, size, content));
            return Ok(TransferredMap { head: head.transpose()?, body: base });
        };
        let sizes = Sizes { from: face.size(), to: base.size() };
        let graft = self.graft(&self.pair, sizes, content, Direction::Forward);
        let graft = graft.shared_blend(Arc::clone(&self.blend)).build().or_work()?;
        let overlay = graft.overlay(&face, base.format()).or_work()?.opaque();
        let overlay = toned(overlay, self.toning.as_ref(), false).or_work()?;
        let base = if content == Content::Color { base } else { as_data(base) };
        let body = overlay.lay(0, base).or_work()?;
        let head = self.head.as_ref();
        let head = head.map(|head| self.in_own_layout(head, face, &body, (content, false)));
        Ok(TransferredMap { head: head.transpose()?, body })
    }

    /// The colours of a face in the head's own layout, if it keeps that.
    ///
    /// - `body`: with the face.
    pub(super) fn head_color(&self, face: Texture, body: &Texture) -> Result<Option<Texture>> {
        let head = self.head.as_ref();
        head.map(|head| self.in_own_layout(head, face, body, (Content::Color, true))).transpose()
    }

    /// Composites a face over the body's colours, in the head's layout. Where the face is opaque,
    /// its texels are kept but for the tone. At the border it is transparent, so that both textures
    /// agree there.
    ///
    /// - `content`: the meaning of the values, and whether the tone is applied.
    fn in_own_layout(
        &self,
        head: &HeadLayout,
        face: Texture,
        body: &Texture,
        (content, is_toned): (Content, bool),
    ) -> Result<Texture> {
        let size = self.limited(face.size());
        if size != face.size() {
            self.observer.note(format_args!(
                "`preset` limits the head texture: resampling it from {} to {size}",
                face.size()
            ));
        }
        let filter = self.filter.unwrap_or_default();
        let face = face.resized(size, filter, Averaging::Encoded).or_input()?;
        let beneath = self.beneath(body, Some(&face), size, content)?;
        let sizes = Sizes { from: size, to: size };
        let graft = self.graft(head.pair(), sizes, content, Direction::Forward);
        let graft = graft.shared_blend(Arc::clone(head.blend())).build().or_work()?;
        let overlay = graft.overlay(face, beneath.format()).or_work()?.opaque();
        let overlay = toned(overlay, head.toning(), is_toned).or_work()?;
        overlay.lay(0, beneath).or_work()
    }

    /// The body's texture in the head's layout.
    ///
    /// - `around`: fills what the body does not cover.
    fn beneath(
        &self,
        body: &Texture,
        around: Option<&Texture>,
        size: Size,
        content: Content,
    ) -> Result<Texture> {
        let around = match around {
            Some(around) => around.clone(),
            None => body.clone().resized(size, Filter::Bilinear, Averaging::Encoded).or_work()?,
        };
        let channels = around.channels().without_alpha();
        let depth = around.depth();
        let around = around.converted(channels, depth);
        let sizes = Sizes { from: body.size(), to: size };
        // Maps in the body's layout already follow glTF.
        let content = match content {
            Content::Normals(_) => {
                Content::Normals(NormalOptions::new(NormalY::OpenGl, NormalY::OpenGl))
            }
            other => other,
        };
        let graft = self.graft(&self.pair, sizes, content, Direction::Reverse).build().or_work()?;
        graft.apply(body, around).or_work()
    }

    fn graft(
        &self,
        pair: &Arc<Pair>,
        sizes: Sizes,
        content: Content,
        direction: Direction,
    ) -> uvgraft::GraftBuilder {
        let graft = Graft::builder(Arc::clone(pair), sizes)
            .direction(direction)
            .content(content)
            .gutter_px(self.gutter_px)
            .prefer(self.prefer);
        match self.filter {
            Some(filter) => graft.filter(filter),
            None => graft,
        }
    }

    /// A size within the preset's limit.
    pub(super) fn limited(&self, size: Size) -> Size {
        let Some(side) = self.preset else { return size };
        let longest = size.width.max(size.height);
        if longest <= side {
            return size;
        }
        let scaled =
            |own: u32| ((u64::from(own) * u64::from(side) / u64::from(longest)) as u32).max(1);
        Size::new(scaled(size.width), scaled(size.height))
    }
}

fn as_data(texture: Texture) -> Texture {
    texture.with_encoding(uvgraft::Encoding::Data)
}
