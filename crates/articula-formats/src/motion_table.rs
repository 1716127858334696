//! Motion-error tables as bytes: `segs` (keys of every joint) and `posekeys` (whole poses).
//!
//! Source: `docs/methods/motion-lod.md` part 9. Little endian; a header with the hashes of rig,
//! clip and mesh, then ascending frame numbers as variable-length gaps, about one byte per key. The
//! levels of `segs` are nested: the coarsest is stored first and complete, and each finer one adds
//! keys, so a prefix of the levels is usable. The layout is described in
//! `docs/formats/motion-tables.md`.

use crate::{Limits, ReadError};
use articula_core::playback::{ErrorMatrix, ErrorMatrixTable};
use articula_core::{
    ByteReader, Contact, ContactTable, KeyMode, KeyTable, MAX_JOINTS, PoseKeys, TableHashes,
    push_varint,
};

const SEGS: &[u8; 4] = b"ASEG";
const POSE_KEYS: &[u8; 4] = b"APKY";
const CONTACTS: &[u8; 4] = b"ACON";
const ERRORS: &[u8; 4] = b"AERR";
const COMPACT: &[u8; 4] = b"ACLP";
const VERSION: u8 = 1;
/// Upper bound on the number of levels: tolerances double from level to level, so no table needs
/// more.
const MAX_LEVELS: usize = 64;

/// Encodes the keys of every joint at every tolerance level. Coarser levels must be subsets of
/// finer ones, as [`KeyTable::check`] requires; a key that violates this is left out of the coarser
/// level.
pub fn write_key_table(table: &KeyTable) -> Vec<u8> {
    let levels = table.levels();
    let mut out = head(
        SEGS,
        mode_byte(table.mode),
        &table.hashes,
        table.base_metres,
    );
    out.extend(table.rate_hz.to_le_bytes());
    out.extend(table.frames.to_le_bytes());
    push_varint(&mut out, table.keys.len() as u64);
    push_varint(&mut out, levels as u64);
    for joint in &table.keys {
        let mut coarser: &[u32] = &[];
        for level in (0..levels).rev() {
            let keys = joint.get(level).map_or(&[][..], Vec::as_slice);
            let added: Vec<u32> = keys
                .iter()
                .copied()
                .filter(|k| coarser.binary_search(k).is_err())
                .collect();
            gaps(&mut out, &added);
            coarser = keys;
        }
    }
    out
}

/// Decodes the output of [`write_key_table`].
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::Unsupported`] for another version,
/// [`ReadError::LimitExceeded`].
pub fn read_key_table(bytes: &[u8], limits: &Limits) -> Result<KeyTable, ReadError> {
    let mut r = ByteReader::new(bytes);
    let (mode, hashes, base_metres) = head_of(&mut r, SEGS)?;
    let mode = match mode {
        0 => KeyMode::Hold,
        1 => KeyMode::Linear,
        other => {
            return Err(r.bad(format!("key mode {other}, expected 0 or 1")).into());
        }
    };
    let rate_hz = r.positive("a rate")?;
    let frames = r.u32()?;
    Limits::check("byte 36", "frames", u64::from(frames), limits.frames)?;
    let joints = count(&mut r, "joints", MAX_JOINTS)?;
    let levels = count(&mut r, "levels", MAX_LEVELS)?;
    let mut keys = Vec::with_capacity(joints);
    for _ in 0..joints {
        let mut per_level: Vec<Vec<u32>> = Vec::with_capacity(levels);
        for _ in 0..levels {
            let mut merged = per_level.last().cloned().unwrap_or_default();
            merged.extend(gaps_of(&mut r, frames)?);
            merged.sort_unstable();
            if merged.windows(2).any(|w| w[0] == w[1]) {
                return Err(r.bad("a key repeats a key of a coarser level").into());
            }
            per_level.push(merged);
        }
        per_level.reverse();
        keys.push(per_level);
    }
    r.end()?;
    Ok(KeyTable {
        hashes,
        rate_hz,
        frames,
        base_metres,
        mode,
        keys,
    })
}

/// Encodes whole-pose keys.
pub fn write_pose_keys(keys: &PoseKeys) -> Vec<u8> {
    let mut out = head(POSE_KEYS, 0, &keys.hashes, keys.base_metres);
    out.extend(keys.tick_hz.to_le_bytes());
    out.extend(keys.ticks.to_le_bytes());
    push_varint(&mut out, keys.levels.len() as u64);
    for level in &keys.levels {
        // An empty list encodes "evaluate every frame": a level that is kept has a first key.
        gaps(&mut out, level.as_deref().unwrap_or_default());
    }
    out
}

/// Decodes the output of [`write_pose_keys`].
///
/// # Errors
/// As [`read_key_table`].
pub fn read_pose_keys(bytes: &[u8], limits: &Limits) -> Result<PoseKeys, ReadError> {
    let mut r = ByteReader::new(bytes);
    let (_, hashes, base_metres) = head_of(&mut r, POSE_KEYS)?;
    let tick_hz = r.positive("a tick rate")?;
    let ticks = r.u32()?;
    Limits::check("byte 36", "ticks", u64::from(ticks), limits.frames)?;
    let count = count(&mut r, "levels", MAX_LEVELS)?;
    let mut levels = Vec::with_capacity(count);
    for _ in 0..count {
        let keys = gaps_of(&mut r, ticks.saturating_add(1))?;
        levels.push((!keys.is_empty()).then_some(keys));
    }
    r.end()?;
    Ok(PoseKeys {
        hashes,
        tick_hz,
        ticks,
        base_metres,
        levels,
    })
}

/// Encodes a motion stream (ABP-2) of a clip, with the hashes of what it was made of.
pub fn write_compact_clip(hashes: &TableHashes, stream: &[u8]) -> Vec<u8> {
    let mut out = COMPACT.to_vec();
    out.extend([VERSION, 0, 0, 0]);
    put_hashes(&mut out, hashes);
    out.extend(stream);
    out
}

/// Decodes the output of [`write_compact_clip`]: the hashes and the stream, which is not checked.
///
/// # Errors
/// As [`read_key_table`].
pub fn read_compact_clip<'a>(
    bytes: &'a [u8],
    limits: &Limits,
) -> Result<(TableHashes, &'a [u8]), ReadError> {
    Limits::check("byte 0", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut r = ByteReader::new(bytes);
    let (_, hashes) = start_of(&mut r, COMPACT)?;
    Ok((hashes, &bytes[r.at()..]))
}

/// Encodes contacts.
pub fn write_contact_table(table: &ContactTable) -> Vec<u8> {
    let mut out = CONTACTS.to_vec();
    out.extend([VERSION, 0, 0, 0]);
    put_hashes(&mut out, &table.hashes);
    out.extend(table.rate_hz.to_le_bytes());
    out.extend(table.frames.to_le_bytes());
    push_varint(&mut out, table.contacts.len() as u64);
    for contact in &table.contacts {
        push_varint(&mut out, contact.joint as u64);
        push_varint(&mut out, contact.frames.start as u64);
        push_varint(&mut out, contact.frames.len() as u64);
    }
    out
}

/// Decodes the output of [`write_contact_table`].
///
/// # Errors
/// As [`read_key_table`].
pub fn read_contact_table(bytes: &[u8], limits: &Limits) -> Result<ContactTable, ReadError> {
    let mut r = ByteReader::new(bytes);
    let (_, hashes) = start_of(&mut r, CONTACTS)?;
    let rate_hz = r.positive("a rate")?;
    let frames = r.u32()?;
    Limits::check("byte 36", "frames", u64::from(frames), limits.frames)?;
    let found = r.varint()?;
    if found > r.left() as u64 {
        let what = format!("{found} contacts exceed the bytes left");
        return Err(r.bad(what).into());
    }
    let mut contacts = Vec::with_capacity(found as usize);
    for _ in 0..found {
        let joint = count(&mut r, "joints", MAX_JOINTS)?;
        let (start, length) = (r.varint()?, r.varint()?);
        let end = start + length;
        if length == 0 || end > u64::from(frames) {
            let what = format!("frames {start} to {end} of a contact, the clip has {frames}");
            return Err(r.bad(what).into());
        }
        contacts.push(Contact {
            joint,
            frames: start as usize..end as usize,
        });
    }
    r.end()?;
    Ok(ContactTable {
        hashes,
        rate_hz,
        frames,
        contacts,
    })
}

/// Encodes an error matrix; joints whose errors are all 0 take no bytes.
pub fn write_error_matrix(table: &ErrorMatrixTable) -> Vec<u8> {
    let matrix = &table.matrix;
    let mut out = ERRORS.to_vec();
    out.extend([VERSION, 0, 0, 0]);
    put_hashes(&mut out, &table.hashes);
    out.extend(table.rate_hz.to_le_bytes());
    out.extend((matrix.frames() as u32).to_le_bytes());
    push_varint(&mut out, matrix.joints() as u64);
    let moves = |j: &u32| (0..matrix.frames()).any(|f| matrix.frame(f)[*j as usize] != 0.0);
    let joints: Vec<u32> = (0..matrix.joints() as u32).filter(moves).collect();
    gaps(&mut out, &joints);
    for frame in 0..matrix.frames() {
        let errors = matrix.frame(frame);
        joints
            .iter()
            .for_each(|j| out.extend(errors[*j as usize].to_le_bytes()));
    }
    out
}

/// Decodes the output of [`write_error_matrix`].
///
/// # Errors
/// As [`read_key_table`].
pub fn read_error_matrix(bytes: &[u8], limits: &Limits) -> Result<ErrorMatrixTable, ReadError> {
    let mut r = ByteReader::new(bytes);
    let (_, hashes) = start_of(&mut r, ERRORS)?;
    let rate_hz = r.positive("a rate")?;
    let frames = r.u32()? as usize;
    Limits::check("byte 36", "frames", frames as u64, limits.frames)?;
    let joints = count(&mut r, "joints", MAX_JOINTS)?;
    let moving = gaps_of(&mut r, joints as u32)?;
    let size = (frames * joints) as u64;
    Limits::check("byte 40", "errors", size, limits.elements)?;
    let floats = r.slice(frames * moving.len() * 4)?.as_chunks::<4>().0;
    r.end()?;
    let mut values = vec![0.0; frames * joints];
    for (i, bytes) in floats.iter().enumerate() {
        let error = f32::from_le_bytes(*bytes);
        if !(error.is_finite() && error >= 0.0) {
            return Err(r
                .bad(format!("an error of {error}, expected at least 0"))
                .into());
        }
        let (frame, joint) = (i / moving.len(), moving[i % moving.len()] as usize);
        values[frame * joints + joint] = error;
    }
    let matrix = ErrorMatrix::new(joints, values).map_err(|e| r.bad(e.to_string()))?;
    Ok(ErrorMatrixTable {
        hashes,
        rate_hz,
        matrix,
    })
}

fn mode_byte(mode: KeyMode) -> u8 {
    match mode {
        KeyMode::Hold => 0,
        KeyMode::Linear => 1,
    }
}

fn head(magic: &[u8; 4], mode: u8, hashes: &TableHashes, base_metres: f32) -> Vec<u8> {
    let mut out = magic.to_vec();
    out.extend([VERSION, mode, 0, 0]);
    put_hashes(&mut out, hashes);
    out.extend(base_metres.to_le_bytes());
    out
}

fn put_hashes(out: &mut Vec<u8>, hashes: &TableHashes) {
    for hash in [hashes.rig, hashes.clip, hashes.mesh] {
        out.extend(hash.to_le_bytes());
    }
}

/// Writes a count, then the difference of each number to the previous one (the first as it is).
fn gaps(out: &mut Vec<u8>, rising: &[u32]) {
    push_varint(out, rising.len() as u64);
    let mut before = 0;
    for value in rising {
        push_varint(out, u64::from(value - before));
        before = *value;
    }
}

fn head_of(r: &mut ByteReader<'_>, magic: &[u8; 4]) -> Result<(u8, TableHashes, f32), ReadError> {
    let (mode, hashes) = start_of(r, magic)?;
    Ok((mode, hashes, r.positive("a tolerance")?))
}

/// Reads what all tables begin with: magic, version, mode and hashes.
fn start_of(r: &mut ByteReader<'_>, magic: &[u8; 4]) -> Result<(u8, TableHashes), ReadError> {
    let found = r.take::<4>()?;
    if found != *magic {
        let expected = String::from_utf8_lossy(magic);
        return Err(ReadError::malformed(
            "byte 0",
            format!("not a table: it does not begin with \"{expected}\""),
        ));
    }
    let [version, mode, _, _] = r.take::<4>()?;
    if version != VERSION {
        return Err(ReadError::Unsupported {
            at: "byte 4".into(),
            what: format!("version {version} of the table"),
            mend: "rebuild the asset with this version of Articula".into(),
        });
    }
    let hashes = TableHashes {
        rig: r.u64()?,
        clip: r.u64()?,
        mesh: r.u64()?,
    };
    Ok((mode, hashes))
}

/// Reads ascending numbers below `end`. Each takes at least one byte, so the file size bounds their
/// count.
fn gaps_of(r: &mut ByteReader<'_>, end: u32) -> Result<Vec<u32>, ReadError> {
    let count = r.varint()?;
    if count > r.left() as u64 {
        return Err(r.bad(format!("{count} keys exceed the bytes left")).into());
    }
    let mut values = Vec::with_capacity(count as usize);
    let mut before = 0u64;
    for i in 0..count {
        let gap = r.varint()?;
        before += gap;
        if (i > 0 && gap == 0) || before >= u64::from(end) {
            return Err(r
                .bad(format!(
                    "key {before} does not rise or is outside the {end} frames"
                ))
                .into());
        }
        values.push(before as u32);
    }
    Ok(values)
}

/// Reads a count that must not exceed `limit`.
fn count(r: &mut ByteReader<'_>, which: &'static str, limit: usize) -> Result<usize, ReadError> {
    let at = format!("byte {}", r.at());
    let count = r.varint()?;
    Limits::check(&at, which, count, limit as u64)?;
    Ok(count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn nested(frames: u32) -> impl Strategy<Value = Vec<Vec<u32>>> {
        prop::collection::vec(prop::collection::btree_set(0..frames, 0..20), 3).prop_map(|adds| {
            let mut level = std::collections::BTreeSet::new();
            let mut levels: Vec<Vec<u32>> = adds
                .into_iter()
                .map(|add| {
                    level.extend(add);
                    level.iter().copied().collect()
                })
                .collect();
            levels.reverse();
            levels
        })
    }

    fn table() -> impl Strategy<Value = KeyTable> {
        (
            prop::collection::vec(nested(500), 0..6),
            any::<[u64; 3]>(),
            any::<bool>(),
        )
            .prop_map(|(keys, [rig, clip, mesh], hold)| KeyTable {
                hashes: TableHashes { rig, clip, mesh },
                rate_hz: 30.0,
                frames: 500,
                base_metres: 0.0005,
                mode: if hold { KeyMode::Hold } else { KeyMode::Linear },
                keys,
            })
    }

    proptest! {
        #[test]
        fn segs_come_back(table in table()) {
            let bytes = write_key_table(&table);
            prop_assert_eq!(read_key_table(&bytes, &Limits::default()).unwrap(), table);
        }

        #[test]
        fn segs_cut_short_are_errors(table in table()) {
            let bytes = write_key_table(&table);
            for end in 0..bytes.len() {
                prop_assert!(read_key_table(&bytes[..end], &Limits::default()).is_err());
            }
        }

        #[test]
        fn altered_bytes_never_panic(table in table(), at in any::<prop::sample::Index>(), byte in any::<u8>()) {
            let mut bytes = write_key_table(&table);
            let at = at.index(bytes.len());
            bytes[at] = byte;
            if let Ok(read) = read_key_table(&bytes, &Limits::default()) {
                prop_assert!(read.keys.iter().flatten().flatten().all(|k| *k < read.frames));
            }
        }
    }

    #[test]
    fn error_matrices_come_back_without_joints_that_do_not_move() {
        let values = vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.25, 0.0];
        let table = ErrorMatrixTable {
            hashes: TableHashes::default(),
            rate_hz: 25.0,
            matrix: ErrorMatrix::new(3, values).unwrap(),
        };
        let bytes = write_error_matrix(&table);
        let read = |bytes: &[u8]| read_error_matrix(bytes, &Limits::default());
        assert_eq!(read(&bytes).unwrap(), table);
        // Three frames of the two joints that move, and nothing for the first.
        assert_eq!(bytes.len(), 8 + 24 + 8 + 1 + 3 + 3 * 2 * 4);
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err());
        }
        let mut negative = bytes.clone();
        let last = negative.len() - 1;
        negative[last] = 0xbf;
        assert!(read(&negative).is_err());
    }

    #[test]
    fn contacts_come_back_and_lie_within_the_clip() {
        let table = ContactTable {
            hashes: TableHashes {
                rig: 1,
                clip: 2,
                mesh: 3,
            },
            rate_hz: 30.0,
            frames: 40,
            contacts: vec![
                Contact {
                    joint: 7,
                    frames: 0..12,
                },
                Contact {
                    joint: 200,
                    frames: 39..40,
                },
            ],
        };
        let bytes = write_contact_table(&table);
        let read = |bytes: &[u8]| read_contact_table(bytes, &Limits::default());
        assert_eq!(read(&bytes).unwrap(), table);
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err());
        }
        let mut beyond = bytes.clone();
        let last = beyond.len() - 1;
        beyond[last] = 2;
        assert!(read(&beyond).unwrap_err().to_string().contains("39 to 41"));
    }

    #[test]
    fn pose_keys_come_back_and_other_files_are_refused() {
        let keys = PoseKeys {
            hashes: TableHashes {
                rig: 1,
                clip: 2,
                mesh: 3,
            },
            tick_hz: 120.0,
            ticks: 160,
            base_metres: 0.0005,
            levels: vec![None, Some(vec![0, 7, 160]), Some(vec![0, 160])],
        };
        let bytes = write_pose_keys(&keys);
        assert_eq!(read_pose_keys(&bytes, &Limits::default()).unwrap(), keys);
        let of = |bytes: &[u8]| {
            read_pose_keys(bytes, &Limits::default())
                .unwrap_err()
                .to_string()
        };
        assert!(of(b"nothing").contains("byte 0"));
        let mut newer = bytes.clone();
        newer[4] = 2;
        assert!(of(&newer).contains("rebuild the asset"));
        let mut huge = bytes;
        huge[40..44].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(of(&huge).contains("limit"));
    }
}
