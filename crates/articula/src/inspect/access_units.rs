//! Access units of a stream of a motion: what a cut by level or region leaves out.

use crate::clip_streams::{StreamKind, region_name};
use crate::error::{Context, Error, Result};
use articula_stream::{StreamLimits, Unit, abp1, afp1};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Access units of a stream of bones or of facial animation parameters.
#[derive(Debug, Serialize)]
pub struct AccessUnitsInspection {
    /// Name of the profile.
    pub profile: &'static str,
    /// Number of access units.
    pub access_units: usize,
    /// Size of the file without what any level or region has: heads, lengths, codes and padding, in
    /// bytes.
    pub bytes_common: f64,
    /// What each level of articulation adds, coarsest first.
    pub loa: Vec<StreamShare>,
    /// What each region has.
    pub regions: Vec<StreamShare>,
}

/// A share of a stream.
#[derive(Debug, Serialize)]
pub struct StreamShare {
    /// The level of articulation, or the name of the region.
    pub name: String,
    /// Number of bones or parameters.
    pub items: usize,
    /// Size in bytes, in whole bits.
    pub bytes: f64,
}

/// Lists the access units of a stream and checks the map by which it is cut; `file` identifies the
/// file in errors.
///
/// # Errors
/// An [`Error`] that names the file and the position in it, or says that the bytes are no such
/// stream.
pub fn inspect_access_units(
    bytes: &[u8],
    file: &str,
    limits: &StreamLimits,
) -> Result<AccessUnitsInspection> {
    let (profile, map, item) = match StreamKind::of(bytes) {
        Some(StreamKind::Abp1) => ("ABP-1", abp1::unit(bytes, limits), "joint"),
        Some(StreamKind::Afp1) => ("AFP-1", afp1::unit(bytes, limits), "parameter"),
        Some(StreamKind::Abp2 | StreamKind::Afp2 | StreamKind::Fba) | None => {
            let what = "neither a stream of bones nor one of facial animation parameters";
            return Err(Error::unsuited(what)).context(file);
        }
    };
    let map = map.context(file)?;
    map.check().context("map")?;
    map.check_values(bytes).context("map")?;
    let (loa, regions) = (shares(&map, "loa", item), shares(&map, "region", item));
    let of_items: f64 = loa.values().map(|(_, bits)| *bits as f64 / 8.0).sum();
    let row = |name: String, (items, bits): &(BTreeSet<u32>, u64)| StreamShare {
        name,
        items: items.len(),
        bytes: *bits as f64 / 8.0,
    };
    Ok(AccessUnitsInspection {
        profile,
        access_units: map.children.len() - 1,
        bytes_common: bytes.len() as f64 - of_items,
        regions: regions
            .iter()
            .map(|(number, share)| row(region_name(item != "joint", *number), share))
            .collect(),
        loa: loa
            .iter()
            .map(|(level, share)| row(level.to_string(), share))
            .collect(),
    })
}

/// For each value of a marker, the numbers of the items that have it, and the bits of their units.
fn shares(map: &Unit, scheme: &str, item: &str) -> BTreeMap<u32, (BTreeSet<u32>, u64)> {
    let mut shares = BTreeMap::new();
    map.visit(&mut |unit| {
        if let (Some(value), Some(number)) = (unit.marker(scheme), unit.marker(item)) {
            let share: &mut (BTreeSet<u32>, u64) = shares.entry(value).or_default();
            share.0.insert(number);
            share.1 += unit.bits.end - unit.bits.start;
        }
    });
    shares
}
