//! Limits of a written file, and those that platforms have published.

use super::{OptimizeReport, TextureContents, TextureOptimized};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// What a written file may not exceed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OptimizeLimits {
    /// Greatest number of bytes of the file.
    pub max_bytes: Option<usize>,
    /// Greatest number of triangles of all meshes that are shown.
    pub max_triangles: Option<usize>,
    /// Longest side in pixels of any picture that a material uses; larger ones are made smaller.
    pub max_textures_px: Option<usize>,
    /// Greatest number of joints of all skins. Of a file with more, those that are missed least are merged
    /// into joints above them.
    pub max_joints: Option<usize>,
}

/// Limits that a platform has published.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlatformLimits {
    /// Name, such as `vrchat-quest`.
    pub name: String,
    /// What the limits are for.
    pub about: String,
    /// The limits.
    #[serde(flatten)]
    pub limits: OptimizeLimits,
    /// Address of the page that states them.
    pub source: String,
    /// Date on which the page was read.
    pub seen: String,
}

impl OptimizeLimits {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the source of a report is within them.
    pub fn allow_source(&self, report: &OptimizeReport) -> bool {
        let is_within = |found: usize, max: Option<usize>| max.is_none_or(|max| found <= max);
        is_within(report.bytes_in, self.max_bytes)
            && report.merged_joints.is_none()
            && is_within(report.triangles_in, self.max_triangles)
            && too_large(&report.textures, self.max_textures_px, |t| t.size_in).is_none()
    }

    /// The narrower of two limits each.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let least = |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min();
        Self {
            max_bytes: least(self.max_bytes, other.max_bytes),
            max_triangles: least(self.max_triangles, other.max_triangles),
            max_textures_px: least(self.max_textures_px, other.max_textures_px),
            max_joints: least(self.max_joints, other.max_joints),
        }
    }
}

/// The first texture with a side above a limit, or of a size that is not known.
pub(super) fn too_large(
    textures: &[TextureOptimized],
    max_px: Option<usize>,
    size: impl Fn(&TextureOptimized) -> Option<[u32; 2]>,
) -> Option<&TextureOptimized> {
    let max_px = max_px?;
    let is_large = |sides: [u32; 2]| sides.iter().any(|px| *px as usize > max_px);
    let mut used = textures
        .iter()
        .filter(|texture| texture.holds != TextureContents::Unknown);
    used.find(|texture| size(texture).is_none_or(is_large))
}

impl PlatformLimits {
    /// All that are known.
    ///
    /// # Errors
    /// [`Error::Argument`] if the table of the library is malformed.
    pub fn all() -> Result<Vec<Self>> {
        let read = serde_json::from_str(include_str!("limits.json"));
        read.map_err(|e| Error::argument(format!("limits.json: {e}")))
    }

    /// Those of a name.
    ///
    /// # Errors
    /// [`Error::Argument`] that lists the names if there is no such.
    pub fn of(name: &str) -> Result<Self> {
        let all = Self::all()?;
        let names: Vec<String> = all.iter().map(|p| p.name.clone()).collect();
        let found = all.into_iter().find(|p| p.name == name);
        found.ok_or_else(|| {
            let what = format!("fit: unknown \"{name}\"; known are {}", names.join(", "));
            Error::argument(what)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn all_published_limits_have_a_source_a_date_and_a_name_of_their_own() {
        let all = PlatformLimits::all().unwrap();
        assert!(all.len() >= 3);
        let names: BTreeSet<&str> = all.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        for platform in &all {
            assert!(platform.source.starts_with("https://"), "{platform:?}");
            let date: Vec<u32> = platform.seen.split('-').flat_map(str::parse).collect();
            assert!(
                matches!(date[..], [2024..=2100, 1..=12, 1..=31]),
                "{platform:?}"
            );
            assert!(!platform.limits.is_none());
        }
        assert_eq!(
            PlatformLimits::of("mona").unwrap().limits.max_triangles,
            Some(25_000)
        );
        let line = PlatformLimits::of("moon").unwrap_err().to_string();
        assert!(line.contains("vrchat-quest, "), "{line}");
    }

    #[test]
    fn of_two_limits_the_narrower_holds() {
        let wide = OptimizeLimits {
            max_bytes: Some(9),
            max_triangles: Some(3),
            max_textures_px: Some(512),
            max_joints: None,
        };
        let narrow = OptimizeLimits {
            max_bytes: Some(4),
            max_triangles: None,
            max_textures_px: Some(1024),
            max_joints: Some(1),
        };
        let both = OptimizeLimits {
            max_bytes: Some(4),
            max_triangles: Some(3),
            max_textures_px: Some(512),
            max_joints: Some(1),
        };
        assert_eq!(wide.and(narrow), both);
        assert!(OptimizeLimits::default().is_none() && !both.is_none());
    }
}
