//! What a pickle holds, value by value.

use super::array::Array;
use super::node::{Id, Node};

/// A pickle that was read.
#[derive(Debug)]
pub struct Pickle<'a> {
    pub(super) nodes: Vec<Node<'a>>,
    pub(super) root: Id,
}

impl Pickle<'_> {
    /// The value that was pickled.
    pub const fn root(&self) -> Value<'_> {
        Value { nodes: self.nodes.as_slice(), id: self.root }
    }
}

/// A value in a pickle. Values may hold themselves: whoever walks through them needs a bound.
#[derive(Debug, Clone, Copy)]
pub struct Value<'p> {
    nodes: &'p [Node<'p>],
    id: Id,
}

impl<'p> Value<'p> {
    pub(super) const fn new(nodes: &'p [Node<'p>], id: Id) -> Self {
        Self { nodes, id }
    }

    /// Another value of the same pickle.
    pub(super) const fn other(self, id: Id) -> Self {
        Self { id, ..self }
    }

    pub(super) const fn node(self) -> &'p Node<'p> {
        &self.nodes[self.id.0 as usize]
    }

    /// What it is, for messages: `"a dict"`.
    pub const fn kind(self) -> &'static str {
        match self.node() {
            Node::None => "None",
            Node::Bool(_) => "a bool",
            Node::Int(_) => "an int",
            Node::Float(_) => "a float",
            Node::Text(_) => "a string",
            Node::Bytes(_) => "bytes",
            Node::List(_) => "a list",
            Node::Tuple(_) => "a tuple",
            Node::Dict(_) => "a dict",
            Node::Global(_) => "a Python name",
            Node::Dtype(_) => "a dtype",
            Node::Array(_) => "an array",
            Node::Objects(_) => "an array of objects",
            Node::Texts => "an array of strings",
            Node::Set => "a set",
            Node::Made(making) => making.class.kind(),
            Node::Persistent(_) => "an external object",
        }
    }

    /// Whether it is `None`.
    pub const fn is_none(self) -> bool {
        matches!(self.node(), Node::None)
    }

    /// The value of a bool.
    pub const fn as_bool(self) -> Option<bool> {
        match self.node() {
            Node::Bool(value) => Some(*value),
            _ => None,
        }
    }

    /// The value of an int that fits 64 bits; others are refused when a pickle is read.
    pub const fn as_int(self) -> Option<i64> {
        match self.node() {
            Node::Int(value) => Some(*value),
            _ => None,
        }
    }

    /// The value of a float.
    pub const fn as_float(self) -> Option<f64> {
        match self.node() {
            Node::Float(value) => Some(*value),
            _ => None,
        }
    }

    /// A text. Python 2 wrote texts as bytes; those that are UTF-8 are taken too.
    pub fn as_str(self) -> Option<&'p str> {
        match self.node() {
            Node::Text(text) => Some(text),
            Node::Bytes(bytes) => std::str::from_utf8(bytes).ok(),
            _ => None,
        }
    }

    /// The bytes of a `bytes`, a `bytearray` or a text of Python 2.
    pub fn as_bytes(self) -> Option<&'p [u8]> {
        match self.node() {
            Node::Bytes(bytes) => Some(bytes),
            _ => None,
        }
    }

    /// What a list or a tuple holds.
    pub fn items(self) -> Option<impl ExactSizeIterator<Item = Self>> {
        match self.node() {
            Node::List(items) | Node::Tuple(items) => {
                Some(items.iter().map(move |&id| Self { id, ..self }))
            }
            _ => None,
        }
    }

    /// The keys and values of a dict, in the order in which they were written.
    pub fn entries(self) -> Option<impl ExactSizeIterator<Item = (Self, Self)>> {
        match self.node() {
            Node::Dict(entries) => {
                let value = move |id| Self { id, ..self };
                Some(entries.iter().map(move |&(key, held)| (value(key), value(held))))
            }
            _ => None,
        }
    }

    /// What a dict holds under a text; the last one, should there be several.
    pub fn get(self, key: &str) -> Option<Self> {
        let Node::Dict(entries) = self.node() else { return None };
        let value = |id| Self { id, ..self };
        // Bytes against bytes: a key of megabytes is told apart by its length.
        let is_key = |id: Id| match value(id).node() {
            Node::Text(text) => &**text == key,
            Node::Bytes(bytes) => &**bytes == key.as_bytes(),
            _ => false,
        };
        let found = entries.iter().rev().find(|&&(found, _)| is_key(found));
        found.map(|&(_, held)| value(held))
    }

    /// An array of numbers, or a single NumPy number as an array without axes.
    pub fn as_array(self) -> Option<Array<'p>> {
        match self.node() {
            Node::Array(Some(layout)) => {
                let data = Self { id: layout.data, ..self }.as_bytes()?;
                Some(Array { layout, data })
            }
            _ => None,
        }
    }

    /// What an array of objects holds, whatever its shape.
    pub fn objects(self) -> Option<impl ExactSizeIterator<Item = Self>> {
        match self.node() {
            Node::Objects(items) => self.other(*items).items(),
            _ => None,
        }
    }

    /// What something outside of the pickle is called by.
    pub const fn persistent(self) -> Option<Self> {
        match self.node() {
            Node::Persistent(id) => Some(self.other(*id)),
            _ => None,
        }
    }
}
