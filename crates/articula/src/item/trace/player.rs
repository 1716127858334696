//! The virtual player: a clock, one request in flight, and playback that waits for what is missing.

use super::client::Client;
use super::content::Content;
use super::judge::Judge;
use super::options::TraceOptions;
use super::playback::{TracePlayback, TracePolicy, TraceSample};
use super::stage::Stage;
use super::timeline::FrameOf;
use super::view::{Action, Policy, View};
use crate::error::Result;
use crate::item::adapt::texture_error_px;
use crate::item::delivery::PieceOf;
use crate::item::delivery::{is_motion, largest, mesh_level};
use crate::item::part::PartKind;
use articula_stream::decide::{BandwidthTrace, Transfer};

/// Time without asking a policy that waits, seconds.
const WAIT_SECS: f64 = 0.1;
/// Times that differ by less are equal, seconds.
const SAME_SECS: f64 = 1e-9;

/// State of a playback.
pub(super) struct Player<'a> {
    content: &'a Content,
    stage: &'a Stage,
    judge: &'a mut Judge,
    trace: &'a BandwidthTrace,
    options: &'a TraceOptions,
    client: Client<'a>,
    now: f64,
    position: f64,
    /// Number of plays that have begun.
    begun: usize,
    is_playing: bool,
    startup: Option<f64>,
    stalls: usize,
    stall_secs: f64,
    /// Time of the stall of the moment so far.
    waited: f64,
    /// Bytes of pieces that were given up.
    given_up: u64,
    samples: Vec<TraceSample>,
}

impl<'a> Player<'a> {
    pub(super) fn new(
        (content, stage, judge): (&'a Content, &'a Stage, &'a mut Judge),
        trace: &'a BandwidthTrace,
        options: &'a TraceOptions,
    ) -> Self {
        Self {
            content,
            stage,
            judge,
            trace,
            options,
            client: Client::new(content, stage),
            now: 0.0,
            position: 0.0,
            begun: 0,
            is_playing: false,
            startup: None,
            stalls: 0,
            stall_secs: 0.0,
            waited: 0.0,
            given_up: 0,
            samples: Vec::new(),
        }
    }

    /// Plays until the time is over.
    pub(super) fn play(
        mut self,
        which: TracePolicy,
        policy: &mut dyn Policy,
    ) -> Result<TracePlayback> {
        // It tells what else there is.
        let manifest = self.content.delivery.catalogue.find(PieceOf::Manifest);
        let manifest: Vec<usize> = manifest.into_iter().collect();
        let transfer = self.fetch(&manifest, f64::INFINITY)?;
        policy.transferred(&transfer);
        while self.now < self.options.secs {
            let view = View {
                now_secs: self.now,
                position_secs: self.position,
                next_play: self.begun,
                has: &self.client.has,
                content: self.content,
                capacity_bps: self.trace.at(self.now),
            };
            match policy.next(&view) {
                Action::Wait => self.advance(self.now + WAIT_SECS)?,
                Action::Fetch(pieces, give_up_secs) => {
                    let transfer = self.fetch(&pieces, give_up_secs)?;
                    policy.transferred(&transfer);
                }
            }
        }
        self.sample_until(self.options.secs)?;
        Ok(TracePlayback {
            policy: which,
            startup_secs: self.startup,
            stalls: self.stalls,
            stall_secs: self.stall_secs,
            bytes: self.client.bytes + self.given_up,
            unused_bytes: self.unused_bytes() + self.given_up,
            levels: self.content.delivery.ladder.levels.len(),
            samples: self.samples,
        })
    }

    /// Plays while a request is in flight; its pieces come one after the other.
    fn fetch(&mut self, pieces: &[usize], give_up_secs: f64) -> Result<Transfer> {
        let first_byte_secs = self.now + self.options.latency_secs;
        let until = give_up_secs.max(first_byte_secs).min(self.options.secs);
        let mut last_byte_secs = first_byte_secs;
        let mut bytes = 0;
        for piece in pieces {
            let of_piece = self.content.delivery.catalogue.pieces[*piece].bytes;
            let bits = 8.0 * (bytes + of_piece) as f64;
            let finish = self.trace.finish(first_byte_secs, bits);
            last_byte_secs = finish.max(first_byte_secs).min(until);
            self.advance(last_byte_secs)?;
            if finish > until {
                let through = self.trace.bits(first_byte_secs, until) / 8.0;
                let given_up = (through as u64).saturating_sub(bytes).min(of_piece);
                self.given_up += given_up;
                bytes += given_up;
                break;
            }
            bytes += of_piece;
            if !self.client.has[*piece] {
                self.client.take(*piece)?;
            }
            self.resume();
        }
        // A request takes time, whatever it brings.
        self.advance(first_byte_secs)?;
        Ok(Transfer {
            bytes,
            first_byte_secs,
            last_byte_secs,
        })
    }

    /// Moves the clock, plays, and samples.
    fn advance(&mut self, until: f64) -> Result<()> {
        while self.now < until - SAME_SECS {
            let step = until - self.now;
            if !self.is_playing {
                self.sample_until(until)?;
                if self.startup.is_some() && self.begun < self.content.timeline.plays.len() {
                    self.stall_secs += step;
                    self.waited += step;
                }
                self.now = until;
                break;
            }
            let border = self.content.timeline.plays[self.begun - 1].end_secs;
            let left = border - self.position;
            if left < step {
                self.sample_until(self.now + left)?;
                self.now += left;
                self.position = border;
                self.begin_play();
            } else {
                self.sample_until(until)?;
                self.now = until;
                self.position += step;
            }
        }
        Ok(())
    }

    /// At the end of a play: begins the next one, or waits for it.
    fn begin_play(&mut self) {
        let plays = &self.content.timeline.plays;
        match plays.get(self.begun) {
            Some(play) if self.content.is_ready(&self.client.has, play) => self.begun += 1,
            Some(_) => {
                self.is_playing = false;
                self.stalls += 1;
                self.waited = 0.0;
            }
            None => self.is_playing = false,
        }
    }

    /// Goes on if what was waited for is there.
    fn resume(&mut self) {
        let next = self.content.timeline.plays.get(self.begun);
        let is_ready = next.is_some_and(|play| self.content.is_ready(&self.client.has, play));
        if !self.is_playing && is_ready {
            self.is_playing = true;
            self.startup.get_or_insert(self.now);
            self.begun += 1;
            self.waited = 0.0;
        }
    }

    /// Takes the samples from now up to a time, up to which nothing changes but the time.
    fn sample_until(&mut self, until: f64) -> Result<()> {
        loop {
            let secs = self.samples.len() as f64 * self.options.sample_secs;
            if secs > until || secs > self.options.secs {
                return Ok(());
            }
            let sample = self.sample(secs)?;
            self.samples.push(sample);
        }
    }

    fn sample(&mut self, secs: f64) -> Result<TraceSample> {
        let content = self.content;
        let timeline = &content.timeline;
        let since = (secs - self.now).max(0.0);
        let position = self.position + if self.is_playing { since } else { 0.0 };
        let view = View {
            now_secs: secs,
            position_secs: position,
            next_play: self.begun,
            has: &self.client.has,
            content,
            capacity_bps: 0.0,
        };
        let mut sample = TraceSample {
            secs,
            bandwidth_bps: self.trace.at(secs),
            bytes: self.client.bytes + self.given_up,
            is_playing: self.is_playing,
            position_secs: position,
            buffer_secs: view.buffer_secs(),
            ..TraceSample::default()
        };
        if self.startup.is_none() || self.begun == 0 {
            return Ok(sample);
        }
        let play = self.begun - 1;
        let shown = timeline.frame_of(play, position);
        // While playback waits, time goes on.
        let lost = if self.is_playing {
            0.0
        } else {
            self.waited + since
        };
        let truth = match lost > 0.0 {
            true => timeline.frame_at(position + lost),
            false => shown,
        };
        self.describe(&mut sample, play);
        self.measure(&mut sample, (shown, truth), timeline.plays[play].unit)?;
        Ok(sample)
    }

    /// The layers that are shown.
    fn describe(&self, sample: &mut TraceSample, play: usize) {
        let (content, has) = (self.content, &self.client.has);
        let play = &content.timeline.plays[play];
        let (part, of) = content.motion_part(play.motion);
        let levels = content.delivery.ladder.levels.iter();
        let complete = levels.take_while(|level| {
            content.delivery.missing_of_shape(has, level).is_empty()
                && content.missing_of_unit(has, play, &level[part]).is_empty()
        });
        sample.level = complete.count();
        let there = content.delivery.layers_there(has, part, Some(play.unit));
        let loa = |layer: usize| {
            let keep = &of.layers[layer].keep;
            keep.get("loa").or_else(|| keep.get("face_loa")).copied()
        };
        let shown = || (0..there.len()).filter(|layer| there[*layer]);
        sample.loa = shown().filter_map(loa).max();
        let of_loa = shown().filter(|layer| loa(*layer) == sample.loa);
        sample.tier = of_loa
            .filter_map(|l| of.layers[l].keep.get("tier").copied())
            .min();
        for (index, part) in content.parts().filter(|(_, part)| !is_motion(part)) {
            let there = content.delivery.layers_there(has, index, None);
            if part.kind == PartKind::Texture {
                let px = largest(part, &there);
                sample.texture_px = Some(sample.texture_px.map_or(px, |least| least.min(px)));
            } else {
                sample.mesh_level = mesh_level(part, &there);
            }
        }
    }

    fn measure(
        &mut self,
        sample: &mut TraceSample,
        frames: (FrameOf, FrameOf),
        unit: usize,
    ) -> Result<()> {
        let content = self.content;
        let stage = (content, self.stage);
        let error_m = self.judge.error_m(stage, &mut self.client, frames, unit)?;
        let skin = error_m * content.pixels_per_metre;
        let textures = content
            .parts()
            .filter(|(_, part)| part.kind == PartKind::Texture);
        let texture = textures.map(|(index, part)| {
            let there = content.delivery.layers_there(&self.client.has, index, None);
            texture_error_px(part, &there, content.pixels_per_metre)
        });
        let texture = texture.fold(0.0, f64::max);
        sample.skin_px = Some(skin);
        sample.texture_error_px = Some(texture);
        sample.error_px = Some(skin + texture);
        Ok(())
    }

    /// Bytes of access units that came and did not begin.
    fn unused_bytes(&self) -> u64 {
        let content = self.content;
        let shown: Vec<(usize, usize)> = content.timeline.plays[..self.begun]
            .iter()
            .map(|play| (content.timeline.motions[play.motion].part, play.unit))
            .collect();
        let is_unused = |part: usize, unit: Option<usize>| {
            unit.is_some_and(|unit| !shown.contains(&(part, unit)))
        };
        content.bytes_there(&self.client.has, is_unused)
    }
}
