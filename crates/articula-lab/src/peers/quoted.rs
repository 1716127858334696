//! Published times of other evaluators, measured elsewhere on another machine; never run here.
//!
//! Source: `docs/methods/runtime.md` part 1: one 2-core x86-64 machine, one thread, the same
//! character and clip. Compare them with the floor of that machine (168, 182 and 349 ns), not with
//! times measured here.

/// Times of one evaluator, in nanoseconds per character and frame.
pub(crate) struct Quoted {
    pub(crate) who: &'static str,
    /// The work that the time covers.
    pub(crate) work: &'static str,
    /// Number of characters, and the time or range of times.
    pub(crate) times: &'static [(usize, Range)],
}

/// Minimum and maximum; equal where a single time was given.
pub(crate) type Range = (f64, f64);

/// The floor on the machine of the quoted times, 3x4 output stored.
pub(crate) const FLOOR_THERE: [(usize, f64); 3] = [(100, 168.0), (1000, 182.0), (4000, 349.0)];

/// All quoted times.
pub(crate) const QUOTED: &[Quoted] = &[
    Quoted {
        who: "ozz-animation 0.16 (C++)",
        work: "local to model fused with sampling",
        times: &[
            (100, (818.0, 818.0)),
            (1000, (820.0, 1582.0)),
            (4000, (2169.0, 2169.0)),
        ],
    },
    Quoted {
        who: "ACL (C++)",
        work: "decompression to local poses only",
        times: &[(100, (479.0, 479.0)), (1000, (596.0, 596.0))],
    },
    Quoted {
        who: "bevy 0.19",
        work: "animation systems and transforms (first column: 200 characters)",
        times: &[(100, (23e3, 31e3)), (1000, (27e3, 43e3))],
    },
];
