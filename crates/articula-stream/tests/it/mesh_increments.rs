//! A client that fetches what it lacks of a growing selection of mesh levels has the meshes of that
//! selection, cut from the whole stream, in any order of arrival.

use crate::clustered_stream::levels;
use crate::increments::{bytes_of, has, part, shuffled};
use articula_mutate::Dice;
use articula_stream::mesh::{EncodedMeshStream, MeshStream, Receiver, write};
use articula_stream::{ByteRanges, CutRule, StreamLimits, Unit, cut, difference, selected};
use proptest::prelude::*;
use std::sync::OnceLock;

fn meshes() -> &'static EncodedMeshStream {
    static MESHES: OnceLock<EncodedMeshStream> = OnceLock::new();
    MESHES.get_or_init(|| {
        let (table, objects) = levels();
        write(table, objects, 0..table.levels.len()).unwrap()
    })
}

/// A client of a mesh that has the head.
fn mesh_client() -> Receiver {
    let head = MeshStream::head_length(&meshes().bytes).unwrap();
    Receiver::read(&meshes().bytes[..head], &StreamLimits::default()).unwrap()
}

fn assert_same_meshes(a: &Receiver, b: &Receiver) {
    for object in 0..a.stream().objects.len() {
        assert_eq!(a.finest_level(object), b.finest_level(object));
        assert!(a.mesh(object) == b.mesh(object) && a.triangles(object) == b.triangles(object));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn a_mesh_of_increments_is_that_of_the_cut(
        rules in prop::collection::vec((0_u32..6, 0_u32..4), 1..5),
        seed: u64,
    ) {
        let stream = meshes();
        let mut dice = Dice::new(seed);
        let head = stream.unit.children[0].bytes();
        let mut client = mesh_client();
        let mut have: ByteRanges = std::iter::once(0..head).collect();
        let mut fetched = Vec::new();
        for (level, objects) in rules {
            let rule = CutRule::default().at_least("level", level);
            let objects = (0..2).filter(|o| objects >> o & 1 == 0).collect();
            let rule = rule.among("object", objects);
            let want = selected(&stream.unit, |unit| rule.keeps(unit)).unwrap();
            let more = difference(&have, &want);
            let union = have.union(&want);
            prop_assert_eq!(have.bytes() + more.bytes(), union.bytes());
            for range in shuffled(more.ranges().to_vec(), &mut dice) {
                let refined = client.receive_at(range.start, part(&stream.bytes, &range)).unwrap();
                let sorted = refined.is_sorted();
                prop_assert!(sorted);
                fetched.push(range);
            }
            have = union;
            let mut again = mesh_client();
            for range in shuffled(fetched.clone(), &mut dice) {
                again.receive_at(range.start, part(&stream.bytes, &range)).unwrap();
            }
            assert_same_meshes(&client, &again);
            let keeps = |unit: &Unit| unit.label != "chunk" || has(&have, &bytes_of(unit));
            let of_cut = cut(&stream.bytes, &stream.unit, keeps).unwrap();
            assert_same_meshes(&client, &Receiver::read(&of_cut.bytes, &StreamLimits::default()).unwrap());
        }
    }
}

#[test]
fn chunks_wait_for_coarser_ones_and_go_with_what_is_freed() {
    let stream = meshes();
    let mut client = mesh_client();
    let chunk = |level, object| {
        let head = MeshStream::open(&stream.bytes, &StreamLimits::default()).unwrap();
        let range = head.chunk(level, object).unwrap();
        (range.start as u64, &stream.bytes[range])
    };
    let count = client.stream().levels.levels.len();
    let give = |client: &mut Receiver, level| {
        let (offset, bytes) = chunk(level, 1);
        client.receive_at(offset, bytes).unwrap()
    };
    for level in 0..count - 1 {
        assert!(give(&mut client, level).is_empty());
        assert_eq!(client.finest_level(1), None);
    }
    assert_eq!(give(&mut client, count - 1), [1]);
    let whole = Receiver::read(&stream.bytes, &StreamLimits::default()).unwrap();
    assert!(client.finest_level(1) == Some(0) && client.mesh(1) == whole.mesh(1));
    assert_eq!(client.finest_level(0), None);
    // Freed levels come back only when they are fetched again.
    client.coarsen(1, count - 1);
    assert!(give(&mut client, 0).is_empty());
    client.coarsen(1, 1);
    for level in (1..count - 1).rev() {
        assert_eq!(give(&mut client, level), [1]);
    }
    assert_eq!(
        client.finest_level(1),
        Some(1),
        "the finest was freed while it waited"
    );
    let (offset, bytes) = chunk(0, 1);
    let mut bad = bytes.to_vec();
    bad[bytes.len() / 2] ^= 4;
    assert!(client.receive_at(offset, &bad).is_err());
    assert!(client.receive_at(offset, &bytes[1..]).is_err());
    assert!(client.receive_at(offset + 1, &bytes[1..]).is_err());
    assert_eq!(client.finest_level(1), Some(1));
    assert_eq!(client.receive_at(offset, bytes).unwrap(), [1]);
    assert!(client.mesh(1) == whole.mesh(1));
    assert!(client.receive_at(offset, bytes).unwrap().is_empty());
}
