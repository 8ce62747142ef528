//! From photographs of a face to the texture and the shape of a head.
//!
//! [`network`] runs small neural networks, and [`landmarks`] finds faces and their 468 landmarks
//! with two of them.

#![forbid(unsafe_code)]

pub mod landmarks;
pub mod network;
