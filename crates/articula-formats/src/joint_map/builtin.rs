//! The built-in joint maps.

use super::file;
use crate::limits::Limits;
use articula_core::joint_names::JointMap;
use std::sync::LazyLock;

macro_rules! profile {
    ($name:literal) => {
        include_str!(concat!("../../data/joint_maps/", $name, ".json"))
    };
}

/// Narrow maps come before wide ones: on a tie the first wins.
const FILES: [&str; 22] = [
    profile!("vrm-1"),
    profile!("vrm-0"),
    profile!("mixamo"),
    profile!("cmu-bvh"),
    profile!("cmu-asf"),
    profile!("mocap-hands"),
    profile!("biped"),
    profile!("character-creator"),
    profile!("unreal"),
    profile!("smpl"),
    profile!("smpl-x"),
    profile!("makehuman"),
    profile!("makehuman-1"),
    profile!("kaykit"),
    profile!("quaternius-modular-men"),
    profile!("quaternius-modular-women"),
    profile!("quaternius"),
    profile!("pab"),
    profile!("godette"),
    profile!("torso-joints"),
    profile!("biovision"),
    profile!("webxr-hand"),
];

static PROFILES: LazyLock<Vec<JointMap>> = LazyLock::new(|| {
    let parsed = FILES.iter().map(|json| {
        file::parse(json.as_bytes(), &Limits::default())
            .expect("a test parses every built-in joint map")
    });
    std::iter::once(file::of_the_standard())
        .chain(parsed)
        .collect()
});

/// Returns the built-in joint maps; of several that match equally many joints the first is used.
pub fn builtin() -> &'static [JointMap] {
    &PROFILES
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_own_profile_reads_and_tells_its_source() {
        let names: BTreeSet<&str> = builtin().iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names.len(), FILES.len() + 1, "two profiles share a name");
        assert!(
            builtin()
                .iter()
                .all(|p| !p.title.is_empty() && !p.source.is_empty())
        );
    }
}
