//! Any bytes as a mesh level of some layout, and as its refinement: meshes that match the layout,
//! or an error. The first three bytes choose the layout and split the rest in two.
#![no_main]

use articula_stream::StreamLimits;
use articula_stream::mesh::{Layout, MorphLayout, decode_level};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some(([kind, joints, cut], rest)) = bytes.split_first_chunk::<3>() else {
        return;
    };
    let has = |bit: u8| kind >> bit & 1;
    let morph = MorphLayout {
        has_normals: has(0) > 0,
    };
    let layout = Layout {
        position_bits: 8 + 2 * (kind >> 6),
        normal_bits: 8 * has(1),
        texcoord_bits: 10 * has(2),
        has_colors: has(3) > 0,
        joints: u16::from(*joints),
        morphs: vec![morph; usize::from(has(4))],
    };
    let limits = StreamLimits {
        elements: 1 << 18,
        ..StreamLimits::default()
    };
    let (coarse, fine) = rest.split_at(rest.len().min(usize::from(*cut) * 4));
    let Ok(coarse) = decode_level(None, coarse, &layout, &limits) else {
        return;
    };
    assert!(coarse.check(&layout).is_ok());
    if let Ok(fine) = decode_level(Some(&coarse), fine, &layout, &limits) {
        assert!(fine.check(&layout).is_ok());
        assert!(fine.positions.len() >= coarse.positions.len());
        assert!(fine.wedge_points.len() >= coarse.wedge_points.len());
    }
});
