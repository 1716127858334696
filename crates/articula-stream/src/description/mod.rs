//! Descriptions of streams, of their adaptation and of the context of use, after MPEG-21 (digital
//! item declaration, ISO/IEC 21000-2, and digital item adaptation, ISO/IEC 21000-7).
//!
//! - [`write_gbsd`], [`read_gbsd`]: the map of a stream as XML
//! - [`gbsd_to_bin`]: from a description and the original stream to the stream described
//! - [`Selection`], [`adapt_gbsd`], [`stylesheet()`]: what to keep, and the transformation of a
//!   description by it, here or by an XSLT processor
//! - [`Context`]: what is known of network, device, viewer and view
//! - [`Aqos`]: tables by which the parameters of an adaptation follow from a context
//! - [`Did`], [`BsdLink`]: the resources of a digital item, and what adapts them
//!
//! The step from content to what a client gets: of a [`Did`] a [`BsdLink`] names [`Aqos`] and gBSD;
//! [`Aqos::bind`] and [`Aqos::decide`] give values for a [`Context`], [`BsdLink::selection`] a
//! [`Selection`], which [`crate::cut()`] takes with the map of the stream, or [`adapt_gbsd`] and
//! [`gbsd_to_bin`] with its description: the bytes are the same.
//!
//! All documents are read within [`crate::DescriptionLimits`]; document types and with them entities
//! are refused, and nothing is ever fetched.

mod aqos;
mod bsd_link;
mod context;
mod did;
mod gbsd;
mod item_path;
mod xml;

pub use aqos::{
    Aqos, Axis, BANDWIDTH, Column, Constraints, Content, Decided, Expression, IoPin, LAYERS,
    LookUpTable, Module, Objective, Pins, StackFunction, Term, UtilityFunction,
};
pub use bsd_link::BsdLink;
pub use context::{Benchmark, Context, Modality, Network, Preferences, Terminal, View};
pub use did::{Did, DidComponent, DidDescriptor, DidItem, DidResource};
pub use gbsd::{
    AdaptMode, FixedParameter, Gbsd, GbsdOptions, Holes, Selection, adapt_gbsd, gbsd_to_bin,
    read_gbsd, stylesheet, write_gbsd,
};
pub use item_path::ItemPath;
