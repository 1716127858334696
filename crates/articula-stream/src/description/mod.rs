//! Descriptions of streams, of their adaptation and of the context of use, after MPEG-21 (digital
//! item declaration, ISO/IEC 21000-2, and digital item adaptation, ISO/IEC 21000-7).
//!
//! - [`Context`]: what is known of network, device, viewer and view

mod context;

pub use context::{Context, Modality, Network, Preferences, Terminal, View};
