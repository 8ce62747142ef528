//! What the outputs of a transfer are made from: files and options.

use std::io;
use std::path::Path;

use uvgraft_files::input::Input;

use crate::base_source::BaseSource;
use crate::blending::Blending;
use crate::fingerprint::{Fingerprint, input_digest};
use crate::material::Values;
use crate::plan::TransferPlan;
use crate::region::RegionPart;
use crate::transfer::{Inputs, Transfer};

impl Fingerprint {
    /// The fingerprint of what textures with one base are made from, apart from their own source.
    pub(crate) fn of_batch(
        mut self,
        values: Values,
        onto: Option<&BaseSource>,
    ) -> io::Result<Self> {
        self.add(&format!("{values:?}"));
        match onto {
            Some(BaseSource::Image(image)) => self.add_input(image)?,
            Some(BaseSource::Color(unit)) => self.add(&format!("{unit:?}")),
            None => {}
        }
        Ok(self)
    }
}

/// The parts of a region, with the content of their files; in an order of their own, since theirs does
/// not matter.
fn region_text(parts: &[RegionPart]) -> io::Result<String> {
    let text = |part: &RegionPart| {
        let mut names = part.names.clone();
        names.sort();
        names.dedup();
        Ok(format!("{:?} {names:?} {}", part.side, input_digest(&part.input)?))
    };
    let mut parts = parts.iter().map(text).collect::<io::Result<Vec<_>>>()?;
    parts.sort();
    parts.dedup();
    Ok(format!("{parts:?}"))
}

impl Transfer {
    /// What textures depend on, apart from their own source and the list of them.
    pub(crate) fn shared_inputs<'a>(&'a self, plan: &'a TransferPlan) -> Vec<&'a Input> {
        let bases = plan.batches.iter().filter_map(|batch| batch.onto.as_ref()?.as_image());
        self.common_inputs().into_iter().chain(bases).collect()
    }

    /// The list of the textures, if they are in a file.
    pub(crate) fn list_path(&self) -> Option<&Path> {
        match &self.inputs {
            Inputs::Listed { list, .. } => list.path(),
            Inputs::Textures { .. } | Inputs::Material(_) => None,
        }
    }

    /// What all batches depend on.
    pub(crate) fn common_inputs(&self) -> Vec<&Input> {
        std::iter::once(self.correspondence.input())
            .chain(self.region.inputs())
            .chain(self.common_images())
            .collect()
    }

    /// The images among them.
    fn common_images(&self) -> impl Iterator<Item = &Input> {
        let blending = self.blending.as_ref();
        let skin = blending.and_then(|blending| blending.skin.as_ref());
        let labels = blending.and_then(|blending| blending.labels.as_ref());
        // What the labels of the albedo exclude is excluded from all maps.
        let albedo = self.labelled_map();
        let images = [skin, labels, albedo, self.source_mask.as_ref(), self.fill.as_ref()];
        images.into_iter().flatten()
    }

    /// The fingerprint of what all batches are made from.
    pub(crate) fn common_fingerprint(&self) -> io::Result<Fingerprint> {
        let mut common = Fingerprint::new();
        common.add(&self.options_text());
        common.add_input(self.correspondence.input())?;
        for parts in [&self.region.include, &self.region.exclude] {
            common.add(&region_text(parts)?);
        }
        self.common_images().try_for_each(|image| common.add_input(image))?;
        Ok(common)
    }

    /// All options that affect a result, as text; the content of files is added to the fingerprint
    /// separately.
    fn options_text(&self) -> String {
        let Self { direction, size, filter, map, overlap, averaging, normals, fit, .. } = self;
        let Self { region, blending, source_mask, fill, write, .. } = self;
        // A hard edge without a tone change is the same as no blending.
        let blending = blending.as_ref().filter(|blending| blending.needs_labels());
        let blending = blending.map(|Blending { feather, options, skin, labels }| {
            (*feather, *options, skin.is_some(), labels.is_some())
        });
        let region = (region.grow, region.unit);
        // With a blend, material maps end at the boundary of the mask.
        let ends_at_mask = self.blending.is_some() && matches!(self.inputs, Inputs::Material(_));
        let masks = (source_mask.is_some(), fill.is_some(), ends_at_mask);
        format!(
            "{direction:?} {size:?} {filter:?} {map:?} {overlap:?} {averaging:?} {normals:?} {fit:?} \
             {region:?} {blending:?} {masks:?} {write:?}"
        )
    }
}
