//! What the values of a pickle are made of. Values lie in one list and refer to each other by number, so that
//! those which are shared, or hold themselves, are held once and dropped without recursion.

use std::borrow::Cow;

use crate::numpy::Dtype;
use crate::numpy::text::TextDtype;

/// The number of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Id(pub(super) u32);

/// One value, with the numbers of those that it holds.
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
    /// An array; `None` between its creation and its filling.
    Array(Option<Box<ArrayLayout>>),
    /// An array of whatever the list of that number holds.
    Objects(Id),
    /// An array of several texts, which nobody asks for.
    Texts,
    /// A set, of which nobody asks what it holds.
    Set,
    /// An object of a known class.
    Made(Box<Making>),
    /// What lies outside of the pickle, under a name.
    Persistent(Id),
}

/// What an array holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Items {
    Numbers(Dtype),
    Texts(TextDtype),
    /// Whatever the pickle holds, one by one.
    Objects,
}

impl Items {
    /// From NumPy's notation; nothing for structures, dates and other rare things.
    pub(super) fn from_text(text: &str) -> Option<Self> {
        match text {
            "O" | "O8" | "O4" | "|O" | "|O8" => Some(Self::Objects),
            _ => Dtype::from_text(text)
                .map(Self::Numbers)
                .or_else(|| TextDtype::from_text(text.as_bytes()).map(Self::Texts)),
        }
    }
}

/// What an array is, and which value of the pickle holds its bytes.
#[derive(Debug)]
pub(super) struct ArrayLayout {
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) fortran_order: bool,
    pub(super) data: Id,
}

impl ArrayLayout {
    /// The bytes that the shape asks for, if they can be counted.
    pub(super) fn bytes(&self) -> Option<usize> {
        self.dtype.bytes(&self.shape)
    }
}

/// A class or function that a pickle may name, of which only the arguments and the state are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Class {
    /// SciPy's matrices by columns: state `data`, `indices`, `indptr`, `_shape`.
    SparseColumns,
    /// SciPy's matrices by rows, with the same state.
    SparseRows,
    /// SciPy's matrices by places: state `data`, `_shape`, and `row` and `col` or `coords`.
    SparsePlaces,
    /// `chumpy.ch.Ch`: an array, in the state's `x`.
    Chumpy,
    /// `chumpy.reordering.Select`: the numbers `idxs` of `a`, in shape `preferred_shape`.
    ChumpySelect,
    /// `torch._utils._rebuild_tensor` and `_rebuild_tensor_v2`: storage, offset, shape, strides.
    Tensor,
    /// `torch._utils._rebuild_parameter`: a tensor, and what training needs of it.
    Parameter,
    /// A class of torch's storages, which is only ever named.
    Storage(StorageKind),
}

impl Class {
    /// What an object of it is, for messages.
    pub(super) const fn kind(self) -> &'static str {
        match self {
            Self::SparseColumns | Self::SparseRows | Self::SparsePlaces => "a sparse matrix",
            Self::Chumpy | Self::ChumpySelect => "a chumpy array",
            Self::Tensor | Self::Parameter => "a tensor",
            Self::Storage(_) => "a torch storage",
        }
    }
}

/// What kind of number a torch storage holds.
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

/// What a call of a class was given, and what it was filled with.
#[derive(Debug)]
pub(super) struct Making {
    pub(super) class: Class,
    pub(super) args: Vec<Id>,
    pub(super) state: Option<Id>,
}

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Global {
    /// The class of arrays, which is only ever handed to the next.
    Ndarray,
    /// Makes an array that is filled afterwards.
    Reconstruct,
    /// Makes an array of its bytes, in protocol 5.
    FromBuffer,
    /// Makes a single number.
    Scalar,
    Dtype,
    /// Bytes in protocols that have none: a text, to be encoded.
    Encode,
    /// Bytes in such protocols where there are none.
    NoBytes,
    /// Makes an object of a class, in protocols that have no instruction for it.
    Reconstructor,
    /// The class that all others come from, which is only ever handed to the one before.
    Object,
    OrderedDict,
    /// Sets in protocols that have no instruction for them.
    Set,
    /// A tuple of torch's, made of a plain one.
    Size,
    Class(Class),
}
