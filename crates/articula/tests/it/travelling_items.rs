//! Items of characters whose first clip travels: all of it is in view of the camera of the forms in 2D.

use crate::real;
use crate::short::shortened;
use articula::item::{FlatEntry, PackageOptions, package};
use articula::{CharacterFile, Executor, fs};
use articula_core::source::Property;

/// A character that walks eight metres towards where it looks, past a camera that stands before its
/// first frame.
fn travelling() -> Option<CharacterFile> {
    let path = real::file("glb/RobotExpressive.glb")?;
    let mut robot = shortened(fs::open(path).unwrap(), 0.5);
    let root = robot.character().skeleton.joints[0].rest.translation;
    for clip in robot.clips_mut() {
        clip.channels
            .retain(|c| c.target != 0 || c.property != Property::Translation);
        let mut way = clip.channels[0].clone();
        way.target = 0;
        way.property = Property::Translation;
        way.interpolation = articula_core::source::Interpolation::Linear;
        way.times_secs = vec![0.0, clip.duration_secs];
        way.values = [root, root + 8.0 * glam::Vec3::Z]
            .iter()
            .flat_map(|place| place.to_array())
            .collect();
        clip.channels.push(way);
    }
    Some(robot)
}

#[test]
fn a_clip_that_travels_is_packaged_with_both_forms() {
    let Some(robot) = travelling() else { return };
    let options = PackageOptions {
        clips: vec!["Robot_Walking".to_owned()],
        mesh_levels: 1,
        ..PackageOptions::default()
    };
    let item = package(robot, &options, &Executor::default()).unwrap();
    let flat = &item.manifest.flat;
    assert_eq!(flat.len(), 2, "{:?}", item.manifest.warnings);
    assert!(item.manifest.warnings.iter().all(|w| !w.starts_with("2D")));
    let [moving, still] = [&flat[0], &flat[1]];
    assert_eq!(moving.clip.as_deref(), Some("Robot_Walking"));
    // Small enough to stand for a character that is not.
    let sent = |form: &FlatEntry| item.manifest.sent_bytes(&form.file);
    assert!(sent(moving) <= 25_000, "{moving:?}");
    assert!(sent(still) <= 12_000, "{still:?}");
    // All of the way is within the picture of 400 pixels, so the still is off by less.
    assert!((40.0..400.0 * 1.5).contains(&still.error_px), "{still:?}");
    for form in flat {
        let raw = item.file(&form.file).unwrap().len() as u64;
        assert!(sent(form) < raw && form.bytes == raw);
    }
}
