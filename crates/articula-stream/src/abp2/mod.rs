//! ABP-2: the motion of a character as a stream that is cut by bytes.
//!
//! The form is described in `docs/formats/abp2.md`, the encoder in `docs/methods/motion-stream.md`.
//! A stream has a head and access units of up to a second; an access unit has units of one group of
//! joints and one tier of tolerance each. A unit needs only the coarser tiers of its own group, so
//! that dropping units leaves a valid stream ([`motion_map`], [`crate::cut()`]), and any prefix of a
//! stream decodes. Head and units have checksums, which a cut leaves as they are.
//!
//! - [`encode()`], [`MotionOptions`]: a clip within a tolerance in metres of skin
//! - [`MotionReceiver`]: decodes what has arrived
//! - [`MotionHead`], [`motion_map`], [`prefix_map`]: what a stream, or a prefix of one, holds
//! - [`CarriedSkeleton`]: the joints, if a stream carries them
//!
//! ```
//! use articula_core::source::{Joint, Skeleton};
//! use articula_core::{Articulation, Clip, JointArticulation, Mesh, Region, Rig, Track, Tracks, Transform};
//! use articula_stream::abp2::{MotionOptions, MotionReceiver, encode, motion_map};
//! use articula_stream::{CutRule, StreamLimits, cut};
//! use glam::{Quat, Vec3};
//!
//! // A bar that turns by one radian in a second.
//! let bar = Joint { name: "bar".into(), parent: None, rest: Transform::default(), in_skin: true };
//! let known = JointArticulation { hanim: None, level: 0, region: Region::Torso };
//! let articulation = Articulation { profile: String::new(), joints: vec![known] };
//! let rig = Rig::new(&Skeleton { joints: vec![bar] }, articulation)?;
//! let turn = (0..31).map(|i| Quat::from_rotation_z(i as f32 / 30.0)).collect();
//! let tracks = Tracks {
//!     rotations: vec![Track { target: 0, step: false, values: turn }],
//!     ..Tracks::default()
//! };
//! let clip = Clip::new("turn", 30.0, 31, 1, tracks)?;
//!
//! let limits = StreamLimits::default();
//! let coded = encode(&rig, &Mesh::default(), &clip, &MotionOptions::default())?;
//! let received = MotionReceiver::read(&coded.bytes, &rig, &limits)?;
//! let shown = received.clip()?.tracks().rotations[0].values[30];
//! assert!(shown.angle_between(Quat::from_rotation_z(1.0)) < 1e-4 / 0.03 + 1e-3);
//!
//! // Tier 2 allows nine times the error, for fewer bytes.
//! let coarse = CutRule::default().at_least("tier", 2);
//! let shorter = cut(&coded.bytes, &coded.unit, |unit| coarse.keeps(unit))?;
//! assert!(shorter.bytes.len() < coded.bytes.len());
//! assert_eq!(motion_map(&shorter.bytes, &limits)?, shorter.unit);
//! # Ok::<(), articula_stream::StreamError>(())
//! ```

mod access_unit;
mod arrived;
mod contexts;
mod decode;
mod encode;
pub(crate) mod face_channels;
mod grouping;
mod head;
mod levels;
mod map;
mod motion_state;
mod places;
mod pose_unit;
mod receiver;
mod rotation;
mod shown;
mod skeleton;
mod start_contexts;
mod step;
mod tracks;
mod unit_form;
mod wavelet;

pub use encode::{EncodedMotion, ManifestRow, MotionOptions, SkinError, UnitOrder, encode};
pub use grouping::{Group, Grouping};
pub use head::{FaceHead, MotionHead};

pub(crate) use encode::encode_face;
pub use map::{motion_map, prefix_map};
pub use receiver::MotionReceiver;
pub use skeleton::CarriedSkeleton;
