//! Descriptions of the stored streams of all codecs: they come back, and every cut of them is that
//! of the map, of xsltproc and of a script in node.

use crate::description_tools::{Judges, LIMITS};
use articula_stream::description::{
    GbsdOptions, Holes, Selection, gbsd_to_bin, read_gbsd, write_gbsd,
};
use articula_stream::mesh::MeshStream;
use articula_stream::{StreamLimits, Unit, abp1, abp2, afp1};

/// The stored streams with their maps.
fn streams() -> Vec<(&'static str, &'static [u8], Unit)> {
    let limits = StreamLimits::default();
    let bones: &[u8] = include_bytes!("../golden/wave.abp");
    let coarse: &[u8] = include_bytes!("../golden/wave-loa-0.abp");
    let motion: &[u8] = include_bytes!("../golden/walk.abp");
    let face: &[u8] = include_bytes!("../golden/wave.afp");
    let tiers: &[u8] = include_bytes!("../golden/wave2.afp");
    let mesh: &[u8] = include_bytes!("../golden/levels-2.ams");
    vec![
        ("ABP-1", bones, abp1::unit(bones, &limits).unwrap()),
        (
            "ABP-1 at level 0",
            coarse,
            abp1::unit(coarse, &limits).unwrap(),
        ),
        ("ABP-2", motion, abp2::motion_map(motion, &limits).unwrap()),
        ("AFP-1", face, afp1::unit(face, &limits).unwrap()),
        ("AFP-2", tiers, abp2::motion_map(tiers, &limits).unwrap()),
        (
            "mesh",
            mesh,
            MeshStream::open(mesh, &limits).unwrap().unit(),
        ),
    ]
}

/// The values that markers of a scheme have in a map.
fn values(map: &Unit, scheme: &str) -> Vec<u32> {
    let mut found = Vec::new();
    map.visit(&mut |unit| found.extend(unit.marker(scheme)));
    found.sort_unstable();
    found.dedup();
    found
}

/// Selections that keep a part of a stream, by all markers that it has.
fn selections(map: &Unit) -> Vec<Selection> {
    let mut all = vec![Selection::default()];
    let has = |scheme: &str| !values(map, scheme).is_empty();
    let is_face = has("parameter") || has("face_loa");
    if has("loa") && !has("parameter") {
        all.extend((0..5).map(Selection::of_loa));
        let legs = Selection {
            body_regions: Some(0b11_1000),
            ..Selection::of_loa(5)
        };
        all.extend([
            legs.clone(),
            Selection {
                body_loa: Some(2),
                ..legs
            },
        ]);
    }
    if has("joint") {
        let joints = values(map, "joint").into_iter().step_by(3).collect();
        all.push(Selection {
            joints: Some(joints),
            ..Selection::default()
        });
    }
    for tier in values(map, "tier") {
        all.push(Selection {
            tier: Some(tier + 1),
            ..Selection::default()
        });
    }
    for level in values(map, "level") {
        all.push(Selection {
            mesh_level: Some(level + 1),
            ..Selection::default()
        });
    }
    if has("level") {
        let regions = values(map, "region");
        let mixed = regions.iter().zip([1, 0, 2].into_iter().cycle());
        all.push(Selection {
            mesh_levels: mixed.map(|(region, level)| (*region, level)).collect(),
            ..Selection::default()
        });
    }
    if has("parameter") {
        let faps = values(map, "parameter").into_iter().step_by(2).collect();
        all.push(Selection {
            parameters: Some(faps),
            ..Selection::default()
        });
    }
    if is_face {
        for levels in [[0; 8], [2; 8], [3, 2, 1, 0, 3, 2, 1, 0]] {
            all.push(Selection {
                face_levels: Some(levels),
                ..Selection::default()
            });
        }
        let mouth = Selection {
            face_regions: Some(0b10),
            ..Selection::default()
        };
        all.push(mouth.clone());
        all.push(Selection {
            face_levels: Some([1; 8]),
            tier: Some(1),
            ..mouth
        });
    }
    all
}

#[test]
fn stored_streams_come_back_through_their_descriptions() {
    for (what, stream, map) in streams() {
        let options = GbsdOptions {
            bitstream: Some("clip.bin".into()),
        };
        let text = write_gbsd(&map, &options).unwrap();
        let found = read_gbsd(text.as_bytes(), &LIMITS).unwrap();
        assert_eq!(found.unit, map, "{what}");
        assert_eq!(found.bitstream.as_deref(), Some("clip.bin"));
        let bytes = gbsd_to_bin(text.as_bytes(), stream, Holes::Refuse, &LIMITS).unwrap();
        assert!(bytes == stream, "{what}");
    }
}

#[test]
fn cuts_of_stored_streams_are_those_of_other_programs() {
    let mut judges = Judges::new("stored_streams");
    let mut cuts = 0;
    for (what, stream, map) in streams() {
        let text = write_gbsd(&map, &GbsdOptions::default()).unwrap();
        for selection in selections(&map) {
            let part = judges.check(&format!("{what}: {selection:?}"), &text, stream, &selection);
            cuts += usize::from(part.len() < stream.len());
        }
    }
    assert!(cuts > 25, "{cuts} cuts");
    judges.finish();
}

#[test]
fn names_in_descriptions_are_those_of_annex_b_and_of_each_codec() {
    for (what, _, map) in streams() {
        let text = write_gbsd(&map, &GbsdOptions::default()).unwrap();
        let names: &[&str] = match what {
            "ABP-2" => &[
                "\":ABP2:AccessUnit\"",
                "\":ABP2:AuBytes\"",
                "\":ABP2:Unit\"",
                "marker=\"L:",
            ],
            "AFP-1" => &[
                "\":AFP1:FapMask\"",
                "\":AFP1:NoOfFaps\"",
                "marker=\"access_unit A:0\"",
            ],
            "AFP-2" => &["\":AFP2:Unit\"", " T:0\""],
            "mesh" => &[
                "\":AMS:Chunk\"",
                "vh:bytesOf=\"u3\"",
                "vh:coding=\"littleEndian\"",
            ],
            _ => &["\":MG4:BoneMask\"", "\":MG4:NoOfBones\"", "<gBSDUnit start"],
        };
        for name in names {
            assert!(text.contains(name), "{what}: {name}");
        }
        assert!(!text.contains(":VH:"), "{what}: a name of no table");
    }
}
