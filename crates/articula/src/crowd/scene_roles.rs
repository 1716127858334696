//! Parts of scene files that say who matters and what hides whom: roles, zones, cues, clips, walls.
//!
//! The format is described in `docs/formats/scene.md`.

use super::scene_cast::CharacterEntry;
use crate::camera_path::ensure;
use crate::error::{Context, Error, Result};
use crate::open::choose;
use articula_build::{Cue, IMPORTANCE_RANGE, Role, SceneImportance, USUAL_ROLES, Wall, Zone};
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Maximum numbers of walls, zones, cues and roles.
const MAX_ENTRIES: usize = 10_000;

/// What a scene file says beside its characters and its camera.
#[derive(Debug, Default)]
pub(super) struct RolesFile {
    pub(super) roles: BTreeMap<String, f32>,
    pub(super) cues: Vec<CueFile>,
    pub(super) zones: Vec<ZoneFile>,
    pub(super) clip_importance: BTreeMap<String, f32>,
    pub(super) walls: Vec<WallFile>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CueFile {
    t: f64,
    role: Option<String>,
    members: Vec<u32>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ZoneFile {
    min: [f32; 2],
    max: [f32; 2],
    importance: f32,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WallFile {
    centre: [f32; 3],
    size: [f32; 3],
    #[serde(default)]
    yaw_deg: f32,
}

impl RolesFile {
    /// Checks everything; `roles_of` has the role of each character.
    pub(super) fn read(
        &self,
        roles_of: &[Option<&str>],
        cast: &[CharacterEntry<'_>],
    ) -> Result<(SceneImportance, Vec<Wall>)> {
        for (what, count) in [
            ("roles", self.roles.len()),
            ("cues", self.cues.len()),
            ("zones", self.zones.len()),
            ("walls", self.walls.len()),
        ] {
            ensure(count <= MAX_ENTRIES, || {
                format!("{what}: {count} entries; give at most {MAX_ENTRIES}")
            })?;
        }
        let roles = self.named_roles()?;
        let role_of = |name: &str| {
            let names = roles.iter().map(|r| r.name.as_str());
            let found = choose("role", name, names);
            found.map_err(|e| Error::unsuited(e.to_string()))
        };
        let mut importance = SceneImportance {
            clips: self.clips(cast)?,
            ..SceneImportance::default()
        };
        if roles_of.iter().any(Option::is_some) {
            for (i, role) in roles_of.iter().enumerate() {
                let role = role.map(|name| role_of(name).map(|r| r as u16)).transpose();
                let role = role.with_context(|| format!("members[{i}]: role"))?;
                importance.role_of.push(role);
            }
        }
        for (i, cue) in self.cues.iter().enumerate() {
            let read = self.cue(i, cue, roles_of.len(), &role_of);
            importance
                .cues
                .push(read.with_context(|| format!("cues[{i}]"))?);
        }
        for (i, zone) in self.zones.iter().enumerate() {
            let read = zone.read().with_context(|| format!("zones[{i}]"));
            importance.zones.push(read?);
        }
        let walls = self.walls.iter().enumerate();
        let walls = walls.map(|(i, w)| w.read().with_context(|| format!("walls[{i}]")));
        let walls = walls.collect::<Result<_>>()?;
        importance.roles = roles;
        Ok((importance, walls))
    }

    /// The roles of the file, and the usual ones that it does not name.
    fn named_roles(&self) -> Result<Vec<Role>> {
        let mut roles = SceneImportance::default().roles;
        roles.retain(|role| !self.roles.contains_key(&role.name));
        for (name, importance) in &self.roles {
            checked(*importance).with_context(|| format!("roles: {name}"))?;
            roles.push(Role {
                name: name.clone(),
                importance: *importance,
            });
        }
        Ok(roles)
    }

    /// Importance of each clip of each character; empty if all are neutral.
    fn clips(&self, cast: &[CharacterEntry<'_>]) -> Result<Vec<Vec<f32>>> {
        let mut importance = SceneImportance::default();
        let names: Vec<Vec<&str>> = cast
            .iter()
            .map(|c| c.clips.iter().map(|clip| clip.name.as_str()).collect())
            .collect();
        for (name, value) in &self.clip_importance {
            checked(*value).with_context(|| format!("clip_importance: {name}"))?;
            if !importance.mark_clips(&names, name, *value) {
                let all = names.iter().flatten().copied();
                let found = choose("clip", name, all).map_err(|e| Error::unsuited(e.to_string()));
                found.context("clip_importance")?;
            }
        }
        Ok(importance.clips)
    }

    fn cue(
        &self,
        at: usize,
        cue: &CueFile,
        members: usize,
        role_of: &dyn Fn(&str) -> Result<usize>,
    ) -> Result<Cue> {
        let before = at.checked_sub(1).map_or(0.0, |at| self.cues[at].t);
        ensure(cue.t.is_finite() && cue.t >= before, || {
            "t: give seconds, at least 0 and those of the cue before".to_owned()
        })?;
        let beyond = cue.members.iter().find(|m| **m as usize >= members);
        ensure(beyond.is_none(), || {
            let beyond = beyond.copied().unwrap_or_default();
            format!(
                "members: there is no character {beyond}; they are counted from 0 to {}",
                members - 1
            )
        })?;
        let role = cue.role.as_deref().map(role_of).transpose()?;
        Ok(Cue {
            secs: cue.t,
            role: role.map(|r| r as u16),
            members: cue.members.clone(),
        })
    }

    /// Writes what a scene says; roles that are as usual are left out.
    pub(super) fn of(
        importance: &SceneImportance,
        walls: &[Wall],
        cast: &[CharacterEntry<'_>],
    ) -> Self {
        let usual = |role: &Role| USUAL_ROLES.contains(&(role.name.as_str(), role.importance));
        let roles = importance.roles.iter().filter(|r| !usual(r));
        let name = |role: u16| {
            importance
                .roles
                .get(usize::from(role))
                .map(|r| r.name.clone())
        };
        let of_each = importance.clips.iter().zip(cast);
        let marked = of_each.flat_map(|(marks, character)| marks.iter().zip(character.clips));
        let marked = marked.filter(|(i, _)| **i != 1.0);
        Self {
            roles: roles.map(|r| (r.name.clone(), r.importance)).collect(),
            cues: importance
                .cues
                .iter()
                .map(|cue| CueFile {
                    t: cue.secs,
                    role: cue.role.and_then(name),
                    members: cue.members.clone(),
                })
                .collect(),
            zones: importance
                .zones
                .iter()
                .map(|zone| ZoneFile {
                    min: zone.least.to_array(),
                    max: zone.greatest.to_array(),
                    importance: zone.importance,
                })
                .collect(),
            clip_importance: marked.map(|(i, c)| (c.name.clone(), *i)).collect(),
            walls: walls
                .iter()
                .map(|wall| WallFile {
                    centre: wall.centre.to_array(),
                    size: wall.size.to_array(),
                    yaw_deg: wall.yaw_radians.to_degrees(),
                })
                .collect(),
        }
    }
}

impl ZoneFile {
    fn read(&self) -> Result<Zone> {
        let (least, greatest) = (Vec2::from(self.min), Vec2::from(self.max));
        let is_range = least.cmple(greatest).all() && (least + greatest).is_finite();
        ensure(is_range, || {
            "min, max: give [x, z], least and greatest".to_owned()
        })?;
        checked(self.importance)?;
        Ok(Zone {
            least,
            greatest,
            importance: self.importance,
        })
    }
}

impl WallFile {
    fn read(&self) -> Result<Wall> {
        let (centre, size) = (Vec3::from(self.centre), Vec3::from(self.size));
        ensure(centre.is_finite() && self.yaw_deg.is_finite(), || {
            "centre, yaw_deg: give finite numbers".to_owned()
        })?;
        ensure(size.cmpgt(Vec3::ZERO).all() && size.is_finite(), || {
            "size: give width, height and depth above 0 m".to_owned()
        })?;
        Ok(Wall {
            centre,
            size,
            yaw_radians: self.yaw_deg.to_radians(),
        })
    }
}

fn checked(importance: f32) -> Result<()> {
    ensure(IMPORTANCE_RANGE.contains(&importance), || {
        "importance: give 1/64 to 64; 1 is neutral, 2 halves the tolerance".to_owned()
    })
}
