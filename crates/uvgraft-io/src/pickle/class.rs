//! Known classes of pickled objects.

use super::node::{Class, Global, Making, Node};
use super::value::Value;

/// An object of a known class.
#[derive(Debug, Clone, Copy)]
pub struct Made<'p> {
    making: &'p Making,
    value: Value<'p>,
}

impl<'p> Made<'p> {
    /// Of which class.
    pub const fn class(self) -> Class {
        self.making.class
    }

    /// An argument of its constructor.
    pub fn arg(self, index: usize) -> Option<Value<'p>> {
        self.making.args.get(index).map(|&id| self.value.other(id))
    }

    /// An attribute of its state.
    pub fn attribute(self, name: &str) -> Option<Value<'p>> {
        self.value.other(self.making.state?).get(name)
    }
}

impl<'p> Value<'p> {
    /// An object of a known class.
    pub fn as_made(self) -> Option<Made<'p>> {
        match self.node() {
            Node::Made(making) => Some(Made { making, value: self }),
            _ => None,
        }
    }

    /// The class that a name stands for.
    pub const fn as_class(self) -> Option<Class> {
        match self.node() {
            Node::Global(Global::Class(class)) => Some(*class),
            _ => None,
        }
    }
}
