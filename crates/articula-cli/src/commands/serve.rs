//! `articula serve DIR`: serves the characters of a folder over HTTP.

use crate::arguments::number;
use crate::console::Console;
use crate::{fault, files};
use anyhow::Context;
use articula_serve::{
    AnsweredRequest, Catalogue, Preparation, Progress, RequestWatcher, ServeOptions,
};
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Where it listens if nothing else is said.
const ADDRESS: ([u8; 4], u16) = ([127, 0, 0, 1], 8080);

/// Arguments of `serve`.
#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Folder of characters (.glb, .vrm, .fbx, items); what is made of them goes to .articula in it
    #[arg(value_name = "DIR", required_unless_present = "store")]
    folder: Option<PathBuf>,
    /// The same by a flag
    #[arg(long, value_name = "DIR", conflicts_with = "folder")]
    store: Option<PathBuf>,
    /// File of the catalogue (SQLite), if it is not to be DIR/.articula/catalogue.sqlite3: for a DIR on a network disk
    #[arg(long, value_name = "FILE")]
    catalogue: Option<PathBuf>,
    /// Address and port to listen on; port 0 chooses one
    #[arg(long, value_name = "ADDR", default_value_t = SocketAddr::from(ADDRESS))]
    addr: SocketAddr,
    /// Write nothing and take nothing: serve what is packaged
    #[arg(long)]
    read_only: bool,
    /// Send to each connection at most so many kilobits (1000 bits) per second, as a slow network does
    #[arg(long, value_name = "KBPS", value_parser = rate)]
    throttle_kbps: Option<f64>,
    /// One line for each request on standard error
    #[arg(long, value_enum, value_name = "FORM", default_value_t = Log::Off)]
    log: Log,
    /// Take characters only from clients that send `Authorization: Bearer TOKEN`
    #[arg(long, value_name = "TOKEN")]
    token: Option<String>,
    /// Let web pages of this origin read what is served, such as `https://example.com`; `*` lets all
    #[arg(long, value_name = "ORIGIN", value_parser = origin)]
    allow_origin: Option<String>,
    /// Folder of the studio's pages (web/studio/dist), served below /studio/
    #[arg(long, value_name = "DIR")]
    studio: Option<PathBuf>,
}

impl ServeArgs {
    /// A folder with all else as by default.
    pub(crate) fn of_folder(folder: PathBuf) -> Self {
        Self {
            folder: Some(folder),
            store: None,
            catalogue: None,
            addr: SocketAddr::from(ADDRESS),
            read_only: false,
            throttle_kbps: None,
            log: Log::Off,
            token: None,
            allow_origin: None,
            studio: None,
        }
    }
}

/// Form of the lines about requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Log {
    /// A JSON object: method, path, status, bytes, ms
    Json,
    /// The same as words
    Text,
    /// None
    Off,
}

impl Log {
    /// Writes the lines; nothing without.
    fn watcher(self) -> Option<RequestWatcher> {
        let line: fn(&AnsweredRequest) -> String = match self {
            // Texts and numbers cannot fail.
            Self::Json => |of| serde_json::to_string(of).unwrap_or_default(),
            Self::Text => |of| {
                let AnsweredRequest {
                    method,
                    path,
                    status,
                    bytes,
                    ms,
                } = of;
                let bytes = bytes.map_or("-".to_owned(), |bytes| bytes.to_string());
                format!("{method} {path} {status} {bytes} {ms:.1}")
            },
            Self::Off => return None,
        };
        Some(RequestWatcher::new(move |request| {
            // Who reads no more of it is no reason to end.
            let _ = writeln!(std::io::stderr(), "{}", line(request));
        }))
    }
}

/// What is served.
#[derive(Debug, Serialize)]
struct Listening {
    url: String,
    folder: String,
    characters: usize,
    ready: usize,
}

/// Serves until the program is interrupted; connections that are open then end first.
pub(crate) fn run(args: &ServeArgs, console: &Console) -> anyhow::Result<()> {
    // One of the two is there.
    let folder = args.folder.as_ref().or(args.store.as_ref());
    let folder = folder.context("no folder")?;
    if !folder.is_dir() {
        let what = format!("{}: there is no such folder; make it", files::shown(folder));
        return Err(fault::usage(what));
    }
    let is_local = args.addr.ip().is_loopback();
    if !is_local && args.token.is_none() && !args.read_only {
        let what =
            "anyone who reaches this address could store characters; give --token or --read-only";
        return Err(fault::usage(format!("--addr {}: {what}", args.addr)));
    }
    if let Some(studio) = args
        .studio
        .as_ref()
        .filter(|dir| !dir.join("index.html").is_file())
    {
        let what = "there is no index.html in it; `npm run build --workspace articula-studio` in web/ makes it";
        return Err(fault::usage(format!(
            "--studio {}: {what}",
            files::shown(studio)
        )));
    }
    let of_all = ServeOptions::default();
    let options = ServeOptions {
        // What comes from this machine may be a proxy, behind which all clients have one address.
        most_of_address: (!is_local).then_some(of_all.most_connections / 2),
        read_only: args.read_only,
        catalogue: args.catalogue.clone(),
        token: args.token.clone(),
        allow_origin: args.allow_origin.clone(),
        studio: args.studio.clone(),
        throttle_bps: args.throttle_kbps.map(|kbps| 1e3 * kbps),
        watcher: args.log.watcher(),
        ..of_all
    };
    let catalogue = Catalogue::open(folder, &options)?;
    for note in catalogue.notes() {
        console.note(note);
    }
    let runtime = tokio::runtime::Runtime::new().context("threads of the server")?;
    let listening = || {
        format!(
            "{}: another program may use it; choose another port",
            args.addr
        )
    };
    let preparation = Preparation::start(catalogue.clone());
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind(args.addr).await;
        let listener = listener.with_context(listening)?;
        let states = catalogue.states();
        let is_ready = |state: &articula_serve::CharacterState| state.progress == Progress::Ready;
        let told = Listening {
            url: format!("http://{}/", listener.local_addr()?),
            folder: files::shown(folder),
            characters: states.len(),
            ready: states.iter().filter(|(_, state)| is_ready(state)).count(),
        };
        console.result(&told, |told| {
            format!(
                "{}: {} characters of {}, {} ready; Ctrl-C ends it\n",
                told.url, told.characters, told.folder, told.ready
            )
        })?;
        articula_serve::serve(listener, catalogue, interrupted()).await?;
        anyhow::Ok(())
    });
    preparation.stop();
    served
}

/// Parses a rate in kilobits per second.
fn rate(text: &str) -> Result<f64, String> {
    number(text, |kbps| kbps >= 1.0, "a number from 1 on")
}

/// Parses an origin of web pages.
fn origin(text: &str) -> Result<String, String> {
    let host = ["http://", "https://"]
        .iter()
        .find_map(|scheme| text.strip_prefix(scheme));
    let is_host =
        |host: &str| !host.is_empty() && host.bytes().all(|b| b.is_ascii_graphic() && b != b'/');
    match text == "*" || host.is_some_and(is_host) {
        true => Ok(text.to_owned()),
        false => Err(
            "expected a scheme and host without a path, such as https://example.com, or *"
                .to_owned(),
        ),
    }
}

/// Ends when the program is asked to end.
async fn interrupted() {
    let interrupt = tokio::signal::ctrl_c();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = interrupt => {}
                _ = terminate.recv() => {}
            }
            return;
        }
    }
    // Without the signal the server goes on until it is killed.
    if interrupt.await.is_err() {
        std::future::pending::<()>().await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_a_scheme_and_a_host() {
        for right in ["*", "https://example.com", "http://127.0.0.1:8080"] {
            assert_eq!(origin(right).as_deref(), Ok(right));
        }
        for wrong in [
            "",
            "example.com",
            "https://",
            "https://a.com/",
            "https://a b",
            "ftp://a",
        ] {
            assert!(origin(wrong).is_err(), "{wrong}");
        }
    }
}
