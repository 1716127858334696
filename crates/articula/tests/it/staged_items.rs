//! Items that are packaged in stages: each is complete, and holds what the one before does.

use crate::real;
use crate::short::shortened;
use articula::item::{
    AdaptOptions, Item, ItemCut, ItemPart, ItemReceiver, MANIFEST, PackageOptions, PartKind,
    Regions, assemble, decide, package, package_in_stages,
};
use articula::{CharacterFile, Error, Executor, OpenOptions, fs};
use articula_core::source::RawClip;
use articula_formats::Limits;
use articula_stream::description::Context;

/// A character with a texture and two clips.
fn textured() -> Option<CharacterFile> {
    let mut file = shortened(fs::open(real::file("glb/CesiumMan.glb")?).unwrap(), 0.3);
    let second = RawClip {
        name: "second".to_owned(),
        ..file.character().clips[0].clone()
    };
    file.clips_mut().push(second);
    Some(file)
}

fn options() -> PackageOptions {
    PackageOptions {
        mesh_levels: 3,
        flat: false,
        texture_distances_m: vec![3.0, 12.0],
        ..PackageOptions::default()
    }
}

/// The item, opened again from its files.
fn reopened(item: &Item) -> Item {
    let files = item.files();
    let file = |name: &str| files.iter().find(|f| f.0 == name).map(|f| f.1.clone());
    let manifest = file(MANIFEST).unwrap();
    let mut resolver = |name: &str| file(name).ok_or_else(|| "there is no such file".into());
    Item::open(&manifest, &Limits::default(), &mut resolver).unwrap()
}

/// The part of the same kind and name.
fn same<'a>(item: &'a Item, part: &ItemPart) -> &'a ItemPart {
    let mut parts = item.manifest.parts.iter();
    let found = parts.find(|p| (p.kind, &p.name) == (part.kind, &part.name));
    found.unwrap_or_else(|| panic!("{:?} {}", part.kind, part.name))
}

#[test]
fn every_stage_is_an_item_of_which_the_next_one_has_all() {
    let Some(file) = textured() else { return };
    let work = Executor::default();
    let mut stages: Vec<Item> = Vec::new();
    let last = package_in_stages(file.clone(), &options(), &work, &mut |item| {
        stages.push(item.clone());
        Ok(())
    });
    stages.push(last.unwrap());
    let whole = package(file, &options(), &work).unwrap();
    assert!(*stages.last().unwrap() == whole, "stages end with the item");
    // Base, textures, the first clip, mesh levels, the second clip.
    assert_eq!(stages.len(), 5);

    for stage in &stages {
        assert_eq!(reopened(stage), *stage);
        let shown = assemble(stage, &OpenOptions::default()).unwrap();
        assert!(
            !shown.character().meshes[0].primitives[0]
                .triangles
                .is_empty()
        );
        assert!(!shown.character().clips.is_empty());
    }
    for pair in stages.windows(2) {
        let [before, after] = pair else { continue };
        assert!(after.sent_bytes() >= before.sent_bytes());
        for part in &before.manifest.parts {
            let of_after = same(after, part);
            if part.kind == PartKind::Texture {
                continue;
            }
            // What was made is a cut of what is made.
            let named = |layer: usize| {
                let name = &of_after.layers[layer].name;
                part.layers.iter().position(|l| l.name == *name)
            };
            let cut = after.kept(|p, layer| {
                (p.kind, &p.name) != (part.kind, &part.name) || named(layer).is_some()
            });
            let file = part.file.as_deref().unwrap();
            assert!(cut.unwrap().file(file) == before.file(file), "{file}");
            for (layer, name) in (0..of_after.layers.len()).filter_map(|l| Some((l, named(l)?))) {
                let (error, stated) = (of_after.layers[layer].error_m, part.layers[name].error_m);
                // Meshes of the base are measured in one clip alone.
                match part.kind {
                    PartKind::Mesh => assert!(stated > 0.0 && stated < 2.0 * error),
                    _ => assert_eq!(stated, error, "{} {file}", part.layers[name].name),
                }
            }
        }
    }

    check_receiver(&stages);

    let base = &stages[0];
    let tiers = whole.manifest.parts.iter().map(|p| p.layers.len());
    assert!(tiers.max() > Some(5));
    assert!(base.manifest.parts.iter().all(|p| p.layers.len() <= 4));
    assert!(3 * base.sent_bytes() < whole.sent_bytes());
}

/// A client that fetches each stage as it is made shows it, and fetches of a stream that grows no layer
/// twice.
fn check_receiver(stages: &[Item]) {
    let mut client = ItemReceiver::new(&manifest(&stages[0]), &OpenOptions::default()).unwrap();
    let mut held = 0;
    for (s, stage) in stages.iter().enumerate() {
        client = client.renewed(&manifest(stage)).unwrap();
        let missing = client.missing(&all(stage)).unwrap();
        let heads = stage.manifest.parts.iter().map(|part| part.base_bytes);
        let heads: u64 = heads.sum();
        assert!(missing.bytes() + held <= stage.bytes() + heads, "stage {s}");
        for (name, ranges) in missing.files() {
            for range in ranges.ranges() {
                let bytes = &stage.file(name).unwrap()[range.start as usize..range.end as usize];
                client.receive(name, range.start, bytes).unwrap();
            }
        }
        let right = assemble(stage, &OpenOptions::default()).unwrap();
        let shown = client.character().unwrap();
        assert!(shown.character() == right.character(), "stage {s}");
        // Small sizes of textures are not sent again, but not needed either.
        let textures = stage
            .manifest
            .parts
            .iter()
            .filter(|p| p.kind == PartKind::Texture);
        held = client.held().bytes() - textures.map(|p| p.layers[0].bytes).sum::<u64>();
    }
    // A server that was stopped while it packaged begins anew: all is here, until the item is whole.
    for (s, stage) in stages.iter().enumerate().chain(stages.iter().enumerate()) {
        client = client.renewed(&manifest(stage)).unwrap();
        assert_eq!(client.missing(&all(stage)).unwrap().bytes(), 0, "stage {s}");
    }
    let right = assemble(&stages[stages.len() - 1], &OpenOptions::default()).unwrap();
    assert!(client.character().unwrap().character() == right.character());
    client.settle();
    client = client.renewed(&manifest(&stages[0])).unwrap();
    assert!(client.missing(&all(&stages[0])).unwrap().bytes() > 0);
}

fn manifest(item: &Item) -> Vec<u8> {
    item.files().pop().unwrap().1
}

/// All layers of an item.
fn all(item: &Item) -> ItemCut {
    let parts = item.manifest.parts.iter();
    ItemCut::Layers {
        kept: parts.map(|part| vec![true; part.layers.len()]).collect(),
        regions: Regions::default(),
    }
}

#[test]
fn an_error_of_the_caller_stops_the_work() {
    let Some(file) = textured() else { return };
    let mut stages = 0;
    let stopped = package_in_stages(file, &options(), &Executor::default(), &mut |_| {
        stages += 1;
        Err(Error::Io("the disk is full".to_owned()))
    });
    assert!(matches!(stopped, Err(Error::Io(what)) if what == "the disk is full"));
    assert_eq!(stages, 1);
}

/// Of a character of many parts and clips, 15 kB without the heads of the other clips.
#[test]
fn the_least_of_an_item_is_small() {
    let Some(path) = real::file("glb/RobotExpressive.glb") else {
        return;
    };
    let file = fs::open(path).unwrap();
    let clips = file.character().clips.len() as u64;
    let options = PackageOptions {
        flat: false,
        ..PackageOptions::default()
    };
    let mut base = None;
    let stopped = package_in_stages(file, &options, &Executor::default(), &mut |item| {
        base = Some(item.clone());
        Err(Error::Cancelled)
    });
    assert!(stopped.is_err());
    let nothing = AdaptOptions {
        max_bytes: Some(1),
        ..AdaptOptions::default()
    };
    let decided = decide(&base.unwrap(), &Context::default(), &nothing).unwrap();
    let least = decided.least_bytes.unwrap() + 300 * (clips - 1);
    assert!(least <= 15_000, "{least} bytes");
}
