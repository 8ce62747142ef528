//! Faces in a photograph, and the landmarks of each.
