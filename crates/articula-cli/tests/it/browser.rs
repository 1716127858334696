//! Pictures survive the transfer to the browser and back unchanged.

use crate::judges::browser::{Item, shots, write};

/// A square moves 40 pixels per second; at 0.5 s its left side is at 20.
const MOVING: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 40">
<rect y="10" width="20" height="20" fill="#c00"><animate attributeName="x" values="0;80" dur="2s"
repeatCount="indefinite"/></rect></svg>"##;

#[test]
fn a_moving_square_is_seen_where_it_is() {
    let file = write("moving.svg", MOVING.as_bytes());
    let item = |kind| Item {
        kind,
        file: file.clone(),
        size: [100, 40],
        times_secs: vec![0.0, 0.5],
        plays: true,
    };
    let Some(seen) = shots(&[item("smil"), item("smil-img")]) else {
        return;
    };
    for seen in seen {
        assert!(seen.plays);
        let left = |i: usize| {
            let picture = &seen.pictures[i];
            assert_eq!((picture.width(), picture.height()), (100, 40));
            (0..100).find(|x| picture.get(*x, 20) == Some([204, 0, 0, 255]))
        };
        assert_eq!([left(0), left(1)], [Some(0), Some(20)]);
    }
}
