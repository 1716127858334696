//! Items that arrive in pieces: whatever was selected before, in whatever order it came, a client shows
//! what the same selection cut from the whole item shows, and receives no byte twice.

use crate::real;
use crate::short::shortened;
use articula::item::{
    AdaptOptions, AdaptedItem, FaceMotion, Item, ItemBytes, ItemChange, ItemCut, ItemReceiver,
    MANIFEST, PackageOptions, PartKind, Regions, adapt, assemble, decide, package,
};
use articula::{Data, DataFormat, Executor, OpenOptions, fs, open_data};
use articula_core::source::RawClip;
use articula_mutate::{Edit, Mutations};
use articula_stream::ByteRanges;
use articula_stream::description::Context;
use proptest::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::OnceLock;

fn options() -> PackageOptions {
    PackageOptions {
        mesh_levels: 3,
        flat: false,
        texture_distances_m: vec![3.0],
        ..PackageOptions::default()
    }
}

/// Mesh levels, two motions of the body and a texture.
pub(crate) fn textured() -> Option<&'static Item> {
    static ITEM: OnceLock<Option<Item>> = OnceLock::new();
    let made = || {
        let mut file = shortened(fs::open(real::file("glb/CesiumMan.glb")?).unwrap(), 0.3);
        let second = RawClip {
            name: "second".to_owned(),
            ..file.character().clips[0].clone()
        };
        file.clips_mut().push(second);
        Some(package(file, &options(), &Executor::default()).unwrap())
    };
    ITEM.get_or_init(made).as_ref()
}

/// Mesh levels by region and a motion of the face.
fn speaking() -> Option<&'static Item> {
    static ITEM: OnceLock<Option<Item>> = OnceLock::new();
    let made = || {
        let file = shortened(
            fs::open(real::file("glb/ict_head_talk_554.glb")?).unwrap(),
            0.1,
        );
        let talk = real::bytes("fap/speech_synthetic.fap")?;
        let open = OpenOptions::default();
        let Data::Fap(mut clip) = open_data(&talk, "talk.fap", DataFormat::Fap, &open)
            .unwrap()
            .data
        else {
            panic!("a FAP file holds a FAP clip");
        };
        clip.frames.truncate(12);
        let options = PackageOptions {
            faces: vec![FaceMotion {
                file: "talk.fap".into(),
                clip,
            }],
            ..options()
        };
        Some(package(file, &options, &Executor::default()).unwrap())
    };
    ITEM.get_or_init(made).as_ref()
}

pub(crate) fn manifest(item: &Item) -> Vec<u8> {
    let mut files = item.files();
    let found = files.pop().filter(|(name, _)| name == MANIFEST);
    found.unwrap().1
}

fn receiver(item: &Item) -> ItemReceiver {
    ItemReceiver::new(&manifest(item), &OpenOptions::default()).unwrap()
}

/// Passes ranges of files to a receiver in an order by `seed`, each in two pieces.
fn fetch(item: &Item, receiver: &mut ItemReceiver, wanted: &ItemBytes, seed: u64) {
    let mut ranges: Vec<(String, u64, u64)> = wanted
        .files()
        .flat_map(|(name, ranges)| {
            let ranges = ranges.ranges().iter();
            ranges.map(move |range| (name.to_owned(), range.start, range.end))
        })
        .collect();
    ranges.sort_by_key(|(name, start, _)| mixed(seed ^ mixed(*start ^ name.len() as u64)));
    for (name, start, end) in ranges {
        let file = item.file(&name).unwrap();
        let middle = start + mixed(seed ^ end) % (end - start);
        for range in [start..middle, middle..end] {
            let bytes = &file[range.start as usize..range.end as usize];
            receiver.receive(&name, range.start, bytes).unwrap();
        }
    }
}

fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^ (x >> 29)
}

/// A cut that keeps of each part what some numbers select: a layer with all that it needs, or nothing.
fn selection(item: &Item, numbers: &[usize]) -> Vec<Vec<bool>> {
    let parts = item.manifest.parts.iter().enumerate();
    let of_part = parts.map(|(p, part)| {
        let chosen = numbers[p % numbers.len()] % (part.layers.len() + 1);
        match (chosen, part.kind) {
            (0, _) => vec![false; part.layers.len()],
            (of, PartKind::Texture) => (0..part.layers.len()).map(|l| l + 1 == of).collect(),
            (of, _) => part.closure(&[of - 1]),
        }
    });
    of_part.collect()
}

fn layers(kept: Vec<Vec<bool>>) -> ItemCut {
    ItemCut::Layers {
        kept,
        regions: Regions::default(),
    }
}

/// What a client shows that has these layers: the item cut to them.
fn expected(item: &Item, held: &[Vec<bool>]) -> Item {
    match adapt(item, &layers(held.to_vec())).unwrap() {
        AdaptedItem::Layers(item) => item,
        AdaptedItem::Flat { entry, .. } => panic!("{}", entry.file),
    }
}

fn check(item: &Item, steps: &[Vec<usize>], seed: u64) {
    let mut client = receiver(item);
    let mut held: Vec<Vec<bool>> = selection(item, &[0]);
    let mut fetched: BTreeMap<String, ByteRanges> = BTreeMap::new();
    for (s, numbers) in steps.iter().enumerate() {
        let kept = selection(item, numbers);
        let cut = layers(kept.clone());
        // Who has nothing yet fetches what is cut for the same layers, no more and no less.
        let alone = item.manifest.wanted(&cut).unwrap().bytes();
        assert_eq!(alone, expected(item, &kept).bytes());
        let missing = client.missing(&cut).unwrap();
        for (name, ranges) in missing.files() {
            let known = fetched.entry(name.to_owned()).or_default();
            let both = known.union(ranges);
            assert_eq!(both.bytes(), known.bytes() + ranges.bytes(), "{name} twice");
            *known = both;
        }
        fetch(item, &mut client, &missing, seed ^ s as u64);
        assert_eq!(client.missing(&cut).unwrap().bytes(), 0);
        for (held, kept) in held.iter_mut().zip(&kept) {
            held.iter_mut()
                .zip(kept)
                .for_each(|(held, kept)| *held |= kept);
        }
        if mixed(seed ^ s as u64).is_multiple_of(3) {
            // The same state of the item again: nothing is lost.
            client = client.renewed(&manifest(item)).unwrap();
            assert_eq!(client.missing(&cut).unwrap().bytes(), 0);
        }
        if mixed(seed ^ s as u64).is_multiple_of(2) {
            // The client ends, and another goes on from what it stored, in another order.
            let mut next = receiver(item);
            let stored = client.held();
            assert_eq!(stored.files().count(), fetched.len());
            fetch(item, &mut next, &stored, !seed);
            for (name, _) in stored.files() {
                assert!(next.pieces(name).eq(client.pieces(name)), "{name}");
            }
            client = next;
        }
        let shown = client.character().unwrap();
        let right = assemble(&expected(item, &held), &OpenOptions::default()).unwrap();
        assert!(shown.character() == right.character(), "step {s}: {kept:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn a_client_shows_what_the_same_selections_cut_show(
        steps in prop::collection::vec(prop::collection::vec(0_usize..1000, 5), 1..5),
        seed in any::<u64>(),
    ) {
        for item in [textured(), speaking()].into_iter().flatten() {
            check(item, &steps, seed);
        }
    }
}

#[test]
fn what_is_wrong_is_refused_and_fetched_again() {
    let Some(item) = textured() else { return };
    let all = ItemCut::Layers {
        kept: item
            .manifest
            .parts
            .iter()
            .map(|p| vec![true; p.layers.len()])
            .collect(),
        regions: Regions::default(),
    };
    let mut client = receiver(item);
    let wanted = client.missing(&all).unwrap();
    // Of the sizes of a texture the largest is enough.
    let textures = |bytes: &ItemBytes| {
        bytes
            .files()
            .filter(|(name, _)| name.starts_with("textures/"))
            .count()
    };
    assert_eq!(textures(&wanted), 1);
    for (name, ranges) in wanted.files() {
        let file = item.file(name).unwrap();
        assert!(client.receive(name, file.len() as u64, &[0]).is_err());
        assert_eq!(ranges.bytes(), file.len() as u64);
        let mut bytes = file.to_vec();
        bytes[file.len() / 2] ^= 0x10;
        let (start, end) = bytes.split_at(file.len() - 1);
        let found = client.receive(name, 0, start);
        // Nothing tells what is wrong with a picture before it is whole, or with a motion before its figure.
        let found = found.and_then(|_| client.receive(name, start.len() as u64, end));
        assert!(
            found.is_err() && client.pieces(name).next().is_none(),
            "{name}"
        );
        if name == "clips/second.abp" {
            assert_eq!(client.receive(name, 0, start).unwrap(), ItemChange::Nothing);
        }
    }
    assert!(client.receive("figure.glb.exe", 0, &[0]).is_err());
    let figure = item.file("figure.glb").unwrap();
    let why = client.receive("figure.glb", 0, figure).unwrap_err();
    assert!(why.to_string().contains("clips/second.abp"), "{why}");
    assert_eq!(client.pieces("clips/second.abp").count(), 0);
    let wanted = client.missing(&all).unwrap();
    fetch(item, &mut client, &wanted, 3);
    assert_eq!(client.missing(&all).unwrap().bytes(), 0);
    let right = assemble(item, &OpenOptions::default()).unwrap();
    assert!(client.character().unwrap().character() == right.character());
}

/// The manifest as version 1 has it: neither hashes nor ranges.
fn manifest_of_version_1(item: &Item) -> Vec<u8> {
    let mut plain: Value = serde_json::from_slice(&manifest(item)).unwrap();
    plain["version"] = 1.into();
    plain.as_object_mut().unwrap().remove("files");
    for part in plain["parts"].as_array_mut().unwrap() {
        part.as_object_mut().unwrap().remove("base_ranges");
        for layer in part["layers"].as_array_mut().unwrap() {
            layer.as_object_mut().unwrap().remove("ranges");
        }
    }
    plain.to_string().into_bytes()
}

#[test]
fn streams_without_ranges_are_shown_once_they_are_whole() {
    for item in [textured(), speaking()].into_iter().flatten() {
        let plain = manifest_of_version_1(item);
        let mut client = ItemReceiver::new(&plain, &OpenOptions::default()).unwrap();
        let parts = item.manifest.parts.iter();
        let all = ItemCut::Layers {
            kept: parts.map(|p| vec![true; p.layers.len()]).collect(),
            regions: Regions::default(),
        };
        let missing = client.missing(&all).unwrap();
        for (name, ranges) in missing.files() {
            let file = item.file(name).unwrap();
            assert_eq!(ranges.bytes(), file.len() as u64, "{name}");
            let (start, end) = file.split_at(file.len() / 2);
            let later = client.receive(name, start.len() as u64, end).unwrap();
            assert_eq!(later, ItemChange::Nothing, "{name}");
            let whole = client.receive(name, 0, start).unwrap();
            // Motions of the body come before the figure, which shows them.
            let waits = name.ends_with(".abp");
            assert_eq!(whole == ItemChange::Nothing, waits, "{name}");
        }
        let right = assemble(item, &OpenOptions::default()).unwrap();
        assert!(
            !right.character().meshes[0].primitives[0]
                .triangles
                .is_empty()
        );
        assert!(client.character().unwrap().character() == right.character());
    }
}

#[test]
fn hostile_manifests_and_bytes_end_in_values_or_errors() {
    let Some(item) = textured() else { return };
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::Delete(8),
            Edit::Word(&["0", "-1", "1e99", "null", "[]", "18446744073709551615"]),
        ],
        most: 3,
    };
    let all = |client: &ItemReceiver| ItemCut::Layers {
        kept: (client.manifest().parts.iter())
            .map(|part| vec![true; part.layers.len()])
            .collect(),
        regions: Regions::default(),
    };
    mutations.read_of(&manifest(item), 150, |manifest| {
        let Ok(mut client) = ItemReceiver::new(manifest, &OpenOptions::default()) else {
            return false;
        };
        let missing = client.missing(&all(&client)).unwrap();
        for (name, ranges) in missing.files() {
            for range in ranges.ranges() {
                let bytes = item.file(name).unwrap_or_default();
                let (start, end) = (range.start as usize, range.end as usize);
                let bytes = bytes.get(start..end).unwrap_or(b"0123456789");
                let _ = client.receive(name, range.start, bytes);
            }
        }
        client.character().is_ok()
    });
    // Without hashes, streams and the figure are read as they come.
    let mut plain: Value = serde_json::from_slice(&manifest(item)).unwrap();
    plain["version"] = 1.into();
    plain.as_object_mut().unwrap().remove("files");
    let plain = plain.to_string().into_bytes();
    for name in ["mesh.ams", "clips/second.abp", "figure.glb"] {
        mutations.read_of(item.file(name).unwrap(), 40, |bytes| {
            let mut client = ItemReceiver::new(&plain, &OpenOptions::default()).unwrap();
            for file in ["figure.glb", "mesh.ams", "clips/second.abp"] {
                let right = item.file(file).unwrap();
                let given = if file == name { bytes } else { right };
                let given = &given[..given.len().min(right.len())];
                let _ = client.receive(file, 0, given);
            }
            client.character().is_ok()
        });
    }
}

#[test]
fn a_client_decides_by_the_manifest_as_who_has_the_item_does() {
    let options = AdaptOptions::default();
    for item in [textured(), speaking()].into_iter().flatten() {
        let client = receiver(item);
        let mut outcomes = Vec::new();
        for kbps in [10.0, 100.0, 300.0, 3000.0] {
            let mut context = Context::default();
            context.network.available_bps = Some(1e3 * kbps);
            context.view.distance_m = Some(4.0);
            context.terminal.codecs = ["ams", "abp2", "afp2"].map(str::to_owned).to_vec();
            let decided = client.decide(&context, &options).unwrap();
            assert_eq!(decided, decide(item, &context, &options).unwrap());
            outcomes.push(decided.cut);
        }
        assert!(
            outcomes[0].is_none() && outcomes[3].is_some(),
            "{outcomes:?}"
        );
        let mut context = Context::default();
        context.terminal.codecs = vec!["ams".to_owned()];
        assert!(client.decide(&context, &options).unwrap().cut.is_none());
        context.preferences.body_regions = Some(1);
        assert!(client.decide(&context, &options).is_err());
    }
}
