//! Calls of imported names. No Python code is run: each call creates one value of this crate.

use std::borrow::Cow;

use super::error::PickleError;
use super::machine::Machine;
use super::node::{ArrayLayout, Class, Global, Id, Instance, Items, Node};
use super::value::Value;
use crate::numpy::text::TextDtype;
use crate::numpy::{Dtype, MAX_AXES};
use crate::obj::shown;

impl<'a> Machine<'a> {
    /// The result of calling a name.
    pub(super) fn call(&mut self, callee: Id, args: &[Id]) -> Result<Node<'a>, PickleError> {
        let &Node::Global(global) = self.value(callee).node() else {
            let kind = self.value(callee).kind();
            return Err(self.scan.malformed(format!("must call a global, got {kind}")));
        };
        match (global, args) {
            (Global::Reconstruct, &[class, _, _])
                if matches!(self.value(class).node(), Node::Global(Global::Ndarray)) =>
            {
                Ok(Node::Array(None))
            }
            (Global::Dtype, &[name, ..]) => self.items_named(name).map(Node::Dtype),
            (Global::Scalar, &[dtype, data]) => match self.items(dtype)? {
                Items::Texts(dtype) => self.texts(dtype, &[], data),
                _ => self.array(self.dtype(dtype)?, Vec::new(), false, data),
            },
            (Global::FromBuffer, &[data, dtype, shape, order]) => {
                let fortran_order = match self.value(order).as_str() {
                    Some("C") => false,
                    Some("F") => true,
                    _ => return Err(self.scan.malformed("array order must be C or F")),
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
            (Global::Reconstructor, &[class, base, _])
                if matches!(self.value(base).node(), Node::Global(Global::Object)) =>
            {
                match self.value(class).as_class() {
                    Some(class) => Ok(object(class, &[])),
                    None => Err(self.scan.malformed("object of an unknown class")),
                }
            }
            (Global::OrderedDict, []) => Ok(Node::Dict(Vec::new())),
            (Global::OrderedDict, &[items]) => self.dict_of_pairs(items),
            // The items of a set are never needed.
            (Global::Set, [] | [_]) => Ok(Node::Set),
            (Global::Size, &[shape]) => {
                let shape = self.arguments(shape)?;
                Ok(Node::Tuple(shape))
            }
            (Global::Class(Class::Storage(_)), _) => {
                Err(self.scan.malformed("torch storage inside the pickle"))
            }
            (Global::Class(class), args) => Ok(object(class, args)),
            _ => Err(self.scan.malformed(format!("unsupported call of {global:?}"))),
        }
    }

    /// Sets the state of a created value: a tuple for NumPy's dtypes and arrays, a dict for
    /// objects.
    pub(super) fn build(&mut self, object: Id, state: Id) -> Result<(), PickleError> {
        let filled = match self.value(object).node() {
            Node::Dtype(items) => {
                let items = *items;
                self.filled_dtype(items, state)?
            }
            Node::Array(_) => self.filled_array(state)?,
            Node::Object(instance) if matches!(self.value(state).node(), Node::Dict(_)) => {
                let (class, args) = (instance.class, instance.args.clone());
                Node::Object(Box::new(Instance { class, args, state: Some(state) }))
            }
            // Torch's dicts of tensors have attributes with version information.
            Node::Dict(_) if matches!(self.value(state).node(), Node::Dict(_)) => return Ok(()),
            found => {
                let what = if matches!(found, Node::Object(_) | Node::Dict(_)) {
                    "in an unsupported way"
                } else {
                    "although it takes no state"
                };
                let kind = self.value(object).kind();
                return Err(self.scan.malformed(format!("{kind} is built {what}")));
            }
        };
        self.replace(object, filled);
        Ok(())
    }

    fn filled_dtype(&self, items: Items, state: Id) -> Result<Node<'a>, PickleError> {
        let [_, order, nested, names, fields, _, _, _] = self.arguments(state)?[..] else {
            return Err(self.scan.malformed("unsupported state of a dtype"));
        };
        if ![nested, names, fields].iter().all(|&id| self.value(id).is_none()) {
            return Err(self.scan.malformed("structured dtype"));
        }
        let big_endian = match self.value(order).as_str() {
            Some("<" | "|") => false,
            Some(">") => true,
            _ => return Err(self.scan.malformed("unknown byte order of a dtype")),
        };
        Ok(Node::Dtype(match items {
            Items::Numbers(dtype) => Items::Numbers(Dtype { big_endian, ..dtype }),
            Items::Texts(dtype) => Items::Texts(TextDtype { big_endian, ..dtype }),
            Items::Objects => Items::Objects,
        }))
    }

    fn filled_array(&mut self, state: Id) -> Result<Node<'a>, PickleError> {
        let [_, shape, dtype, fortran_order, data] = self.arguments(state)?[..] else {
            return Err(self.scan.malformed("unsupported state of an array"));
        };
        let fortran_order = self.flag(fortran_order)?;
        let (items, shape) = (self.items(dtype)?, self.shape(shape)?);
        match items {
            Items::Numbers(dtype) => self.array(dtype, shape, fortran_order, data),
            Items::Texts(dtype) => self.texts(dtype, &shape, data),
            Items::Objects => {
                let count = shape.iter().copied().try_fold(1, usize::checked_mul);
                let found = self.value(data).items().map(|items| items.len());
                if count.is_none() || count != found {
                    return Err(self.scan.malformed(
                        "the number of objects does not match the shape of their array",
                    ));
                }
                Ok(Node::Objects(data))
            }
        }
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
            return Err(self.scan.malformed(format!("must be the bytes of an array, got {kind}")));
        };
        let layout = ArrayLayout { dtype, shape, fortran_order, data };
        if layout.bytes() != Some(bytes.len()) {
            let (shape, width, found) = (&layout.shape, dtype.width, bytes.len());
            return Err(self.scan.malformed(format!(
                "an array of shape {shape:?} with {width} bytes per value cannot have {found} bytes"
            )));
        }
        Ok(Node::Array(Some(Box::new(layout))))
    }

    /// An array of strings. Only a single string is kept.
    fn texts(
        &mut self,
        dtype: TextDtype,
        shape: &[usize],
        data: Id,
    ) -> Result<Node<'a>, PickleError> {
        let bytes = self.value(data).as_bytes().unwrap_or_default();
        let count = shape.iter().copied().try_fold(1, usize::checked_mul);
        let wanted = count.zip(dtype.width()).and_then(|(count, width)| count.checked_mul(width));
        if wanted != Some(bytes.len()) {
            return Err(self
                .scan
                .malformed("the size of an array of strings does not match its shape"));
        }
        if count != Some(1) {
            return Ok(Node::Texts);
        }
        let (length, text) = (bytes.len(), dtype.read(bytes));
        let text = text.ok_or_else(|| self.scan.malformed("invalid character in a string"))?;
        self.count_copy(length)?;
        Ok(Node::Text(Cow::Owned(text)))
    }

    fn items_named(&self, name: Id) -> Result<Items, PickleError> {
        let name = self.value(name).as_str().unwrap_or_default();
        Items::from_text(name).ok_or_else(|| {
            let name = shown(name.as_bytes());
            self.scan.malformed(format!("array dtype must be numeric, got `{name}`"))
        })
    }

    fn items(&self, id: Id) -> Result<Items, PickleError> {
        match self.value(id).node() {
            Node::Dtype(items) => Ok(*items),
            _ => Err(self.scan.malformed("array without a dtype")),
        }
    }

    fn dtype(&self, id: Id) -> Result<Dtype, PickleError> {
        match self.items(id)? {
            Items::Numbers(dtype) => Ok(dtype),
            Items::Objects => Err(self.scan.malformed("array values must be numbers, got objects")),
            Items::Texts(_) => {
                Err(self.scan.malformed("array values must be numbers, got strings"))
            }
        }
    }

    /// A dict from key-value pairs, as Python 2 stored an `OrderedDict`.
    fn dict_of_pairs(&mut self, items: Id) -> Result<Node<'a>, PickleError> {
        let pair = |item: Value<'_>| match item.node() {
            Node::List(pair) | Node::Tuple(pair) => match pair[..] {
                [key, value] => Some((key, value)),
                _ => None,
            },
            _ => None,
        };
        let pairs = self.value(items).items();
        let pairs: Option<Vec<(Id, Id)>> = pairs.and_then(|pairs| pairs.map(pair).collect());
        let pairs = pairs.ok_or_else(|| self.scan.malformed("dict without key-value pairs"))?;
        // One list may be converted into any number of dicts.
        self.count_copy(size_of_val(&pairs[..]))?;
        Ok(Node::Dict(pairs))
    }

    fn shape(&mut self, id: Id) -> Result<Vec<usize>, PickleError> {
        let sides = self.value(id).items().filter(|sides| sides.len() <= MAX_AXES);
        let side = |value: Value<'_>| value.as_int().and_then(|side| usize::try_from(side).ok());
        let shape: Option<Vec<usize>> = sides.and_then(|sides| sides.map(side).collect());
        let shape = shape.ok_or_else(|| self.scan.malformed("array without a shape"))?;
        // One tuple may be the shape of any number of arrays.
        self.count_copy(size_of_val(&shape[..]))?;
        Ok(shape)
    }

    /// A bool, or 0 or 1 as in protocols without bools.
    fn flag(&self, id: Id) -> Result<bool, PickleError> {
        let value = self.value(id);
        let flag = value.as_bool().or(match value.as_int() {
            Some(0) => Some(false),
            Some(1) => Some(true),
            _ => None,
        });
        flag.ok_or_else(|| self.scan.malformed("must be a bool"))
    }

    /// The bytes of a string of characters below 256.
    fn latin1(&mut self, text: Id) -> Result<Node<'a>, PickleError> {
        let Node::Text(text) = self.value(text).node() else {
            return Err(self.scan.malformed("must be a string of bytes"));
        };
        let length = text.len();
        let bytes: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
        let bytes =
            bytes.ok_or_else(|| self.scan.malformed("string with characters beyond a byte"))?;
        self.count_copy(length)?;
        Ok(Node::Bytes(Cow::Owned(bytes)))
    }
}

fn object<'a>(class: Class, args: &[Id]) -> Node<'a> {
    Node::Object(Box::new(Instance { class, args: args.to_vec(), state: None }))
}
