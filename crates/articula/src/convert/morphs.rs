//! Transfer of morph weights and expressions between characters, by name.

use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, RawMesh};

/// Channels for the other character; joint channels are ignored.
pub(super) fn channels(from: &Character, clip: &RawClip, onto: &Character) -> Vec<Channel> {
    let mut made = weights(from, clip, onto);
    for channel in clip
        .channels
        .iter()
        .filter(|c| c.property == Property::Expression)
    {
        let name = &from.expressions[channel.target].name;
        let twin = onto.expressions.iter().position(|e| e.name == *name);
        made.extend(twin.map(|target| Channel {
            target,
            ..channel.clone()
        }));
    }
    made
}

/// Channels of morph weights.
fn weights(from: &Character, clip: &RawClip, onto: &Character) -> Vec<Channel> {
    let of_weights = |c: &&Channel| c.property == Property::Weights;
    if are_same(&from.meshes, &onto.meshes) {
        return clip.channels.iter().filter(of_weights).cloned().collect();
    }
    let mut made = Vec::new();
    for (target, mesh) in onto.meshes.iter().enumerate() {
        let weights = clip.channels.iter().filter(of_weights);
        // If several source meshes have matching names, the one with the most matches drives.
        let shared = |c: &&Channel| twins(&from.meshes[c.target], mesh).flatten().count();
        if let Some(channel) = weights.max_by_key(shared)
            && shared(&channel) > 0
        {
            made.push(weights_of(
                channel,
                &from.meshes[channel.target],
                mesh,
                target,
            ));
        }
    }
    made
}

/// Whether both characters have the same meshes, whose morph targets need no names then.
fn are_same(from: &[RawMesh], onto: &[RawMesh]) -> bool {
    let vertices = |mesh: &RawMesh| -> usize {
        let of_primitives = mesh.primitives.iter().map(|p| p.positions.len());
        of_primitives.sum()
    };
    let shape = |mesh: &RawMesh| (vertices(mesh), mesh.morph_weights.len());
    let mut pairs = from.iter().zip(onto);
    from.len() == onto.len()
        && pairs.all(|(a, b)| {
            (&a.name, &a.morph_names, shape(a)) == (&b.name, &b.morph_names, shape(b))
        })
}

/// For each morph target of `onto`, the index of the one of `from` with its name.
fn twins<'a>(from: &'a RawMesh, onto: &'a RawMesh) -> impl Iterator<Item = Option<usize>> + 'a {
    let named = |name: &String| {
        let same = |n: &String| !name.is_empty() && n == name;
        from.morph_names.iter().position(same)
    };
    onto.morph_names.iter().map(named)
}

fn weights_of(channel: &Channel, from: &RawMesh, onto: &RawMesh, target: usize) -> Channel {
    let twins: Vec<Option<usize>> = twins(from, onto).collect();
    let width = from.morph_weights.len();
    let cubic = channel.interpolation == Interpolation::CubicSpline;
    let mut values = Vec::with_capacity(channel.values.len() / width.max(1) * twins.len());
    for (row, weights) in channel.values.chunks_exact(width).enumerate() {
        // Tangents of a missing target are 0.
        let is_tangent = cubic && row % 3 != 1;
        for (slot, twin) in twins.iter().enumerate() {
            let rest = if is_tangent {
                0.0
            } else {
                onto.morph_weights[slot]
            };
            values.push(twin.map_or(rest, |t| weights[t]));
        }
    }
    Channel {
        target,
        values,
        ..channel.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Expression;

    fn with_morphs(names: &[&str], rest: f32) -> Character {
        Character {
            meshes: vec![RawMesh {
                morph_names: names.iter().map(|n| (*n).to_owned()).collect(),
                morph_weights: vec![rest; names.len()],
                ..RawMesh::default()
            }],
            ..Character::default()
        }
    }

    fn driven(property: Property, values: Vec<f32>) -> RawClip {
        RawClip {
            channels: vec![Channel {
                target: 0,
                property,
                interpolation: Interpolation::Linear,
                times_secs: vec![0.0, 1.0],
                values,
            }],
            ..RawClip::default()
        }
    }

    #[test]
    fn weights_follow_their_names_and_others_stay_at_rest() {
        let from = with_morphs(&["smile", "blink"], 0.0);
        let onto = with_morphs(&["blink", "frown", "smile"], 0.25);
        let clip = driven(Property::Weights, vec![0.1, 0.2, 0.3, 0.4]);
        let made = channels(&from, &clip, &onto);
        assert_eq!(made.len(), 1);
        assert_eq!(made[0].values, [0.2, 0.25, 0.1, 0.4, 0.25, 0.3]);
        assert!(channels(&from, &clip, &with_morphs(&["other"], 0.0)).is_empty());
    }

    #[test]
    fn weights_of_the_same_mesh_need_no_names() {
        let unnamed = |targets: usize| Character {
            meshes: vec![RawMesh {
                morph_weights: vec![0.0; targets],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        let clip = driven(Property::Weights, vec![0.1, 0.2, 0.3, 0.4]);
        assert_eq!(channels(&unnamed(2), &clip, &unnamed(2)), clip.channels);
        assert!(channels(&unnamed(2), &clip, &unnamed(3)).is_empty());
    }

    #[test]
    fn expressions_follow_their_names() {
        let named = |names: &[&str]| Character {
            expressions: names
                .iter()
                .map(|name| Expression {
                    name: (*name).to_owned(),
                    ..Expression::default()
                })
                .collect(),
            ..Character::default()
        };
        let clip = driven(Property::Expression, vec![0.0, 1.0]);
        let made = channels(&named(&["happy"]), &clip, &named(&["sad", "happy"]));
        assert_eq!((made.len(), made[0].target), (1, 1));
        assert!(channels(&named(&["happy"]), &clip, &named(&["sad"])).is_empty());
    }
}
