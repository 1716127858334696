//! Animations as streams that can be cut: conversion of the clips of characters and faces.
//!
//! - [`sniff`]: which stream some bytes are
//! - [`abp1`]: the motion of a character as ABP-1, and back
//! - [`afp1`]: facial animation parameters as AFP-1, and back
//!
//! The streams themselves, and the map by which they are cut, are those of `articula_stream`.

pub mod abp1;
pub mod afp1;

/// A stream of an animation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKind {
    /// Bones, BBA-style, profile ABP-1.
    Abp1,
    /// Facial animation parameters, profile AFP-1.
    Afp1,
}

/// Returns which stream some bytes are, by how they begin.
pub fn sniff(bytes: &[u8]) -> Option<StreamKind> {
    match bytes.first_chunk()? {
        b"ABPF" => Some(StreamKind::Abp1),
        b"AFPF" => Some(StreamKind::Afp1),
        _ => None,
    }
}
