//! Progressive streams of virtual humans: coded data of which any prefix is usable, and a
//! codec-independent map of a stream for cutting it.
//!
//! - [`Unit`], [`Marker`], [`Field`], [`Coding`]: which bits of a stream hold what, independent of
//!   the codec; numbers in them can be rewritten
//! - [`cut()`], [`CutRule`]: removes units from a stream, by its map alone
//! - [`selected`], [`difference()`], [`ByteRanges`]: which bytes a client must fetch to refine what it has
//! - [`write_index`], [`read_index`]: the map as bytes; [`cut_by_index`]: a cut by these, several times as fast
//! - [`description`]: descriptions after MPEG-21: of streams (gBSD), of their adaptation, of the context
//!   of use
//! - [`decide`]: what to send and to show, by network, device, view and user
//! - `mesh`: mesh levels as a progressive stream (cargo feature `codecs`, on by default)
//! - `abp1`: body animations that can be cut by bones, in a BBA-style form (`codecs`)
//! - `abp2`: body animations within a tolerance of the skin, that can be cut by joints and by tolerance
//!   (`codecs`)
//! - `afp1`: face animations that can be cut by parameters (`codecs`)
//! - `afp2`: face animations within a tolerance, in the units of `abp2` (`codecs`)
//! - `fba`: face animations as MPEG-4's binary stream, for interchange (`codecs`)
//! - [`StreamKind`]: which stream some bytes are
//! - `mp4`: MP4 files around these streams, and the streams in MP4 files (`codecs`)
//! - [`StreamError`], [`StreamLimits`]: errors, and limits on memory and time
//!
//! A program that only cuts streams disables the feature `codecs` and depends on neither codec, hash
//! nor JSON parser.
//!
//! ```
//! use articula_stream::{Coding, CutRule, Field, Meaning, Unit, cut};
//!
//! // A length byte, followed by that number of bytes: one of tier 1, then two of tier 0.
//! let stream = [3, 10, 20, 30];
//! let unit = Unit {
//!     fields: vec![Field {
//!         name: "length".into(),
//!         bits: 0..8,
//!         value: 3,
//!         coding: Coding::LittleEndian,
//!         meaning: Meaning::BytesAfter,
//!     }],
//!     children: vec![
//!         Unit::of_bytes("unit", 1..2).marked("tier", 1),
//!         Unit::of_bytes("unit", 2..4).marked("tier", 0),
//!     ],
//!     ..Unit::of_bytes("packet", 0..4)
//! };
//! unit.check()?;
//! unit.check_values(&stream)?;
//! let coarse = CutRule::default().at_least("tier", 1);
//! let shorter = cut(&stream, &unit, |unit| coarse.keeps(unit))?;
//! assert_eq!(shorter.bytes, [1, 10]);
//! # Ok::<(), articula_core::Mismatch>(())
//! ```
//!
//! Levels and tiers count from 0, the finest; the bytes start with the coarsest. Levels of
//! articulation count as in H-Anim, from the coarsest.
//!
//! There are no files, sockets, clocks or threads here: bytes in, bytes out, and time is an argument.
//! Codecs and cut decide nothing. No input causes a panic.

#[cfg(feature = "codecs")]
pub mod abp1;
#[cfg(feature = "codecs")]
pub mod abp2;
#[cfg(feature = "codecs")]
pub mod afp1;
#[cfg(feature = "codecs")]
pub mod afp2;
mod bits;
mod coding;
#[cfg(feature = "codecs")]
mod component;
#[cfg(feature = "codecs")]
mod container;
mod cut;
#[cfg(feature = "codecs")]
mod dct;
pub mod decide;
pub mod description;
mod error;
#[cfg(feature = "codecs")]
mod face;
#[cfg(feature = "codecs")]
pub mod fba;
#[cfg(feature = "codecs")]
mod frame_rate;
#[cfg(feature = "codecs")]
mod golomb;
mod increment;
mod index;
mod index_cut;
mod kind;
mod limits;
#[cfg(feature = "codecs")]
pub mod mesh;
#[cfg(feature = "codecs")]
pub mod mp4;
#[cfg(feature = "codecs")]
mod range_coder;
mod records;
mod unit;

pub use coding::Coding;
#[cfg(feature = "codecs")]
pub use component::CodingType;
pub use cut::{Cut, CutRule, cut};
pub use error::StreamError;
#[cfg(feature = "codecs")]
pub use face::{DecodedFace, FaceClip, FaceFrame, FaceReadOptions};
#[cfg(feature = "codecs")]
pub use frame_rate::FrameRate;
pub use increment::{ByteRanges, difference, selected};
pub use index::{read_index, write_index};
pub use index_cut::{IndexedCut, cut_by_index};
pub use kind::StreamKind;
pub use limits::{DescriptionLimits, StreamLimits};
pub use unit::{Field, Marker, Meaning, Unit};
