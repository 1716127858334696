//! An item played over a recorded bandwidth: what a client asks for, what its receivers show, and how far
//! that is from the whole character.
//!
//! Method: `docs/methods/adaptation.md`, part 6. Time is an argument: the clock is virtual.
//!
//! ```text
//! Item, Context, TraceOptions ─ TracePlayer::new ─▶ TracePlayer
//! TracePlayer, BandwidthTrace, TracePolicy ─ TracePlayer::play ─▶ TracePlayback
//! ```
//!
//! - `options`, `playback`: what is asked, and what it gives
//! - `timeline`, `content`: what plays when, and what can be fetched for it
//! - `view`, `joint`, `thesis`, `versions`: policies
//! - `stage`, `client`, `judge`: receivers, what they show, and its error
//! - `player`: the virtual clock

mod client;
mod content;
mod joint;
mod judge;
mod options;
mod playback;
mod player;
mod stage;
mod thesis;
mod timeline;
mod versions;
mod view;

pub use options::TraceOptions;
pub use playback::{TracePlayback, TracePolicy, TraceSample};

use super::adapt::applied_regions;
use super::files::Item;
use crate::error::{Context as _, Result};
use articula_stream::decide::BandwidthTrace;
use articula_stream::description::Context;
use content::Content;
use joint::JointChoice;
use judge::Judge;
use player::Player;
use stage::Stage;
use thesis::ThesisRatio;
use versions::ByLevel;
use view::Policy;

/// Plays an item over traces of bandwidth.
///
/// All policies get the same layers by ranges of bytes, one request at a time, and keep what they have;
/// they differ in what they ask for. Motions play one after the other.
pub struct TracePlayer {
    content: Content,
    stage: Stage,
    judge: Judge,
    options: TraceOptions,
}

impl std::fmt::Debug for TracePlayer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let item = &self.content.item.manifest.name;
        f.debug_struct("TracePlayer")
            .field("item", item)
            .field("options", &self.options)
            .finish_non_exhaustive()
    }
}

impl TracePlayer {
    /// Prepares an item for a view, a device and wishes; the bandwidth of the context does not count.
    /// Regions that these leave out are not sent, and count in the error.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names what is out of its bounds, or the file of the item that is
    /// malformed; if the item has no motion, or streams without ranges of bytes; if the context gets no
    /// 3D.
    pub fn new(item: &Item, context: &Context, options: &TraceOptions) -> Result<Self> {
        options.check()?;
        context.check()?;
        let sent = applied_regions(item, &context.preferences)?.without_flat();
        let stage = Stage::of(item).context(&item.manifest.name)?;
        Ok(Self {
            judge: Judge::of(item, &stage)?,
            content: Content::of(sent, context, options)?,
            stage,
            options: *options,
        })
    }

    /// Plays from nothing. The same input gives the same playback.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the stream that is malformed.
    pub fn play(&mut self, trace: &BandwidthTrace, policy: TracePolicy) -> Result<TracePlayback> {
        let mut decides: Box<dyn Policy> = match policy {
            TracePolicy::Joint => Box::new(JointChoice::new()),
            TracePolicy::Thesis => Box::new(ThesisRatio::new(self.options.adapt.wait_secs)),
            TracePolicy::Rate => Box::new(ByLevel::rate()),
            TracePolicy::Buffer => Box::new(ByLevel::buffer()),
        };
        let parts = (&self.content, &self.stage, &mut self.judge);
        Player::new(parts, trace, &self.options).play(policy, decides.as_mut())
    }
}
