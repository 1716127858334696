//! Characters in motion before a camera, set up as by the command `flatten`.

use anyhow::{Context, Result};
use articula::flatten::{FramedCharacter, FramedParts, Shot, TriangleCount};
use articula::{CharacterFile, Figure};
use articula_build::decimate;
use articula_core::source::{Character, Property, RawClip as SourceClip};
use articula_core::{Camera, Viewport};
use articula_flat::Bounds;
use articula_flat::Projection;
use articula_flat::planar::{BakeOptions, Lighting, PlanarSubject, Turntable};
use glam::Vec3;
use std::path::Path;

/// Side of the picture in pixels.
pub(super) const SIDE_PX: f32 = 400.0;

/// Frames per second, the default of `articula flatten`.
const FPS: f64 = 25.0;

/// Placement of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Framing {
    /// As close as the motion allows, at this azimuth to the left in degrees.
    Tight(f32),
    /// For faces: 4.5 half heights away, the picture 1.15 times as high as the face
    /// (docs/methods/vector.md, part 9).
    Face,
    /// Before the head of a whole figure: the part above this fraction of its height.
    Above(f32),
}

/// A character in motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) file: &'static str,
    pub(super) clip: &'static str,
    /// Fraction of the clip that is used; 1 is the whole clip.
    pub(super) share: f64,
    pub(super) framing: Framing,
    pub(super) turn_degrees: f32,
    pub(super) triangles: usize,
    pub(super) kind: Kind,
}

/// Acceptance bounds that apply to a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A speaking face: bounds 1 to 5.
    Face,
    /// A body: bounds 1, 4 and 5, with the limits of a walk.
    Walk,
    /// Only the bound on the painting order.
    Other,
}

const KNIGHT: &str = "glb/KayKit_Knight.glb";
const HEAD: &str = "glb/ict_head_talk_554.glb";
const WOMAN: &str = "glb/mh_female_dance.glb";

const fn knight(name: &'static str, clip: &'static str, yaw: f32, turn: f32, kind: Kind) -> Case {
    Case {
        name,
        file: KNIGHT,
        clip,
        share: 1.0,
        framing: Framing::Tight(yaw),
        turn_degrees: turn,
        triangles: 600,
        kind,
    }
}

const fn face(name: &'static str, clip: &'static str, kind: Kind) -> Case {
    Case {
        name,
        file: HEAD,
        clip,
        share: 1.0,
        framing: Framing::Face,
        turn_degrees: 0.0,
        triangles: usize::MAX,
        kind,
    }
}

/// All cases; the first is that of a small run.
pub(super) const CASES: [Case; 8] = [
    face("face, talk", "talk", Kind::Face),
    face("face, talk and turn", "talk_turn", Kind::Face),
    knight("knight, walk", "Walking_A", 0.0, 0.0, Kind::Walk),
    knight("knight, walk, 20°", "Walking_A", 20.0, 0.0, Kind::Walk),
    knight(
        "knight, walk and full turn",
        "Walking_A",
        0.0,
        360.0,
        Kind::Walk,
    ),
    knight(
        "knight, attack",
        "1H_Melee_Attack_Slice_Diagonal",
        0.0,
        0.0,
        Kind::Walk,
    ),
    Case {
        name: "woman, dance",
        file: WOMAN,
        clip: "dance",
        share: 0.25,
        framing: Framing::Tight(0.0),
        turn_degrees: 0.0,
        triangles: 1500,
        kind: Kind::Other,
    },
    Case {
        name: "woman, talk",
        file: WOMAN,
        clip: "talk",
        share: 1.0,
        framing: Framing::Above(0.86),
        turn_degrees: 0.0,
        triangles: 600,
        kind: Kind::Other,
    },
];

impl Case {
    /// Reads the character; also returns the names of the meshes that are hidden.
    pub(super) fn figure(&self, data: &Path) -> Result<(Figure, Vec<String>)> {
        let (opened, hidden) = self.open(data)?;
        Ok((Figure::new(opened)?, hidden))
    }

    /// Sets up the camera and simplifies the visible triangles.
    pub(super) fn framed<'a>(&self, figure: &'a Figure) -> Result<FramedCharacter<'a>> {
        let asset = &figure.asset;
        let clip = figure.clip(Some(self.clip))?;
        let clip = clip.with_context(|| format!("{}: no clip {}", self.file, self.clip))?;
        let length = f64::from(asset.clips[clip].duration_secs()) * self.share;
        let (frame_times_secs, fps) = frame_times(length);
        let mut parts = FramedParts {
            triangles: asset.mesh.triangles.clone(),
            options: BakeOptions {
                camera: Camera::looking_at(Vec3::Z, Vec3::ZERO, viewport()),
                projection: Projection::Perspective,
                lighting: Lighting::default(),
                fps,
                turn: Turntable {
                    axis: (0.0, 0.0),
                    radians_per_sec: (f64::from(self.turn_degrees.to_radians()) / length) as f32,
                },
            },
            frame_times_secs,
        };
        let shot = Shot {
            clip: Some(clip),
            fps,
            turn_deg: self.turn_degrees,
            viewport: viewport(),
            triangles: TriangleCount::All,
            ..Shot::default()
        };
        let framed = FramedCharacter::from_parts(figure, shot, parts.clone());
        let looks: Vec<f64> = parts.frame_times_secs.iter().copied().step_by(3).collect();
        (parts.options.camera, parts.options.turn) = self.camera(&framed, &looks)?;
        if parts.triangles.len() > self.triangles {
            let seen = framed.subject().seen(&looks, &parts.options)?;
            parts.triangles = decimate(asset, &seen, Some(clip), self.triangles, &[])?;
        }
        Ok(FramedCharacter::from_parts(figure, shot, parts))
    }

    /// The camera of the case, and the turn about the figure's middle.
    fn camera(&self, framed: &FramedCharacter<'_>, looks: &[f64]) -> Result<(Camera, Turntable)> {
        let subject = framed.subject();
        let still = Turntable::default();
        let bounds = subject.bounds(looks, &still).context("nothing to frame")?;
        let turn = Turntable {
            axis: (bounds.middle().x, bounds.middle().z),
            ..framed.options.turn
        };
        let at_rest = PlanarSubject {
            clip: None,
            ..subject
        };
        let rest = at_rest.bounds(&[0.0], &still).context("nothing to frame")?;
        let camera = match self.framing {
            Framing::Tight(yaw) => {
                let angles = (yaw.to_radians(), 0.0);
                let camera = subject.camera(looks, &turn, angles, viewport());
                camera.context("nothing to frame")?
            }
            Framing::Face => before(&rest),
            Framing::Above(share) => {
                let mut head = rest;
                head.low.y += share * (rest.high.y - rest.low.y);
                before(&head)
            }
        };
        Ok((camera, turn))
    }

    fn open(&self, data: &Path) -> Result<(CharacterFile, Vec<String>)> {
        let mut opened = articula::fs::open(data.join(self.file))?;
        let mut hidden = Vec::new();
        if self.file == KNIGHT {
            // Keep one sword and no shield.
            let is_worn = |name: &str| name.starts_with("Knight_") || name == "1H_Sword";
            let names = opened.character().meshes.iter().map(|m| m.name.clone());
            hidden = names.filter(|name| !is_worn(name)).collect();
            opened.keep_meshes(&[], &hidden)?;
        }
        if self.file == WOMAN && self.clip == "talk" {
            let speech = articula::fs::open(data.join(HEAD))?;
            let clip = speech_onto(speech.character(), opened.character())?;
            opened.clips_mut().push(clip);
        }
        Ok((opened, hidden))
    }
}

/// Frame times in seconds and the frame rate, as `articula flatten` chooses them: the rate nearest
/// to its default for which the last frame falls on the end of the clip.
fn frame_times(length_secs: f64) -> (Vec<f64>, f32) {
    let steps = (length_secs * FPS).round().max(1.0);
    let time = |f: u32| length_secs * f64::from(f) / steps;
    let times = (0..=steps as u32).map(time).collect();
    (times, (steps / length_secs) as f32)
}

/// The speech of one head on the morph targets with the same names of another.
fn speech_onto(from: &Character, onto: &Character) -> Result<SourceClip> {
    let clip = from.clips.iter().find(|c| c.name == "talk");
    let clip = clip.context("no clip talk")?;
    let channel = clip
        .channels
        .iter()
        .find(|c| c.property == Property::Weights);
    let channel = channel.context("no morph track in talk")?;
    let names = &from.meshes[channel.target].morph_names;
    let faces = onto.meshes.iter().enumerate();
    let mut channels = Vec::new();
    for (m, mesh) in faces.filter(|(_, mesh)| !mesh.morph_names.is_empty()) {
        let alike = |name: &String| names.iter().position(|n| same(n, name));
        let sources: Vec<Option<usize>> = mesh.morph_names.iter().map(alike).collect();
        let mut own = channel.clone();
        own.target = m;
        own.values = channel
            .values
            .chunks(names.len())
            .flat_map(|key| sources.iter().map(|s| s.map_or(0.0, |s| key[s])))
            .collect();
        channels.push(own);
    }
    Ok(SourceClip {
        channels,
        ..clip.clone()
    })
}

/// Whether two names mean the same morph target: `eyeBlink_L` and `eyeBlinkLeft`.
fn same(a: &str, b: &str) -> bool {
    let plain = |name: &str| {
        let long = name.replace("_L", "Left").replace("_R", "Right");
        long.to_lowercase()
    };
    plain(a) == plain(b)
}

fn viewport() -> Viewport {
    Viewport {
        width_px: SIDE_PX,
        height_px: SIDE_PX,
        // The camera of the faces: 4.5 half heights away.
        fov_y_radians: 2.0 * (1.0f32 / 4.5).atan(),
    }
}

/// The camera before a head.
pub(super) fn before(bounds: &Bounds) -> Camera {
    let half = 1.15 * 0.5 * (bounds.high.y - bounds.low.y);
    let middle = bounds.middle();
    Camera::looking_at(middle + Vec3::Z * 4.5 * half, middle, viewport())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_frame_falls_on_the_end_of_the_clip() {
        // 1.05 s at 25 Hz are 26.25 steps, so 26 of them at 24.76 Hz.
        let (times, fps) = frame_times(1.05);
        assert_eq!((times.len(), times[0], times[26]), (27, 0.0, 1.05));
        assert!((fps - 26.0 / 1.05).abs() < 1e-5);
        assert_eq!(frame_times(5.0).0.len(), 126);
    }
}
