//! The smallest of a few Deflate streams.
//!
//! Source: RFC 1950 and 1951. Numbers of few repetitions take fewer bytes by their frequencies alone
//! than by short matches, which Deflate's usual encoders prefer; and parts of different kinds by
//! codes of their own.

use miniz_oxide::deflate::core::{
    CompressionStrategy, CompressorOxide, TDEFLFlush, compress_to_output,
    create_comp_flags_from_zip_params,
};

/// Bytes after which a new block, with a code for the numbers that follow, may be smaller.
const BLOCKS: [usize; 4] = [8192, 12_288, 16_384, usize::MAX];
/// The best of the encoder's levels.
const LEVEL: i32 = 9;
/// A head and checksum of zlib around the stream.
const ZLIB: i32 = 15;

/// The smallest zlib stream of those that are tried.
pub(super) fn smallest(body: &[u8]) -> Vec<u8> {
    let strategies = [CompressionStrategy::Default, CompressionStrategy::Filtered];
    let streams = strategies
        .into_iter()
        .flat_map(|strategy| BLOCKS.map(|block| (strategy, block)))
        .map(|(strategy, block)| stream(body, strategy, block));
    streams.min_by_key(Vec::len).unwrap_or_default()
}

/// One zlib stream, in blocks of a size.
fn stream(body: &[u8], strategy: CompressionStrategy, block: usize) -> Vec<u8> {
    let flags = create_comp_flags_from_zip_params(LEVEL, ZLIB, strategy as i32);
    let mut encoder = CompressorOxide::new(flags);
    let mut out = Vec::new();
    let mut left = body;
    loop {
        let (part, rest) = left.split_at(left.len().min(block));
        let flush = match rest.is_empty() {
            true => TDEFLFlush::Finish,
            false => TDEFLFlush::Sync,
        };
        compress_to_output(&mut encoder, part, flush, |bytes| {
            out.extend_from_slice(bytes);
            true
        });
        left = rest;
        if left.is_empty() {
            return out;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn streams_are_zlib_and_the_smallest_is_kept() {
        // Small numbers of a skewed distribution (splitmix64), in which only short runs repeat.
        let mut state = 0u64;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (mixed ^ (mixed >> 27)).leading_zeros() as u8
        };
        let body: Vec<u8> = (0..40_000).map(|_| next()).collect();
        for body in [&body[..], &[], &[7; 12_288]] {
            let packed = smallest(body);
            let mut found = Vec::new();
            let mut decoder = flate2::read::ZlibDecoder::new(&packed[..]);
            decoder.read_to_end(&mut found).unwrap();
            assert_eq!(found, body);
        }
        let usual = stream(&body, CompressionStrategy::Default, usize::MAX);
        assert!(smallest(&body).len() < usual.len());
    }
}
