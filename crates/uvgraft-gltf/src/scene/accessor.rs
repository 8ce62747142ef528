//! Arrays in a file's buffers, checked against their real length before anything is allocated.
//!
//! # Source
//! Khronos, "glTF 2.0 Specification", section 3.6, "Binary Data Storage".

use super::asset::Bytes;
use super::budget::MAX_NUMBERS;
use super::check::{find, slice, too_many};
use super::document::{Accessor, Document};
use super::error::SceneError;

/// A file's arrays.
pub(super) struct Accessors<'a> {
    document: &'a Document,
    buffers: &'a [Bytes<'a>],
    decoded: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u32, place: &str) -> Result<Self, SceneError> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => {
                let reason = format!("component type must be 5120 to 5126, got {code}");
                return Err(SceneError::content(place, reason));
            }
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A stored number as a float; `normalized` integers are mapped to 0 to 1 or -1 to 1.
    fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let word = |k: usize| bytes.get(k).copied().unwrap_or(0);
        let two = [word(0), word(1)];
        let four = [word(0), word(1), word(2), word(3)];
        let (value, most) = match self {
            Self::F32 => return f32::from_le_bytes(four),
            Self::U32 => return u32::from_le_bytes(four) as f32,
            Self::I8 => (f32::from(word(0) as i8), 127.0),
            Self::U8 => (f32::from(word(0)), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes(two)), 32_767.0),
            Self::U16 => (f32::from(u16::from_le_bytes(two)), 65_535.0),
        };
        if normalized { (value / most).max(-1.0) } else { value }
    }

    fn uint(self, bytes: &[u8]) -> Option<u32> {
        let word = |k: usize| u32::from(bytes.get(k).copied().unwrap_or(0));
        match self {
            Self::U8 => Some(word(0)),
            Self::U16 => Some(word(0) | word(1) << 8),
            Self::U32 => Some(word(0) | word(1) << 8 | word(2) << 16 | word(3) << 24),
            _ => None,
        }
    }
}

/// Elements at a constant stride in a buffer, all within its bounds.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

/// Sparse replacements: indices, and new elements.
type Replacements<'a> = (Vec<u32>, Strided<'a>);

impl<'a> Accessors<'a> {
    pub const fn new(document: &'a Document, buffers: &'a [Bytes<'a>]) -> Self {
        Self { document, buffers, decoded: 0 }
    }

    /// Reads elements of `N` finite numbers each.
    ///
    /// - `wanted`: required number of elements, if known.
    pub fn floats<const N: usize>(
        &mut self,
        index: u32,
        wanted: Option<usize>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let values = self.elements::<_, N>(index, wanted, |component, bytes, normalized| {
            Some(component.float(bytes, normalized))
        })?;
        if let Some(at) = values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
            let reason = format!("element {at} must be finite, got {:?}", values[at]);
            return Err(SceneError::content(format!("accessor {index}"), reason));
        }
        Ok(values)
    }

    /// Reads elements of `N` unsigned integers each.
    pub fn uints<const N: usize>(
        &mut self,
        index: u32,
        wanted: Option<usize>,
    ) -> Result<Vec<[u32; N]>, SceneError> {
        self.elements(index, wanted, |component, bytes, _| component.uint(bytes))
    }

    /// - `number`: decodes a number, of which it receives the type, the bytes and whether it is
    ///   normalized; `None` for one that is not an unsigned integer.
    fn elements<T: Copy + Default, const N: usize>(
        &mut self,
        index: u32,
        wanted: Option<usize>,
        number: impl Fn(Component, &[u8], bool) -> Option<T>,
    ) -> Result<Vec<[T; N]>, SceneError> {
        let place = format!("accessor {index}");
        let (accessor, component) = self.checked::<N>(index, wanted, &place)?;
        let mut values = vec![[T::default(); N]; accessor.count as usize];
        let decode = |bytes: &[u8], value: &mut [T; N]| {
            for (value, bytes) in value.iter_mut().zip(bytes.chunks_exact(component.size())) {
                *value = number(component, bytes, accessor.normalized).ok_or_else(|| {
                    SceneError::content(place.as_str(), "must hold unsigned integers")
                })?;
            }
            Ok::<_, SceneError>(())
        };
        if let Some(dense) = self.dense(accessor, component.size() * N, &place)? {
            for (at, value) in values.iter_mut().enumerate() {
                decode(dense.element(at), value)?;
            }
        }
        if let Some((indices, sparse)) = self.sparse(accessor, component.size() * N, &place)? {
            for (at, &index) in indices.iter().enumerate() {
                decode(sparse.element(at), &mut values[index as usize])?;
            }
        }
        Ok(values)
    }

    /// Number of components of an element.
    pub fn width(&self, index: u32) -> Result<usize, SceneError> {
        width(self.accessor(index)?, &format!("accessor {index}"))
    }

    /// Number of elements, as stated.
    pub fn count(&self, index: u32) -> Result<usize, SceneError> {
        self.accessor(index).map(|accessor| usize::try_from(accessor.count).unwrap_or(usize::MAX))
    }

    /// The bytes of a buffer view, and its stride.
    pub fn view(&self, index: u32, place: &str) -> Result<(&'a [u8], Option<u64>), SceneError> {
        let views = &self.document.buffer_views;
        let view = find(views, index, "buffer view", place)?;
        let place = format!("buffer view {index}");
        let stored = (view.buffer, view.byte_offset, view.byte_length);
        Ok((slice(self.buffers, stored, &place)?, view.byte_stride))
    }

    fn accessor(&self, index: u32) -> Result<&'a Accessor, SceneError> {
        find(&self.document.accessors, index, "accessor", "the file")
    }

    /// An accessor, with type, count and total of decoded values checked.
    fn checked<const N: usize>(
        &mut self,
        index: u32,
        wanted: Option<usize>,
        place: &str,
    ) -> Result<(&'a Accessor, Component), SceneError> {
        let accessor = self.accessor(index)?;
        let component = Component::new(accessor.component_type, place)?;
        let found = width(accessor, place)?;
        if found != N {
            let reason =
                format!("must have {N} components, got {} ({found} components)", accessor.shape);
            return Err(SceneError::content(place, reason));
        }
        if let Some(wanted) = wanted
            && accessor.count != wanted as u64
        {
            let reason = format!("must have {wanted} elements, got {}", accessor.count);
            return Err(SceneError::content(place, reason));
        }
        let numbers = accessor.count.saturating_mul(N as u64);
        self.decoded = self.decoded.saturating_add(numbers);
        too_many("numbers in arrays", self.decoded, MAX_NUMBERS)?;
        Ok((accessor, component))
    }

    fn dense(
        &self,
        accessor: &Accessor,
        size: usize,
        place: &str,
    ) -> Result<Option<Strided<'a>>, SceneError> {
        let Some(view) = accessor.buffer_view else { return Ok(None) };
        self.strided(view, accessor.byte_offset, accessor.count, size, place).map(Some)
    }

    fn sparse(
        &mut self,
        accessor: &Accessor,
        size: usize,
        place: &str,
    ) -> Result<Option<Replacements<'a>>, SceneError> {
        let Some(sparse) = &accessor.sparse else { return Ok(None) };
        let component = Component::new(sparse.indices.component_type, place)?;
        let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
        let stored = self.strided(view, offset, sparse.count, component.size(), place)?;
        self.decoded = self.decoded.saturating_add(sparse.count);
        too_many("numbers in arrays", self.decoded, MAX_NUMBERS)?;
        let mut indices = Vec::with_capacity(sparse.count as usize);
        for at in 0..sparse.count as usize {
            let index = component.uint(stored.element(at));
            match index.filter(|&index| u64::from(index) < accessor.count) {
                Some(index) => indices.push(index),
                None => {
                    let reason = format!(
                        "sparse index {at} must be less than {}, got {index:?}",
                        accessor.count
                    );
                    return Err(SceneError::content(place, reason));
                }
            }
        }
        let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
        let values = self.strided(view, offset, sparse.count, size, place)?;
        Ok(Some((indices, values)))
    }

    fn strided(
        &self,
        view: u32,
        offset: u64,
        count: u64,
        size: usize,
        place: &str,
    ) -> Result<Strided<'a>, SceneError> {
        let (bytes, stride) = self.view(view, place)?;
        let stride = stride.unwrap_or(size as u64);
        if stride < size as u64 || stride > 4096 {
            let reason = format!(
                "stride must be at least the element size of {size} bytes and at most 4096, got \
                 {stride}"
            );
            return Err(SceneError::content(place, reason));
        }
        // The last element need not be padded to the stride.
        let end = match count {
            0 => Some(offset),
            _ => (count - 1)
                .checked_mul(stride)
                .and_then(|length| length.checked_add(size as u64))
                .and_then(|length| length.checked_add(offset)),
        };
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let found = bytes.len();
            let reason = format!(
                "{count} elements of {size} bytes at offset {offset} exceed buffer view {view}, \
                 which has {found} bytes"
            );
            return Err(SceneError::content(place, reason));
        }
        Ok(Strided { bytes: &bytes[offset as usize..], stride: stride as usize, size })
    }
}

fn width(accessor: &Accessor, place: &str) -> Result<usize, SceneError> {
    Ok(match accessor.shape.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        other => {
            let reason = format!("type must be SCALAR, VEC2 to VEC4 or MAT4, got {other:?}");
            return Err(SceneError::content(place, reason));
        }
    })
}
