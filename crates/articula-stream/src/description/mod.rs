//! Descriptions of streams, of their adaptation and of the context of use, after MPEG-21 (digital
//! item declaration, ISO/IEC 21000-2, and digital item adaptation, ISO/IEC 21000-7).
//!
//! - [`write_gbsd`], [`read_gbsd`]: the map of a stream as XML
//! - [`gbsd_to_bin`]: from a description and the original stream to the stream described
//! - [`Selection`], [`adapt_gbsd`], [`stylesheet()`]: what to keep, and the transformation of a
//!   description by it, here or by an XSLT processor
//! - [`Context`]: what is known of network, device, viewer and view
//!
//! All documents are read within [`crate::DescriptionLimits`]; document types and with them entities
//! are refused, and nothing is ever fetched.

mod context;
mod gbsd;
mod xml;

pub use context::{Context, Modality, Network, Preferences, Terminal, View};
pub use gbsd::{
    AdaptMode, FixedParameter, Gbsd, GbsdOptions, Holes, Selection, adapt_gbsd, gbsd_to_bin,
    read_gbsd, stylesheet, write_gbsd,
};
