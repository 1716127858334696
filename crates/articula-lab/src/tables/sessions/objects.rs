//! Requests for one object over connections that are kept open: our server, and nginx on the same file.

use crate::tables::served::Served;
use anyhow::{Context, Result};
use std::fmt::Write as _;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

/// Connections at once.
const CONNECTIONS: usize = 32;
/// Runs of each server, of which the median counts.
const ROUNDS: usize = 5;

/// Requests a second.
pub(super) struct Objects {
    bytes: usize,
    ours: f64,
    /// Nothing where there is no nginx.
    nginx: Option<f64>,
}

impl Objects {
    pub(super) fn write(&self, page: &mut String) {
        let (nginx, ratio) = match self.nginx {
            Some(nginx) => (format!("{nginx:.0}"), format!("{:.2}", self.ours / nginx)),
            None => ("not installed".to_owned(), "-".to_owned()),
        };
        // Writing to a string cannot fail.
        let _ = write!(
            page,
            "## Objects\n\nOne object of {} bytes that is in memory, over {CONNECTIONS} connections that stay open; the \
             median of {ROUNDS} runs of each server in turn, nginx with two workers, sendfile and no log.\n\n\
             | requests a second | of nginx | ours / nginx |\n| --- | --- | --- |\n| {:.0} | {nginx} | {ratio} |\n",
            self.bytes, self.ours
        );
    }
}

/// nginx on a folder, until it is dropped.
struct Nginx {
    child: Child,
    at: SocketAddr,
}

impl Nginx {
    fn start(folder: &Path) -> Result<Option<Self>> {
        let at = TcpListener::bind("127.0.0.1:0")?.local_addr()?;
        let root = folder.display();
        let config = format!(
            "daemon off; user root; worker_processes 2; pid {root}/nginx.pid; error_log {root}/nginx.log; \
             events {{ worker_connections 256; }} http {{ access_log off; sendfile on; tcp_nopush on; \
             keepalive_requests 1000000; open_file_cache max=100; \
             server {{ listen {at}; root {root}; }} }}"
        );
        let file = folder.join("nginx.conf");
        std::fs::write(&file, config)?;
        let started = Command::new("nginx")
            .arg("-c")
            .arg(&file)
            .arg("-p")
            .arg(folder)
            .stderr(Stdio::null())
            .spawn();
        let Ok(child) = started else { return Ok(None) };
        let made = Self { child, at };
        let start = Instant::now();
        while TcpStream::connect(at).is_err() {
            anyhow::ensure!(
                start.elapsed() < Duration::from_secs(5),
                "nginx does not answer"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(Some(made))
    }
}

impl Drop for Nginx {
    fn drop(&mut self) {
        // Its workers end with it when it is asked, not when it is killed.
        let _ = Command::new("kill")
            .arg(self.child.id().to_string())
            .status();
        let _ = self.child.wait();
    }
}

/// Asks both servers for the figure of the character.
pub(super) fn compare(served: &Served, folder: &Path, requests: usize) -> Result<Objects> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()?;
    let name = runtime.block_on(figure(served.at))?;
    let object = folder
        .join(".articula/objects")
        .join(&name[..2])
        .join(&name);
    let bytes = std::fs::read(&object).context("the figure of the character")?;
    std::fs::write(folder.join("object"), &bytes)?;
    let nginx = Nginx::start(folder)?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let path = format!("/v1/o/{name}");
        ours.push(runtime.block_on(rate(served.at, &path, bytes.len(), requests))?);
        if let Some(nginx) = &nginx {
            theirs.push(runtime.block_on(rate(nginx.at, "/object", bytes.len(), requests))?);
        }
    }
    Ok(Objects {
        bytes: bytes.len(),
        ours: crate::measure::median(&mut ours),
        nginx: nginx.is_some().then(|| crate::measure::median(&mut theirs)),
    })
}

/// The hash of the figure, by the manifest.
async fn figure(at: SocketAddr) -> Result<String> {
    let mut stream = tokio::net::TcpStream::connect(at).await?;
    let ask = "GET /v1/characters/character/manifest.json HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
    stream.write_all(ask.as_bytes()).await?;
    let mut text = String::new();
    stream.read_to_string(&mut text).await?;
    let (_, body) = text.split_once("\r\n\r\n").context("no manifest")?;
    let manifest: serde_json::Value = serde_json::from_str(body)?;
    let hash = manifest["files"]["figure.glb"]["hash"].as_str();
    Ok(hash.context("the figure has no hash")?.to_owned())
}

/// Requests a second for a path.
async fn rate(at: SocketAddr, path: &str, bytes: usize, requests: usize) -> Result<f64> {
    let start = Instant::now();
    let each = requests / CONNECTIONS;
    let tasks: Vec<_> = (0..CONNECTIONS)
        .map(|_| {
            let ask = format!("GET {path} HTTP/1.1\r\nHost: a\r\n\r\n");
            tokio::spawn(async move {
                let mut stream = tokio::net::TcpStream::connect(at).await?;
                let mut answer = vec![0; bytes + 4096];
                for _ in 0..each {
                    stream.write_all(ask.as_bytes()).await?;
                    read(&mut stream, &mut answer, bytes).await?;
                }
                Ok::<(), anyhow::Error>(())
            })
        })
        .collect();
    for task in tasks {
        task.await??;
    }
    Ok((each * CONNECTIONS) as f64 / start.elapsed().as_secs_f64())
}

/// Reads an answer with a body of so many bytes.
async fn read(stream: &mut tokio::net::TcpStream, answer: &mut [u8], bytes: usize) -> Result<()> {
    let mut there = 0;
    let mut head = None;
    loop {
        let count = stream.read(&mut answer[there..]).await?;
        anyhow::ensure!(count > 0, "the server closed the connection");
        there += count;
        if head.is_none() {
            let end = answer[..there]
                .windows(4)
                .position(|four| four == b"\r\n\r\n");
            head = end.map(|end| end + 4);
            anyhow::ensure!(answer.starts_with(b"HTTP/1.1 200"), "the server refuses");
        }
        if head.is_some_and(|head| there >= head + bytes) {
            return Ok(());
        }
    }
}
