//! Conversion of a skeleton and a motion file into a character in metres, +Y up.

use super::amc::{self, Bones, MotionText};
use super::asf::{self, Dof, SkeletonText, turned};
use super::hierarchy::{self, Hierarchy};
use crate::capture_text::capture_text;
use crate::error::{Assumption, Parsed, ReadError, Warning};
use crate::limits::Limits;
use crate::motion_file::{MotionFile, ReadOptions};
use crate::notes::Notes;
use crate::units::{self, Size};
use crate::words::{FRAME_TIMES_SECS, odd_frame_time};
use articula_core::source::{self, Character, Interpolation, Joint, Property, RawClip, Skeleton};
use articula_core::{Transform, same_hemisphere};
use glam::{Quat, Vec3};

/// Frames per second of the CMU and most other motions.
const USUAL_RATE_HZ: f32 = 120.0;

/// Adds the kind of file to the position of a warning.
fn of_file(kind: &str, warning: Warning) -> Warning {
    Warning {
        at: format!("{kind} {}", warning.at),
        ..warning
    }
}

/// Reads a skeleton file and, optionally, a motion file. The result has a joint for the root and
/// for the start of every bone, whose rest orientation is the bone's axis. Rotations are keyed for
/// every bone that the motion rotates, translations for every bone that it translates.
///
/// # Errors
/// [`ReadError::Malformed`] naming file and line, what was found and what was expected;
/// [`ReadError::LimitExceeded`].
pub fn read(
    asf: &[u8],
    amc: Option<&[u8]>,
    options: &ReadOptions,
    limits: &Limits,
) -> Result<Parsed<MotionFile>, ReadError> {
    let length = asf.len().max(amc.map_or(0, <[u8]>::len));
    Limits::check("file", "bytes", length as u64, limits.bytes)?;
    let mut notes = Notes::default();
    let text = capture_text(asf, |odd| notes.push(of_file("asf", odd)));
    let text = asf::parse(&text, limits, &mut notes)?;
    let tree = hierarchy::build(&text, limits, &mut notes)?;
    let mut motion = MotionText::default();
    if let Some(amc) = amc {
        let amc = capture_text(amc, |odd| notes.push(of_file("amc", odd)));
        let bones = Bones {
            text: &text,
            tree: &tree,
        };
        motion = amc::parse(&amc, bones, limits, &mut notes)?;
    }
    let rate_hz = rate_hz(options, &motion, &mut notes)?;
    let odd = odd_frame_time(rate_hz.recip()).filter(|_| motion.frames > 1);
    if let Some(what) = odd {
        notes.add("amc", what);
    }
    let figure = Figure::new(text, tree, motion, rate_hz);
    if figure.stretches() {
        let what = "changing lengths of bones (the degree of freedom \"l\") are left out";
        notes.add("amc", what);
    }
    let mut warnings = notes.into_list();
    let basis = figure.basis(options, &mut warnings)?;
    Ok(Parsed {
        value: figure.file(&basis),
        warnings,
    })
}

fn rate_hz(
    options: &ReadOptions,
    motion: &MotionText,
    notes: &mut Notes,
) -> Result<f32, ReadError> {
    if let Some(rate_hz) = options.rate_hz {
        if FRAME_TIMES_SECS.contains(&rate_hz.recip()) {
            return Ok(rate_hz);
        }
        let what = format!("the frame rate must be above 0, found {rate_hz}");
        return Err(ReadError::malformed("options", what));
    }
    if motion.rate_hz.is_none() && motion.frames > 1 {
        let what =
            format!("the file has no frame rate; {USUAL_RATE_HZ} frames per second are assumed");
        notes.push(Warning::guess("amc", what, Assumption::Rate));
    }
    Ok(motion.rate_hz.unwrap_or(USUAL_RATE_HZ))
}

/// Returns metres per unit, and how that was determined. `length` is the number of file units per
/// inch where writers respect it: the writers of the CMU files state 0.45.
fn scale(length: f32, size: Size) -> (f32, Option<String>) {
    const INCH: f32 = 0.0254;
    const VICON: f32 = 0.45;
    let declared = INCH / length;
    let height = size.height();
    let known = (length - VICON).abs() < 1e-6;
    if known || (length != 1.0 && units::ADULT.contains(&(height * declared))) {
        let what = format!(
            "length {length} is read as inches / {length}: 1 unit = {declared} m, and the figure \
             is {} m tall",
            height * declared
        );
        return (declared, Some(what));
    }
    units::scale(size)
}

/// Conversion of file space to metres with +Y up: rotations of the root, at rest and in motion.
struct Basis {
    scale: f32,
    rest: Quat,
    motion: Quat,
}

/// The figure in the file's units and axes. All lists are indexed by slot of the hierarchy.
struct Figure {
    text: SkeletonText,
    tree: Hierarchy,
    motion: MotionText,
    rate_hz: f32,
    /// Radians per unit of angle of the motion.
    radians: f32,
    /// Orientation of the bone's axes in the figure; the identity for the root, whose orientation
    /// turns the figure as a whole.
    axes: Vec<Quat>,
    /// Offsets from start to end, in the axes of the figure; zero for the root.
    ways: Vec<Vec3>,
    root_orientation: Quat,
}

impl Figure {
    fn new(text: SkeletonText, tree: Hierarchy, motion: MotionText, rate_hz: f32) -> Self {
        let radians = |degrees: bool| if degrees { 1f32.to_radians() } else { 1.0 };
        let own = radians(text.degrees);
        let bone = |slot: &Option<usize>| slot.map(|b| &text.bones[b]);
        let axis = |slot| bone(slot).map_or(Quat::IDENTITY, |b| b.axis.rotation(own));
        let way = |slot| {
            bone(slot).map_or(Vec3::ZERO, |b| {
                b.direction.as_dvec3().normalize_or_zero().as_vec3() * b.length
            })
        };
        Self {
            axes: tree.bones.iter().map(axis).collect(),
            ways: tree.bones.iter().map(way).collect(),
            root_orientation: text.root_orientation.rotation(own),
            radians: radians(motion.degrees.unwrap_or(text.degrees)),
            rate_hz,
            text,
            tree,
            motion,
        }
    }

    fn stretches(&self) -> bool {
        let bones = self.bones();
        (0..self.axes.len())
            .any(|s| bones.dofs(s).contains(&Dof::Stretch) && !self.motion_rows(s).is_empty())
    }

    fn bones(&self) -> Bones<'_> {
        Bones {
            text: &self.text,
            tree: &self.tree,
        }
    }

    fn motion_rows(&self, slot: usize) -> &[amc::Row] {
        self.motion.rows.get(slot).map_or(&[], Vec::as_slice)
    }

    /// Returns the local translation and rotation of a joint, for the values of a frame or at rest.
    fn local(&self, slot: usize, first_value: Option<usize>) -> (Vec3, Quat) {
        let dofs = self.bones().dofs(slot);
        let values = first_value.map_or(&[][..], |first| &self.motion.values[first..]);
        let mut shift = Vec3::ZERO;
        for (dof, value) in dofs.iter().zip(values) {
            if let Dof::Shift(axis) = dof {
                shift[*axis] = *value;
            }
        }
        let turns = dofs
            .iter()
            .zip(values)
            .filter_map(|(dof, value)| match dof {
                Dof::Turn(axis) => Some((*axis, value * self.radians)),
                _ => None,
            });
        let turn = turned(turns);
        match self.tree.parents[slot] {
            None => {
                let rotation = self.root_orientation * turn;
                (self.text.root_place + shift, rotation.normalize())
            }
            Some(parent) => {
                let back = self.axes[parent].inverse();
                let place = back * (self.ways[parent] + self.axes[slot] * shift);
                (place, (back * self.axes[slot] * turn).normalize())
            }
        }
    }

    /// Returns the index of a slot's values in a frame: its last row up to that frame.
    fn values_at(&self, slot: usize, frame: usize) -> Option<usize> {
        let rows = self.motion_rows(slot);
        let after = rows.partition_point(|r| r.frame <= frame);
        Some(rows[after.checked_sub(1)?].first_value)
    }

    /// Returns the starts of the bones at rest.
    fn rest_places(&self) -> Vec<Vec3> {
        let mut places: Vec<Vec3> = Vec::with_capacity(self.axes.len());
        for parent in &self.tree.parents {
            places.push(match parent {
                None => self.text.root_place,
                Some(p) => places[*p] + self.root_orientation * self.ways[*p],
            });
        }
        places
    }

    fn basis(
        &self,
        options: &ReadOptions,
        warnings: &mut Vec<Warning>,
    ) -> Result<Basis, ReadError> {
        let places = self.rest_places();
        let leaves = self.leaves().into_iter();
        let ends = leaves.map(|slot| (slot, self.root_orientation * self.ways[slot]));
        let length = |parent: &Option<usize>| parent.map_or(0.0, |p| self.ways[p].length());
        let name = |bone: &Option<usize>| bone.map_or("root", |b| self.text.bones[b].name.as_str());
        let head_and_root = |frame: usize, chain: &[usize]| {
            let (mut point, mut root) = (Vec3::ZERO, Vec3::ZERO);
            for &slot in chain {
                let (place, rotation) = self.local(slot, self.values_at(slot, frame));
                point = place + rotation * point;
                root = place;
            }
            (point, root)
        };
        let motion = units::Motion {
            frames: self.motion.frames,
            head_and_root: &head_and_root,
        };
        let figure = units::Figure {
            names: self.tree.bones.iter().map(name).collect(),
            parents: self.tree.parents.clone(),
            places,
            lengths: self.tree.parents.iter().map(length).collect(),
            ends: ends.collect(),
        };
        let (rest_z, motion_z) = figure.has_z_up(options.up, Some(motion), warnings);
        let guess = || scale(self.text.length, figure.size(rest_z));
        let scale = units::scale_to_metres(options.scale_to_metres, guess, warnings)?;
        let z_up = |z: bool| if z { units::y_from_z() } else { Quat::IDENTITY };
        Ok(Basis {
            scale,
            rest: z_up(rest_z),
            motion: z_up(motion_z),
        })
    }

    fn file(&self, basis: &Basis) -> MotionFile {
        let joint = |slot: usize| {
            let (place, rotation) = self.placed(slot, None, basis.scale, basis.rest);
            let name = match self.tree.bones[slot] {
                None => &self.text.root_name,
                Some(bone) => &self.text.bones[bone].name,
            };
            Joint {
                name: name.clone(),
                parent: self.tree.parents[slot],
                rest: Transform {
                    translation: place,
                    rotation,
                    scale: Vec3::ONE,
                },
                in_skin: true,
            }
        };
        let joints = (0..self.axes.len()).map(joint).collect();
        let clip = self.clip(basis);
        MotionFile {
            frame_time_secs: clip.as_ref().map_or(0.0, |_| self.rate_hz.recip()),
            character: Character {
                name: self.text.name.clone(),
                skeleton: Skeleton { joints },
                clips: clip.into_iter().collect(),
                ..Character::default()
            },
            end_sites: self.end_sites(basis.scale),
        }
    }

    /// Returns the ends of leaf bones, unless they have no length.
    fn end_sites(&self, scale: f32) -> Vec<(usize, Vec3)> {
        let leaves = self.leaves().into_iter();
        let ends = leaves.map(|s| (s, self.axes[s].inverse() * self.ways[s] * scale));
        ends.filter(|(_, way)| *way != Vec3::ZERO).collect()
    }

    /// Returns the bones without children.
    fn leaves(&self) -> Vec<usize> {
        let mut last = vec![true; self.axes.len()];
        for parent in self.tree.parents.iter().flatten() {
            last[*parent] = false;
        }
        (0..last.len()).filter(|slot| last[*slot]).collect()
    }

    /// Returns the local translation in metres and the rotation of a joint, with +Y up; `up` turns
    /// the root.
    fn placed(&self, slot: usize, values: Option<usize>, scale: f32, up: Quat) -> (Vec3, Quat) {
        let (place, rotation) = self.local(slot, values);
        match self.tree.parents[slot] {
            Some(_) => (place * scale, rotation),
            None => (up * place * scale, (up * rotation).normalize()),
        }
    }

    fn clip(&self, basis: &Basis) -> Option<RawClip> {
        let last_frame = self.motion.frames.checked_sub(1)?;
        let mut channels = Vec::new();
        for slot in 0..self.axes.len() {
            let dofs = self.bones().dofs(slot);
            let rows = self.motion_rows(slot);
            if dofs.is_empty() || rows.is_empty() {
                continue;
            }
            let keys = self.keys(slot, basis);
            let keyed = |property, values: Vec<f32>| source::Channel {
                target: slot,
                property,
                interpolation: Interpolation::Linear,
                times_secs: keys.times_secs.clone(),
                values,
            };
            if dofs.iter().any(|d| matches!(d, Dof::Shift(_))) {
                channels.push(keyed(Property::Translation, keys.translations.clone()));
            }
            if dofs.iter().any(|d| matches!(d, Dof::Turn(_))) {
                channels.push(keyed(Property::Rotation, keys.rotations.clone()));
            }
        }
        Some(RawClip {
            name: "motion".to_owned(),
            duration_secs: self.time_secs(last_frame),
            channels,
        })
    }

    fn time_secs(&self, frame: usize) -> f32 {
        (frame as f64 / f64::from(self.rate_hz)) as f32
    }

    /// Returns a joint's keys: one for each row, and one more at the end of each interval of frames
    /// without a row, so that the joint holds there.
    fn keys(&self, slot: usize, basis: &Basis) -> Keys {
        let placed = |values| self.placed(slot, values, basis.scale, basis.motion);
        let mut keys = Keys::default();
        let mut held: Option<amc::Row> = None;
        for &row in self.motion_rows(slot) {
            let missing = held.map_or(0, |h| h.frame + 1)..row.frame;
            if let Some(frame) = missing.last() {
                let values = held.map(|h| h.first_value);
                if held.is_none() && frame > 0 {
                    keys.push(0.0, placed(values));
                }
                keys.push(self.time_secs(frame), placed(values));
            }
            keys.push(self.time_secs(row.frame), placed(Some(row.first_value)));
            held = Some(row);
        }
        keys
    }
}

/// Keys of one joint, flattened.
#[derive(Default)]
struct Keys {
    times_secs: Vec<f32>,
    translations: Vec<f32>,
    rotations: Vec<f32>,
    last: Quat,
}

impl Keys {
    fn push(&mut self, time_secs: f32, (place, rotation): (Vec3, Quat)) {
        self.last = same_hemisphere(self.last, rotation);
        self.times_secs.push(time_secs);
        self.translations.extend(place.to_array());
        self.rotations.extend(self.last.to_array());
    }
}
