//! Any bytes as the index of a stream: a map that is written again as it was read, or an error; and the same
//! cut by records as by the map.
#![no_main]

use articula_stream::{StreamError, Unit, cut, cut_by_index, read_index, write_index};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let map = read_index(bytes);
    if let Ok(map) = &map {
        assert_eq!(read_index(&write_index(map)).as_ref(), Ok(map));
    }
    let stream = [0; 1 << 12];
    let keeps = |unit: &Unit| unit.markers.iter().all(|marker| marker.value % 2 == 0);
    let by_map = map.and_then(|map| {
        map.check_values(&stream)?;
        let made = cut(&stream, &map, keeps)?;
        Ok::<_, StreamError>((made.bytes, write_index(&made.unit)))
    });
    let by_records = cut_by_index(&stream, bytes, keeps);
    assert_eq!(by_records.map(|made| (made.bytes, made.index)), by_map);
});
