//! Known classes of pickled objects.

use super::value::{Id, Node, Value};

/// A class or function known to this crate, of which only the arguments and the state are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Class {
    /// SciPy's column-compressed matrices: state `data`, `indices`, `indptr`, `_shape`.
    SparseColumns,
    /// SciPy's row-compressed matrices, with the same state.
    SparseRows,
    /// SciPy's coordinate matrices: state `data`, `_shape`, and `row` and `col` or `coords`.
    SparsePlaces,
    /// `chumpy.ch.Ch`: an array, in the state's `x`.
    Chumpy,
    /// `chumpy.reordering.Select`: the values `idxs` of `a`, in shape `preferred_shape`.
    ChumpySelect,
    /// `torch._utils._rebuild_tensor` and `_rebuild_tensor_v2`: storage, offset, shape, strides.
    Tensor,
    /// `torch._utils._rebuild_parameter`: a tensor, and its training state.
    Parameter,
    /// A torch storage class, which is only named, never called.
    Storage(StorageKind),
}

impl Class {
    /// A description of its objects, for messages.
    pub(super) const fn kind(self) -> &'static str {
        match self {
            Self::SparseColumns | Self::SparseRows | Self::SparsePlaces => "a sparse matrix",
            Self::Chumpy | Self::ChumpySelect => "a chumpy array",
            Self::Tensor | Self::Parameter => "a tensor",
            Self::Storage(_) => "a torch storage",
        }
    }
}

/// The type of the values of a torch storage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as in torch")]
pub enum StorageKind {
    Double,
    Float,
    Half,
    BFloat16,
    Long,
    Int,
    Short,
    Char,
    Byte,
    Bool,
}

/// The arguments and the state of an object.
#[derive(Debug)]
pub(super) struct Making {
    pub(super) class: Class,
    pub(super) args: Vec<Id>,
    pub(super) state: Option<Id>,
}

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
            Node::Global(super::globals::Global::Class(class)) => Some(*class),
            _ => None,
        }
    }
}
