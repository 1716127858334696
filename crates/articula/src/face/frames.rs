//! The values of the low-level parameters in the frames of a clip.

use articula_build::face::{FaceFrames, FapValues, add_expression, add_viseme};
use articula_core::fap_table::LOW_FAP_COUNT;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};

/// The low-level values of all frames, and those of their visemes and expressions.
pub(super) fn face_frames(clip: &FapClip) -> FaceFrames {
    let low = |frame: &FapFrame| FapValues(frame.low.map(|v| v as f32));
    FaceFrames {
        low: clip.frames.iter().map(low).collect(),
        high: clip.frames.iter().map(high_level).collect(),
    }
}

/// The low-level values of the viseme and expression of a frame, unless it defines them.
fn high_level(frame: &FapFrame) -> FapValues {
    let mut values = FapValues::default();
    let (viseme, expression) = (frame.viseme, frame.expression);
    if !viseme.defines {
        add_viseme(&mut values, [viseme.select1, viseme.select2], viseme.blend);
    }
    if !expression.defines {
        let select = [expression.select1, expression.select2];
        let intensity = [expression.intensity1, expression.intensity2];
        add_expression(&mut values, select, intensity);
    }
    values
}

/// The values of a frame of a FAP file: whole numbers.
pub(crate) fn rounded(values: &FapValues) -> [i32; LOW_FAP_COUNT] {
    const LARGEST: f32 = 1e6;
    values.0.map(|v| v.clamp(-LARGEST, LARGEST).round() as i32)
}

/// A name as that of a clip in a FAP file, which has no spaces.
pub(crate) fn file_name(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join("_")
}

/// Which parameters move in any frame; FAP 3 at index 0.
pub(super) fn moving(frames: &[FapValues]) -> [bool; LOW_FAP_COUNT] {
    std::array::from_fn(|index| frames.iter().any(|f| f.0[index] != 0.0))
}
