//! Expressions as animations that one number drives, with masks and mappings.
//!
//! Source: `KHR_character_expression` (its response evaluator: the driver runs through the whole
//! animation), `_joint`, `_morphtarget`, `_texture`, `_mask`, `_mapping`; and the older drafts that
//! list the expressions under the typed extensions. Differs: between the two ends of an animation
//! the response is taken as linear.

use super::super::node_meshes::NodeMeshes;
use super::super::place::{Place, whole};
use super::super::reader::Reader;
use super::super::skeleton::Skeletal;
use super::{EXPRESSION, ExpressionSet, ExpressionShare, extension};
use crate::error::ReadError;
use articula_core::LibmQuat;
use articula_core::angle_between;
use articula_core::source::{
    Channel, Expression, Interpolation, JointBinding, Mask, MaskKind, MorphBinding, Property,
    RawClip, evaluate,
};
use glam::{Quat, Vec3};
use std::collections::{HashMap, HashSet};

/// Elements counted for one binding, channel or mask, against the limit on decoded elements.
const COST: u64 = 8;

/// Deviation of a response from linear that is not reported: weights, metres, radians.
const STRAIGHT: f32 = 1e-3;

/// Smallest difference of a weight from rest that counts as driven.
const STILL: f32 = 1e-6;

/// The expressions, and clip and expression index for each one that has a clip.
#[derive(Debug, Default)]
pub(in super::super) struct Found {
    pub(in super::super) expressions: Vec<Expression>,
    pub(in super::super) clips: Vec<(usize, usize)>,
}

/// Reads all expressions; `clips` are the animations in order.
pub(in super::super) fn read(
    reader: &mut Reader<'_>,
    skeletal: &Skeletal,
    shown: &NodeMeshes,
    clips: &[RawClip],
) -> Result<Found, ReadError> {
    let mut found = Found::default();
    let root = reader.root.clone();
    let entries = entries(&root);
    for place in &entries {
        reader.charge(place, 4 * COST)?;
        let mut expression = Expression {
            name: place.text("expression").to_owned(),
            ..Expression::default()
        };
        match place.index("animation", clips.len()) {
            Ok(Some(clip)) => {
                let response = Response::new(&root, place, clip, &clips[clip]);
                response.fill(reader, skeletal, shown, &mut expression)?;
                found.clips.push((clip, found.expressions.len()));
            }
            Ok(None) => reader.warn(place, "the expression has no animation and no effect"),
            Err(error) => reader.warn(place, format!("the expression has no effect: {error}")),
        }
        found.expressions.push(expression);
    }
    let names = Names::new(&found.expressions);
    for (place, expression) in entries.iter().zip(&mut found.expressions) {
        expression.masks = masks(reader, place, &names)?;
    }
    Ok(found)
}

/// Returns the entries of all drafts: the family's own list, then those under the typed extensions.
fn entries<'a>(root: &Place<'a>) -> Vec<Place<'a>> {
    let lists = ["", "_mapping", "_morphtarget", "_joint", "_texture"];
    let list = |suffix: &&str| extension(root, &format!("{EXPRESSION}{suffix}"));
    let lists = lists.iter().filter_map(list);
    lists
        .flat_map(|place| place.entries("expressions").unwrap_or_default())
        .collect()
}

/// The animation of one expression, with the channels that belong to it.
struct Response<'a> {
    place: Place<'a>,
    clip: &'a RawClip,
    channels: Vec<&'a Channel>,
    /// Number of channels that drive no joint or morph target.
    others: usize,
}

impl<'a> Response<'a> {
    fn new(root: &Place<'a>, place: &Place<'a>, index: usize, clip: &'a RawClip) -> Self {
        let animation = root.entry("animations", index);
        let all = animation.map_or(Vec::new(), |a| a.entries("channels").unwrap_or_default());
        // Drafts before KHR_character_expression listed the channels of each entry.
        let listed = place
            .get("channels")
            .map(|_| place.entries("channels").unwrap_or_default());
        let count = match &listed {
            Some(listed) => listed.len(),
            None => all.len(),
        };
        let channels: Vec<&Channel> = match listed {
            None => clip.channels.iter().collect(),
            Some(listed) => {
                let wanted: HashSet<u64> = listed.iter().filter_map(|c| c.whole().ok()).collect();
                // Channels that were not read are missing from the clip; channel indices of the
                // document apply to the clip only if none is missing.
                let is_whole = all.len() == clip.channels.len();
                let numbered = clip.channels.iter().enumerate();
                let wanted = numbered.filter(|(i, _)| !is_whole || wanted.contains(&(*i as u64)));
                wanted.map(|(_, c)| c).collect()
            }
        };
        let driving = |c: &&Channel| c.property != Property::Expression;
        let channels: Vec<&Channel> = channels.into_iter().filter(driving).collect();
        Self {
            place: place.clone(),
            clip,
            others: count.saturating_sub(channels.len()),
            channels,
        }
    }

    fn fill(
        &self,
        reader: &mut Reader<'_>,
        skeletal: &Skeletal,
        shown: &NodeMeshes,
        expression: &mut Expression,
    ) -> Result<(), ReadError> {
        let mut curved = false;
        let mut of_joint: HashMap<usize, usize> = HashMap::new();
        for channel in &self.channels {
            reader.charge(&self.place, COST)?;
            if channel.property == Property::Weights {
                let rest = &shown.meshes[channel.target].morph_weights;
                reader.charge(&self.place, COST * rest.len() as u64)?;
                let full = self.at(channel, 1.0, rest.len());
                let driven = full.iter().zip(rest).enumerate();
                let driven = driven.filter(|(_, (full, rest))| (*full - *rest).abs() > STILL);
                expression
                    .morphs
                    .extend(driven.map(|(target, (full, rest))| MorphBinding {
                        mesh: channel.target,
                        target,
                        weight: full - rest,
                    }));
                curved |= self.curves(channel, rest.len());
            } else {
                let rest = skeletal.skeleton.joints[channel.target].rest;
                let joint = channel.target;
                let place = *of_joint.entry(joint).or_insert_with(|| {
                    expression.joints.push(JointBinding { joint, full: rest });
                    expression.joints.len() - 1
                });
                let full_pose = &mut expression.joints[place].full;
                let width = if channel.property == Property::Rotation {
                    4
                } else {
                    3
                };
                let full = self.at(channel, 1.0, width);
                match channel.property {
                    Property::Rotation => full_pose.rotation = Quat::from_slice(&full),
                    Property::Scale => full_pose.scale = Vec3::from_slice(&full),
                    _ => full_pose.translation = Vec3::from_slice(&full),
                }
                curved |= self.curves(channel, width);
            }
        }
        let is_step = |c: &&&Channel| c.interpolation == Interpolation::Step;
        let steps = self.channels.iter().filter(is_step).count();
        expression.is_binary = steps > 0 && steps == self.channels.len();
        expression.unapplied = self.others;
        if curved {
            let what = "its response is not linear; replaced by a line from rest to full";
            reader.warn(&self.place, what);
        }
        Ok(())
    }

    /// Returns the value of a channel at a driver value.
    fn at(&self, channel: &Channel, driver: f32, width: usize) -> Vec<f32> {
        let mut value = vec![0.0; width];
        evaluate::channel(channel, driver * self.clip.duration_secs, &mut value);
        value
    }

    fn curves(&self, channel: &Channel, width: usize) -> bool {
        if channel.interpolation == Interpolation::Step || width == 0 {
            return false;
        }
        let (from, to) = (self.at(channel, 0.0, width), self.at(channel, 1.0, width));
        [0.25, 0.5, 0.75].iter().any(|&driver| {
            let found = self.at(channel, driver, width);
            if channel.property == Property::Rotation {
                let straight = Quat::from_slice(&from).libm_slerp(Quat::from_slice(&to), driver);
                return angle_between(straight, Quat::from_slice(&found)) > STRAIGHT;
            }
            let straight = from.iter().zip(&to).map(|(a, b)| a + (b - a) * driver);
            found
                .iter()
                .zip(straight)
                .any(|(f, s)| (f - s).abs() > STRAIGHT)
        })
    }
}

/// Reads the masks of an expression. A target is an index or, in earlier drafts, a name.
fn masks(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    names: &Names,
) -> Result<Vec<Mask>, ReadError> {
    let Some(list) = extension(place, &format!("{EXPRESSION}_mask")) else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for mask in list.entries("masks").unwrap_or_default() {
        reader.charge(&mask, COST)?;
        let share = |key: &str, absent| {
            let share = mask.get(key).map_or(Ok(absent), |v| v.float());
            share.map_or(absent, |share| share.clamp(0.0, 1.0))
        };
        let kind = match mask.text("type") {
            "" | "blend" => MaskKind::Blend,
            "block" => MaskKind::Block {
                above: share("threshold", 0.0),
            },
            _ => {
                reader.warn(&mask, "a mask of an unknown type is ignored");
                continue;
            }
        };
        match mask.get("target").and_then(|t| names.own(&t)) {
            Some(target) => found.push(Mask {
                target,
                kind,
                amount: share("amount", 1.0),
                adds: false,
            }),
            None => reader.warn(&mask, "the target is not an expression; left out"),
        }
    }
    Ok(found)
}

/// Names of the character's expressions; of equal ones the first counts.
struct Names {
    first: HashMap<String, usize>,
    count: usize,
}

impl Names {
    fn new(expressions: &[Expression]) -> Self {
        let mut first = HashMap::new();
        for (i, expression) in expressions.iter().enumerate() {
            first.entry(expression.name.clone()).or_insert(i);
        }
        let count = expressions.len();
        Self { first, count }
    }

    /// Returns an expression of the character by index or name.
    fn own(&self, value: &Place<'_>) -> Option<usize> {
        if let Some(index) = whole(value.value()) {
            return usize::try_from(index).ok().filter(|i| *i < self.count);
        }
        self.first.get(value.value().as_str()?).copied()
    }
}

/// Reads the mappings to known sets of expressions. Entries name an expression of the character as
/// `source`; in earlier drafts it is the key and the known one is `target`.
pub(super) fn sets(reader: &mut Reader<'_>, expressions: &[Expression]) -> Vec<ExpressionSet> {
    let mapping = extension(&reader.root, &format!("{EXPRESSION}_mapping"));
    let sets = mapping.and_then(|m| m.get("expressionSetMappings"));
    let names = Names::new(expressions);
    let mut found = Vec::new();
    for (name, set) in sets.map_or(Vec::new(), |s| s.members()) {
        let mut shares = Vec::new();
        let mut lost = 0;
        for (key, list) in set.members() {
            let entries = set.entries(key).unwrap_or_default();
            lost += usize::from(list.value().as_array().is_none());
            for entry in entries {
                match share(key, &entry, &names) {
                    Some(share) => shares.push(share),
                    None => lost += 1,
                }
            }
        }
        if lost > 0 {
            reader.warn(
                &set,
                format!("{lost} entries do not name an expression; left out"),
            );
        }
        let set = name.to_owned();
        found.push(ExpressionSet { set, shares });
    }
    found
}

fn share(key: &str, entry: &Place<'_>, names: &Names) -> Option<ExpressionShare> {
    let weight = entry.get("weight").map_or(Ok(1.0), |w| w.float()).ok()?;
    let (known, expression) = match entry.get("source") {
        Some(source) => (key.to_owned(), names.own(&source)?),
        None => {
            let known = entry.get("target")?.value().as_str()?;
            (known.to_owned(), *names.first.get(key)?)
        }
    };
    Some(ExpressionShare {
        known,
        expression,
        weight,
    })
}
