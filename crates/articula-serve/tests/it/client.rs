//! A server for a test, and requests to it over a plain connection.

use articula::item::PackageOptions;
use articula_serve::{Catalogue, Preparation, ServeOptions, router, serve};
use std::future::Future;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::pin::Pin;
use std::thread::JoinHandle;
use tokio::sync::oneshot;

/// Options by which a character is packaged in little time.
pub(crate) fn options() -> ServeOptions {
    ServeOptions {
        package: PackageOptions {
            mesh_levels: 2,
            flat: false,
            texture_distances_m: vec![3.0],
            ..PackageOptions::default()
        },
        ..ServeOptions::default()
    }
}

type Ending = Pin<Box<dyn Future<Output = ()> + Send>>;
/// Answers connections until its last argument ends.
type Answering = fn(tokio::net::TcpListener, Catalogue, Ending) -> Ending;

/// A server of a folder, until it is dropped.
pub(crate) struct Server {
    pub(crate) at: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    pub(crate) fn start(folder: &Path, options: &ServeOptions) -> Self {
        Self::run(folder, options, |listener, catalogue, stopped| {
            Box::pin(async { serve(listener, catalogue, stopped).await.unwrap() })
        })
    }

    /// The routes as a part of those of another server, below `/avatars`.
    pub(crate) fn nested(folder: &Path, options: &ServeOptions) -> Self {
        Self::run(folder, options, |listener, catalogue, stopped| {
            let routes = axum::Router::new().nest_service("/avatars", router(catalogue));
            let served = axum::serve(listener, routes).with_graceful_shutdown(stopped);
            Box::pin(async { served.await.unwrap() })
        })
    }

    fn run(folder: &Path, options: &ServeOptions, answer: Answering) -> Self {
        let catalogue = Catalogue::open(folder, options).unwrap();
        let preparation = Preparation::start(catalogue.clone());
        let (stop, stopped) = oneshot::channel();
        let (tell, told) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_multi_thread();
            let runtime = { runtime }.worker_threads(2).enable_all().build().unwrap();
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
                tell.send(listener.local_addr().unwrap()).unwrap();
                let stopped = Box::pin(async {
                    let _ = stopped.await;
                });
                answer(listener, catalogue, stopped).await;
            });
            preparation.stop();
        });
        Self {
            at: told.recv().unwrap(),
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    pub(crate) fn get(&self, path: &str, headers: &[(&str, &str)]) -> Answer {
        self.request("GET", path, headers, b"")
    }

    /// The status of a request to change the protocol of a connection, which then ends.
    pub(crate) fn upgrade(&self, path: &str, headers: &[(&str, &str)]) -> u16 {
        let mut head = format!("GET {path} HTTP/1.1\r\nHost: test\r\nConnection: upgrade\r\n");
        for (name, value) in headers {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        let mut stream = TcpStream::connect(self.at).unwrap();
        stream.write_all(format!("{head}\r\n").as_bytes()).unwrap();
        let mut first = [0; 12];
        stream.read_exact(&mut first).unwrap();
        let first = std::str::from_utf8(&first).unwrap();
        first.trim_start_matches("HTTP/1.1 ").parse().unwrap()
    }

    pub(crate) fn request(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> Answer {
        let mut head = format!("{method} {path} HTTP/1.1\r\nHost: test\r\nConnection: close\r\n");
        for (name, value) in headers {
            head.push_str(&format!("{name}: {value}\r\n"));
        }
        head.push_str(&format!("Content-Length: {}\r\n\r\n", body.len()));
        let mut stream = TcpStream::connect(self.at).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        // A server that refuses a body need not read it.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        Answer::read(&bytes)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// What a server answered.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    headers: Vec<(String, String)>,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    fn read(bytes: &[u8]) -> Self {
        let end = bytes
            .windows(4)
            .position(|four| four == b"\r\n\r\n")
            .unwrap();
        let head = std::str::from_utf8(&bytes[..end]).unwrap();
        let mut lines = head.split("\r\n");
        let status = lines.next().unwrap().split(' ').nth(1).unwrap();
        let header = |line: &str| {
            let (name, value) = line.split_once(':').unwrap();
            (name.to_lowercase(), value.trim().to_owned())
        };
        Self {
            status: status.parse().unwrap(),
            headers: lines.map(header).collect(),
            body: bytes[end + 4..].to_vec(),
        }
    }

    pub(crate) fn header(&self, name: &str) -> &str {
        let found = self.headers.iter().find(|(known, _)| known == name);
        found.map_or("", |(_, value)| value)
    }

    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}
