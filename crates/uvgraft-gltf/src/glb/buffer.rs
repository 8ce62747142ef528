//! Builds the binary chunk of a file: bytes, buffer views into them, and accessors of the views.

use super::json::{
    Accessor, BufferView, FLOAT, Sparse, SparseIndices, SparseValues, UNSIGNED_INT, UNSIGNED_SHORT,
};

/// Alignment of views, in bytes; suits every component type.
const ALIGNMENT: usize = 4;

#[derive(Default)]
pub(super) struct Buffer {
    pub bytes: Vec<u8>,
    pub views: Vec<BufferView>,
    pub accessors: Vec<Accessor>,
}

/// The values of one animation sampler, stored in a view shared with others.
pub(super) struct Track {
    pub values: Vec<f32>,
    /// Components of an element.
    pub components: usize,
    /// Whether the accessor has `min` and `max`, which sampler inputs require.
    pub bounds: bool,
}

impl Buffer {
    /// Appends bytes as a view; returns its index.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.align();
        let byte_offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.views.push(BufferView { buffer: 0, byte_offset, byte_length: bytes.len(), target });
        self.views.len() - 1
    }

    fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
    }

    /// Appends vectors as an accessor; returns its index.
    pub fn floats<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        target: Option<u32>,
        bounds: bool,
    ) -> usize {
        let view = self.view(&float_bytes(values.as_flattened()), target);
        let (min, max) =
            if bounds { extremes(values.as_flattened(), N) } else { Default::default() };
        self.accessor(Accessor { min, max, ..plain(view, FLOAT, values.len(), kind(N)) })
    }

    /// Appends indices as an accessor, as 16-bit integers if they fit, else 32-bit.
    pub fn indices(&mut self, indices: &[u32], target: Option<u32>) -> usize {
        let (component_type, bytes) = index_bytes(indices);
        let view = self.view(&bytes, target);
        self.accessor(plain(view, component_type, indices.len(), "SCALAR"))
    }

    /// Appends already encoded integers as an accessor of four-component vectors.
    pub fn vec4s(&mut self, bytes: &[u8], component_type: u32, count: usize, target: u32) -> usize {
        let view = self.view(bytes, Some(target));
        self.accessor(plain(view, component_type, count, "VEC4"))
    }

    /// Appends an accessor of `count` offsets, sparse where that is smaller; vertices not listed
    /// have offset 0.
    ///
    /// - `offsets`: vertices, in ascending order, with their offsets.
    pub fn offsets(&mut self, offsets: &[(u32, [f32; 3])], count: usize, bounds: bool) -> usize {
        // Sparse accessors without entries are allowed, but not every reader supports them.
        let nothing = [(0, [0.0; 3])];
        let offsets = if offsets.is_empty() { &nothing } else { offsets };
        let vertices: Vec<u32> = offsets.iter().map(|&(vertex, _)| vertex).collect();
        let values: Vec<[f32; 3]> = offsets.iter().map(|&(_, value)| value).collect();
        let (component_type, indices) = index_bytes(&vertices);
        const VALUE_BYTES: usize = 12;
        if indices.len() + values.len() * VALUE_BYTES >= count * VALUE_BYTES {
            let mut dense = vec![[0.0; 3]; count];
            for &(vertex, value) in offsets {
                dense[vertex as usize] = value;
            }
            return self.floats(&dense, Some(super::json::ARRAY_BUFFER), bounds);
        }
        let (mut min, mut max) = (Vec::new(), Vec::new());
        if bounds {
            // Bounds include the zero offset of unlisted vertices.
            let stay = if values.len() < count { &[[0.0; 3]][..] } else { &[] };
            (min, max) = extremes([&values[..], stay].concat().as_flattened(), 3);
        }
        let indices = SparseIndices { buffer_view: self.view(&indices, None), component_type };
        let bytes = float_bytes(values.as_flattened());
        let values = SparseValues { buffer_view: self.view(&bytes, None) };
        let sparse = Some(Sparse { count: vertices.len(), indices, values });
        let (component_type, kind) = (FLOAT, "VEC3");
        let dense = Accessor { component_type, count, kind, min, max, ..Accessor::default() };
        self.accessor(Accessor { sparse, ..dense })
    }

    /// Appends tracks as one view with one accessor each; returns their indices.
    pub fn tracks(&mut self, tracks: &[Track]) -> Vec<usize> {
        let all: Vec<f32> = tracks.iter().flat_map(|track| &track.values).copied().collect();
        let view = self.view(&float_bytes(&all), None);
        let mut byte_offset = 0;
        let mut numbers = Vec::with_capacity(tracks.len());
        for Track { values, components, bounds } in tracks {
            let (min, max) =
                if *bounds { extremes(values, *components) } else { Default::default() };
            let count = values.len() / components;
            let accessor = plain(view, FLOAT, count, kind(*components));
            numbers.push(self.accessor(Accessor { byte_offset, min, max, ..accessor }));
            byte_offset += values.len() * size_of::<f32>();
        }
        numbers
    }

    fn accessor(&mut self, accessor: Accessor) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn plain(view: usize, component_type: u32, count: usize, kind: &'static str) -> Accessor {
    let buffer_view = Some(view);
    Accessor { buffer_view, component_type, count, kind, ..Accessor::default() }
}

const fn kind(components: usize) -> &'static str {
    match components {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

/// Minimum and maximum of each component.
fn extremes(values: &[f32], components: usize) -> (Vec<f32>, Vec<f32>) {
    let (mut min, mut max) = (vec![f32::INFINITY; components], vec![f32::NEG_INFINITY; components]);
    for element in values.chunks_exact(components) {
        for (k, &value) in element.iter().enumerate() {
            min[k] = min[k].min(value);
            max[k] = max[k].max(value);
        }
    }
    (min, max)
}

fn float_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Encodes as 16 bits unless an index reaches 65535, which some graphics APIs treat as primitive
/// restart.
fn index_bytes(indices: &[u32]) -> (u32, Vec<u8>) {
    if indices.iter().all(|&index| index < u32::from(u16::MAX)) {
        let bytes = indices.iter().flat_map(|&index| (index as u16).to_le_bytes());
        (UNSIGNED_SHORT, bytes.collect())
    } else {
        (UNSIGNED_INT, indices.iter().flat_map(|index| index.to_le_bytes()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_aligned_and_bounds_exact() {
        let mut buffer = Buffer::default();
        assert_eq!(buffer.view(&[1, 2, 3], None), 0);
        let accessor = buffer.floats(&[[1.0, -2.0], [0.5, 4.0]], None, true);
        let BufferView { byte_offset, byte_length, .. } = buffer.views[1];
        assert_eq!((byte_offset, byte_length), (4, 16));
        assert_eq!(buffer.bytes[..8], [1, 2, 3, 0, 0, 0, 0x80, 0x3f]);
        let Accessor { min, max, count, kind, .. } = &buffer.accessors[accessor];
        assert_eq!((&min[..], &max[..], *count), (&[0.5, -2.0][..], &[1.0, 4.0][..], 2));
        assert_eq!(*kind, "VEC2");
    }

    #[test]
    fn indices_are_as_narrow_as_they_can_be() {
        let mut buffer = Buffer::default();
        buffer.indices(&[0, 65_534], None);
        buffer.indices(&[0, 65_535], None);
        let types: Vec<u32> = buffer.accessors.iter().map(|a| a.component_type).collect();
        assert_eq!(types, [UNSIGNED_SHORT, UNSIGNED_INT]);
    }

    #[test]
    fn few_offsets_are_sparse_and_many_are_not() {
        let mut buffer = Buffer::default();
        let offset = |vertex| (vertex, [1.0, 2.0, -3.0]);
        buffer.offsets(&[offset(7)], 100, true);
        let few = &buffer.accessors[0];
        assert_eq!((&few.min[..], &few.max[..]), (&[0.0, 0.0, -3.0][..], &[1.0, 2.0, 0.0][..]));
        assert!(few.sparse.as_ref().is_some_and(|sparse| sparse.count == 1));
        // An offset takes 14 bytes sparse and 12 dense, so dense is smaller from 6 of 7 on.
        let many: Vec<_> = (0..6).map(offset).collect();
        buffer.offsets(&many, 7, true);
        assert!(buffer.accessors[1].sparse.is_none());
        buffer.offsets(&many[..5], 7, true);
        assert!(buffer.accessors[2].sparse.is_some());
    }
}
