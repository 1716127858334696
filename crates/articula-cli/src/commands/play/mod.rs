//! `articula play URL`: shows a served character while it arrives.
//!
//! - `fetch`, `link`: what the client asks for over HTTP, and a session, on threads of their own
//! - `captions`: what is said on the clock of a clip
//! - `event`, `keys`: what happens to the client
//! - `slider`: a bandwidth that changes over time
//! - `show`: the loop that shows it
//! - `monitor`: what is shown, in numbers
//! - `phase`: the same between two movements of the slider
//! - `output`, `screen`: where pictures go; `graphics`, `kitty`, `sixel`: terminals that show pixels

mod captions;
mod event;
mod fetch;
mod graphics;
mod keys;
mod kitty;
mod link;
mod monitor;
mod output;
mod phase;
mod screen;
mod show;
mod sixel;
mod slider;

use crate::commands::device_score::{DeviceScore, device_score};
use crate::commands::server::Server;
use crate::console::Console;
use crate::fault;
use articula::client::{Client, ClientOptions};
use articula::stream::description::Context;
use clap::Args;
use keys::Keys;
use monitor::Sample;
use output::Output;
use phase::Phase;
use screen::Screen;
use serde::Serialize;
use show::Show;
use slider::Slider;
use std::path::PathBuf;
use std::sync::mpsc::channel;
use std::time::Instant;

/// Seconds that are shown where nobody can end it.
const SECONDS: f64 = 10.0;

/// Arguments of `play`.
#[derive(Debug, Args)]
pub(crate) struct PlayArgs {
    /// Address of a server, as `articula serve` prints it
    #[arg(value_name = "URL")]
    url: String,
    /// Name of the character; not needed if the server has one
    name: Option<String>,
    /// Let the server decide, in a session over WebSocket [default: decide here, and fetch ranges]
    #[arg(long)]
    session: bool,
    /// Name of the clip to show [default: the first that arrives]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Go on where another session is, by its number on the page of the server: its character, clip and time
    #[arg(long = "continue", value_name = "N", conflicts_with_all = ["name", "clip"])]
    session_before: Option<u64>,
    /// Report of articula bench device, or the score of this device in percent of the reference machine: less is
    /// fetched that takes less time per frame
    #[arg(long, value_name = "N|F.json", value_parser = device_score)]
    device_score: Option<DeviceScore>,
    /// Most bandwidth to use, kbit/s [default: what the network has]; the keys left and right halve and double
    /// it
    #[arg(long, value_name = "KBPS")]
    bandwidth_kbps: Option<f64>,
    /// Change the bandwidth over time: from so many seconds after the first picture on so many kbit/s, or `full`
    #[arg(long, value_name = "S:KBPS,...", conflicts_with = "bandwidth_kbps")]
    slider: Option<Slider>,
    /// Distance in metres for which is chosen what to fetch; the keys up and down halve and double it
    #[arg(long, value_name = "M")]
    distance_m: Option<f32>,
    /// Seconds to show, from the first picture on [default: 10, or until `q` or Ctrl-C in a terminal]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Write pictures into a folder, in place of the terminal
    #[arg(long, value_name = "DIR")]
    frames: Option<PathBuf>,
    /// Show bandwidth, decision, layers, joints, times and memory below the picture, or write them for each
    /// second; the key `m` in a terminal
    #[arg(long)]
    monitor: bool,
}

/// What was shown.
#[derive(Debug, Serialize)]
struct Played {
    name: String,
    /// `session` or `http`.
    by: &'static str,
    /// Time from the start to the first picture.
    first_picture_secs: f64,
    pictures: usize,
    /// A moment of each second, and each at which another level was there.
    samples: Vec<Sample>,
    /// The times between two movements of the slider.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    phases: Vec<Phase>,
}

/// Fetches a character and shows it.
pub(crate) fn run(args: &PlayArgs, console: &Console) -> anyhow::Result<()> {
    let start = Instant::now();
    let mut output = args.output(console)?;
    let server = Server::new(&args.url)?;
    let before = match args.session_before {
        Some(number) => Some(server.session(number)?),
        None => None,
    };
    let name = match (&args.name, &before) {
        (Some(name), _) => name.clone(),
        (None, Some(before)) => before.name.clone(),
        (None, None) => server.only_character()?,
    };
    let mut client = Client::new(&args.context()?, &ClientOptions::default())?;
    let character = client.add(&name);
    let clip = before.as_ref().map_or(&args.clip, |before| &before.clip);
    let from_secs = before.as_ref().map_or(0.0, |before| before.position_secs);
    client.play_from(character, clip.as_deref(), from_secs, 0.0);
    let (sender, events) = channel();
    let _keys = match &output {
        Output::Terminal(_) => Keys::start(&sender),
        Output::Folder(..) | Output::Nowhere => None,
    };
    let show = Show {
        server,
        start,
        client,
        is_session: args.session,
        slider: args.slider.as_ref(),
        seconds: args.seconds(&output),
        has_monitor: args.monitor,
    };
    let shown = show.run(&events, &sender, &mut output)?;
    let played = Played {
        name,
        by: if args.session { "session" } else { "http" },
        first_picture_secs: shown.first_picture_secs(start)?,
        pictures: shown.pictures,
        samples: shown.samples,
        phases: shown.phases,
    };
    console.result(&played, |played| {
        let mut text = format!(
            "{}: first picture after {:.2} s, {} pictures\n",
            played.name, played.first_picture_secs, played.pictures
        );
        for sample in &played.samples {
            let more = match args.monitor {
                true => format!(
                    "; {:.0} kB/s, {} joints, {:.0} pictures/s, {:.1} ms",
                    sample.bytes_per_second / 1e3,
                    sample.joints_sampled,
                    sample.fps,
                    sample.frame_ms
                ),
                false => String::new(),
            };
            text.push_str(&format!("{:8.2} s  {}{more}\n", sample.secs, sample.line()));
        }
        if !played.phases.is_empty() {
            text.push_str(&phase::table(&played.phases).text());
        }
        text
    })
}

impl PlayArgs {
    fn output<'a>(&'a self, console: &'a Console) -> anyhow::Result<Output<'a>> {
        if let Some(folder) = &self.frames {
            console.files.make_folder(folder)?;
            return Ok(Output::Folder(console, folder));
        }
        if console.is_json() {
            return Ok(Output::Nowhere);
        }
        let none = "standard output is no terminal; give --frames DIR, or --json for times alone";
        Screen::new()
            .map(Output::Terminal)
            .ok_or_else(|| fault::usage(none))
    }

    /// What is known of the network and the view.
    fn context(&self) -> anyhow::Result<Context> {
        let mut context = Context::default();
        if let Some(score) = &self.device_score {
            score.add_to(&mut context)?;
        }
        context.network.available_bps = self.bandwidth_kbps.map(|kbps| 1e3 * kbps);
        context.view.distance_m = self.distance_m.map(f64::from);
        // Pictures of it in 2D are not shown here.
        context.terminal.codecs = ["ams", "abp2", "afp2"].map(str::to_owned).to_vec();
        Ok(context)
    }

    /// Seconds to show; `None` until the program is ended.
    fn seconds(&self, output: &Output<'_>) -> Option<f64> {
        match output {
            Output::Terminal(_) => self.seconds,
            Output::Folder(..) | Output::Nowhere => Some(self.seconds.unwrap_or(SECONDS)),
        }
    }
}
