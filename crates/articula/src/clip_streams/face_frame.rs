//! Frames and rates of facial animation parameters, as files and streams have them.

use crate::error::{Error, Result};
use articula_formats::mpeg4::fap::{FapClip, FapExpression, FapFrame, Viseme};
use articula_stream::{FaceFrame, FrameRate};

/// The rate of a clip in a stream of this name.
pub(super) fn frame_rate(clip: &FapClip, stream: &str) -> Result<FrameRate> {
    let hz = clip.rate_hz;
    FrameRate::nearest(f64::from(hz)).ok_or_else(|| {
        Error::unsuited(format!(
            "{hz} frames per second; {stream} holds 1/16 to 255"
        ))
    })
}

/// The values of a frame.
pub(super) fn plain(frame: &FapFrame) -> FaceFrame {
    let (viseme, expression) = (&frame.viseme, &frame.expression);
    FaceFrame {
        viseme: [
            viseme.select1,
            viseme.select2,
            viseme.blend,
            u8::from(viseme.defines),
        ],
        expression: [
            expression.select1,
            expression.intensity1,
            expression.select2,
            expression.intensity2,
            u8::from(expression.init_face),
            u8::from(expression.defines),
        ],
        low: frame.low,
    }
}

/// A frame of these values.
pub(super) fn fap_frame(frame: &FaceFrame, number: u32) -> FapFrame {
    let [select1, select2, blend, defines] = frame.viseme;
    let viseme = Viseme {
        select1,
        select2,
        blend,
        defines: defines == 1,
    };
    let [select1, intensity1, select2, intensity2, init_face, defines] = frame.expression;
    FapFrame {
        number,
        viseme,
        expression: FapExpression {
            select1,
            intensity1,
            select2,
            intensity2,
            init_face: init_face == 1,
            defines: defines == 1,
        },
        low: frame.low,
    }
}
