//! Items over a network: a client that fetches by itself and one in a session get what they ask for, once.

use crate::received_items::{manifest, textured};
use articula::client::{
    Client, ClientAnswer, ClientMessage, ClientOptions, ClientRequest, DeliveryPlan, Feed,
    FeedChange, FeedNext, FeedPlan, ServerMessage,
};
use articula::item::{
    AdaptOptions, Item, ItemReceiver, Manifest, PackageOptions, PartKind, compressed, package,
};
use articula::{Executor, Figure, fs};
use articula_mutate::{Edit, Mutations};
use articula_stream::ByteRanges;
use articula_stream::decide::Transfer;
use articula_stream::description::{Context, Modality};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which bytes of which file were sent.
#[derive(Debug, Default)]
struct Sent {
    bytes: u64,
    ranges: BTreeMap<String, Vec<Range<u64>>>,
}

impl Sent {
    fn add(&mut self, file: &str, range: Range<u64>) {
        self.bytes += range.end - range.start;
        self.ranges.entry(file.to_owned()).or_default().push(range);
    }

    /// What was sent last was lost on the way.
    fn lose(&mut self, file: &str, range: &Range<u64>) {
        self.bytes -= range.end - range.start;
        let of_file = self.ranges.get_mut(file).and_then(Vec::pop);
        assert_eq!(of_file.as_ref(), Some(range));
    }

    /// No byte came twice.
    fn check_once(&self) {
        for (file, ranges) in &self.ranges {
            let all: ByteRanges = ranges.iter().cloned().collect();
            let sum: u64 = ranges.iter().map(|range| range.end - range.start).sum();
            assert_eq!(all.bytes(), sum, "{file}: {ranges:?}");
        }
    }
}

/// A network of a bandwidth, on a virtual clock.
struct Network<'a> {
    item: &'a Item,
    bits_per_second: f64,
    now_secs: f64,
    sent: Sent,
}

impl<'a> Network<'a> {
    fn new(item: &'a Item, bits_per_second: f64) -> Self {
        Self {
            item,
            bits_per_second,
            now_secs: 0.0,
            sent: Sent::default(),
        }
    }

    /// Answers all requests that a client makes now; `fails` says of which nothing comes.
    fn answer(&mut self, client: &mut Client, fails: &mut dyn FnMut() -> bool) {
        while let Some((id, request)) = client.next_request(self.now_secs) {
            let answer = match request {
                ClientRequest::Manifest { known: None, .. } => ClientAnswer::Manifest {
                    bytes: manifest(self.item),
                    is_whole: true,
                },
                ClientRequest::Manifest { .. } => ClientAnswer::Unchanged { is_whole: true },
                ClientRequest::Bytes { .. } if fails() => ClientAnswer::Failed,
                ClientRequest::Bytes { object, increment } => {
                    let range = increment.range.clone();
                    assert_eq!(self.item.manifest.files[&increment.file].hash, object);
                    let file = self.item.file(&increment.file).unwrap();
                    let first_byte_secs = self.now_secs;
                    let bits = 8.0 * (range.end - range.start) as f64;
                    self.now_secs += bits / self.bits_per_second;
                    self.sent.add(&increment.file, range.clone());
                    assert!(!increment.is_whole || range == (0..file.len() as u64));
                    ClientAnswer::Bytes {
                        bytes: file[range.start as usize..range.end as usize].to_vec(),
                        transfer: Transfer {
                            bytes: range.end - range.start,
                            first_byte_secs,
                            last_byte_secs: self.now_secs,
                        },
                    }
                }
            };
            client.answer(id, answer, self.now_secs).unwrap();
            client.frame(self.now_secs, 0.0).unwrap();
        }
    }
}

fn client() -> (Client, usize) {
    let mut client = Client::new(&context(), &ClientOptions::default()).unwrap();
    let character = client.add("walker");
    (client, character)
}

/// Someone near, who sees everything.
fn context() -> Context {
    let mut context = Context::default();
    context.view.distance_m = Some(1.0);
    context.preferences.tolerance_px = Some(0.0);
    context
}

#[test]
fn a_client_fetches_each_byte_once_and_plays_from_the_least_on() {
    let Some(item) = textured() else { return };
    let (mut client, character) = client();
    let mut network = Network::new(item, 400e3);
    let mut levels = Vec::new();
    let mut number = 0;
    // Every seventh request fails.
    let mut fails = || {
        number += 1;
        number % 7 == 3
    };
    for _ in 0..400 {
        network.answer(&mut client, &mut fails);
        network.now_secs += 0.05;
        client.frame(network.now_secs, 0.05).unwrap();
        levels.push(client.report(character).level);
    }
    let report = client.report(character);
    assert!(report.is_complete, "{report:?}");
    network.sent.check_once();
    // The bytes that were counted are those of the least level, then of finer ones.
    assert!(
        levels.windows(2).all(|pair| pair[0] <= pair[1]),
        "{levels:?}"
    );
    assert_eq!(report.level, report.levels);
    assert_eq!(report.bytes, network.sent.bytes);
    let shown = client.character(character).unwrap();
    let clips = shown.player().unwrap().model().clips();
    assert_eq!(clips.len(), 2);
    assert!(shown.position_secs() > 0.0 && shown.version() > 1);
    // What is shown is the item.
    let whole = articula::item::assemble(item, &articula::OpenOptions::default()).unwrap();
    let figure = shown.figure().unwrap();
    assert!(figure.opened.character().meshes == whole.character().meshes);
    let parts = item.manifest.parts.iter().enumerate();
    let mut motions = parts.filter(|(_, part)| part.kind == PartKind::BodyMotion);
    let receiver = shown.receiver().unwrap();
    assert!(motions.all(|(part, _)| clips.contains(&receiver.clip(part).unwrap())));
}

/// Sends all that a session has for a client, for some messages at most; returns whether it is over.
fn serve(item: &Item, feed: &mut Feed, client: &mut Client, sent: &mut Sent, most: usize) -> bool {
    let mut now = 0.0;
    let manifest_bytes = manifest(item);
    let hash = blake3::hash(&manifest_bytes);
    let known = feed.set_manifest(0, &Arc::new(item.manifest.clone()), &hash.to_hex());
    let options = AdaptOptions::default();
    let plan = |feed: &Feed| {
        let context = feed.context_of(0);
        let layers = DeliveryPlan::new(&item.manifest, &context, &options);
        FeedPlan::new(layers, &item.manifest, &context, &options).unwrap()
    };
    let made = plan(feed);
    feed.set_plan(0, made, now);
    let mut messages = vec![ServerMessage::Manifest {
        character: 0,
        is_whole: true,
        hash: *hash.as_bytes(),
        bytes: match known {
            true => Vec::new(),
            false => compressed("manifest.json", &manifest_bytes).unwrap(),
        },
    }];
    for _ in 0..most {
        for message in std::mem::take(&mut messages) {
            // As bytes, as they travel.
            let message = ServerMessage::read(&message.to_bytes()).unwrap();
            if let Some(answer) = client.take(message, now).unwrap() {
                let answer = ClientMessage::read(&answer.to_bytes()).unwrap();
                assert_eq!(feed.take(answer, now).unwrap(), []);
            }
        }
        match feed.next(now) {
            FeedNext::Bytes(increment, file) => {
                let range = increment.range.start as usize..increment.range.end as usize;
                let bytes = &item.file(&increment.file).unwrap()[range];
                sent.add(&increment.file, increment.range.clone());
                let short = compressed(&increment.file, bytes).filter(|_| increment.is_whole);
                messages.push(ServerMessage::Bytes {
                    character: 0,
                    file,
                    offset: increment.range.start,
                    is_compressed: short.is_some(),
                    bytes: short.unwrap_or_else(|| bytes.to_vec()),
                });
            }
            FeedNext::Decision(decision) => messages.push(ServerMessage::Decision(decision)),
            FeedNext::Statistics(statistics) => {
                messages.push(ServerMessage::Statistics(statistics));
            }
            FeedNext::Complete(character) => {
                assert_eq!(character, 0);
                return true;
            }
            FeedNext::Wait(until) => {
                let bound = feed.context_of(0).network.available_bps;
                assert!(bound.is_some(), "nothing to wait for");
                now = until.max(now + 0.01);
                client.frame(now, 0.01).unwrap();
                if let Some(update) = client.update(now) {
                    assert_eq!(feed.take(update, now).unwrap(), []);
                }
            }
        }
    }
    lose(item, messages, sent);
    false
}

/// A connection ends before the last messages come.
fn lose(item: &Item, messages: Vec<ServerMessage>, sent: &mut Sent) {
    for message in messages {
        if let ServerMessage::Bytes {
            file,
            offset,
            bytes,
            is_compressed,
            ..
        } = message
        {
            let (name, entry) = item.manifest.files.iter().nth(usize::from(file)).unwrap();
            let bytes = if is_compressed {
                entry.bytes
            } else {
                bytes.len() as u64
            };
            sent.lose(name, &(offset..offset + bytes));
        }
    }
}

#[test]
fn sessions_go_on_where_one_before_was_cut_off() {
    let Some(item) = textured() else { return };
    let (mut client, character) = client();
    let mut sent = Sent::default();
    let mut sessions = 0;
    loop {
        sessions += 1;
        let hello = ClientMessage::read(&client.hello(0.0).to_bytes()).unwrap();
        let mut feed = Feed::new(hello, 0.0).unwrap();
        if serve(item, &mut feed, &mut client, &mut sent, 9) {
            break;
        }
        assert!(sessions < 200);
    }
    assert!(sessions > 3, "{sessions} sessions");
    client.frame(1.0, 0.01).unwrap();
    client.frame(2.0, 0.01).unwrap();
    let report = client.report(character);
    assert!(
        report.is_complete && report.level == report.levels,
        "{report:?}"
    );
    sent.check_once();
    // The same manifest, since all of the item is made now, asks for nothing.
    let again = ServerMessage::Manifest {
        character: 0,
        is_whole: true,
        hash: *blake3::hash(&manifest(item)).as_bytes(),
        bytes: Vec::new(),
    };
    assert_eq!(client.take(again, 2.0).unwrap(), None);
    let decision = client.decision(character).unwrap();
    assert!(decision.levels > 1 && decision.decision["explanation"].is_string());
}

#[test]
fn a_nearer_view_asks_for_more_and_a_bandwidth_bounds_what_comes() {
    let Some(item) = textured() else { return };
    let (mut client, character) = client();
    let mut far = context();
    far.view.distance_m = Some(60.0);
    far.preferences.tolerance_px = Some(1.0);
    client.set_context(&far, 0.0).unwrap();
    let mut network = Network::new(item, 100e6);
    let mut never = || false;
    for _ in 0..50 {
        network.answer(&mut client, &mut never);
        network.now_secs += 0.1;
        client.frame(network.now_secs, 0.1).unwrap();
    }
    let of_far = client.report(character);
    assert!(of_far.is_complete, "{of_far:?}");
    let mut near = context();
    near.network.available_bps = Some(80e3);
    client.set_context(&near, network.now_secs).unwrap();
    let (begin, bytes) = (network.now_secs, network.sent.bytes);
    let position = client.character(character).unwrap().position_secs();
    for _ in 0..10 {
        network.answer(&mut client, &mut never);
        network.now_secs += 0.1;
        client.frame(network.now_secs, 0.001).unwrap();
    }
    let came = (network.sent.bytes - bytes) as f64;
    let allowed = 10e3 * (network.now_secs - begin + 0.25);
    // One request goes over the bound at most.
    assert!(
        came > 0.0 && came <= allowed + 65536.0,
        "{came} of {allowed}"
    );
    assert!(!client.report(character).is_complete);
    let shown = client.character(character).unwrap();
    assert!(
        (shown.position_secs() - position).abs() < 0.02,
        "the clip begins anew"
    );
    network.sent.check_once();
}

#[test]
fn characters_share_a_bandwidth_by_importance_and_the_least_of_all_comes_first() {
    let Some(item) = textured() else { return };
    let (mut client, first) = client();
    let second = client.add("walker, nearer");
    client.set_view(second, 4.0, None).unwrap();
    let mut came = [0, 0];
    let mut shown_after = [None, None];
    let mut complete_after = [None, None];
    let mut now_secs = 0.0;
    while !client.is_complete() {
        now_secs += 0.3;
        while let Some((id, request)) = client.next_request(now_secs) {
            let answer = match request {
                ClientRequest::Manifest { .. } => ClientAnswer::Manifest {
                    bytes: manifest(item),
                    is_whole: true,
                },
                ClientRequest::Bytes { increment, .. } => {
                    let (start, end) = (increment.range.start, increment.range.end);
                    came[increment.character] += end - start;
                    let file = item.file(&increment.file).unwrap();
                    let bytes = file[start as usize..end as usize].to_vec();
                    now_secs += 0.3;
                    let transfer = Transfer {
                        bytes: end - start,
                        first_byte_secs: now_secs - 0.2,
                        last_byte_secs: now_secs,
                    };
                    ClientAnswer::Bytes { bytes, transfer }
                }
            };
            client.answer(id, answer, now_secs).unwrap();
            client.frame(now_secs, 0.0).unwrap();
            for character in [first, second] {
                let report = client.report(character);
                if report.level > 0 {
                    shown_after[character].get_or_insert(came);
                }
                if report.is_complete {
                    complete_after[character].get_or_insert(came);
                }
            }
        }
        client.frame(now_secs, 0.0).unwrap();
    }
    let all = client.report(second).bytes;
    let [Some(first_shown), Some(second_shown)] = shown_after else {
        panic!("both are shown: {shown_after:?}");
    };
    // Neither is refined before both are there.
    assert!(
        first_shown[0] < all / 2 && second_shown[1] < all / 2,
        "{shown_after:?}, {all}"
    );
    // When the one that matters has all, the other has the least and a fourth of what came after it.
    let then = complete_after[second].unwrap();
    assert!(
        then[0] > first_shown[0] / 2 && then[0] < 7 * all / 10,
        "{then:?} of {all}"
    );
}

#[test]
fn messages_come_back_and_mutated_ones_are_refused_or_harmless() {
    let Some(item) = textured() else { return };
    let (mut client, _) = client();
    let hello = client.hello(0.0);
    assert_eq!(ClientMessage::read(&hello.to_bytes()).unwrap(), hello);
    let shown = client.shown(59.5, 2.25);
    assert_eq!(ClientMessage::read(&shown.to_bytes()).unwrap(), shown);
    let short = manifest(item);
    let manifest_message = ServerMessage::Manifest {
        character: 0,
        is_whole: false,
        hash: *blake3::hash(&short).as_bytes(),
        bytes: compressed("manifest.json", &short).unwrap(),
    };
    let bytes = ServerMessage::Bytes {
        character: 0,
        file: 1,
        offset: 7,
        is_compressed: false,
        bytes: vec![1, 2, 3],
    };
    let complete = ServerMessage::Complete { character: 513 };
    for message in [&manifest_message, &bytes, &complete] {
        assert_eq!(ServerMessage::read(&message.to_bytes()).unwrap(), *message);
    }
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::Delete(8),
            Edit::Word(&["0", "-1", "1e99", "null", "[]", "18446744073709551615"]),
        ],
        most: 3,
    };
    for message in [hello.to_bytes(), shown.to_bytes()] {
        mutations.read_of(&message, 300, |bytes| {
            let read = ClientMessage::read(bytes);
            if let Ok(read) = &read
                && let Ok(mut feed) = Feed::new(read.clone(), 0.0)
            {
                let _ = feed.take(read.clone(), 0.1);
                let _ = feed.next(0.2);
            }
            read.is_ok()
        });
    }
    for message in [&manifest_message, &bytes, &complete] {
        mutations.read_of(&message.to_bytes(), 100, |bytes| {
            let read = ServerMessage::read(bytes);
            if let Ok(read) = &read {
                let _ = client.take(read.clone(), 0.1);
            }
            read.is_ok()
        });
    }
}

#[test]
fn a_session_refuses_what_is_not_of_it() {
    let Some(item) = textured() else { return };
    let (mut client, _) = client();
    let ClientMessage::Hello(update) = client.hello(0.0) else {
        panic!("it begins with a hello");
    };
    assert!(Feed::new(ClientMessage::Update(update.clone()), 0.0).is_err());
    let mut feed = Feed::new(ClientMessage::Hello(update.clone()), 0.0).unwrap();
    assert!(
        feed.take(ClientMessage::Hello(update.clone()), 0.0)
            .is_err()
    );
    let mut other = update;
    other.version = 2;
    let text = ClientMessage::Hello(other).to_bytes();
    assert!(
        ClientMessage::read(&text)
            .unwrap_err()
            .to_string()
            .contains("version")
    );
    // A server that claims more than there is.
    let huge = ServerMessage::Bytes {
        character: 0,
        file: 0,
        offset: 0,
        is_compressed: true,
        bytes: compressed("a.txt", &vec![0; 50_000_000]).unwrap(),
    };
    let hash = *blake3::hash(&manifest(item)).as_bytes();
    let first = ServerMessage::Manifest {
        character: 0,
        is_whole: true,
        hash,
        bytes: compressed("manifest.json", &manifest(item)).unwrap(),
    };
    assert!(
        client.take(huge.clone(), 0.0).is_err(),
        "before the manifest"
    );
    client.take(first, 0.0).unwrap();
    let error = client.take(huge, 0.0).unwrap_err().to_string();
    assert!(error.contains("more than"), "{error}");
    let lying = ServerMessage::Manifest {
        character: 0,
        is_whole: true,
        hash: [7; 32],
        bytes: compressed("manifest.json", &manifest(item)).unwrap(),
    };
    assert!(client.take(lying, 0.0).is_err());
}

/// The receiver of a client is the one of the library: what it has of an item can be asked.
#[test]
fn a_change_of_characters_is_told() {
    let Some(item) = textured() else { return };
    let (mut client, _) = client();
    let mut feed = Feed::new(client.hello(0.0), 0.0).unwrap();
    client.add("second");
    let update = client.update(0.0).unwrap();
    assert_eq!(feed.take(update, 0.0).unwrap(), [FeedChange::Characters]);
    let names: Vec<&str> = feed.characters().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["walker", "second"]);
    client.set_view(1, 2.0, Some(9.0)).unwrap();
    let update = client.update(0.0).unwrap();
    assert_eq!(feed.take(update, 0.0).unwrap(), [FeedChange::Plan(1)]);
    assert_eq!(feed.context_of(1).view.distance_m, Some(9.0));
    let of: &Manifest = &item.manifest;
    let known = ItemReceiver::new(&manifest(item), &articula::OpenOptions::default()).unwrap();
    assert_eq!(known.manifest(), of);
}

/// A small figure that turns, with forms in 2D.
fn with_forms() -> Item {
    let options = PackageOptions {
        mesh_levels: 2,
        flat_px: 64,
        ..PackageOptions::default()
    };
    package(fs::open(base()).unwrap(), &options, &Executor::default()).unwrap()
}

fn base() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb")
}

/// A server that begins anew may have another item by the same name: the objects of the first are gone.
#[test]
fn a_client_goes_on_with_another_item_of_the_same_name() {
    let Some(first) = textured() else { return };
    let second = with_forms();
    let (mut client, character) = client();
    let mut now_secs = 0.0;
    let mut lost = 0;
    for step in 0..400 {
        let item = if step < 2 { first } else { &second };
        let text = manifest(item);
        let hash = blake3::hash(&text).to_hex().to_string();
        now_secs += 0.1;
        // One request a step, so that the first item is not there whole.
        if let Some((id, request)) = client.next_request(now_secs) {
            let answer = match request {
                ClientRequest::Manifest { known, .. } if known.as_ref() == Some(&hash) => {
                    ClientAnswer::Unchanged { is_whole: true }
                }
                ClientRequest::Manifest { .. } => ClientAnswer::Manifest {
                    bytes: text,
                    is_whole: true,
                },
                ClientRequest::Bytes { object, increment } => {
                    let range = increment.range.start as usize..increment.range.end as usize;
                    let files = &mut item.manifest.files.iter();
                    match files.find(|(_, of)| of.hash == object) {
                        Some((file, _)) => ClientAnswer::Bytes {
                            bytes: item.file(file).unwrap()[range].to_vec(),
                            transfer: Transfer {
                                bytes: increment.range.end - increment.range.start,
                                first_byte_secs: now_secs - 0.05,
                                last_byte_secs: now_secs,
                            },
                        },
                        None => {
                            lost += 1;
                            ClientAnswer::Failed
                        }
                    }
                }
            };
            client.answer(id, answer, now_secs).unwrap();
        }
        client.frame(now_secs, 0.1).unwrap();
    }
    assert_eq!(lost, 1, "it asks what the server has now");
    assert!(client.is_complete());
    let shown = client.character(character).unwrap();
    let triangles = |figure: &Figure| figure.asset.mesh.triangles.len();
    let whole = Figure::new(fs::open(base()).unwrap()).unwrap();
    assert_eq!(triangles(shown.figure().unwrap()), triangles(&whole));
}

#[test]
fn nothing_is_sent_in_a_context_that_is_refused() {
    let item = with_forms();
    let (mut client, _) = client();
    let mut feed = Feed::new(client.hello(0.0), 0.0).unwrap();
    let text = manifest(&item);
    let hash = blake3::hash(&text);
    feed.set_manifest(0, &Arc::new(item.manifest.clone()), &hash.to_hex());
    let first = ServerMessage::Manifest {
        character: 0,
        is_whole: true,
        hash: *hash.as_bytes(),
        bytes: compressed("manifest.json", &text).unwrap(),
    };
    let held = client.take(first, 0.0).unwrap().unwrap();
    feed.take(held, 0.0).unwrap();
    let plan = || {
        let options = AdaptOptions::default();
        let plan = DeliveryPlan::new(&item.manifest, &context(), &options);
        FeedPlan::new(plan, &item.manifest, &context(), &options).unwrap()
    };
    let mut sent = Sent::default();
    let mut come = |feed: &mut Feed, most: usize| {
        for _ in 0..most {
            match feed.next(0.0) {
                FeedNext::Bytes(increment, _) => sent.add(&increment.file, increment.range),
                FeedNext::Complete(_) | FeedNext::Wait(_) => break,
                _ => {}
            }
        }
        sent.check_once();
        sent.bytes
    };
    feed.set_plan(0, plan(), 0.0);
    let before = come(&mut feed, 3);
    assert!(before > 0);
    feed.refuse_plan(0);
    assert_eq!(come(&mut feed, 100), before);
    // Another plan goes on where the first was.
    feed.set_plan(0, plan(), 0.0);
    assert!(come(&mut feed, 1000) > before);
}

#[test]
fn a_client_that_asks_for_a_form_in_2d_gets_it_alone_until_it_asks_for_the_figure() {
    let item = with_forms();
    let mut flat = context();
    flat.preferences.modality = Some(Modality::Vector);
    flat.network.available_bps = Some(1e6);
    let form = &item.manifest.flat[0];
    let whole: Vec<Range<u64>> = std::iter::once(0..form.bytes).collect();
    let all = [(form.file.clone(), whole)];

    // Over HTTP.
    let (mut client, character) = client();
    client.set_context(&flat, 0.0).unwrap();
    let mut network = Network::new(&item, 1e6);
    let mut step = |client: &mut Client| {
        for _ in 0..100 {
            network.answer(client, &mut || false);
            network.now_secs += 0.05;
            client.frame(network.now_secs, 0.05).unwrap();
        }
        network.sent.check_once();
        network.sent.ranges.clone()
    };
    assert_eq!(Vec::from_iter(step(&mut client)), all);
    let shown = client.character(character).unwrap();
    let bytes = item.file(&form.file).unwrap();
    assert_eq!(shown.flat(), Some((&*form.file, bytes)));
    assert!(shown.figure().is_none());
    let mut mesh = flat.clone();
    mesh.preferences.modality = Some(Modality::Mesh);
    client.set_context(&mesh, 5.0).unwrap();
    step(&mut client);
    let shown = client.character(character).unwrap();
    assert!(shown.flat().is_none() && shown.figure().is_some());

    // In a session.
    let mut client = Client::new(&flat, &ClientOptions::default()).unwrap();
    client.add("walker");
    let mut feed = Feed::new(client.hello(0.0), 0.0).unwrap();
    let mut sent = Sent::default();
    assert!(serve(&item, &mut feed, &mut client, &mut sent, 100));
    assert_eq!(Vec::from_iter(sent.ranges), all);
    assert!(client.character(0).unwrap().flat().is_some());
}
