//! Arrays of vertices that primitives share: each is unpacked once.
//!
//! Exporters of VRM write a face's vertices and morph targets once, for a primitive for each material.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::Hash;
use std::sync::Arc;

use glam::Vec3;

use super::accessor::Accessors;
use super::appearance::UvSource;
use super::document;
use super::error::SceneError;
use super::geometry::{
    Displacements, Influences, first_at_position, influence_sets, read_colors, read_displacements,
    read_influences, read_triangles, vectors,
};

/// A UV set: its accessor, or none for zeros; its length, and how it is transformed.
pub(super) type UvKey = (Option<u32>, usize, Option<[u32; 5]>);

/// Triangles: their accessor, or none for all vertices in order; their mode, and the number of vertices.
pub(super) type TrianglesKey = (Option<u32>, u32, usize);

/// An array, which is read unless it is known.
pub(super) fn shared<K: Eq + Hash, T: ?Sized>(
    known: &mut HashMap<K, Arc<T>>,
    key: K,
    read: impl FnOnce() -> Result<Arc<T>, SceneError>,
) -> Result<Arc<T>, SceneError> {
    match known.entry(key) {
        Entry::Occupied(known) => Ok(Arc::clone(known.get())),
        Entry::Vacant(unknown) => Ok(Arc::clone(unknown.insert(read()?))),
    }
}

/// Reads arrays of a file, and remembers them by their accessors.
pub(super) struct SharedArrays<'s, 'a> {
    pub accessors: &'s mut Accessors<'a>,
    vectors: HashMap<u32, Arc<[Vec3]>>,
    first: HashMap<u32, Arc<[u32]>>,
    uv: HashMap<UvKey, Arc<[[f32; 2]]>>,
    colors: HashMap<u32, Arc<[[f32; 4]]>>,
    triangles: HashMap<TrianglesKey, Arc<[[u32; 3]]>>,
    displacements: HashMap<(u32, usize), Displacements>,
    influences: HashMap<(Vec<[u32; 2]>, usize), Arc<Influences>>,
}

impl<'s, 'a> SharedArrays<'s, 'a> {
    pub fn new(accessors: &'s mut Accessors<'a>) -> Self {
        Self {
            accessors,
            vectors: HashMap::new(),
            first: HashMap::new(),
            uv: HashMap::new(),
            colors: HashMap::new(),
            triangles: HashMap::new(),
            displacements: HashMap::new(),
            influences: HashMap::new(),
        }
    }

    /// - `wanted`: required number of elements, if known.
    pub fn vectors(
        &mut self,
        index: u32,
        wanted: Option<usize>,
    ) -> Result<Arc<[Vec3]>, SceneError> {
        let known = self.vectors.get(&index);
        if let Some(known) = known.filter(|it| wanted.is_none_or(|wanted| wanted == it.len())) {
            return Ok(Arc::clone(known));
        }
        let read: Arc<[Vec3]> = vectors(self.accessors.floats(index, wanted)?).into();
        self.vectors.insert(index, Arc::clone(&read));
        Ok(read)
    }

    /// For each vertex, the first vertex at its position.
    ///
    /// - `index`: accessor of `positions`.
    pub fn first_at_position(&mut self, index: u32, positions: &[Vec3]) -> Arc<[u32]> {
        let first = self.first.entry(index);
        Arc::clone(first.or_insert_with(|| first_at_position(positions).into()))
    }

    /// UV coordinates, transformed; zeros without an accessor.
    pub fn uv(
        &mut self,
        index: Option<u32>,
        count: usize,
        source: &UvSource,
    ) -> Result<Arc<[[f32; 2]]>, SceneError> {
        shared(&mut self.uv, (index, count, source.transform_bits()), || {
            let mut uv = match index {
                Some(index) => self.accessors.floats::<2>(index, Some(count))?,
                None => vec![[0.0; 2]; count],
            };
            source.transform(&mut uv);
            Ok(uv.into())
        })
    }

    /// Linear RGBA.
    pub fn colors(&mut self, index: u32, count: usize) -> Result<Arc<[[f32; 4]]>, SceneError> {
        if let Some(known) = self.colors.get(&index).filter(|known| known.len() == count) {
            return Ok(Arc::clone(known));
        }
        let read: Arc<[_]> = read_colors(index, count, self.accessors)?.into();
        self.colors.insert(index, Arc::clone(&read));
        Ok(read)
    }

    /// - `count`: number of vertices.
    pub fn triangles(
        &mut self,
        primitive: &document::Primitive,
        count: usize,
        place: &str,
    ) -> Result<Arc<[[u32; 3]]>, SceneError> {
        let key = (primitive.indices, primitive.mode.unwrap_or(4), count);
        shared(&mut self.triangles, key, || {
            Ok(read_triangles(primitive, count, place, self.accessors)?.into())
        })
    }

    pub fn displacements(&mut self, index: u32, count: usize) -> Result<Displacements, SceneError> {
        shared(&mut self.displacements, (index, count), || {
            read_displacements(index, count, self.accessors)
        })
    }

    pub fn influences(
        &mut self,
        primitive: &document::Primitive,
        count: usize,
    ) -> Result<Option<Arc<Influences>>, SceneError> {
        let key = (influence_sets(primitive), count);
        if let Some(known) = self.influences.get(&key) {
            return Ok(Some(Arc::clone(known)));
        }
        let Some(read) = read_influences(&key.0, count, self.accessors)? else { return Ok(None) };
        let read = Arc::new(read);
        self.influences.insert(key, Arc::clone(&read));
        Ok(Some(read))
    }
}
