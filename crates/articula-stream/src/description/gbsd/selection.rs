//! What an adaptation keeps of a stream, by the markers of its units.

use crate::unit::{Marker, Unit};
use articula_core::Mismatch;

/// Greatest level of articulation of a body.
const MOST_LOA: u32 = 5;

/// What is kept of a stream; `None` keeps everything. A unit is dropped, with its parts, if one of
/// its markers is not allowed; units without the marker stay.
///
/// The same values steer the exported [stylesheet](super::stylesheet()), under other names.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    /// Level of articulation of the body, 0 (coarsest) to 5: marker `loa` up to it.
    pub body_loa: Option<u32>,
    /// Regions of the body, bit `r - 1` for region `r`: marker `region` of bones and motions.
    pub body_regions: Option<u8>,
    /// Joints: marker `joint`.
    pub joints: Option<Vec<u32>>,
    /// Tier, 0 is the finest: marker `tier` from it on.
    pub tier: Option<u32>,
    /// Mesh level, 0 is the finest: marker `level` from it on.
    pub mesh_level: Option<u32>,
    /// Finest levels of regions of a mesh, as region and level, on top of `mesh_level`: markers
    /// `region` and `level`. Regions that are not listed are kept.
    pub mesh_levels: Vec<(u32, u32)>,
    /// Level of articulation of each region of the face, 0 (very low) to 3 (high): markers
    /// `face_loa` with `face_region`, or `loa` with `region` of a unit with `parameter`.
    pub face_levels: Option<[u8; 8]>,
    /// Regions of the face, the groups of its parameters, bit `r` for region `r`.
    pub face_regions: Option<u8>,
    /// Numbers of face parameters: marker `parameter`.
    pub parameters: Option<Vec<u32>>,
}

impl Selection {
    /// Up to a level of articulation of the body.
    pub fn of_loa(loa: u32) -> Self {
        Self {
            body_loa: Some(loa),
            ..Self::default()
        }
    }

    /// Checks that levels exist.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the level, and those that exist.
    pub fn check(&self) -> Result<(), Mismatch> {
        let out_of_range = |at: &str, found: u32, most: u32| {
            let what = format!("level out of range: {found}, expected 0 to {most}");
            Err(Mismatch::new(at, what))
        };
        if let Some(loa) = self.body_loa.filter(|loa| *loa > MOST_LOA) {
            return out_of_range("body_loa", loa, MOST_LOA);
        }
        if let Some(level) = self.face_levels.into_iter().flatten().find(|l| *l > 3) {
            return out_of_range("face_levels", u32::from(level), 3);
        }
        Ok(())
    }

    /// Whether a unit of a map stays, seen by itself; for [`crate::cut()`].
    pub fn keeps(&self, unit: &Unit) -> bool {
        self.keeps_markers(&unit.markers)
    }

    pub(super) fn keeps_markers(&self, markers: &[Marker]) -> bool {
        if markers.is_empty() {
            return true;
        }
        let of = |scheme: &str| {
            let found = markers.iter().find(|marker| marker.scheme == scheme);
            found.map(|marker| marker.value)
        };
        let at_most = |value: Option<u32>, most: Option<u32>| match (value, most) {
            (Some(value), Some(most)) => value <= most,
            _ => true,
        };
        let among = |value: Option<u32>, list: &Option<Vec<u32>>| match (value, list) {
            (Some(value), Some(list)) => list.contains(&value),
            _ => true,
        };
        let parameter = of("parameter");
        let (level, loa, region) = (of("level"), of("loa"), of("region"));
        // The region of a mesh has another numbering.
        let body = if parameter.is_some() {
            (None, None)
        } else {
            (loa, region.filter(|_| level.is_none()))
        };
        let face = if parameter.is_some() {
            (loa, region)
        } else {
            (of("face_loa"), of("face_region"))
        };
        at_most(body.0, self.body_loa)
            && in_mask(
                body.1.map(|region| region.wrapping_sub(1)),
                self.body_regions,
            )
            && at_most(self.tier, of("tier"))
            && at_most(self.mesh_level, level)
            && at_most(self.level_of_mesh_region(level.and(region)), level)
            && among(of("joint"), &self.joints)
            && among(parameter, &self.parameters)
            && in_mask(face.1, self.face_regions)
            && self.keeps_face(face)
    }

    fn level_of_mesh_region(&self, region: Option<u32>) -> Option<u32> {
        let mut listed = self.mesh_levels.iter();
        listed.find(|(r, _)| Some(*r) == region).map(|(_, l)| *l)
    }

    fn keeps_face(&self, (loa, region): (Option<u32>, Option<u32>)) -> bool {
        let (Some(levels), Some(loa), Some(region)) = (self.face_levels, loa, region) else {
            return true;
        };
        let level = levels.get(region as usize);
        level.is_some_and(|level| loa <= u32::from(*level))
    }

    /// The parameters of the [stylesheet](super::stylesheet()) that keep the same; those that are
    /// left out keep everything.
    pub fn parameters(&self) -> Vec<(&'static str, String)> {
        let list = |values: &Vec<u32>| {
            let words: Vec<String> = values.iter().map(u32::to_string).collect();
            // A list of none is not the same as no list.
            if words.is_empty() {
                "none".into()
            } else {
                words.join(" ")
            }
        };
        let pairs = |pairs: &[(u32, u32)]| {
            let words: Vec<String> = pairs.iter().map(|(r, l)| format!("{r}:{l}")).collect();
            words.join(" ")
        };
        let digits = |levels: [u8; 8]| levels.iter().map(u8::to_string).collect::<String>();
        let all = [
            ("nLayersOut", self.body_loa.map(|loa| loa.to_string())),
            ("regionMask", self.body_regions.map(|mask| mask.to_string())),
            ("joints", self.joints.as_ref().map(list)),
            ("tierOut", self.tier.map(|tier| tier.to_string())),
            (
                "meshLevelOut",
                self.mesh_level.map(|level| level.to_string()),
            ),
            (
                "meshLevels",
                (!self.mesh_levels.is_empty()).then(|| pairs(&self.mesh_levels)),
            ),
            ("faceLevels", self.face_levels.map(digits)),
            (
                "faceRegionMask",
                self.face_regions.map(|mask| mask.to_string()),
            ),
            ("fapsOut", self.parameters.as_ref().map(list)),
        ];
        let told = all
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)));
        told.collect()
    }

    /// Sets what a parameter of the stylesheet says, by its name: the inverse of
    /// [`Selection::parameters`]. An empty value keeps everything.
    ///
    /// # Errors
    /// A [`Mismatch`] for a name that is no such parameter, and a value that it cannot have.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Mismatch> {
        let value = value.trim();
        let wrong =
            |expected: &str| Mismatch::new(name, format!("found \"{value}\", expected {expected}"));
        let number = || match value {
            "" => Ok(None),
            _ => value
                .parse::<u32>()
                .map(Some)
                .map_err(|_| wrong("a whole number")),
        };
        let mask = || match value {
            "" => Ok(None),
            _ => value.parse::<u8>().map(Some).map_err(|_| wrong("0 to 255")),
        };
        let list = || match value {
            "" => Ok(None),
            "none" => Ok(Some(Vec::new())),
            _ => {
                let words = value.split_ascii_whitespace().map(str::parse);
                let numbers: Result<Vec<u32>, _> = words.collect();
                numbers.map(Some).map_err(|_| wrong("numbers, or none"))
            }
        };
        match name {
            "nLayersOut" => self.body_loa = number()?,
            "regionMask" => self.body_regions = mask()?,
            "joints" => self.joints = list()?,
            "tierOut" => self.tier = number()?,
            "meshLevelOut" => self.mesh_level = number()?,
            "meshLevels" => {
                let pair = |word: &str| {
                    let (region, level) = word.split_once(':')?;
                    Some((region.parse().ok()?, level.parse().ok()?))
                };
                let pairs: Option<Vec<_>> = value.split_ascii_whitespace().map(pair).collect();
                self.mesh_levels = pairs.ok_or_else(|| wrong("pairs such as 0:2 1:3"))?;
            }
            "faceRegionMask" => self.face_regions = mask()?,
            "fapsOut" => self.parameters = list()?,
            "faceLevels" => {
                let digits: Vec<u8> = value.bytes().map(|b| b.wrapping_sub(b'0')).collect();
                self.face_levels = match digits.try_into() {
                    Ok(levels) => Some(levels),
                    Err(_) if value.is_empty() => None,
                    Err(_) => return Err(wrong("eight digits, 0 to 3")),
                };
            }
            _ => {
                let known: Vec<&str> = PARAMETERS.to_vec();
                let what = format!("is no parameter, expected one of {}", known.join(", "));
                return Err(Mismatch::new(name, what));
            }
        }
        self.check()
    }
}

/// Names of the parameters of the stylesheet.
const PARAMETERS: [&str; 9] = [
    "nLayersOut",
    "regionMask",
    "joints",
    "tierOut",
    "meshLevelOut",
    "meshLevels",
    "faceLevels",
    "faceRegionMask",
    "fapsOut",
];

fn in_mask(bit: Option<u32>, mask: Option<u8>) -> bool {
    match (bit, mask) {
        (Some(bit), Some(mask)) => bit < 8 && mask >> bit & 1 == 1,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(markers: &[(&'static str, u32)]) -> Unit {
        markers
            .iter()
            .fold(Unit::of_bytes("", 0..0), |unit, (scheme, value)| {
                unit.marked(*scheme, *value)
            })
    }

    #[test]
    fn bones_by_level_region_and_joint() {
        let bone = unit(&[("loa", 2), ("region", 3), ("joint", 7)]);
        let keeps = |selection: Selection| selection.keeps(&bone);
        assert!(keeps(Selection::of_loa(2)) && !keeps(Selection::of_loa(1)));
        let regions = |mask| Selection {
            body_regions: Some(mask),
            ..Selection::default()
        };
        assert!(keeps(regions(0b100)) && !keeps(regions(0b1111_1011)));
        let joints = |list| Selection {
            joints: Some(list),
            ..Selection::default()
        };
        assert!(keeps(joints(vec![7])) && !keeps(joints(vec![])));
        let face = Selection {
            face_levels: Some([0; 8]),
            face_regions: Some(0),
            ..Selection::default()
        };
        assert!(keeps(face), "a bone is no part of the face");
        assert!(!regions(0xff).keeps(&unit(&[("region", 9)])));
        assert!(!regions(0xff).keeps(&unit(&[("region", 0)])));
    }

    #[test]
    fn faces_by_level_and_region() {
        let levels = Selection {
            face_levels: Some([3, 1, 0, 0, 0, 0, 0, 0]),
            ..Selection::default()
        };
        let of = |loa, region| unit(&[("loa", loa), ("region", region), ("parameter", 3)]);
        assert!(levels.keeps(&of(1, 1)) && !levels.keeps(&of(2, 1)) && !levels.keeps(&of(0, 8)));
        let group = |loa, region| unit(&[("face_loa", loa), ("face_region", region)]);
        assert!(levels.keeps(&group(3, 0)) && !levels.keeps(&group(1, 2)));
        assert!(levels.keeps(&unit(&[("parameter", 3)])));
        assert!(
            Selection::of_loa(0).keeps(&of(3, 1)),
            "no level of the body"
        );
    }

    #[test]
    fn levels_of_meshes_and_tiers_count_from_the_finest() {
        let chunk = unit(&[("level", 1), ("region", 2)]);
        let level = |level| Selection {
            mesh_level: Some(level),
            ..Selection::default()
        };
        assert!(level(1).keeps(&chunk) && !level(2).keeps(&chunk));
        let none = Selection {
            body_regions: Some(0),
            ..Selection::default()
        };
        assert!(none.keeps(&chunk), "no region of the body");
        let tier = |tier| Selection {
            tier: Some(tier),
            ..Selection::default()
        };
        assert!(tier(1).keeps(&unit(&[("tier", 1)])) && !tier(1).keeps(&unit(&[("tier", 0)])));
    }

    #[test]
    fn parameters_come_back() {
        let all = Selection {
            body_loa: Some(2),
            body_regions: Some(127),
            joints: Some(vec![]),
            tier: Some(1),
            mesh_levels: vec![(0, 2), (4, 1)],
            mesh_level: Some(3),
            face_levels: Some([3, 2, 1, 0, 0, 1, 2, 3]),
            face_regions: Some(255),
            parameters: Some(vec![3, 68]),
        };
        assert_eq!(
            all.parameters().iter().map(|p| p.0).collect::<Vec<_>>(),
            PARAMETERS
        );
        let mut found = Selection::default();
        for (name, value) in all.parameters() {
            found.set(name, &value).unwrap();
        }
        assert_eq!(found, all);
        for name in PARAMETERS {
            found.set(name, "").unwrap();
            assert!(found.set(name, "x").is_err());
        }
        assert_eq!(found, Selection::default());
        assert!(found.set("levels", "1").is_err());
        assert!(found.set("faceLevels", "33333334").is_err());
    }

    #[test]
    fn levels_that_do_not_exist_are_refused() {
        assert!(Selection::of_loa(5).check().is_ok());
        let said = Selection::of_loa(6).check().unwrap_err().to_string();
        assert_eq!(said, "body_loa: level out of range: 6, expected 0 to 5");
    }
}
