//! A character that a server is given: it is shown from the first stage on, each byte is fetched once, and
//! it is never packaged again.

use crate::client::{Server, options};
use crate::real;
use articula::item::{ItemBytes, ItemCut, ItemReceiver, MANIFEST, Regions, assemble, package};
use articula::{Executor, OpenOptions, open};
use articula_serve::Catalogue;
use std::collections::BTreeSet;

/// Fetches ranges of objects, each of which no one had before.
fn fetch(
    server: &Server,
    client: &mut ItemReceiver,
    wanted: &ItemBytes,
    fetched: &mut BTreeSet<(String, u64)>,
) -> u64 {
    let mut bytes = 0;
    for (name, ranges) in wanted.files() {
        let hash = client.manifest().files[name].hash.clone();
        for range in ranges.ranges() {
            let value = format!("bytes={}-{}", range.start, range.end - 1);
            let answer = server.get(&format!("/v1/o/{hash}"), &[("Range", &value)]);
            assert_eq!(answer.status, 206);
            assert_eq!(answer.body.len() as u64, range.end - range.start);
            for byte in range.clone() {
                assert!(
                    fetched.insert((hash.clone(), byte)),
                    "byte {byte} of {name} twice"
                );
            }
            client.receive(name, range.start, &answer.body).unwrap();
            bytes += answer.body.len() as u64;
        }
    }
    bytes
}

fn all(client: &ItemReceiver) -> ItemCut {
    let parts = client.manifest().parts.iter();
    ItemCut::Layers {
        kept: parts.map(|part| vec![true; part.layers.len()]).collect(),
        regions: Regions::default(),
    }
}

fn state(server: &Server) -> String {
    let answer = server.get("/v1/characters/man", &[]);
    answer.json()["state"].as_str().unwrap().to_owned()
}

#[test]
fn a_character_is_shown_from_its_first_stage_on() {
    let Some(glb) = real::bytes("glb/CesiumMan.glb") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    assert_eq!(server.get("/v1/characters", &[]).body, b"[]");
    let put = server.request("PUT", "/v1/characters/man", &[], &glb);
    assert_eq!(
        (put.status, put.json()["state"].as_str()),
        (202, Some("waiting"))
    );

    let path = "/v1/characters/man/manifest.json";
    let mut client: Option<ItemReceiver> = None;
    let (mut tag, mut fetched, mut sent) = (String::new(), BTreeSet::new(), Vec::new());
    loop {
        let was_ready = state(&server) == "ready";
        let answer = server.get(&format!("{path}?wait=60"), &[("If-None-Match", &tag)]);
        if answer.status == 304 {
            assert!(was_ready, "it waits for news otherwise");
            break;
        }
        assert_eq!(answer.status, 200);
        answer.header("etag").clone_into(&mut tag);
        let open = OpenOptions::default();
        let mut now = match &client {
            None => ItemReceiver::new(&answer.body, &open).unwrap(),
            Some(client) => client.renewed(&answer.body).unwrap(),
        };
        let missing = now.missing(&all(&now)).unwrap();
        sent.push(fetch(&server, &mut now, &missing, &mut fetched));
        let shown = now.character().unwrap();
        let primitive = &shown.character().meshes[0].primitives[0];
        assert!(!primitive.triangles.is_empty() && !shown.character().clips.is_empty());
        client = Some(now);
    }
    // At least the base and the whole were seen, and the base is a small part.
    assert!(
        sent.len() >= 2 && 3 * sent[0] < sent.iter().sum(),
        "{sent:?}"
    );
    let work = Executor::default();
    let mut nothing = |_: &str| Err("nothing".to_owned());
    let opened = open(&glb, "man.glb", &OpenOptions::default(), &mut nothing).unwrap();
    let item = package(opened, &options().package, &work).unwrap();
    let right = assemble(&item, &OpenOptions::default()).unwrap();
    let shown = client.unwrap().character().unwrap();
    assert!(shown.character() == right.character());
    assert!(
        server
            .get("/", &[])
            .body
            .windows(5)
            .any(|word| word == b"ready")
    );

    conditional(&server, path, &item.files().pop().unwrap().1);
    let counted = server.get("/metrics", &[]);
    let counted = String::from_utf8(counted.body).unwrap();
    assert!(counted.contains("articula_packaged_total 1\n"), "{counted}");
    drop(server);

    // The next server on the folder has it at once, also if it may not write.
    let mut read_only = options();
    read_only.read_only = true;
    let server = Server::start(folder.path(), &read_only);
    assert_eq!(state(&server), "ready");
    let again = server.get(path, &[("If-None-Match", &tag)]);
    assert_eq!((again.status, again.body.len()), (304, 0));
    assert_eq!(
        server
            .request("PUT", "/v1/characters/other", &[], &glb)
            .status,
        403
    );
    drop(server);
    // Packaged in another way, it is another item.
    let mut other = options();
    other.package.mesh_levels = 1;
    let catalogue = Catalogue::open(folder.path(), &other).unwrap();
    let waits = articula_serve::Progress::Waiting;
    assert_eq!(catalogue.state("man").unwrap().progress, waits);
}

/// Requests with conditions, ranges and codings.
fn conditional(server: &Server, path: &str, manifest: &[u8]) {
    let whole = server.get(path, &[]);
    assert_eq!((whole.status, &*whole.body), (200, manifest));
    assert_eq!(whole.header("content-type"), "application/json");
    assert_eq!(whole.header("cache-control"), "no-cache");
    let short = server.get(path, &[("Accept-Encoding", "gzip, br")]);
    assert_eq!(short.header("content-encoding"), "br");
    assert!(3 * short.body.len() < manifest.len());
    assert_ne!(short.header("etag"), whole.header("etag"));
    let part = server.get(path, &[("Range", "bytes=1-15"), ("Accept-Encoding", "br")]);
    assert_eq!((part.status, &*part.body), (206, &manifest[1..16]));
    let of = format!("bytes 1-15/{}", manifest.len());
    assert_eq!(
        (
            part.header("content-range"),
            part.header("content-encoding")
        ),
        (&*of, "")
    );
    let stale = server.get(path, &[("Range", "bytes=1-15"), ("If-Range", "\"other\"")]);
    assert_eq!((stale.status, stale.body.len()), (200, manifest.len()));
    let beyond = server.get(path, &[("Range", "bytes=99999999-")]);
    let of = format!("bytes */{}", manifest.len());
    assert_eq!((beyond.status, beyond.header("content-range")), (416, &*of));
    let head = server.request("HEAD", path, &[], b"");
    let length = manifest.len().to_string();
    assert_eq!((head.status, head.body.len()), (200, 0));
    assert_eq!(head.header("content-length"), length);
    let object = whole.header("etag").trim_matches('"').to_owned();
    let same = server.get(&format!("/v1/o/{object}"), &[]);
    assert_eq!(same.body, manifest);
    assert!(same.header("cache-control").contains("immutable"));
    let figure = server.get(&path.replace(MANIFEST, "figure.glb"), &[]);
    assert_eq!(figure.header("content-type"), "model/gltf-binary");
    assert!(figure.body.starts_with(b"glTF"));
}
