//! A server that is killed at any moment of an upload, of packaging and of a session, and started again: what it
//! accepted is there, nothing is packaged twice, and a client goes on with what it has.

use crate::connection::{Came, Connection};
use crate::program::folder;
use crate::serving::{request, started};
use articula::client::{Client, ClientOptions};
use articula::stream::description::Context;
use std::net::TcpStream;
use std::path::Path;
use std::time::Instant;

/// Moments at which the server is killed; more by `ARTICULA_KILLS`.
const KILLS: u64 = 2;

/// Goes on with a client for some messages; returns whether all is there.
fn follow(address: &str, client: &mut Client, came: &mut Came, most: u64) -> bool {
    let start = Instant::now();
    let now = || start.elapsed().as_secs_f64();
    let mut connection = Connection::open(address);
    let mut is_open = connection.send(&client.hello(0.0));
    for _ in 0..most {
        let Some(message) = connection.next().filter(|_| is_open) else {
            return false;
        };
        came.note(client, &message);
        if let Some(answer) = client.take(message, now()).unwrap() {
            is_open = connection.send(&answer);
        }
        client.frame(now(), 0.01).unwrap();
        if client.report(0).is_complete {
            return true;
        }
    }
    false
}

#[test]
fn a_server_that_is_killed_at_any_moment_loses_nothing_and_does_nothing_twice() {
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    let glb = std::fs::read(case).unwrap();
    let told = std::env::var("ARTICULA_KILLS").ok();
    let kills = told.map_or(KILLS, |count| count.parse().unwrap());
    let mut context = Context::default();
    context.view.distance_m = Some(1.0);
    context.preferences.tolerance_px = Some(0.0);
    let mut seed: u64 = 20_261_128;
    let mut dice = |sides: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) % sides
    };
    for kill in 0..kills {
        let folder = folder(&format!("killed-server-{kill}"));
        let mut client = Client::new(&context, &ClientOptions::default()).unwrap();
        client.add("walker");
        let mut came = Came::default();
        // An upload that is cut off in the middle, or is answered: then it counts.
        let (server, address) = started(&folder, &[]);
        let head = "PUT /v1/characters/walker HTTP/1.1\r\n";
        let is_cut = dice(3) == 0;
        if is_cut {
            use std::io::Write as _;
            let mut stream = TcpStream::connect(&address).unwrap();
            let length = glb.len();
            let head = format!("{head}Host: a\r\nContent-Length: {length}\r\n\r\n");
            let half = dice(length as u64) as usize;
            stream
                .write_all(&[head.as_bytes(), &glb[..half]].concat())
                .unwrap();
            drop(server);
            assert!(
                !folder.join("walker.glb").exists(),
                "half an upload is none"
            );
        } else {
            let answer = request(&address, head, &glb);
            assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
            drop(server);
            assert_eq!(std::fs::read(folder.join("walker.glb")).unwrap(), glb);
        }
        // Killed in the middle of packaging or of a session, again and again.
        let (server, address) = started(&folder, &[]);
        if is_cut {
            let answer = request(&address, head, &glb);
            assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
        }
        let mut is_complete = follow(&address, &mut client, &mut came, dice(20));
        drop(server);
        let mut packaged = 0;
        for _ in 0..50 {
            if is_complete {
                break;
            }
            let (server, address) = started(&folder, &[]);
            is_complete = follow(&address, &mut client, &mut came, 30 + dice(60));
            let metrics = request(&address, "GET /metrics HTTP/1.1\r\n", b"");
            packaged += u32::from(metrics.contains("articula_packaged_total 1\n"));
            drop(server);
        }
        assert!(is_complete, "moment {kill}");
        assert!(packaged <= 1, "moment {kill}: packaged {packaged} times");
    }
}
