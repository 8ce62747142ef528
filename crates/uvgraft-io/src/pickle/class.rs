//! Known classes of pickled objects.

use super::node::{Class, Global, Instance, Node};
use super::value::Value;

/// An object of a known class.
#[derive(Debug, Clone, Copy)]
pub struct Object<'p> {
    instance: &'p Instance,
    value: Value<'p>,
}

impl<'p> Object<'p> {
    /// Its class.
    pub const fn class(self) -> Class {
        self.instance.class
    }

    /// An argument of its constructor.
    pub fn arg(self, index: usize) -> Option<Value<'p>> {
        self.instance.args.get(index).map(|&id| self.value.other(id))
    }

    /// An attribute of its state.
    pub fn attribute(self, name: &str) -> Option<Value<'p>> {
        self.value.other(self.instance.state?).get(name)
    }
}

impl<'p> Value<'p> {
    /// An object of a known class.
    pub fn as_object(self) -> Option<Object<'p>> {
        match self.node() {
            Node::Object(instance) => Some(Object { instance, value: self }),
            _ => None,
        }
    }

    /// The class of a name.
    pub const fn as_class(self) -> Option<Class> {
        match self.node() {
            Node::Global(Global::Class(class)) => Some(*class),
            _ => None,
        }
    }
}
