//! Warns of pictures that were not made for the layouts of a pair: swapped arguments, a body's texture
//! through the pair of its head.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use uvgraft::layout_match::{LayoutPoints, LayoutProbe};
use uvgraft::{Direction, Pair, Texture, threads};

use crate::shared::Shared;

/// The pair that pictures are checked against, and a direction.
#[derive(Debug, Clone, Copy)]
pub struct CheckedPair<'a> {
    /// The pair.
    pub pair: &'a Pair,
    /// Names of its source and its target.
    pub names: [&'a str; 2],
    /// The direction of the transfer.
    pub direction: Direction,
}

impl CheckedPair<'_> {
    /// What goes from the layout that is read to the one that is filled, or the other way round.
    fn ordered<T>([source, target]: [T; 2], direction: Direction) -> [T; 2] {
        match direction {
            Direction::Forward => [source, target],
            Direction::Reverse => [target, source],
        }
    }
}

/// What checks of several pictures share: the places to look at, which are found once.
#[derive(Debug, Default)]
pub struct LayoutChecks {
    /// Of the source and of the target.
    points: OnceLock<[LayoutPoints; 2]>,
    /// The base is the same for all textures.
    is_base_checked: AtomicBool,
}

impl LayoutChecks {
    /// A warning of a texture that contradicts the layout that is read, or shows no colours there.
    ///
    /// - `rows`: those that are sure to be decoded.
    /// - `name`: of the texture.
    pub fn source(
        &self,
        checked: CheckedPair<'_>,
        texture: &Texture,
        rows: u32,
        name: &str,
    ) -> Option<String> {
        let [from, to] = self.points(checked);
        let mut probe = LayoutProbe::new([from, to], texture.size()).above(rows);
        probe.look(0, texture);
        if let Some(oddity) = probe.oddity() {
            return Some(oddity.text(name));
        }
        let misfit = probe.misfit()?;
        let [from, to] = CheckedPair::ordered(checked.names, checked.direction);
        let hint = "; are the arguments swapped, or is `reverse` missing or too much?";
        Some(misfit.text(name, from, to) + if misfit.fits_other { hint } else { "" })
    }

    /// A warning of a base that contradicts the layout that is filled, once a probe has seen it.
    pub fn base(checked: CheckedPair<'_>, probe: &LayoutProbe<'_>, name: &str) -> Option<String> {
        let misfit = probe.misfit()?;
        let [from, to] = CheckedPair::ordered(checked.names, checked.direction);
        let hint = "; are texture and base swapped, or is `reverse` missing or too much?";
        Some(misfit.text(name, to, from) + if misfit.fits_other { hint } else { "" })
    }

    /// The points of the layout that is read and of the one that is filled.
    pub fn points(&self, checked: CheckedPair<'_>) -> [&LayoutPoints; 2] {
        let CheckedPair { pair, direction, .. } = checked;
        let [source, target] = self.points.get_or_init(|| {
            let points = LayoutPoints::new;
            threads::join(|| points(pair.source()), || points(pair.target())).into()
        });
        CheckedPair::ordered([source, target], direction)
    }
}

impl Shared {
    /// A warning of a texture that does not fit the layout that is read.
    pub(crate) fn misfit_of_source(
        &self,
        texture: &Texture,
        rows: u32,
        name: &str,
    ) -> Option<String> {
        self.layout_checks.source(self.checked_pair()?, texture, rows, name)
    }

    /// A probe of the base, if it is an image that was not looked at yet.
    pub(crate) fn base_probe(&self) -> Option<LayoutProbe<'_>> {
        let checked = self.checked_pair().filter(|_| self.base.is_image())?;
        if self.layout_checks.is_base_checked.swap(true, Ordering::Relaxed) {
            return None;
        }
        let [from, to] = self.layout_checks.points(checked);
        let mut probe = LayoutProbe::new([to, from], self.base.size());
        if let Some(texture) = self.base.image() {
            probe.look(0, texture);
        }
        Some(probe)
    }

    /// A warning of a base that does not fit the layout that is filled, once the probe has seen it.
    pub(crate) fn misfit_of_base(&self, probe: Option<LayoutProbe<'_>>) -> Option<String> {
        LayoutChecks::base(self.checked_pair()?, &probe?, self.base.name()?)
    }

    /// `None` for maps, which know no layouts, and for what is not a colour.
    fn checked_pair(&self) -> Option<CheckedPair<'_>> {
        let (pair, names) = self.link.named_pair().filter(|_| self.options.values.is_toned())?;
        Some(CheckedPair { pair, names, direction: self.options.direction })
    }
}
