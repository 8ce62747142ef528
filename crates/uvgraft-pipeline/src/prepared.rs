//! A transfer that is prepared once, for callers who bring textures one by one.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use uvgraft::{Size, threads};
use uvgraft_files::input::Input;
use uvgraft_files::output::folder_of;
use uvgraft_image::Format;

use crate::base::Base;
use crate::base_source::BaseSource;
use crate::blending::KnownTexels;
use crate::failure::{Blame, Context, Failure, Result};
use crate::fingerprint::Fingerprint;
use crate::isolated::Isolated;
use crate::layout_checks::LayoutChecks;
use crate::link::Link;
use crate::material::Values;
use crate::observer::Observer;
use crate::outputs::{check_replaceable, resolve};
use crate::plan::format_of;
use crate::shared::{Grafts, Options, Shared};
use crate::source::Source;
use crate::target::Target;
use crate::texture_transfer::{Call, Done, Outcome};
use crate::tiles::has_placeholder;
use crate::transfer::{Inputs, Transfer};
use crate::unchanged::Unchanged;

/// A transfer whose pair or map, base and blend are in memory: [`Transfer::prepare`].
///
/// It owns all that it needs. Any number of threads may use it at once, those of a rayon pool
/// included, and results do not depend on how many do: they are the files that [`Transfer::run`]
/// writes. Threads are shared out among the calls in flight, as many as
/// [`threads::count`] in the thread of a call. A call that panics returns a failure of
/// the work, and the others go on.
pub struct PreparedTransfer {
    shared: Shared,
    fingerprint: Fingerprint,
    fingerprint_text: String,
    /// Files that no output may replace.
    inputs: HashSet<PathBuf>,
    calls: Isolated,
}

/// The result of a texture.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TransferredTexture {
    /// How much texture and base still differ along the boundary once their skin matches, ΔE 2000;
    /// `None` without matching, and where no skin meets skin. See
    /// [`ToneReport::boundary_delta_e`](uvgraft::blend::ToneReport::boundary_delta_e).
    pub boundary_delta_e: Option<f64>,
    /// Length of the encoded result in bytes.
    pub bytes: u64,
    /// Size of the result in texels.
    pub size: Size,
    /// Warnings, which name the texture.
    pub warnings: Vec<String>,
    /// Notes on automatic decisions, such as excluding a collar, which name the texture.
    pub notes: Vec<String>,
}

impl Transfer {
    /// Reads and prepares everything that textures share, for callers who bring them one by one.
    ///
    /// The options are those of [`Inputs::Textures`]. Not used are its sources, of which there may
    /// be none, and [`Transfer::output`], [`Transfer::format`], [`Transfer::existing`],
    /// [`Transfer::shard`], [`Transfer::jobs`] and [`Transfer::memory`].
    ///
    /// - `observer`: receives a note if a mesh unit was assumed, and warnings about what is shared.
    ///
    /// # Errors
    /// As bad input for files that cannot be read or are not regular files, for conflicting
    /// options, and for options that belong to a whole run: the maps of a material, UDIM tiles,
    /// [`Transfer::mask`], [`Transfer::draw_labels`] and [`Transfer::extra_outputs`].
    pub fn prepare(&self, observer: &dyn Observer) -> Result<PreparedTransfer> {
        let (onto, values) = self.shared_base()?;
        self.check_options()?;
        // Before anything is read: a file that changes meanwhile makes its results outdated.
        let fingerprint = self.common_fingerprint().and_then(|it| it.of_batch(values, onto));
        let link = Link::read(&self.correspondence)?;
        let size = link.size(self.size)?;
        let known = KnownTexels::read(self.source_mask.as_ref(), self.fill.as_ref())?;
        known.check(observer)?;
        let mask_sizes = self.mask_sizes();
        mask_sizes.check_base(self.base_options(onto, values, size).header())?;
        let (blend, base) = threads::join(
            || self.blend(&link, &known, None, observer),
            || Base::new(&self.base_options(onto, values, size), true),
        );
        let (blend, base) = (blend?, base?);
        base.non_finite().into_iter().for_each(|warning| observer.warn(warning));
        let files = self.prepared_inputs().into_iter().filter_map(Input::path);
        let fingerprint = fingerprint.map_err(|error| {
            let culprit = files.clone().find(|path| !path.is_file());
            let culprit = culprit.unwrap_or(self.correspondence.input().name()).display();
            Failure::input(format!("{culprit}: {error}"))
        })?;
        Ok(PreparedTransfer {
            shared: Shared {
                options: Options::new(self, values),
                unchanged: base.is_in_memory().then(|| Unchanged::of_base(&base)),
                link: Arc::new(link),
                base,
                blend,
                known: Arc::new(known),
                mask_sizes: Arc::new(mask_sizes),
                grafts: Grafts::default(),
                layout_checks: LayoutChecks::default(),
            },
            fingerprint_text: fingerprint.text(),
            fingerprint,
            inputs: files.map(resolve).collect(),
            calls: Isolated::default(),
        })
    }

    /// What is read once for all textures: the pair or the map, parts of the region, images, and a base
    /// image that they share.
    pub fn prepared_inputs(&self) -> Vec<&Input> {
        let onto = match &self.inputs {
            Inputs::Textures { onto, .. } | Inputs::Listed { onto, .. } => onto.as_ref(),
            Inputs::Material(_) => None,
        };
        let mut inputs = self.common_inputs();
        inputs.extend(onto.and_then(BaseSource::as_image));
        inputs
    }

    /// The base and the values of textures that come one by one.
    fn shared_base(&self) -> Result<(Option<&BaseSource>, Values)> {
        let Inputs::Textures { onto, values, .. } = &self.inputs else {
            return Err(Failure::input(
                "a prepared transfer takes single textures, not a list or the maps of a material",
            ));
        };
        let tiled = onto.as_ref().and_then(BaseSource::path).is_some_and(has_placeholder);
        let ruled_out = [
            (tiled, "a base with an image for each tile"),
            (self.mask.is_some(), "`mask`"),
            (self.draw_labels.is_some(), "`labels`"),
            (!self.extra_outputs.is_empty(), "other outputs"),
        ];
        match ruled_out.into_iter().find(|(is_asked, _)| *is_asked) {
            Some((_, what)) => {
                Err(Failure::option(format!("a prepared transfer cannot be used with {what}")))
            }
            None => Ok((onto.as_ref(), *values)),
        }
    }
}

impl PreparedTransfer {
    /// Transfers a file to a file, which appears when it is whole; the folder must exist.
    ///
    /// - `output`: the image format follows from its extension.
    ///
    /// # Errors
    /// As bad input for a source that is not an image or does not suit the options, and an output
    /// that cannot be written or is also an input; the output is then unchanged.
    pub fn transfer_file(&self, source: &Path, output: &Path) -> Result<TransferredTexture> {
        format_of(output)?;
        self.check_output(source, output)?;
        self.transfer(Source::File(source), Target::File(output))
            .map(|(_, transferred)| transferred)
    }

    /// Transfers an encoded image, and returns an encoded image: the bytes of the file that
    /// [`PreparedTransfer::transfer_file`] writes.
    ///
    /// - `bytes`: an image in any format; see [`uvgraft_image::decode`].
    /// - `name`: stands for the file in messages, as in `row 17: truncated PNG`.
    /// - `format`: that of the result.
    ///
    /// # Errors
    /// As bad input for bytes that are not an image, an image that does not suit the options, and a
    /// result that the format cannot store.
    pub fn transfer_bytes(
        &self,
        bytes: &[u8],
        name: &str,
        format: Format,
    ) -> Result<(Vec<u8>, TransferredTexture)> {
        let name = Path::new(name);
        self.transfer(Source::Bytes { name, bytes }, Target::Bytes { name, format })
    }

    /// Size of the results in texels.
    pub fn size(&self) -> Size {
        self.shared.base.size()
    }

    /// The fingerprint of all options and of the content of all files that textures share, 64
    /// hexadecimal digits. It changes with the version of the program.
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint_text
    }

    /// The fingerprint of everything that the result of an encoded image is made from, 64
    /// hexadecimal digits: what a [`Manifest`](crate::Manifest) records, equal to that of a file
    /// with the same content.
    pub fn fingerprint_of_bytes(&self, bytes: &[u8]) -> String {
        self.fingerprint.with_bytes(bytes)
    }

    /// As [`PreparedTransfer::fingerprint_of_bytes`], for a file.
    ///
    /// # Errors
    /// As bad input if it cannot be read or is not a regular file.
    pub fn fingerprint_of_file(&self, source: &Path) -> Result<String> {
        let fingerprint = self.fingerprint.with_file(source);
        fingerprint.or_input().context(source.display())
    }

    fn check_output(&self, source: &Path, output: &Path) -> Result<()> {
        check_replaceable(output)?;
        let folder = folder_of(output);
        if !folder.is_dir() {
            return Err(Failure::input(format!(
                "cannot write {}: folder {} does not exist",
                output.display(),
                folder.display()
            )));
        }
        let resolved = resolve(output);
        if self.inputs.contains(&resolved) || resolve(source) == resolved {
            let output = output.display();
            return Err(Failure::input(format!(
                "output {output} is also an input; choose another name"
            )));
        }
        Ok(())
    }

    fn transfer(
        &self,
        source: Source<'_>,
        target: Target<'_>,
    ) -> Result<(Vec<u8>, TransferredTexture)> {
        let call = Call { source, target, alone: false, analysis: None, observer: &() };
        let outcome = self.calls.run(|| self.shared.transfer(&call));
        let Outcome { result, log } = outcome.context(source.name().display())?;
        let Done { boundary_delta_e, bytes, image, .. } = result?;
        let (size, warnings, notes) = (self.size(), log.warnings, log.notes);
        Ok((image, TransferredTexture { boundary_delta_e, bytes, size, warnings, notes }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_can_share_it() {
        fn check<T: Send + Sync + 'static>() {}
        check::<PreparedTransfer>();
    }
}
