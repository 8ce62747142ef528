//! The values of a pickle. They are stored in one list and refer to each other by index, so that
//! shared or cyclic values are stored once and dropped without recursion.

use std::borrow::Cow;

use crate::numpy::Dtype;
use crate::numpy::text::TextDtype;

/// The index of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Id(pub(super) u32);

/// One value, with the indices of those it contains.
#[derive(Debug)]
pub(super) enum Node<'a> {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Cow<'a, str>),
    Bytes(Cow<'a, [u8]>),
    List(Vec<Id>),
    Tuple(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    Global(Global),
    Dtype(Items),
    /// An array; `None` between its creation and its initialisation.
    Array(Option<Box<ArrayLayout>>),
    /// An array of the objects in a list.
    Objects(Id),
    /// An array of several strings, which are not kept.
    Texts,
    /// A set, whose items are not kept.
    Set,
    /// An object of a known class.
    Object(Box<Instance>),
    /// A reference to data outside of the pickle, by its identifier.
    Persistent(Id),
}

/// The item type of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Items {
    Numbers(Dtype),
    Texts(TextDtype),
    /// Any values of the pickle.
    Objects,
}

impl Items {
    /// Parses NumPy's notation; `None` for structures, dates and other rare types.
    pub(super) fn from_text(text: &str) -> Option<Self> {
        match text {
            "O" | "O8" | "O4" | "|O" | "|O8" => Some(Self::Objects),
            _ => Dtype::from_text(text)
                .map(Self::Numbers)
                .or_else(|| TextDtype::from_text(text.as_bytes()).map(Self::Texts)),
        }
    }
}

/// An array's type and shape, and the value that holds its bytes.
#[derive(Debug)]
pub(super) struct ArrayLayout {
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) fortran_order: bool,
    pub(super) data: Id,
}

impl ArrayLayout {
    /// The bytes required by the shape, unless it overflows.
    pub(super) fn bytes(&self) -> Option<usize> {
        self.dtype.bytes(&self.shape)
    }
}

/// A class or function that a pickle may import; only its arguments and state are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Class {
    /// SciPy's CSC matrices: state `data`, `indices`, `indptr`, `_shape`.
    SparseCsc,
    /// SciPy's CSR matrices, with the same state.
    SparseCsr,
    /// SciPy's COO matrices: state `data`, `_shape`, and `row` and `col` or `coords`.
    SparseCoo,
    /// `chumpy.ch.Ch`: an array, in the state's `x`.
    Chumpy,
    /// `chumpy.reordering.Select`: the values of `a` at `idxs`, in shape `preferred_shape`.
    ChumpySelect,
    /// `torch._utils._rebuild_tensor` and `_rebuild_tensor_v2`: storage, offset, shape, strides.
    Tensor,
    /// `torch._utils._rebuild_parameter`: a tensor, and data for training.
    Parameter,
    /// A class of torch's storages, which is only referenced.
    Storage(StorageKind),
}

impl Class {
    /// A description of its objects, for messages.
    pub(super) const fn kind(self) -> &'static str {
        match self {
            Self::SparseCsc | Self::SparseCsr | Self::SparseCoo => "a sparse matrix",
            Self::Chumpy | Self::ChumpySelect => "a chumpy array",
            Self::Tensor | Self::Parameter => "a tensor",
            Self::Storage(_) => "a torch storage",
        }
    }
}

/// The value type of a torch storage.
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

/// An object of a known class: the arguments of its constructor, and its state.
#[derive(Debug)]
pub(super) struct Instance {
    pub(super) class: Class,
    pub(super) args: Vec<Id>,
    pub(super) state: Option<Id>,
}

/// The meaning of an imported name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Global {
    /// The class of arrays, which is only passed to `Reconstruct`.
    Ndarray,
    /// Creates an array that is initialised later.
    Reconstruct,
    /// Creates an array from its bytes, in protocol 5.
    FromBuffer,
    /// Creates a single number.
    Scalar,
    Dtype,
    /// Creates bytes from a string, in protocols without bytes.
    Encode,
    /// Creates empty bytes, in the same protocols.
    NoBytes,
    /// Creates an object of a class, in protocols that have no instruction for it.
    Reconstructor,
    /// The base class of all others, which is only passed to `Reconstructor`.
    Object,
    OrderedDict,
    /// Creates a set, in protocols that have no instruction for it.
    Set,
    /// `torch.Size`, made from a tuple.
    Size,
    Class(Class),
}
