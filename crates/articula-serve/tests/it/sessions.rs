//! Sessions over real connections: they begin before a character is packaged, go on after a loss, and who
//! does not keep to the form harms nobody else.

use crate::client::{Server, options};
use crate::connection::{Came, Connection};
use crate::real;
use articula::client::{
    Client, ClientAnswer, ClientMessage, ClientOptions, ClientRequest, ServerMessage,
    SessionUpdate, WantedCharacter,
};
use articula::stream::decide::Transfer;
use articula::stream::description::Context;
use articula_serve::ServeOptions;
use std::net::TcpStream;
use std::time::Instant;
use tungstenite::Message;

/// The reason for which the server ends a session.
fn end(mut connection: Connection) -> String {
    while let Some(message) = connection.next() {
        if let ServerMessage::Error(error) = message {
            return error.error;
        }
    }
    String::new()
}

fn open(server: &Server) -> Connection {
    Connection::open(&server.at.to_string())
}

/// Someone near, who sees everything.
fn client(name: &str) -> Client {
    let mut context = Context::default();
    context.view.distance_m = Some(1.0);
    context.preferences.tolerance_px = Some(0.0);
    let mut client = Client::new(&context, &ClientOptions::default()).unwrap();
    client.add(name);
    client
}

/// Goes on with a client in a session for some messages; returns whether all is there.
fn follow(server: &Server, client: &mut Client, came: &mut Came, most: usize) -> bool {
    let start = Instant::now();
    let now = || start.elapsed().as_secs_f64();
    let mut connection = open(server);
    connection.send(&client.hello(0.0));
    for _ in 0..most {
        let message = connection.next().expect("the session goes on");
        came.note(client, &message);
        if let Some(answer) = client.take(message, now()).unwrap() {
            connection.send(&answer);
        }
        client.frame(now(), 0.01).unwrap();
        if let Some(update) = client.update(now()) {
            connection.send(&update);
        }
        if client.report(0).is_complete {
            return true;
        }
    }
    false
}

fn served(options: &ServeOptions) -> Option<(tempfile::TempDir, Server)> {
    let glb = real::bytes("glb/CesiumMan.glb")?;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("man.glb"), glb).unwrap();
    let server = Server::start(folder.path(), options);
    Some((folder, server))
}

#[test]
fn a_session_begins_before_the_character_is_packaged_and_goes_on_after_losses() {
    let Some((folder, server)) = served(&options()) else {
        return;
    };
    let (mut client, mut came) = (client("man"), Came::default());
    let mut sessions = 0;
    while !follow(&server, &mut client, &mut came, 12) {
        sessions += 1;
        assert!(sessions < 500);
    }
    assert!(sessions > 1, "{sessions} losses");
    let report = client.report(0);
    assert_eq!(
        (report.level, report.stalls),
        (report.levels, 0),
        "{report:?}"
    );
    // A client that has all is sent nothing.
    let before = came.0.values().map(Vec::len).sum::<usize>();
    assert!(follow(&server, &mut client, &mut came, 12));
    assert_eq!(came.0.values().map(Vec::len).sum::<usize>(), before);

    // Another server on the folder packages nothing, and the client that fetches ranges gets the same.
    drop(server);
    let server = Server::start(folder.path(), &options());
    let metrics = String::from_utf8(server.get("/metrics", &[]).body).unwrap();
    assert!(metrics.contains("articula_packaged_total 0"));
    let fetched = fetch(&server);
    let shown = |client: &Client| {
        let of = client.character(0).unwrap();
        let player = of.player().unwrap();
        (
            of.figure().unwrap().opened.character().clone(),
            player.model().clips().to_vec(),
        )
    };
    assert!(shown(&client) == shown(&fetched));

    // An object that was lost is made again, and is the same.
    let receiver = fetched.character(0).unwrap().receiver().unwrap();
    let lost = &receiver.manifest().files["figure.glb"].hash;
    let objects = folder.path().join(".articula/objects");
    std::fs::remove_file(objects.join(&lost[..2]).join(lost)).unwrap();
    drop(server);
    let server = Server::start(folder.path(), &options());
    assert!(shown(&client) == shown(&fetch(&server)));
    let metrics = String::from_utf8(server.get("/metrics", &[]).body).unwrap();
    assert!(metrics.contains("articula_packaged_total 1"), "{metrics}");
}

/// A client that fetches all by itself.
fn fetch(server: &Server) -> Client {
    let (mut client, mut came) = (client("man"), Came::default());
    let start = Instant::now();
    let now = || start.elapsed().as_secs_f64();
    while !client.report(0).is_complete {
        let Some((id, request)) = client.next_request(now()) else {
            client.frame(now(), 0.01).unwrap();
            continue;
        };
        let answer = match request {
            ClientRequest::Manifest { name, known } => {
                let path = format!("/v1/characters/{name}/manifest.json?wait=10");
                let tag = format!("\"{}\"", known.unwrap_or_default());
                let answer = server.get(&path, &[("If-None-Match", &tag)]);
                let is_whole = answer.header("articula-state") == "ready";
                match answer.status {
                    200 => ClientAnswer::Manifest {
                        bytes: answer.body,
                        is_whole,
                    },
                    304 => ClientAnswer::Unchanged { is_whole },
                    other => panic!("{other}"),
                }
            }
            ClientRequest::Bytes { object, increment } => {
                let (start, end) = (increment.range.start, increment.range.end);
                came.add(&object, increment.range);
                let range = format!("bytes={start}-{}", end - 1);
                let first_byte_secs = now();
                let answer = server.get(&format!("/v1/o/{object}"), &[("Range", &range)]);
                assert_eq!(answer.status, 206);
                ClientAnswer::Bytes {
                    bytes: answer.body,
                    transfer: Transfer {
                        bytes: end - start,
                        first_byte_secs,
                        last_byte_secs: now(),
                    },
                }
            }
        };
        client.answer(id, answer, now()).unwrap();
        client.frame(now(), 0.0).unwrap();
    }
    client
}

#[test]
fn who_does_not_keep_to_the_form_is_told_and_harms_nobody() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.glb"), b"glTF").unwrap();
    let server = Server::start(folder.path(), &options());
    let raw = |message: Message| {
        let mut connection = open(&server);
        // A frame that is refused may end the connection while it is sent.
        let _ = connection.0.send(message);
        end(connection)
    };
    let hello = |name: &str| {
        ClientMessage::Hello(SessionUpdate {
            version: 1,
            characters: Some(vec![WantedCharacter {
                name: name.to_owned(),
                ..WantedCharacter::default()
            }]),
            ..SessionUpdate::default()
        })
    };
    assert!(raw(Message::Text("hello".into())).contains("binary"));
    assert!(raw(Message::Binary(vec![0x77].into())).contains("unknown kind"));
    assert!(raw(Message::Binary(vec![].into())).contains("empty"));
    assert!(raw(Message::Binary(b"\x01{\"version\":9}".to_vec().into())).contains("version"));
    let deep = [&b"\x01"[..], "[".repeat(100_000).as_bytes()].concat();
    assert!(raw(Message::Binary(deep.into())).contains("hello"));
    let update = ClientMessage::Update(SessionUpdate::default()).to_bytes();
    assert!(raw(Message::Binary(update.into())).contains("no hello"));
    assert!(raw(Message::Binary(hello("nobody").to_bytes().into())).contains("no such"));
    assert!(raw(Message::Binary(hello("../man").to_bytes().into())).contains("no such"));
    let broken = raw(Message::Binary(hello("broken").to_bytes().into()));
    assert!(broken.contains("broken.glb"), "{broken}");
    // Larger than a message may be.
    raw(Message::Binary(vec![0; 2 << 20].into()));
    // Who sends too much, and a second hello.
    let mut flood = open(&server);
    flood.send(&nothing());
    for _ in 0..300 {
        let message = ClientMessage::Update(SessionUpdate::default()).to_bytes();
        if flood.0.send(Message::Binary(message.into())).is_err() {
            break;
        }
    }
    assert!(end(flood).contains("100 messages"));
    let mut twice = open(&server);
    twice.send(&nothing());
    twice.send(&nothing());
    assert!(end(twice).contains("second hello"));
}

#[test]
fn what_is_wrong_with_one_character_stops_no_other_and_another_device_goes_on() {
    let Some((_folder, server)) = served(&options()) else {
        return;
    };
    let mut first = client("man");
    first.add("nobody");
    let start = Instant::now();
    let now = || start.elapsed().as_secs_f64();
    let mut connection = open(&server);
    connection.send(&first.hello(0.0));
    while !first.report(0).is_complete || first.character(1).unwrap().fault().is_none() {
        let message = connection.next().expect("the session goes on");
        if let Some(answer) = first.take(message, now()).unwrap() {
            connection.send(&answer);
        }
        first.frame(now(), 0.0).unwrap();
    }
    let fault = first.character(1).unwrap().fault().unwrap();
    assert_eq!(fault, "nobody: there is no such character");
    assert_eq!(first.character(0).unwrap().fault(), None);
    // It has played for a second and a half, and says so.
    (0..15).for_each(|_| first.frame(now(), 0.1).unwrap());
    let position = first.character(0).unwrap().position_secs();
    assert!((position - 1.5).abs() < 1e-3, "{position}");
    connection.send(&first.update(now() + 10.0).unwrap());
    let listed = loop {
        // A message is taken before the next second's counters come.
        connection.next().unwrap();
        let listed = server.get("/v1/sessions", &[]).json();
        let of_first = listed[0]["characters"][0].clone();
        if of_first["position_secs"] != 0.0 {
            break of_first;
        }
    };
    assert_eq!(listed["name"], "man");
    let from_secs = listed["position_secs"].as_f64().unwrap();
    assert!((from_secs - position).abs() < 1e-6);

    // Another device goes on there, and begins with what plays then.
    let mut second = client("man");
    second.play_from(0, listed["clip"].as_str(), from_secs, 0.0);
    let mut connection = open(&server);
    connection.send(&second.hello(0.0));
    while second.character(0).unwrap().player().is_none() {
        let message = connection.next().expect("the session goes on");
        if let Some(answer) = second.take(message, now()).unwrap() {
            connection.send(&answer);
        }
        second.frame(now(), 0.01).unwrap();
    }
    let goes_on = second.character(0).unwrap().position_secs() - from_secs;
    assert!((0.0..0.02).contains(&goes_on), "{goes_on}");
}

/// The first message of a session that wants no character.
fn nothing() -> ClientMessage {
    ClientMessage::Hello(SessionUpdate {
        version: 1,
        ..SessionUpdate::default()
    })
}

#[test]
fn beyond_the_limit_a_session_finds_no_place_until_another_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        most_sessions: 2,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    let url = format!("ws://{}/v1/session", server.at);
    let [mut first, mut second] = [(); 2].map(|()| open(&server));
    first.send(&nothing());
    second.send(&nothing());
    for open in [&mut first, &mut second] {
        let statistics = open.next();
        assert!(
            matches!(statistics, Some(ServerMessage::Statistics(_))),
            "{statistics:?}"
        );
    }
    let stream = TcpStream::connect(server.at).unwrap();
    let refused = tungstenite::client(&url, stream);
    assert!(refused.unwrap_err().to_string().contains("503"));
    let listed = server.get("/v1/sessions", &[]).json();
    assert_eq!(listed.as_array().map(Vec::len), Some(2));
    let page = String::from_utf8(server.get("/", &[]).body).unwrap();
    assert!(page.contains("<h2>Sessions</h2>"));
    first.0.close(None).unwrap();
    while first.next().is_some() {}
    let third = loop {
        let stream = TcpStream::connect(server.at).unwrap();
        if let Ok((open, _)) = tungstenite::client(&url, stream) {
            break open;
        }
    };
    let mut third = Connection(third);
    third.send(&nothing());
    assert!(third.next().is_some() && second.next().is_some());
}
