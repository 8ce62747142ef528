//! What an avatar is made of: the pair, the rigged body, and what photographs show.

use std::sync::Arc;

use uvgraft::{Pair, threads};
use uvgraft_avatar::eyes::SeparatedEyes;
use uvgraft_io::pair_file::PairFile;
use uvgraft_pipeline::{Observer, Result};

use super::body::RiggedBody;
use super::features;
use super::plan::Plan;
use super::request::AvatarRequest;
use crate::selfie::FittedSelfie;

pub(super) struct Ingredients {
    /// The pair; its target has a UV island for each eye where there is room for them.
    pub(super) file: PairFile,
    /// As it was given.
    pub(super) given: Arc<Pair>,
    /// How the target's layout was changed.
    pub(super) parted: Option<SeparatedEyes>,
    pub(super) body: RiggedBody,
    pub(super) selfie: Option<FittedSelfie>,
}

impl Ingredients {
    pub(super) fn gather(
        request: &AvatarRequest,
        plan: &Plan,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let mut file = request.read_pair()?;
        observer.check()?;
        let given = Arc::clone(&file.pair);
        let (body, selfie) = threads::join(
            || RiggedBody::new(request, given.target(), observer),
            || {
                let fit = |frames| request.fit(frames, &given, &file.source_name, observer);
                plan.frames.as_ref().map(fit).transpose()
            },
        );
        let (body, selfie) = (body?, selfie?);
        let parted = features::parted(&given, observer)?.map(|(pair, parted)| {
            file.pair = pair;
            parted
        });
        Ok(Self { file, given, parted, body, selfie })
    }
}
