//! `articula play URL`: shows a served character while it arrives.
//!
//! - `server`: requests to a server
//! - `follow`: what is fetched of a character, stage by stage
//! - `screen`: pictures in a terminal

mod follow;
mod screen;
mod server;

use crate::console::Console;
use crate::fault;
use crate::files;
use anyhow::Context as _;
use articula::Figure;
use articula::core::{Wrap, sample, sample_morphs};
use articula::flat::Picture;
use articula::stream::description::Context;
use articula_report::Artist;
use clap::Args;
use follow::{Arrived, Follower};
use screen::Screen;
use serde::Serialize;
use server::Server;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Pictures per second.
const FPS: f64 = 20.0;
/// Width and height of pictures that are written.
const WRITTEN_PX: (u32, u32) = (480, 640);
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
    /// Name of the clip to show [default: the first that arrives]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Bandwidth for which is chosen what to fetch, kbit/s [default: all of it]
    #[arg(long, value_name = "KBPS")]
    bandwidth_kbps: Option<f64>,
    /// Distance in metres for which is chosen what to fetch
    #[arg(long, value_name = "M")]
    distance_m: Option<f32>,
    /// Seconds to show, from the first picture on [default: 10, or until Ctrl-C in a terminal]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Write pictures into a folder, in place of the terminal
    #[arg(long, value_name = "DIR")]
    frames: Option<PathBuf>,
}

/// What was shown.
#[derive(Debug, Serialize)]
struct Played {
    name: String,
    /// Time from the start to the first picture.
    first_picture_secs: f64,
    pictures: usize,
    arrived: Vec<ArrivedReport>,
}

/// Something that was shown from then on.
#[derive(Debug, Serialize)]
struct ArrivedReport {
    secs: f64,
    bytes: u64,
    error_px: f64,
    triangles: usize,
    clips: usize,
    is_all: bool,
}

impl ArrivedReport {
    fn new(arrived: &Arrived, secs: f64) -> Self {
        Self {
            secs,
            bytes: arrived.bytes,
            error_px: arrived.error_px,
            triangles: arrived.figure.asset.mesh.triangles.len(),
            clips: arrived.figure.asset.clips.len(),
            is_all: arrived.is_all,
        }
    }

    fn line(&self) -> String {
        let rest = if self.is_all {
            "all that is chosen"
        } else {
            "more to come"
        };
        format!(
            "{:.1} kB, error at most {:.2} px, {} triangles, {} clips; {rest}",
            self.bytes as f64 / 1e3,
            self.error_px,
            self.triangles,
            self.clips
        )
    }
}

/// Fetches on one thread and shows on another.
pub(crate) fn run(args: &PlayArgs, console: &Console) -> anyhow::Result<()> {
    let start = Instant::now();
    let mut output = args.output(console)?;
    let server = Server::new(&args.url)?;
    let name = match &args.name {
        Some(name) => name.clone(),
        None => server.only_character()?,
    };
    let (sender, arrivals) = std::sync::mpsc::channel();
    let follower = Follower::new(server, &name, args.context());
    let following = std::thread::spawn(move || follower.follow(&sender));
    let played = Show {
        args,
        start,
        arrivals,
        reports: Vec::new(),
        first: None,
        pictures: 0,
    };
    let shown = played.run(&mut output);
    // What could not be fetched explains why nothing is shown.
    if shown.first.is_none() || following.is_finished() {
        let followed = following.join();
        followed.map_err(|_| anyhow::anyhow!("the thread that fetches ended"))??;
    }
    shown.fault?;
    let Some(first) = shown.first else {
        anyhow::bail!("{name}: nothing arrived to be shown");
    };
    let played = Played {
        name,
        first_picture_secs: (first - start).as_secs_f64(),
        pictures: shown.pictures,
        arrived: shown.reports,
    };
    console.result(&played, |played| {
        let mut text = format!(
            "{}: first picture after {:.2} s, {} pictures\n",
            played.name, played.first_picture_secs, played.pictures
        );
        for arrived in &played.arrived {
            text.push_str(&format!("{:8.2} s  {}\n", arrived.secs, arrived.line()));
        }
        text
    })
}

/// Where pictures go.
enum Output<'a> {
    Terminal(Screen),
    Folder(&'a Console, &'a Path),
    /// Drawn, and measured alone.
    Nowhere,
}

impl Output<'_> {
    fn size(&self) -> (u32, u32) {
        match self {
            Self::Terminal(screen) => screen.size(),
            Self::Folder(..) | Self::Nowhere => WRITTEN_PX,
        }
    }

    fn show(&mut self, number: usize, picture: &Picture, below: &str) -> anyhow::Result<()> {
        match self {
            Self::Terminal(screen) => screen.show(picture, below),
            Self::Folder(console, folder) => {
                let path = folder.join(format!("{number:05}.png"));
                files::write_png(&console.files, &path, picture).map(drop)
            }
            Self::Nowhere => Ok(()),
        }
    }
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
    fn context(&self) -> Context {
        let mut context = Context::default();
        context.network.available_bps = self.bandwidth_kbps.map(|kbps| 1e3 * kbps);
        context.view.distance_m = self.distance_m.map(f64::from);
        // Pictures of it in 2D are not shown here.
        context.terminal.codecs = ["ams", "abp2", "afp2"].map(str::to_owned).to_vec();
        context
    }

    /// Seconds to show; `None` until the program is ended.
    fn seconds(&self, output: &Output<'_>) -> Option<f64> {
        match output {
            Output::Terminal(_) => self.seconds,
            Output::Folder(..) | Output::Nowhere => Some(self.seconds.unwrap_or(SECONDS)),
        }
    }
}

/// What is shown as it arrives.
struct Show<'a> {
    args: &'a PlayArgs,
    start: Instant,
    arrivals: Receiver<Arrived>,
    reports: Vec<ArrivedReport>,
    /// When the first picture was shown.
    first: Option<Instant>,
    pictures: usize,
}

/// What was shown in the end.
struct Shown {
    fault: anyhow::Result<()>,
    reports: Vec<ArrivedReport>,
    first: Option<Instant>,
    pictures: usize,
}

impl Show<'_> {
    fn run(mut self, output: &mut Output<'_>) -> Shown {
        let fault = self.show(output);
        Shown {
            fault,
            reports: self.reports,
            first: self.first,
            pictures: self.pictures,
        }
    }

    /// Shows what arrives, until the time is over. The clip goes on when more of it is there.
    fn show(&mut self, output: &mut Output<'_>) -> anyhow::Result<()> {
        let Ok(mut arrived) = self.arrivals.recv() else {
            return Ok(());
        };
        loop {
            let report = ArrivedReport::new(&arrived, self.start.elapsed().as_secs_f64());
            let below = report.line();
            self.reports.push(report);
            match self.until_more(&arrived.figure, &below, output)? {
                Some(more) => arrived = more,
                None => return Ok(()),
            }
        }
    }

    /// Shows a figure until more of it arrives; `None` at the end.
    fn until_more(
        &mut self,
        figure: &Figure,
        below: &str,
        output: &mut Output<'_>,
    ) -> anyhow::Result<Option<Arrived>> {
        let mut artist = Artist::of_figure(figure, output.size());
        let asset = &figure.asset;
        let clip = self.args.clip.as_deref();
        let named = asset
            .clips
            .iter()
            .find(|c| clip.is_none_or(|name| c.name == name));
        let seconds = self.args.seconds(output);
        loop {
            let now = Instant::now();
            let secs = self.first.map_or(0.0, |first| (now - first).as_secs_f64());
            if seconds.is_some_and(|most| secs >= most) {
                return Ok(None);
            }
            let mut pose = asset.rig.rest_pose().clone();
            let mut morphs = asset.mesh.morph_weights.clone();
            if let Some(clip) = named.or(asset.clips.first()) {
                sample(clip, secs, Wrap::Loop, &asset.rig.all(), &mut pose);
                sample_morphs(clip, secs, Wrap::Loop, &mut morphs);
            }
            let picture = artist.figure(&pose, morphs).context("the picture")?;
            self.first.get_or_insert_with(Instant::now);
            output.show(self.pictures, &picture, below)?;
            self.pictures += 1;
            let next = Duration::from_secs_f64(1.0 / FPS).saturating_sub(now.elapsed());
            match self.arrivals.recv_timeout(next) {
                Ok(more) => return Ok(Some(more)),
                Err(RecvTimeoutError::Timeout) => {}
                // Nothing more comes.
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(next),
            }
        }
    }
}
