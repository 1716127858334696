//! The clip that a picture shows unless another is named.

use crate::figure::Figure;

/// Parts of names of motions that show a character well, the best first.
const SHOWN: [&str; 3] = ["walk", "run", "idle"];

/// Returns the index of the first clip with "walk" in its name, else with "run", else with "idle", else the first;
/// `None` without a clip.
pub fn shown_clip(figure: &Figure) -> Option<usize> {
    let clips = &figure.asset.clips;
    chosen(clips.iter().map(|clip| clip.name.as_str()))
}

fn chosen<'a>(names: impl Iterator<Item = &'a str> + Clone) -> Option<usize> {
    let holds = |word: &str| {
        let mut names = names.clone();
        names.position(|name| name.to_lowercase().contains(word))
    };
    let found = SHOWN.into_iter().find_map(holds);
    found.or_else(|| names.clone().next().map(|_| 0))
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_walk_is_shown_before_a_run_and_an_idle() {
        let chosen = |names: &[&str]| super::chosen(names.iter().copied());
        assert_eq!(
            chosen(&["T-Pose", "Idle", "Running_A", "Walking_A"]),
            Some(3)
        );
        assert_eq!(chosen(&["attack", "idle", "Run"]), Some(2));
        assert_eq!(chosen(&["attack", "CharacterArmature|Idle"]), Some(1));
        assert_eq!(chosen(&["attack", "death"]), Some(0));
        assert_eq!(chosen(&[]), None);
    }
}
