//! Meshes of an item: a level for each region, where regions may differ.

use super::memory;
use super::option_of_part::OptionOfPart;
use crate::item::part::{ItemLayer, ItemPart};
use articula_stream::decide::PartOption;
use std::collections::BTreeMap;

/// Most mixes of levels; with more, one region at a time differs from the others.
const MOST: usize = 240;

/// What a region shows.
#[derive(Clone, Copy)]
struct Step {
    /// Index of its layer.
    layer: usize,
    level: u32,
    error_m: f64,
    triangles: i64,
    vertices: i64,
}

/// The options of a mesh, coarsest first.
pub(super) fn options(
    index: usize,
    part: &ItemPart,
    (triangles_per_s, targets): (Option<f64>, u64),
) -> Vec<OptionOfPart> {
    let level = |layer: &ItemLayer| layer.keep.get("level").copied().unwrap_or(0);
    let has_region = |layer: &&ItemLayer| layer.keep.contains_key("region");
    let numbered = || part.layers.iter().enumerate();
    let common: Vec<usize> = numbered()
        .filter(|(_, layer)| !has_region(layer))
        .map(|(i, _)| i)
        .collect();
    let ns_of_triangle = triangles_per_s
        .filter(|n| *n > 0.0)
        .map_or(0.0, |n| 1e9 / n);
    let made = |name: String,
                level: u32,
                error_m: f64,
                [triangles, vertices]: [u64; 2],
                layers: &[usize]| {
        let kept = part.closure(layers);
        OptionOfPart {
            option: PartOption {
                name,
                level,
                error_m,
                bytes_once: part.bytes_of(&kept),
                frame_ns: (triangles as f64 * ns_of_triangle).min(1e12) as u64,
                memory_bytes: memory::mesh(vertices, triangles, targets).min(memory::MOST),
                ..PartOption::default()
            },
            layers: vec![(index, kept)],
            is_even: true,
        }
    };
    let triangles = |layer: &ItemLayer| layer.triangles.unwrap_or(0);
    let vertices = |layer: &ItemLayer| layer.vertices.unwrap_or(0);
    let counts = |layer: &ItemLayer| [triangles(layer), vertices(layer)];
    let mut options: Vec<OptionOfPart> = common
        .iter()
        .map(|i| (*i, &part.layers[*i]))
        .map(|(i, l)| made(l.name.clone(), level(l), l.error_m, counts(l), &[i]))
        .collect();
    let Some(base) = common.last().map(|i| &part.layers[*i]) else {
        return options;
    };
    let regions = steps_of_regions(part, common[common.len() - 1]);
    let names: BTreeMap<u32, &str> = part.regions.iter().map(|r| (r.number, &*r.name)).collect();
    for mix in mixes(&regions.values().map(Vec::len).collect::<Vec<_>>()) {
        let steps: Vec<(u32, Step)> = regions
            .iter()
            .zip(&mix)
            .map(|((region, steps), step)| (*region, steps[*step]))
            .collect();
        let finest = steps.iter().map(|(_, s)| s.level).min();
        let error_m = steps.iter().map(|(_, s)| s.error_m).fold(0.0, f64::max);
        let extra: i64 = steps.iter().map(|(_, s)| s.triangles).sum();
        let more: i64 = steps.iter().map(|(_, s)| s.vertices).sum();
        let with = |of: u64, more: i64| (of as i64).saturating_add(more).max(0) as u64;
        let layers: Vec<usize> = steps.iter().map(|(_, s)| s.layer).collect();
        let mixed = made(
            mix_name(&steps, &names),
            finest.unwrap_or(level(base)),
            error_m,
            [with(triangles(base), extra), with(vertices(base), more)],
            &layers,
        );
        options.push(OptionOfPart {
            is_even: steps.iter().all(|(_, step)| Some(step.level) == finest),
            ..mixed
        });
    }
    options
}

/// Each region: at the base, a layer of all regions, and at its finer levels.
fn steps_of_regions(part: &ItemPart, base: usize) -> BTreeMap<u32, Vec<Step>> {
    let count = |n: Option<u64>| n.unwrap_or(0) as i64;
    let level = |layer: &ItemLayer| layer.keep.get("level").copied().unwrap_or(0);
    let below = &part.layers[base];
    let mut regions: BTreeMap<u32, Vec<Step>> = BTreeMap::new();
    for (i, layer) in part.layers.iter().enumerate() {
        let Some(region) = layer.keep.get("region") else {
            continue;
        };
        let steps = regions.entry(*region).or_insert_with(|| {
            vec![Step {
                layer: base,
                level: level(below),
                error_m: below.error_m,
                triangles: 0,
                vertices: 0,
            }]
        });
        steps.push(Step {
            layer: i,
            level: level(layer),
            error_m: layer.error_alone_m.unwrap_or(layer.error_m),
            // All others are at the level that the layer builds on.
            triangles: count(layer.triangles) - count(below.triangles),
            vertices: count(layer.vertices) - count(below.vertices),
        });
    }
    regions
}

/// `level 1`, or the level of each region.
fn mix_name(steps: &[(u32, Step)], names: &BTreeMap<u32, &str>) -> String {
    let first = steps.first().map_or(0, |(_, step)| step.level);
    if steps.iter().all(|(_, step)| step.level == first) {
        return format!("level {first}");
    }
    let of = |(region, step): &(u32, Step)| {
        let name = names.get(region).copied().unwrap_or("region");
        format!("{name} {}", step.level)
    };
    let parts: Vec<String> = steps.iter().map(of).collect();
    format!("levels: {}", parts.join(", "))
}

/// All mixes of steps but that of all first ones, each region having this number of steps.
fn mixes(counts: &[usize]) -> Vec<Vec<usize>> {
    let product = counts.iter().try_fold(1_usize, |p, n| p.checked_mul(*n));
    let zero = vec![0; counts.len()];
    if product.is_none_or(|p| p > MOST) {
        let most = counts.iter().max().copied().unwrap_or(1);
        let even = (1..most).map(|step| counts.iter().map(|n| step.min(n - 1)).collect());
        let one = counts.iter().enumerate().flat_map(|(region, n)| {
            let zero = zero.clone();
            (1..*n).map(move |step| {
                let mut mix = zero.clone();
                mix[region] = step;
                mix
            })
        });
        return even.chain(one).take(MOST).collect();
    }
    let mut all = vec![zero];
    for (region, n) in counts.iter().enumerate() {
        let before = all.clone();
        all.clear();
        for step in 0..*n {
            all.extend(before.iter().cloned().map(|mut mix| {
                mix[region] = step;
                mix
            }));
        }
    }
    all.retain(|mix| mix.iter().any(|step| *step > 0));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(level: u32, region: Option<u32>, needs: &[usize], error_m: f64) -> ItemLayer {
        let mut keep = BTreeMap::from([("level".to_owned(), level)]);
        keep.extend(region.map(|region| ("region".to_owned(), region)));
        ItemLayer {
            name: format!("level {level}"),
            keep,
            needs: needs.to_vec(),
            bytes: 10_u64.pow(3 - level),
            error_m,
            error_alone_m: region.map(|_| error_m / 2.0),
            triangles: Some(u64::from(100 / (level + 1))),
            ..ItemLayer::default()
        }
    }

    #[test]
    fn regions_mix_below_the_common_levels() {
        let part = ItemPart {
            name: "mesh".into(),
            kind: crate::item::PartKind::Mesh,
            file: None,
            index: None,
            bytes: 0,
            base_bytes: 5,
            base_ranges: Vec::new(),
            base_error_m: None,
            duration_secs: None,
            rate_hz: None,
            frames_measured: None,
            image: None,
            layers: vec![
                layer(2, None, &[], 0.09),
                layer(1, None, &[0], 0.03),
                layer(0, Some(0), &[1], 0.02),
                layer(0, Some(4), &[1], 0.01),
            ],
            levels: Vec::new(),
            regions: Vec::new(),
            face_levels: Vec::new(),
            left_out: Vec::new(),
        };
        let options = options(7, &part, (Some(1e9), 0));
        let of = |i: usize| (options[i].option.bytes_once, options[i].option.level);
        let found: Vec<_> = (0..options.len()).map(of).collect();
        // 10 bytes at level 2, 100 more at level 1, 1000 more for each region at level 0.
        assert_eq!(found, [(15, 2), (115, 1), (1115, 0), (1115, 0), (2115, 0)]);
        // Both at level 0: the greater of their own errors. One alone: the other has that of level 1.
        assert_eq!(options[4].option.error_m, 0.01);
        assert_eq!(options[2].option.error_m, 0.03);
        // 50 at level 1, 50 more for each region.
        assert_eq!(options[4].option.frame_ns, 150);
        assert_eq!(options[4].layers, [(7, vec![true; 4])]);
        assert_eq!(options[2].layers, [(7, vec![true, true, true, false])]);
    }

    #[test]
    fn too_many_mixes_become_even_and_single_ones() {
        assert_eq!(mixes(&[2, 3]).len(), 5);
        let many = mixes(&[5; 6]);
        assert_eq!(many.len(), 4 + 6 * 4);
        assert_eq!(many[3], [4; 6]);
        assert!(mixes(&[]).is_empty());
    }
}
