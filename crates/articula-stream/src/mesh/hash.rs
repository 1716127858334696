//! Hashes that detect damaged or misplaced chunks; they are not signatures.

/// The first 8 bytes of BLAKE3 over the level, the object's record and the coded bytes.
pub(super) type Hash = [u8; 8];

/// Hash of a chunk; `level` is its number in the whole character. A level that is coded alone has
/// another hash than its refinement.
pub(super) fn hash_of(level: usize, is_alone: bool, record: &[u8], chunk: &[u8]) -> Hash {
    let number = 2 * level + usize::from(is_alone);
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(number as u32).to_le_bytes());
    hasher.update(&(record.len() as u32).to_le_bytes());
    hasher.update(record);
    hasher.update(chunk);
    let all = hasher.finalize();
    let mut first = Hash::default();
    first.copy_from_slice(&all.as_bytes()[..8]);
    first
}
