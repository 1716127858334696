//! A server of a folder, on threads of its own.

use anyhow::{Context, Result, bail};
use articula_serve::{Catalogue, Preparation, Progress, ServeOptions, serve};
use std::net::SocketAddr;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::net::TcpListener;
use tokio::sync::oneshot;

/// Longest time to package the character.
const LONGEST: Duration = Duration::from_secs(300);

/// A server, until it is dropped.
pub(super) struct Served {
    pub(super) at: SocketAddr,
    pub(super) catalogue: Catalogue,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    /// Starts a server, and waits until its characters are packaged.
    pub(super) fn start(folder: &Path) -> Result<Self> {
        let options = ServeOptions {
            most_sessions: 1 << 16,
            ..ServeOptions::default()
        };
        let catalogue = Catalogue::open(folder, &options)?;
        let preparation = Preparation::start(catalogue.clone());
        let (stop, stopped) = oneshot::channel();
        let (tell, told) = std::sync::mpsc::channel();
        let served = catalogue.clone();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_multi_thread()
                .enable_all()
                .build();
            let Ok(runtime) = runtime else { return };
            runtime.block_on(async {
                let Ok(listener) = TcpListener::bind("127.0.0.1:0").await else {
                    return;
                };
                let _ = tell.send(listener.local_addr());
                let stopped = async {
                    let _ = stopped.await;
                };
                if let Err(error) = serve(listener, served, stopped).await {
                    eprintln!("the server: {error}");
                }
            });
            preparation.stop();
        });
        let at = told.recv().context("the server did not start")??;
        let made = Self {
            at,
            catalogue,
            stop: Some(stop),
            thread: Some(thread),
        };
        made.wait()?;
        Ok(made)
    }

    fn wait(&self) -> Result<()> {
        let start = Instant::now();
        loop {
            let states = self.catalogue.states();
            let is_failed = |progress: &Progress| matches!(progress, Progress::Failed(_));
            if let Some((name, state)) = states.iter().find(|(_, s)| is_failed(&s.progress)) {
                bail!("{name}: {:?}", state.progress);
            }
            if states
                .iter()
                .all(|(_, state)| state.progress == Progress::Ready)
            {
                return Ok(());
            }
            if start.elapsed() > LONGEST {
                bail!(
                    "the characters are not packaged after {} s",
                    LONGEST.as_secs()
                );
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been told.
            let _ = thread.join();
        }
    }
}
