//! Groups of triangles that move nearly alike, and their motions.

use super::cost::Costs;
use super::fit::{LEAST_AREA, fitted};
use super::item::Item;
use super::placed::Placed;
use crate::planar::keyed_motion::KeyedMotion;
use articula_core::{Cancelled, Progress};
use glam::DVec2;
use std::collections::BTreeMap;

/// Fewest triangles that have a motion of their own.
const FEWEST: usize = 6;
/// Maximum number of motions.
const MOST: usize = 48;
/// Rounds in which groups are divided.
const DIVISIONS: usize = 2;
/// Rounds in which triangles choose their motion, before groups are divided and after each division.
const CHOICES: usize = 3;

/// Motions for some items: at first of each joint, then also of parts of what these move badly. Those that a file cannot
/// hold, such as of a wheel that turns thirty times, and those that collapse between keys, are left out.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn clusters(
    items: &[Item],
    frames: usize,
    progress: &mut Progress<'_>,
) -> Result<Vec<KeyedMotion>, Cancelled> {
    let mut by_part: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
    for (i, item) in items.iter().enumerate() {
        by_part.entry(item.part).or_default().push(i);
    }
    let mut groups: Vec<Vec<usize>> = by_part.into_values().collect();
    let share = 1.0 / (DIVISIONS + 1) as f32;
    let mut motions = chosen(items, &mut groups, frames, &mut progress.part(0.0, share))?;
    for division in 1..=DIVISIONS {
        let halves = groups.iter().zip(&motions);
        groups = halves
            .flat_map(|(group, motion)| divided(items, group, motion, frames))
            .collect();
        let from = division as f32 * share;
        let progress = &mut progress.part(from, from + share);
        motions = chosen(items, &mut groups, frames, progress)?;
    }
    motions.retain(|motion| is_sound(motion, frames));
    Ok(motions)
}

fn is_sound(motion: &KeyedMotion, frames: usize) -> bool {
    let area = |frame: usize| motion.at(frame as f64).matrix2.determinant();
    motion.check(frames as u32).is_ok() && (0..frames).all(|f| area(f) > LEAST_AREA / 2.0)
}

/// Motions of groups, which are changed to the items that each motion suits best.
fn chosen(
    items: &[Item],
    groups: &mut Vec<Vec<usize>>,
    frames: usize,
    progress: &mut Progress<'_>,
) -> Result<Vec<KeyedMotion>, Cancelled> {
    let mut motions = Vec::new();
    for choice in 0..CHOICES {
        let at = |part: f32| (choice as f32 + part) / CHOICES as f32;
        groups.retain(|group| group.len() >= FEWEST);
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        groups.truncate(MOST);
        motions.clear();
        for (g, group) in groups.iter().enumerate() {
            progress.step(at(0.5 * g as f32 / groups.len() as f32))?;
            let members: Vec<&Item> = group.iter().map(|i| &items[*i]).collect();
            motions.push(fitted(&members, frames));
        }
        groups.iter_mut().for_each(Vec::clear);
        let costs = Costs::new(items, &motions, &mut progress.part(at(0.5), at(1.0)))?;
        for (i, best) in costs.best().into_iter().enumerate() {
            if let Some(motion) = best {
                groups[motion as usize].push(i);
            }
        }
    }
    Ok(motions)
}

/// A group in two parts, by the side to which the motion fails them most differently.
fn divided(
    items: &[Item],
    group: &[usize],
    motion: &KeyedMotion,
    frames: usize,
) -> Vec<Vec<usize>> {
    if group.len() < 2 * FEWEST {
        return vec![group.to_vec()];
    }
    let placed = Placed::of(motion, frames);
    let rows: Vec<Vec<DVec2>> = group.iter().map(|i| residue(&items[*i], &placed)).collect();
    let mut axis = longest(&rows);
    // Power iteration for the first principal axis.
    for _ in 0..8 {
        let mut next = vec![DVec2::ZERO; frames];
        for row in &rows {
            let share = dot(row, &axis);
            next.iter_mut().zip(row).for_each(|(n, r)| *n += share * *r);
        }
        let length = dot(&next, &next).sqrt().max(1e-9);
        next.iter_mut().for_each(|n| *n /= length);
        axis = next;
    }
    let (one, other): (Vec<_>, Vec<_>) = group
        .iter()
        .zip(&rows)
        .partition(|(_, row)| dot(row, &axis) > 0.0);
    let members = |half: Vec<(&usize, &Vec<DVec2>)>| half.into_iter().map(|(i, _)| *i).collect();
    vec![members(one), members(other)]
}

/// Path of a triangle's centre in the coordinates of shapes, from its mean; 0 where it is hidden.
fn residue(item: &Item, placed: &[Placed]) -> Vec<DVec2> {
    let centre = |f: usize| {
        let sum: DVec2 = item.corners[f].iter().sum();
        placed[f].to_shape(sum / 3.0)
    };
    let shown = (0..placed.len()).filter(|f| item.is_shown[*f]);
    let count = shown.clone().count().max(1);
    let mean = shown.map(centre).sum::<DVec2>() / count as f64;
    let of = |f: usize| {
        if item.is_shown[f] {
            centre(f) - mean
        } else {
            DVec2::ZERO
        }
    };
    (0..placed.len()).map(of).collect()
}

fn dot(a: &[DVec2], b: &[DVec2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn longest(rows: &[Vec<DVec2>]) -> Vec<DVec2> {
    let longest = rows.iter().max_by(|a, b| dot(a, a).total_cmp(&dot(b, b)));
    longest.cloned().unwrap_or_default()
}
