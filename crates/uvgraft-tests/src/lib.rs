//! Shared by the tests and benches: synthetic pairs and textures, real data where available, and an
//! independent implementation to compare with.

#![forbid(unsafe_code)]

pub mod bodies;
pub mod browser;
pub mod clients;
pub mod downloads;
pub mod dressed;
pub mod fixtures;
pub mod gltf_transform;
pub mod greedy;
pub mod independent;
pub mod looks;
pub mod made_up;
pub mod mannequin;
pub mod mouths;
pub mod normal_bake;
pub mod photographed;
pub mod photographs;
pub mod pictures;
pub mod real;
pub mod remeshed;
pub mod shuffled;
pub mod strip;
pub mod synthetic;
pub mod walkers;

/// Runs the examples on the book's library page as a doc test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/src/library.md")]
pub struct LibraryPage;
