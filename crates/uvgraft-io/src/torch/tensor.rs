//! Tensors: views of a storage of values, by an offset and a stride for each axis.

use std::collections::HashMap;
use std::rc::Rc;

use crate::arrays::archive::ArchiveInMemory;
use crate::arrays::collect::Outside;
use crate::arrays::error::Unread;
use crate::arrays::numeric::NumericArray;
use crate::numpy::order::places;
use crate::numpy::{Dtype, NumberKind, length};
use crate::obj::shown;
use crate::pickle::{Class, Object, StorageKind, Value};

/// Maximum number of axes of torch tensors.
const MAX_AXES: usize = 64;

/// The storages of an archive, each unpacked once.
pub(super) struct Storages<'t, 'a> {
    archive: &'t mut ArchiveInMemory<'a>,
    folder: String,
    big_endian: bool,
    unpacked: HashMap<String, Rc<[u8]>>,
}

/// The view of a tensor into its storage.
struct Strides {
    offset: usize,
    shape: Vec<usize>,
    steps: Vec<usize>,
}

impl<'t, 'a> Storages<'t, 'a> {
    pub(super) fn new(
        archive: &'t mut ArchiveInMemory<'a>,
        folder: &str,
        big_endian: bool,
    ) -> Self {
        Self { archive, folder: folder.to_owned(), big_endian, unpacked: HashMap::new() }
    }

    /// The type of the values of a storage, and their bytes.
    fn storage(&mut self, id: Value<'_>) -> Result<(StorageKind, Rc<[u8]>), Unread> {
        let parts: Vec<Value<'_>> =
            id.persistent().and_then(Value::items).into_iter().flatten().take(6).collect();
        let [tag, class, key, _, count] = parts[..] else {
            return Err(Unread::broken("a tensor must have a storage of five entries"));
        };
        let (Some("storage"), Some(Class::Storage(kind)), Some(key), Some(count)) =
            (tag.as_str(), class.as_class(), key.as_str(), count.as_int())
        else {
            return Err(Unread::broken("unknown name of a tensor's storage"));
        };
        let bytes = match self.unpacked.get(key) {
            Some(bytes) => Rc::clone(bytes),
            None => {
                let name = format!("{}data/{key}", self.folder);
                let index = self.archive.names().iter().position(|found| *found == name);
                let index = index.ok_or_else(|| {
                    Unread::broken(format!(
                        "the archive must contain the storage `{}`",
                        shown(key.as_bytes())
                    ))
                })?;
                let bytes = self.archive.read(index).map_err(Unread::Refused)?;
                let bytes: Rc<[u8]> = bytes.into();
                self.unpacked.insert(key.to_owned(), Rc::clone(&bytes));
                bytes
            }
        };
        let wanted = usize::try_from(count).ok().and_then(|count| count.checked_mul(width(kind)));
        if wanted != Some(bytes.len()) {
            let (width, found) = (width(kind), bytes.len());
            return Err(Unread::broken(format!(
                "a storage of {count} values of {width} bytes cannot have {found} bytes"
            )));
        }
        Ok((kind, bytes))
    }
}

impl Outside for Storages<'_, '_> {
    fn tensor(
        &mut self,
        tensor: Object<'_>,
        spend: &mut dyn FnMut(usize) -> Result<(), Unread>,
    ) -> Result<NumericArray, Unread> {
        let arg =
            |index| tensor.arg(index).ok_or_else(|| Unread::broken("tensor with too few entries"));
        let (storage, offset, shape, strides) = (arg(0)?, arg(1)?, arg(2)?, arg(3)?);
        let offset = size(offset).ok_or_else(|| Unread::broken("tensor without an offset"))?;
        let shape = sizes(shape).ok_or_else(|| Unread::broken("tensor without a shape"))?;
        let steps = sizes(strides).filter(|steps| steps.len() == shape.len());
        let steps = steps
            .ok_or_else(|| Unread::broken("a tensor must have a stride for each dimension"))?;
        let strides = Strides { offset, shape, steps };
        let count = strides.shape.iter().copied().try_fold(1, usize::checked_mul);
        let count = count.ok_or_else(|| {
            Unread::broken(format!("tensor of shape {:?} has too many values", strides.shape))
        })?;
        spend(count)?;
        let (kind, bytes) = self.storage(storage)?;
        let bytes = strides.gather(&bytes, width(kind), count)?;
        let array = match dtype(kind, self.big_endian) {
            Some(dtype) => NumericArray::decode(strides.shape, dtype, &bytes),
            None => NumericArray::decode_brain(strides.shape, &bytes, self.big_endian),
        };
        array.ok_or_else(|| Unread::broken("shape and number of values do not match"))
    }
}

impl Strides {
    /// The bytes of the values, in C order.
    fn gather(&self, bytes: &[u8], width: usize, count: usize) -> Result<Vec<u8>, Unread> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let last =
            self.shape.iter().zip(&self.steps).try_fold(self.offset, |at, (length, step)| {
                at.checked_add((length - 1).checked_mul(*step)?)
            });
        let numbers = bytes.len() / width;
        if last.is_none_or(|last| last >= numbers) {
            let Self { offset, shape, steps } = self;
            return Err(Unread::broken(format!(
                "tensor of shape {shape:?}, strides {steps:?} and offset {offset} exceeds its \
                 storage of {numbers} values"
            )));
        }
        let mut gathered = Vec::with_capacity(count * width);
        for at in places(&self.shape, &self.steps).take(count) {
            gathered.extend_from_slice(&bytes[(self.offset + at) * width..][..width]);
        }
        Ok(gathered)
    }
}

fn size(value: Value<'_>) -> Option<usize> {
    u64::try_from(value.as_int()?).ok().map(length)
}

fn sizes(value: Value<'_>) -> Option<Vec<usize>> {
    value.items().filter(|items| items.len() <= MAX_AXES)?.map(size).collect()
}

/// Bytes of a value.
const fn width(kind: StorageKind) -> usize {
    match kind {
        StorageKind::Double | StorageKind::Long => 8,
        StorageKind::Float | StorageKind::Int => 4,
        StorageKind::Half | StorageKind::BFloat16 | StorageKind::Short => 2,
        StorageKind::Char | StorageKind::Byte | StorageKind::Bool => 1,
    }
}

/// NumPy's type for such values; it has no `bfloat16`.
const fn dtype(storage: StorageKind, big_endian: bool) -> Option<Dtype> {
    let kind = match storage {
        StorageKind::Double | StorageKind::Float | StorageKind::Half => NumberKind::Float,
        StorageKind::BFloat16 => return None,
        StorageKind::Long | StorageKind::Int | StorageKind::Short | StorageKind::Char => {
            NumberKind::Signed
        }
        StorageKind::Byte => NumberKind::Unsigned,
        StorageKind::Bool => NumberKind::Bool,
    };
    Some(Dtype { kind, width: width(storage), big_endian })
}
