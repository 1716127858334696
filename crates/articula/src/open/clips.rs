//! What is odd about the clips of a human figure, told where they are read.

use super::CharacterFile;
use articula_build::retarget::{ClipOddities, RetargetFigure};
use articula_core::source::{Joint, RawClip};
use articula_formats::{Assumption, Warning};

/// Maximum number of clips that are looked at.
const MAX_CLIPS: usize = 64;
/// Least turn of a clip that ends in the pose in which it begins that is told, radians.
const TURN_RADIANS: f32 = 0.35;

/// Returns a warning for each clip that begins with a frame of another pose, and for each that turns
/// every time it repeats.
pub(super) fn oddities(opened: &CharacterFile) -> Vec<Warning> {
    if opened.character.articulation.is_none() && !opened.mapping().humanoid {
        return Vec::new();
    }
    let articulation = opened.articulation();
    let figure = RetargetFigure {
        skeleton: &opened.character.skeleton,
        articulation: &articulation,
        clips: &[],
    };
    // A figure that cannot be used is refused where it is.
    let Ok(figure) = ClipOddities::new(&figure) else {
        return Vec::new();
    };
    let joints = &opened.character.skeleton.joints;
    let clips = opened.character.clips.iter().take(MAX_CLIPS);
    clips.flat_map(|clip| told(&figure, joints, clip)).collect()
}

fn told(figure: &ClipOddities<'_>, joints: &[Joint], clip: &RawClip) -> Vec<Warning> {
    let mut told = Vec::new();
    let mut tell = |what: String, guess| {
        told.push(Warning {
            at: format!("clip \"{}\"", clip.name),
            what,
            guess,
        });
    };
    // A clip that cannot be sampled is refused where it is used.
    if let Ok(Some((joint, radians))) = figure.first_frame_jump(clip) {
        let what = format!(
            "the first frame is of another pose: {} jumps by {:.0} degrees",
            joints[joint].name,
            radians.to_degrees()
        );
        tell(what, Some(Assumption::FirstFrame));
    }
    if let Ok(Some(radians)) = figure.turn_of_repeat(clip, TURN_RADIANS) {
        let what = format!(
            "it ends in the pose in which it begins, turned by {:.0} degrees: so does the figure each \
             time it repeats",
            radians.to_degrees().abs()
        );
        tell(what, None);
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{Channel, Character, Interpolation, Property};
    use articula_human::HumanOptions;
    use glam::Quat;
    use std::sync::LazyLock;

    const FRAMES: usize = 21;

    /// The reference human, whose left knee swings once and whose root turns by an angle in all; the
    /// first frame may have a raised arm.
    fn swinging(turn_radians: f32, jump_radians: f32) -> CharacterFile {
        static HUMAN: LazyLock<Character> =
            LazyLock::new(|| articula_human::human(&HumanOptions::mannequin(2_000)).unwrap());
        let mut character = HUMAN.clone();
        let joint = |name: &str| character.skeleton.find(name).unwrap();
        let times_secs: Vec<f32> = (0..FRAMES).map(|f| f as f32 / 20.0).collect();
        let channel = |name: &str, of: &dyn Fn(usize) -> Quat| Channel {
            target: joint(name),
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.clone(),
            values: (0..FRAMES).flat_map(|f| of(f).to_array()).collect(),
        };
        let share = |f: usize| f as f32 / (FRAMES - 1) as f32;
        let swing = |f: usize| 0.3 * (std::f32::consts::TAU * share(f)).sin();
        let raised = |f: usize| if f == 0 { jump_radians } else { 0.0 };
        let channels = vec![
            channel("humanoid_root", &|f| {
                Quat::from_rotation_y(turn_radians * share(f))
            }),
            channel("l_knee", &|f| Quat::from_rotation_x(swing(f))),
            channel("r_shoulder", &|f| Quat::from_rotation_z(raised(f))),
        ];
        character.clips = vec![RawClip {
            name: "swing".to_owned(),
            duration_secs: 1.0,
            channels,
        }];
        CharacterFile::from_character("human", character)
    }

    #[test]
    fn a_loop_that_turns_is_told_by_how_much() {
        for degrees in [91.0_f32, -45.0, 25.0] {
            let told = oddities(&swinging(degrees.to_radians(), 0.0));
            assert_eq!(told.len(), 1, "{told:?}");
            let turned = format!("turned by {} degrees", degrees.abs());
            assert!(told[0].what.contains(&turned), "{}", told[0].what);
        }
        for degrees in [0.0_f32, 5.0, 360.0] {
            assert_eq!(oddities(&swinging(degrees.to_radians(), 0.0)), []);
        }
    }

    #[test]
    fn a_first_frame_of_another_pose_is_told_until_it_is_skipped() {
        let mut file = swinging(0.0, 1.2);
        let told = oddities(&file);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].what.contains("r_shoulder jumps by 69 degrees"));
        file.warnings = told;
        file.skip_first_frames().unwrap();
        assert!(oddities(&file).is_empty() && file.warnings().is_empty());
    }
}
