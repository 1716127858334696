//! Any bytes as a compressed buffer view of any layout: an error or exactly the bytes of the
//! layout. The first four bytes choose the layout.
#![no_main]

use articula_formats::Limits;
use articula_formats::meshopt::{Filter, Mode, ViewLayout, decode};
use libfuzzer_sys::fuzz_target;

const FILTERS: [Filter; 5] = [
    Filter::None,
    Filter::Octahedral,
    Filter::Quaternion,
    Filter::Exponential,
    Filter::Color,
];

fuzz_target!(|bytes: &[u8]| {
    let Some(([kind, stride, low, high], encoded)) = bytes.split_first_chunk::<4>() else {
        return;
    };
    let (mode, stride) = match kind % 4 {
        0 => (Mode::Triangles, [2, 4][usize::from(stride % 2)]),
        1 => (Mode::Indices, [2, 4][usize::from(stride % 2)]),
        _ => (Mode::Attributes, u64::from(*stride) * 4),
    };
    let filter = match mode {
        Mode::Attributes => FILTERS[usize::from(kind / 4 % 5)],
        _ => Filter::None,
    };
    let count = u64::from(u16::from_le_bytes([*low, *high]));
    let shape = ViewLayout {
        mode,
        filter,
        count,
        stride,
    };
    if let Ok(out) = decode(encoded, &shape, &Limits::default()) {
        assert_eq!(out.len() as u64, count * stride);
    }
});
