//! The skeleton that a stream may carry, so that it can be shown without its character.
//!
//! Form: `docs/formats/abp2.md`, part 3.

use super::grouping::region_number;
use super::head::MotionHead;
use crate::error::StreamError;
use crate::limits::StreamLimits;
use articula_core::loa::MAX_LEVEL;
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, ByteReader, JointArticulation, MalformedBytes, Mismatch, Region, Rig, Transform,
    push_varint,
};
use glam::{Quat, Vec3};

/// The bits of a region's number.
const REGION: u8 = 7;
const IN_SKIN: u8 = 8;
const TURNED: u8 = 16;
const SCALED: u8 = 32;
/// Most bytes of the name of a joint.
const MOST_NAME: u64 = 1 << 12;

/// The joints that a stream carries: names, parents and rest pose as in the character, level of
/// articulation and region of each.
#[derive(Debug, Clone, PartialEq)]
pub struct CarriedSkeleton {
    /// The joints.
    pub skeleton: Skeleton,
    /// Level and region of each; names of H-Anim are not carried.
    pub articulation: Articulation,
}

impl CarriedSkeleton {
    /// Reads the skeleton of a stream, of which the head must be there; `None` if it carries none.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte: a malformed head or skeleton, or one that ends early.
    pub fn open(stream: &[u8], limits: &StreamLimits) -> Result<Option<Self>, StreamError> {
        let read = MotionHead::open_read(stream, limits)?;
        let Some(place) = read.skeleton else {
            return Ok(None);
        };
        let start = place.body.start;
        let read = read_joints(&stream[place.body], read.head.joints);
        let read = read.map_err(|fault| MalformedBytes {
            at: start + fault.at,
            ..fault
        });
        Ok(Some(read?))
    }
}

fn read_joints(bytes: &[u8], count: usize) -> Result<CarriedSkeleton, MalformedBytes> {
    let mut reader = ByteReader::new(bytes);
    let mut skeleton = Skeleton::default();
    let mut articulation = Articulation::default();
    for index in 0..count {
        let (joint, known) = read_joint(&mut reader, index)?;
        skeleton.joints.push(joint);
        articulation.joints.push(known);
    }
    reader.end()?;
    Ok(CarriedSkeleton {
        skeleton,
        articulation,
    })
}

fn read_joint(
    reader: &mut ByteReader<'_>,
    index: usize,
) -> Result<(Joint, JointArticulation), MalformedBytes> {
    let parent = reader.varint()?;
    if parent > index as u64 {
        let what = format!("joint {index} before its parent, joint {}", parent - 1);
        return Err(reader.bad(what));
    }
    let [level, flags] = reader.take()?;
    if level > MAX_LEVEL {
        return Err(reader.bad(format!("level {level}, at most {MAX_LEVEL}")));
    }
    let region = usize::from(flags & REGION).checked_sub(1);
    let region = region.and_then(|number| Region::ALL.get(number));
    let region = region.filter(|_| flags < 2 * SCALED);
    let region = *region.ok_or_else(|| reader.bad(format!("unknown flags {flags:#x}")))?;
    let length = reader.varint()?;
    if length > MOST_NAME {
        return Err(reader.bad(format!("a name of {length} bytes, at most {MOST_NAME}")));
    }
    let name = str::from_utf8(reader.slice(length as usize)?);
    let name = name.map_err(|_| reader.bad("expected a name in UTF-8"))?;
    let mut rest = Transform {
        translation: Vec3::from(floats(reader)?),
        ..Transform::default()
    };
    if flags & TURNED != 0 {
        rest.rotation = Quat::from_array(floats(reader)?);
    }
    if flags & SCALED != 0 {
        rest.scale = Vec3::from(floats(reader)?);
    }
    if !rest.is_finite() {
        return Err(reader.bad(format!("the rest pose of joint {index} is not finite")));
    }
    let joint = Joint {
        name: name.to_owned(),
        parent: (parent as usize).checked_sub(1),
        rest,
        in_skin: flags & IN_SKIN != 0,
    };
    let known = JointArticulation {
        hanim: None,
        level,
        region,
    };
    Ok((joint, known))
}

fn floats<const N: usize>(reader: &mut ByteReader<'_>) -> Result<[f32; N], MalformedBytes> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = f32::from_be_bytes(reader.take()?);
    }
    Ok(values)
}

/// Writes the joints of a rig.
///
/// # Errors
/// A [`Mismatch`] that names a joint whose name is too long.
pub(super) fn write(rig: &Rig) -> Result<Vec<u8>, Mismatch> {
    let mut out = Vec::new();
    for (index, known) in rig.articulation().joints.iter().enumerate() {
        let rest = rig.rest_pose().get(index);
        // By their bits: the hash of the rig tells -0 from 0.
        let bits = |values: [f32; 4]| values.map(f32::to_bits);
        let is_turned = bits(rest.rotation.to_array()) != bits(Quat::IDENTITY.to_array());
        let is_scaled = rest.scale.to_array().map(f32::to_bits) != [1.0_f32.to_bits(); 3];
        let flag = |is_set: bool, flag: u8| if is_set { flag } else { 0 };
        push_varint(&mut out, rig.parent(index).map_or(0, |p| p as u64 + 1));
        out.push(known.level);
        out.push(
            region_number(known.region)
                | flag(rig.skin_joints().contains(index), IN_SKIN)
                | flag(is_turned, TURNED)
                | flag(is_scaled, SCALED),
        );
        let name = rig.name(index);
        if name.len() as u64 > MOST_NAME {
            let what = format!(
                "its name has {} bytes; a stream carries at most {MOST_NAME}",
                name.len()
            );
            return Err(Mismatch::new(format!("joint {index}"), what));
        }
        push_varint(&mut out, name.len() as u64);
        out.extend(name.as_bytes());
        let floats = rest.translation.to_array().into_iter();
        let turn = rest.rotation.to_array().into_iter();
        let floats = floats.chain(turn.filter(|_| is_turned));
        let floats = floats.chain(rest.scale.to_array().into_iter().filter(|_| is_scaled));
        floats.for_each(|value| out.extend(value.to_be_bytes()));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn joint() -> impl Strategy<Value = (Joint, JointArticulation)> {
        let vector = || prop::array::uniform3(-10.0_f32..10.0);
        let turn = prop_oneof![
            Just([0.0, 0.0, 0.0, 1.0]),
            Just([-0.0, 0.0, 0.0, 1.0]),
            prop::array::uniform4(-1.0_f32..1.0)
        ];
        let scale = prop_oneof![Just([1.0; 3]), vector()];
        let labels = (0_u8..=5, 0_usize..Region::ALL.len(), any::<bool>());
        (".{0,12}", any::<usize>(), vector(), turn, scale, labels).prop_map(
            |(name, parent, translation, rotation, scale, (level, region, in_skin))| {
                let rest = Transform {
                    translation: translation.into(),
                    rotation: Quat::from_array(rotation),
                    scale: scale.into(),
                };
                let joint = Joint {
                    name,
                    parent: Some(parent),
                    rest,
                    in_skin,
                };
                let known = JointArticulation {
                    hanim: None,
                    level,
                    region: Region::ALL[region],
                };
                (joint, known)
            },
        )
    }

    proptest! {
        #[test]
        fn skeletons_come_back_to_the_bit(joints in prop::collection::vec(joint(), 1..20)) {
            let (mut joints, known): (Vec<Joint>, Vec<_>) = joints.into_iter().unzip();
            for (index, joint) in joints.iter_mut().enumerate() {
                // One more than the number of joints before it: some are roots.
                let parent = joint.parent.map_or(0, |any| any % (index + 1));
                joint.parent = parent.checked_sub(1);
            }
            let written = CarriedSkeleton {
                skeleton: Skeleton { joints },
                articulation: Articulation { profile: String::new(), joints: known },
            };
            let rig = Rig::new(&written.skeleton, written.articulation.clone()).unwrap();
            let bytes = write(&rig).unwrap();
            let read = read_joints(&bytes, rig.len()).unwrap();
            // Equality does not tell -0 from 0.
            let turns = |all: &Skeleton| -> Vec<[u32; 4]> {
                let joints = all.joints.iter();
                joints.map(|j| j.rest.rotation.to_array().map(f32::to_bits)).collect()
            };
            prop_assert_eq!(turns(&read.skeleton), turns(&written.skeleton));
            prop_assert_eq!(read, written);
            for length in 0..bytes.len() {
                prop_assert!(read_joints(&bytes[..length], rig.len()).is_err());
            }
            prop_assert!(read_joints(&bytes, rig.len() + 1).is_err());
        }

        #[test]
        fn any_bytes_end(bytes in prop::collection::vec(any::<u8>(), 0..200), count in 1_usize..8) {
            if let Ok(read) = read_joints(&bytes, count) {
                prop_assert!(Rig::new(&read.skeleton, read.articulation).is_ok());
            }
        }
    }
}
