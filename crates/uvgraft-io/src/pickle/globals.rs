//! The names that a pickle may use, and what stands for calling them. Nothing of Python's is run:
//! each call makes one value of this crate.

use std::borrow::Cow;

use super::PickleError;
use super::array::{Dtype, Layout, MOST_AXES};
use super::machine::Machine;
use super::value::{Id, Node, Value};
use crate::obj::shown;

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
}

/// NumPy 2 moved its inner modules from `core` to `_core`.
const ALLOWED: [(&str, &str, Global); 11] = [
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
];

impl Global {
    pub(super) fn find(module: &str, name: &str) -> Result<Self, PickleError> {
        let found = ALLOWED.iter().find(|allowed| (allowed.0, allowed.1) == (module, name));
        found.map(|allowed| allowed.2).ok_or_else(|| PickleError::Refused {
            name: format!("{}.{}", shown(module.as_bytes()), shown(name.as_bytes())),
        })
    }
}

impl<'a> Machine<'a> {
    /// What calling a name makes.
    pub(super) fn call(&mut self, callee: Id, args: &[Id]) -> Result<Node<'a>, PickleError> {
        let &Node::Global(global) = self.value(callee).node() else {
            let kind = self.value(callee).kind();
            return Err(self.scan.malformed(format!("found {kind}, wanted something to call")));
        };
        match (global, args) {
            (Global::Reconstruct, &[class, _, _])
                if matches!(self.value(class).node(), Node::Global(Global::Ndarray)) =>
            {
                Ok(Node::Array(None))
            }
            (Global::Dtype, &[name, ..]) => self.dtype_named(name).map(Node::Dtype),
            (Global::Scalar, &[dtype, data]) => {
                let dtype = self.dtype(dtype)?;
                self.array(dtype, Vec::new(), false, data)
            }
            (Global::FromBuffer, &[data, dtype, shape, order]) => {
                let fortran_order = match self.value(order).as_str() {
                    Some("C") => false,
                    Some("F") => true,
                    _ => return Err(self.scan.malformed("an array's order is neither C nor F")),
                };
                let (dtype, shape) = (self.dtype(dtype)?, self.shape(shape)?);
                self.array(dtype, shape, fortran_order, data)
            }
            (Global::Encode, &[text, encoding])
                if matches!(self.value(encoding).as_str(), Some("latin1" | "latin-1")) =>
            {
                self.latin1(text)
            }
            (Global::NoBytes, []) => Ok(Node::Bytes(Cow::Borrowed(b""))),
            _ => Err(self.scan.malformed(format!("{global:?} is called in an unknown way"))),
        }
    }

    /// Fills what a call made: NumPy's dtypes and arrays take a tuple.
    pub(super) fn build(&mut self, object: Id, state: Id) -> Result<(), PickleError> {
        let state = self.arguments(state)?;
        let filled = match (self.value(object).node(), &state[..]) {
            (Node::Dtype(dtype), &[_, order, nested, names, fields, _, _, _]) => {
                if ![nested, names, fields].iter().all(|&id| self.value(id).is_none()) {
                    return Err(self.scan.malformed("an array's dtype has parts"));
                }
                let big_endian = match self.value(order).as_str() {
                    Some("<" | "|") => false,
                    Some(">") => true,
                    _ => return Err(self.scan.malformed("a dtype's byte order is unknown")),
                };
                Node::Dtype(Dtype { big_endian, ..*dtype })
            }
            (Node::Array(_), &[_, shape, dtype, fortran_order, data]) => {
                let fortran_order = self.flag(fortran_order)?;
                let (dtype, shape) = (self.dtype(dtype)?, self.shape(shape)?);
                self.array(dtype, shape, fortran_order, data)?
            }
            (found, _) => {
                let what = if matches!(found, Node::Array(_) | Node::Dtype(_)) {
                    "in an unknown way"
                } else {
                    "that takes nothing"
                };
                let kind = self.value(object).kind();
                return Err(self.scan.malformed(format!("{kind} is filled {what}")));
            }
        };
        self.replace(object, filled);
        Ok(())
    }

    fn array(
        &self,
        dtype: Dtype,
        shape: Vec<usize>,
        fortran_order: bool,
        data: Id,
    ) -> Result<Node<'a>, PickleError> {
        let Some(bytes) = self.value(data).as_bytes() else {
            let kind = self.value(data).kind();
            return Err(self.scan.malformed(format!("found {kind}, wanted an array's bytes")));
        };
        let layout = Layout { dtype, shape, fortran_order, data };
        if layout.bytes() != Some(bytes.len()) {
            let (shape, width, found) = (&layout.shape, dtype.width, bytes.len());
            return Err(self.scan.malformed(format!(
                "an array of shape {shape:?} and {width} bytes a number has {found} bytes"
            )));
        }
        Ok(Node::Array(Some(Box::new(layout))))
    }

    fn dtype_named(&self, name: Id) -> Result<Dtype, PickleError> {
        let name = self.value(name).as_str().unwrap_or_default();
        Dtype::from_text(name).ok_or_else(|| {
            let name = shown(name.as_bytes());
            self.scan.malformed(format!("found an array of dtype `{name}`, wanted numbers"))
        })
    }

    fn dtype(&self, id: Id) -> Result<Dtype, PickleError> {
        match self.value(id).node() {
            Node::Dtype(dtype) => Ok(*dtype),
            _ => Err(self.scan.malformed("an array has no dtype")),
        }
    }

    fn shape(&mut self, id: Id) -> Result<Vec<usize>, PickleError> {
        let sides = self.value(id).items().filter(|sides| sides.len() <= MOST_AXES);
        let side = |value: Value<'_>| value.as_int().and_then(|side| usize::try_from(side).ok());
        let shape: Option<Vec<usize>> = sides.and_then(|sides| sides.map(side).collect());
        let shape = shape.ok_or_else(|| self.scan.malformed("an array has no shape"))?;
        // One tuple may be the shape of any number of arrays.
        self.count_copy(size_of_val(&shape[..]))?;
        Ok(shape)
    }

    /// A bool, or 0 or 1 as protocols without bools write them.
    fn flag(&self, id: Id) -> Result<bool, PickleError> {
        let value = self.value(id);
        let flag = value.as_bool().or(match value.as_int() {
            Some(0) => Some(false),
            Some(1) => Some(true),
            _ => None,
        });
        flag.ok_or_else(|| self.scan.malformed("found no bool where one was wanted"))
    }

    /// The bytes that a text of characters below 256 stands for.
    fn latin1(&mut self, text: Id) -> Result<Node<'a>, PickleError> {
        let Node::Text(text) = self.value(text).node() else {
            return Err(self.scan.malformed("found no text to make bytes of"));
        };
        let length = text.len();
        let bytes: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
        let bytes = bytes.ok_or_else(|| self.scan.malformed("a text stands for no bytes"))?;
        self.count_copy(length)?;
        Ok(Node::Bytes(Cow::Owned(bytes)))
    }
}
