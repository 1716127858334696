//! The table that holds a clip as a motion stream.

use super::{MotionTables, TableReader};
use crate::prepared::part::COMPACT;
use articula_core::{Mismatch, Rig, TableHashes};
use articula_formats::{Limits, read_compact_clip};
use articula_stream::StreamLimits;
use articula_stream::abp2::MotionReceiver;

/// Reads the stream of a clip, if all of it is there and was made for the rig.
pub(super) fn read(
    found: &mut MotionTables,
    reader: &mut TableReader<'_>,
    hashes: impl Fn(&TableHashes) -> TableHashes,
    rig: &Rig,
) {
    let decode = |bytes: &[u8], limits: &Limits| {
        let (hashes, stream) = read_compact_clip(bytes, limits)?;
        Ok((hashes, stream.to_vec()))
    };
    let compact = reader.read(COMPACT, decode, |(of_table, stream)| {
        of_table.check(&hashes(of_table))?;
        let received = MotionReceiver::read(stream, rig, &StreamLimits::default());
        match received {
            Ok(received) if received.is_whole() => Ok(()),
            Ok(_) => Err(Mismatch::new("stream", "it ends early")),
            Err(e) => Err(Mismatch::new("stream", e.to_string())),
        }
    });
    found.compact = compact.map(|(_, stream)| stream);
}
