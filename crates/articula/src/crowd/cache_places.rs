//! Places of cached palettes among all, after those of some clips were left out.

use articula_core::PaletteMap;
use articula_formats::prepared::CacheKeys;

/// Moves palettes together, in the order that they have. There is an entry for each level of the map.
pub(super) fn close_gaps(keys: &mut CacheKeys, map: &PaletteMap) {
    let mut runs: Vec<(&mut u32, u32)> = Vec::new();
    for of_clip in &mut keys.keys {
        for (level, keys) in of_clip.iter_mut().enumerate() {
            if let Some(keys) = keys {
                let palettes = keys.times_secs.len() as u32;
                let matrices = palettes.saturating_mul(map.len(level) as u32);
                runs.push((&mut keys.first_matrix, matrices));
            }
        }
    }
    for of_clip in &mut keys.steps {
        for (level, steps) in of_clip.iter_mut().enumerate() {
            if let Some(steps) = steps {
                let matrices = steps.count.saturating_mul(map.len(level) as u32);
                runs.push((&mut steps.first_matrix, matrices));
            }
        }
    }
    runs.sort_by_key(|(first, _)| **first);
    let (mut next, mut end) = (0_u32, 0_u32);
    let mut before = None;
    for (first, matrices) in runs {
        // Levels that share palettes have the same first matrix; the palettes are as long as the longest.
        if before.replace(*first) != Some(*first) {
            next = end;
        }
        *first = next;
        end = end.max(next.saturating_add(matrices));
    }
}
