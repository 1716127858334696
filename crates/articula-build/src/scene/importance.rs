//! Who matters in a scene, and when: roles that change during play, zones, and clips.
//!
//! Source: the thesis' 3.1.3 (main, secondary and audience characters) and 7.2.3 (importance by the
//! semantics of the application and of the animation).

use super::SceneCharacter;
use glam::Vec2;
use std::ops::RangeInclusive;

/// Least and greatest importance; outside of this range it changes nothing more.
pub const IMPORTANCE_RANGE: RangeInclusive<f32> = 1.0 / 64.0..=64.0;

/// Roles that every scene has, with their importance.
pub const USUAL_ROLES: [(&str, f32); 3] = [("main", 4.0), ("secondary", 1.0), ("audience", 0.5)];

/// Importance of the characters of a scene; by default neutral, with the [`USUAL_ROLES`], which nobody
/// has.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneImportance {
    /// The roles.
    pub roles: Vec<Role>,
    /// Role of each character at the beginning, as an index; empty: none has one.
    pub role_of: Vec<Option<u16>>,
    /// Changes of roles, in order of time.
    pub cues: Vec<Cue>,
    /// Parts of the ground with an importance.
    pub zones: Vec<Zone>,
    /// Importance of each clip of each character of the cast, by their indices; what is left out is 1.
    pub clips: Vec<Vec<f32>>,
}

/// A role in a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Role {
    /// Its name.
    pub name: String,
    /// Its importance: 1 is neutral, 2 halves the tolerance.
    pub importance: f32,
}

/// A change of roles.
#[derive(Debug, Clone, PartialEq)]
pub struct Cue {
    /// Time of the scene in seconds.
    pub secs: f64,
    /// The new role; `None` for none.
    pub role: Option<u16>,
    /// The characters that take it.
    pub members: Vec<u32>,
}

/// A rectangle of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// Least x and z in metres.
    pub least: Vec2,
    /// Greatest x and z in metres.
    pub greatest: Vec2,
    /// Importance of who stands in it: 1 is neutral, 2 halves the tolerance.
    pub importance: f32,
}

impl Default for SceneImportance {
    fn default() -> Self {
        let roles = USUAL_ROLES.map(|(name, importance)| Role {
            name: name.to_owned(),
            importance,
        });
        Self {
            roles: roles.to_vec(),
            role_of: Vec::new(),
            cues: Vec::new(),
            zones: Vec::new(),
            clips: Vec::new(),
        }
    }
}

impl SceneImportance {
    /// Whether all characters are always of importance 1.
    pub fn is_neutral(&self) -> bool {
        self.role_of.iter().all(Option::is_none)
            && self.cues.is_empty()
            && self.zones.is_empty()
            && self.clips.iter().flatten().all(|c| *c == 1.0)
    }

    /// Sets the importance of the clips of a name; `names` are those of the clips of each character of
    /// the cast. Returns whether there is one.
    pub fn mark_clips(&mut self, names: &[Vec<&str>], name: &str, importance: f32) -> bool {
        let mut is_found = false;
        for (character, of_character) in names.iter().enumerate() {
            let Some(clip) = of_character.iter().position(|n| *n == name) else {
                continue;
            };
            is_found = true;
            self.clips
                .resize(names.len().max(self.clips.len()), Vec::new());
            let marks = &mut self.clips[character];
            marks.resize(of_character.len().max(marks.len()), 1.0);
            marks[clip] = importance;
        }
        is_found
    }

    /// Importance of a character in a role: the product of the importance of the role, of the greatest
    /// of its zones, and of the greatest of its clips.
    pub fn of(&self, member: &SceneCharacter, role: Option<u16>) -> f32 {
        let role = role.and_then(|r| self.roles.get(usize::from(r)));
        let place = Vec2::new(member.position.x, member.position.z);
        let holds = |z: &&Zone| z.least.cmple(place).all() && place.cmple(z.greatest).all();
        let zones = self.zones.iter().filter(holds).map(|z| z.importance);
        let clips = self.clips.get(usize::from(member.character));
        let clip = |clip: usize| clips.and_then(|c| c.get(clip)).copied().unwrap_or(1.0);
        let other = member.cross_fade.map_or(0.0, |f| clip(f.other.clip));
        role.map_or(1.0, |r| r.importance)
            * zones.reduce(f32::max).unwrap_or(1.0)
            * clip(member.play.clip).max(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ClipPlayback;
    use glam::Vec3;

    #[test]
    fn role_zone_and_clip_are_multiplied() {
        let zone = |most: f32, importance: f32| Zone {
            least: Vec2::splat(-1.0),
            greatest: Vec2::splat(most),
            importance,
        };
        let importance = SceneImportance {
            roles: vec![Role {
                name: "main".to_owned(),
                importance: 4.0,
            }],
            role_of: Vec::new(),
            cues: Vec::new(),
            zones: vec![zone(5.0, 3.0), zone(2.0, 2.0)],
            clips: vec![vec![1.0, 0.5]],
        };
        let member = |x: f32, clip: usize| SceneCharacter {
            character: 0,
            position: Vec3::new(x, 9.0, 0.0),
            yaw_radians: 0.0,
            scale: 1.0,
            play: ClipPlayback {
                clip,
                phase: 0.0,
                speed: 1.0,
            },
            cross_fade: None,
        };
        assert_eq!(importance.of(&member(9.0, 0), None), 1.0);
        assert_eq!(importance.of(&member(9.0, 0), Some(0)), 4.0);
        assert_eq!(importance.of(&member(5.0, 1), Some(0)), 4.0 * 3.0 * 0.5);
        assert_eq!(
            importance.of(&member(1.0, 0), None),
            3.0,
            "the greatest zone"
        );
        let other = SceneCharacter {
            character: 1,
            ..member(5.0, 1)
        };
        assert_eq!(importance.of(&other, None), 3.0, "its clips are others");
        let mut marked = SceneImportance::default();
        let names = [vec!["idle", "wave"], vec!["walk"], vec!["wave"]];
        assert!(!marked.mark_clips(&names, "fly", 2.0));
        assert!(marked.is_neutral() && marked.mark_clips(&names, "wave", 2.0));
        assert_eq!(marked.clips, [vec![1.0, 2.0], vec![], vec![2.0]]);
        assert!(SceneImportance::default().is_neutral());
        assert!(!importance.is_neutral());
    }
}
