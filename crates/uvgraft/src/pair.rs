//! Two layouts and their links: what a sampling map of any size is made from.

use crate::correspond::{Link, LinkError, link_by_vertices};
use crate::mesh::Mesh;

/// Two meshes and which of their triangles are the same surface. Resolution-free, and the same for
/// both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    source: Mesh,
    target: Mesh,
    links: Vec<Link>,
}

/// Which way a texture is carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Direction {
    /// From the pair's source to its target.
    Forward,
    /// From the pair's target to its source.
    Reverse,
}

impl Direction {
    /// The way back.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }
}

/// Links that do not fit their meshes; only from parts read from a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PairError {
    /// A link names a face that is not there, or corners that are no permutation.
    #[error("link {link} does not fit the meshes: {found:?}")]
    Link {
        /// Which link.
        link: usize,
        /// What it says.
        found: Link,
    },
    /// Links are sorted by target face, then source face, each once.
    #[error("link {link} is out of order")]
    Order {
        /// Which link.
        link: usize,
    },
}

/// A pair seen in one direction.
pub(crate) struct Oriented<'a> {
    pub from: &'a Mesh,
    pub to: &'a Mesh,
    /// For each face of `to`, its counterpart.
    pub from_face: Vec<Option<Counterpart>>,
}

impl<'a> Oriented<'a> {
    /// A mesh whose every face answers itself.
    pub fn identity(mesh: &'a Mesh) -> Self {
        let itself = |face| Some(Counterpart { face, corners: [0, 1, 2] });
        let from_face = (0..mesh.faces().len() as u32).map(itself).collect();
        Self { from: mesh, to: mesh, from_face }
    }
}

/// The face that answers a face, and which of its corners is which.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counterpart {
    pub face: u32,
    /// Corner `k` of the answered face is corner `corners[k]` of this one.
    pub corners: [u8; 3],
}

impl Pair {
    /// Links two meshes whose vertices correspond.
    ///
    /// - `vertex_map`: `[source vertices]`, for each the target vertex it is, or -1 for none.
    ///
    /// Faces are recognised by their vertices, whatever corner they start at and whichever way they
    /// wind. Polygons may be triangulated anew where the two meshes chose different diagonals.
    ///
    /// # Errors
    /// [`LinkError`] for a map of the wrong length or with entries out of range, or if no face
    /// matches.
    pub fn by_vertex_map(
        mut source: Mesh,
        mut target: Mesh,
        vertex_map: &[i64],
    ) -> Result<Self, LinkError> {
        let links = link_by_vertices(&mut source, &mut target, vertex_map)?;
        Ok(Self { source, target, links })
    }

    /// Puts a pair together from parts that were saved.
    ///
    /// # Errors
    /// [`PairError`] if the links do not fit the meshes.
    pub fn from_links(source: Mesh, target: Mesh, links: Vec<Link>) -> Result<Self, PairError> {
        for (index, &found) in links.iter().enumerate() {
            let mut sorted = found.corners;
            sorted.sort_unstable();
            if found.source as usize >= source.faces().len()
                || found.target as usize >= target.faces().len()
                || sorted != [0, 1, 2]
            {
                return Err(PairError::Link { link: index, found });
            }
            if index > 0 && links[index - 1] >= found {
                return Err(PairError::Order { link: index });
            }
        }
        Ok(Self { source, target, links })
    }

    /// The mesh that textures come from in [`Direction::Forward`].
    pub fn source(&self) -> &Mesh {
        &self.source
    }

    /// The mesh that textures go to in [`Direction::Forward`].
    pub fn target(&self) -> &Mesh {
        &self.target
    }

    /// The linked triangles, in the order of their target face.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The mesh whose layout a texture comes from.
    pub fn from(&self, direction: Direction) -> &Mesh {
        match direction {
            Direction::Forward => &self.source,
            Direction::Reverse => &self.target,
        }
    }

    /// The mesh whose layout a texture goes to.
    pub fn to(&self, direction: Direction) -> &Mesh {
        match direction {
            Direction::Forward => &self.target,
            Direction::Reverse => &self.source,
        }
    }

    pub(crate) fn oriented(&self, direction: Direction) -> Oriented<'_> {
        let (from, to) = (self.from(direction), self.to(direction));
        let mut from_face = vec![None; to.faces().len()];
        for link in &self.links {
            let (answered, counterpart) = match direction {
                Direction::Forward => {
                    (link.target, Counterpart { face: link.source, corners: link.corners })
                }
                Direction::Reverse => {
                    let mut corners = [0; 3];
                    for (k, &corner) in link.corners.iter().enumerate() {
                        corners[corner as usize] = k as u8;
                    }
                    (link.source, Counterpart { face: link.target, corners })
                }
            };
            // Where several faces could answer, the first one does.
            from_face[answered as usize].get_or_insert(counterpart);
        }
        Oriented { from, to, from_face }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let positions = uv.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap()
    }

    #[test]
    fn reverse_inverts_the_corners() {
        let pair = Pair::by_vertex_map(triangle(), triangle(), &[1, 2, 0]).unwrap();
        let forward = pair.oriented(Direction::Forward).from_face[0].unwrap();
        let reverse = pair.oriented(Direction::Reverse).from_face[0].unwrap();
        assert_eq!(forward.corners, [2, 0, 1]);
        assert_eq!(reverse.corners, [1, 2, 0]);
    }

    #[test]
    fn refuses_links_that_do_not_fit() {
        let link = |source, target, corners| Link { source, target, corners };
        let build = |links| Pair::from_links(triangle(), triangle(), links);
        assert!(build(vec![link(0, 0, [2, 1, 0])]).is_ok());
        for bad in [link(1, 0, [0, 1, 2]), link(0, 1, [0, 1, 2]), link(0, 0, [0, 1, 1])] {
            assert_eq!(build(vec![bad]), Err(PairError::Link { link: 0, found: bad }));
        }
        let twice = link(0, 0, [0, 1, 2]);
        assert_eq!(build(vec![twice, twice]), Err(PairError::Order { link: 1 }));
    }
}
