//! Expressions of models whose components have names.

use super::Shaped;
use crate::Avatar;
use crate::face::add_named;
use crate::rig::Morph;

impl Shaped<'_> {
    /// Whether the model's components are expressions by name.
    pub fn has_named_expressions(&self) -> bool {
        !self.model.expression_names().is_empty()
    }

    /// The named expressions of the model as morph targets; none if its components have no names.
    pub fn named_expressions(&self) -> Vec<Morph> {
        let names = self.model.expression_names().iter().enumerate();
        names.map(|(at, name)| Morph::from_dense(name, self.model.expression(at))).collect()
    }

    /// Adds the named expressions to an avatar, each as a morph target and as a custom expression,
    /// and the presets that can be made of them.
    pub(super) fn add_named_expressions(&self, avatar: &mut Avatar) {
        add_named(avatar, self.named_expressions());
    }
}
