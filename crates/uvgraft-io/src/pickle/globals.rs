//! The names that a pickle may import. All others are rejected.

use super::error::PickleError;
use super::node::{Class, Global, StorageKind};
use crate::obj::shown;

/// NumPy 2 moved its internal modules from `core` to `_core`; SciPy 1.8 moved its sparse ones
/// likewise.
const ALLOWED: [(&str, &str, Global); 47] = [
    ("numpy", "ndarray", Global::Ndarray),
    ("numpy", "dtype", Global::Dtype),
    ("numpy.core.multiarray", "_reconstruct", Global::Reconstruct),
    ("numpy._core.multiarray", "_reconstruct", Global::Reconstruct),
    ("numpy.core.multiarray", "scalar", Global::Scalar),
    ("numpy._core.multiarray", "scalar", Global::Scalar),
    ("numpy.core.numeric", "_frombuffer", Global::FromBuffer),
    ("numpy._core.numeric", "_frombuffer", Global::FromBuffer),
    ("_codecs", "encode", Global::Encode),
    ("__builtin__", "bytes", Global::NoBytes),
    ("builtins", "bytes", Global::NoBytes),
    ("copy_reg", "_reconstructor", Global::Reconstructor),
    ("copyreg", "_reconstructor", Global::Reconstructor),
    ("__builtin__", "object", Global::Object),
    ("builtins", "object", Global::Object),
    ("__builtin__", "set", Global::Set),
    ("builtins", "set", Global::Set),
    ("collections", "OrderedDict", Global::OrderedDict),
    ("scipy.sparse.csc", "csc_matrix", Global::Class(Class::SparseCsc)),
    ("scipy.sparse._csc", "csc_matrix", Global::Class(Class::SparseCsc)),
    ("scipy.sparse._csc", "csc_array", Global::Class(Class::SparseCsc)),
    ("scipy.sparse._arrays", "csc_array", Global::Class(Class::SparseCsc)),
    ("scipy.sparse.csr", "csr_matrix", Global::Class(Class::SparseCsr)),
    ("scipy.sparse._csr", "csr_matrix", Global::Class(Class::SparseCsr)),
    ("scipy.sparse._csr", "csr_array", Global::Class(Class::SparseCsr)),
    ("scipy.sparse._arrays", "csr_array", Global::Class(Class::SparseCsr)),
    ("scipy.sparse.coo", "coo_matrix", Global::Class(Class::SparseCoo)),
    ("scipy.sparse._coo", "coo_matrix", Global::Class(Class::SparseCoo)),
    ("scipy.sparse._coo", "coo_array", Global::Class(Class::SparseCoo)),
    ("scipy.sparse._arrays", "coo_array", Global::Class(Class::SparseCoo)),
    ("chumpy.ch", "Ch", Global::Class(Class::Chumpy)),
    ("chumpy", "Ch", Global::Class(Class::Chumpy)),
    ("chumpy.reordering", "Select", Global::Class(Class::ChumpySelect)),
    ("torch._utils", "_rebuild_tensor", Global::Class(Class::Tensor)),
    ("torch._utils", "_rebuild_tensor_v2", Global::Class(Class::Tensor)),
    ("torch._utils", "_rebuild_parameter", Global::Class(Class::Parameter)),
    ("torch", "DoubleStorage", Global::Class(Class::Storage(StorageKind::Double))),
    ("torch", "FloatStorage", Global::Class(Class::Storage(StorageKind::Float))),
    ("torch", "HalfStorage", Global::Class(Class::Storage(StorageKind::Half))),
    ("torch", "BFloat16Storage", Global::Class(Class::Storage(StorageKind::BFloat16))),
    ("torch", "LongStorage", Global::Class(Class::Storage(StorageKind::Long))),
    ("torch", "IntStorage", Global::Class(Class::Storage(StorageKind::Int))),
    ("torch", "ShortStorage", Global::Class(Class::Storage(StorageKind::Short))),
    ("torch", "CharStorage", Global::Class(Class::Storage(StorageKind::Char))),
    ("torch", "ByteStorage", Global::Class(Class::Storage(StorageKind::Byte))),
    ("torch", "BoolStorage", Global::Class(Class::Storage(StorageKind::Bool))),
    ("torch", "Size", Global::Size),
];

/// Looks up an imported name.
///
/// # Errors
/// [`PickleError::Refused`] for every name not needed for plain data.
pub(super) fn find(module: &str, name: &str) -> Result<Global, PickleError> {
    let found = ALLOWED.iter().find(|allowed| (allowed.0, allowed.1) == (module, name));
    found.map(|allowed| allowed.2).ok_or_else(|| PickleError::Refused {
        name: format!("{}.{}", shown(module.as_bytes()), shown(name.as_bytes())),
    })
}
