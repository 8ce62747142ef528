//! A body model that anyone may use: MakeHuman's base mesh, shapes and expressions (CC0), with the
//! joints of SMPL-X.

#![forbid(unsafe_code)]
