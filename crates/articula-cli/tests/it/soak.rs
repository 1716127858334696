//! A server that is used for long: sessions, requests and connections that break off, again and again, leave
//! nothing in its memory.

use crate::connection::Connection;
use crate::program::folder;
use crate::serving::{Server, request, started};
use articula::client::{
    ClientMessage, HeldFiles, SESSION_VERSION, ServerMessage, SessionUpdate, WantedCharacter,
};
use std::io::Write as _;
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// Rounds at least; more until the seconds of `ARTICULA_SOAK_SECS` are over.
const ROUNDS: usize = 24;
/// Rounds in which the memory still grows: buffers of connections, threads that wait for files, recent objects.
const FIRST: usize = 8;
/// Sessions at once.
const SESSIONS: usize = 24;
/// Bytes by which it may be larger later: what an allocator leaves.
const SPARE_BYTES: u64 = 6 << 20;

/// Memory of a process; `None` where the system does not tell.
fn memory_bytes(of: &Server) -> Option<u64> {
    let told = std::fs::read_to_string(format!("/proc/{}/statm", of.id())).ok()?;
    Some(4096 * told.split_whitespace().nth(1)?.parse::<u64>().unwrap())
}

/// The whole of a character in a session that decodes nothing; returns the bytes that came.
fn session(address: &str) -> (u64, Connection) {
    let mut connection = Connection::open(address);
    let hello = SessionUpdate {
        version: SESSION_VERSION,
        characters: Some(vec![WantedCharacter {
            name: "walker".to_owned(),
            ..WantedCharacter::default()
        }]),
        ..SessionUpdate::default()
    };
    assert!(connection.send(&ClientMessage::Hello(hello)));
    let mut came = 0;
    loop {
        match connection.next().expect("the session goes on") {
            ServerMessage::Manifest { hash, .. } => {
                let held = HeldFiles {
                    manifest: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
                    ..HeldFiles::default()
                };
                assert!(connection.send(&ClientMessage::Held(held)));
            }
            ServerMessage::Bytes { bytes, .. } => came += bytes.len() as u64,
            ServerMessage::Complete { .. } => return (came, connection),
            ServerMessage::Error(error) => panic!("{error:?}"),
            ServerMessage::Decision(_) | ServerMessage::Statistics(_) => {}
        }
    }
}

/// Sessions at once, of which every other breaks off without a word, requests, and connections that end early.
fn round(address: &str) -> u64 {
    let sessions: Vec<_> = (0..SESSIONS).map(|_| session(address)).collect();
    let came: Vec<u64> = sessions.iter().map(|(came, _)| *came).collect();
    assert!(came.iter().all(|bytes| *bytes == came[0]), "{came:?}");
    for (number, (_, mut connection)) in sessions.into_iter().enumerate() {
        if number % 2 == 0 {
            let _ = connection.0.close(None);
        }
    }
    for (path, status) in [
        ("/v1/characters", "200"),
        ("/v1/characters/walker/manifest.json", "200"),
        ("/v1/characters/walker/figure.glb", "200"),
        ("/v1/characters/nobody", "404"),
        ("/metrics", "200"),
        ("/", "200"),
    ] {
        let mut stream = TcpStream::connect(address).unwrap();
        let head = format!("GET {path} HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        std::io::Read::read_to_end(&mut stream, &mut answer).unwrap();
        let right = format!("HTTP/1.1 {status}");
        assert!(answer.starts_with(right.as_bytes()), "{path}");
        // One that sends half a head, and one that leaves before the answer.
        for part in [&head.as_bytes()[..20], head.as_bytes()] {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(part).unwrap();
        }
    }
    came[0]
}

#[test]
fn a_server_that_is_used_for_long_keeps_its_memory() {
    let folder = folder("soak");
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    std::fs::copy(case, folder.join("walker.glb")).unwrap();
    let (server, address) = started(&folder, &[]);
    while !request(&address, "GET /v1/characters HTTP/1.1\r\n", b"").contains("ready") {}
    let secs = std::env::var("ARTICULA_SOAK_SECS");
    let secs = secs.map_or(0, |secs| secs.parse().unwrap());
    let most = Duration::from_secs(secs);
    let start = Instant::now();
    let (mut rounds, mut came, mut settled) = (0, 0, None);
    while rounds < ROUNDS || start.elapsed() < most {
        let of_round = round(&address);
        assert!(rounds == 0 || of_round == came, "{of_round} {came}");
        came = of_round;
        rounds += 1;
        if rounds == FIRST {
            settled = memory_bytes(&server);
        }
    }
    if let (Some(before), Some(after)) = (settled, memory_bytes(&server)) {
        println!("{rounds} rounds of {SESSIONS} sessions: {before} bytes, then {after}");
        assert!(
            after <= before + SPARE_BYTES,
            "{before} bytes, then {after}"
        );
    }
    // All sessions have left.
    loop {
        let open = request(&address, "GET /v1/sessions HTTP/1.1\r\n", b"");
        if open.ends_with("[]") {
            break;
        }
    }
    drop(server);
}
