//! Leaving out regions of the body, and levels of regions of the face.

use crate::error::Result;
use crate::item::files::Item;
use crate::item::part::{ItemPart, PartKind, RegionEntry};
use articula_core::face_levels::FaceRegion;
use articula_stream::Unit;
use articula_stream::description::Preferences;

/// Which regions of motions stay; `None` keeps all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Regions {
    /// Of the body: bit `n - 1` is region `n`.
    body: Option<u8>,
    /// Finest level of articulation of each region of the face, in the order of [`FaceRegion`].
    face_loa: Option<[u8; FaceRegion::ALL.len()]>,
}

/// The item without the regions that preferences leave out.
pub(in crate::item) fn applied_regions(item: &Item, preferences: &Preferences) -> Result<Item> {
    Regions::of(preferences).applied(item)
}

impl Regions {
    /// Those that preferences ask for.
    pub(super) fn of(preferences: &Preferences) -> Self {
        Self {
            body: preferences.body_regions,
            face_loa: preferences.face_loa,
        }
    }

    /// The item without what does not stay, which its parts list.
    pub(super) fn applied(&self, item: &Item) -> Result<Item> {
        if *self == Self::default() {
            return Ok(item.clone());
        }
        let mut made = item.without_units(|part, unit| !self.keeps(part, unit))?;
        let before = item.manifest.parts.iter();
        for (part, before) in made.manifest.parts.iter_mut().zip(before) {
            let regions = before.regions.iter();
            let lost = regions.filter(|r| self.cuts(before.kind, r.number));
            let known = part.left_out.clone();
            let is_new = |region: &&RegionEntry| known.iter().all(|k| k.name != region.name);
            let faces = before.face_levels.iter();
            let lost = lost.chain(faces.filter(|level| self.coarsest_face() == Some(level.number)));
            part.left_out.extend(lost.filter(is_new).cloned());
        }
        Ok(made)
    }

    /// The coarsest level of articulation of the face that a region is bounded by.
    fn coarsest_face(&self) -> Option<u32> {
        let coarsest = self.face_loa.and_then(|levels| levels.into_iter().min());
        coarsest.map(u32::from)
    }

    /// Whether a region of a motion loses more than what the finest level of its part does not have.
    fn cuts(&self, kind: PartKind, number: u32) -> bool {
        let finest = self.face_loa.and_then(|levels| levels.into_iter().max());
        match kind {
            PartKind::BodyMotion => !self.allows_body(Some(number)),
            PartKind::FaceMotion => finest.is_some_and(|loa| !self.allows_face(number, loa.into())),
            PartKind::Mesh | PartKind::Texture => false,
        }
    }

    fn keeps(&self, part: &ItemPart, unit: &Unit) -> bool {
        let of_face = match (unit.marker("face_region"), unit.marker("face_loa")) {
            (Some(region), Some(loa)) => self.allows_face(region, loa),
            _ => true,
        };
        match part.kind {
            PartKind::BodyMotion => of_face && self.allows_body(unit.marker("region")),
            PartKind::FaceMotion => {
                // AFP-1 has no other regions than those of the face.
                let plain = match (unit.marker("region"), unit.marker("loa")) {
                    (Some(region), Some(loa)) => self.allows_face(region, loa),
                    _ => true,
                };
                of_face && plain
            }
            PartKind::Mesh | PartKind::Texture => true,
        }
    }

    fn allows_body(&self, region: Option<u32>) -> bool {
        let (Some(mask), Some(number)) = (self.body, region) else {
            return true;
        };
        let bit = number.checked_sub(1).filter(|bit| *bit < u8::BITS);
        bit.is_none_or(|bit| mask >> bit & 1 == 1)
    }

    fn allows_face(&self, region: u32, loa: u32) -> bool {
        let Some(finest) = self.face_loa else {
            return true;
        };
        let finest = finest.get(region as usize);
        finest.is_none_or(|finest| loa <= u32::from(*finest))
    }
}
