//! A clip that named inputs drive: the same container, with blend shapes as components.
//!
//! Source: `docs/methods/vector.md` 8.3: coefficients are plain inputs, so a host can supply them.
//! Limits: offsets are added on the screen, so rotations (of the head, a wide opening jaw) follow
//! straight lines; two inputs at once are the sum of both; triangles have one painting order and
//! are never hidden.

use super::clip::INPUT_ONE;
use super::fit::{Errors, Numbers, whole_steps};
use super::make::{PlayerFile, PlayerOptions, allowed, finish, still_parts};
use crate::low_rank::quantised::{Quantised, QuantisedComponent, short};
use crate::planar::{Drawn, Painting, PlanarClip, PlanarError};

/// A character driven by named inputs, each with the blend shape that it adds.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveSource {
    /// Shapes: frame 0 is the character with all inputs at zero, frame `i + 1` with input `i` at
    /// one.
    pub shapes: PlanarClip,
    /// Names of the inputs, as a host passes them.
    pub inputs: Vec<String>,
    /// Clip that plays while no host gives inputs: for each frame a weight of each input, at the
    /// rate of `shapes`. Empty for none.
    pub weights: Vec<Vec<f32>>,
}

/// Writes a file that a host drives through `articulaInputs`.
///
/// `drawn` and `painting` belong to [`LiveSource::shapes`]; the first order of `painting` is used,
/// for all triangles that are drawn in some shape.
///
/// # Errors
/// Errors of the shapes, or [`PlanarError::Mismatch`]: names or weights of the wrong number,
/// tolerances below a thousandth.
pub(crate) fn live_player(
    source: &LiveSource,
    drawn: &Drawn,
    painting: &Painting,
    options: &PlayerOptions,
) -> Result<PlayerFile, PlanarError> {
    check(source)?;
    let allowed = allowed(options)?;
    let (shapes, shading) = (&source.shapes, options.shading);
    let (mut made, topology) = still_parts(shapes, drawn, painting, shading)?;
    let numbers = Numbers::new(shapes, &topology, shading, allowed.light_weight())?;
    made.light_weight = numbers.light_weight;
    made.frames = source.weights.len().max(1) as u32;
    made.shown = vec![vec![0..made.frames]; made.triangles.len()];
    made.epochs.truncate(1);
    made.inputs.clone_from(&source.inputs);
    // Powers of two: the step is a number that the container holds exactly.
    let (mut low, mut high) = (-12.0f64, 4.0f64);
    let mut best = None;
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        let tried = short(middle.exp2()).and_then(|step| motion(source, &numbers, step));
        match tried.filter(|m| errors(&numbers, m).holds(&allowed)) {
            Some(motion) => (best, low) = (Some(motion), middle),
            None => high = middle,
        }
    }
    made.motion = best.ok_or_else(|| {
        mismatch(
            "tolerances",
            "too small for positions this far apart; choose larger ones".to_owned(),
        )
    })?;
    let found = errors(&numbers, &made.motion);
    finish(&made, &found, options.output)
}

fn mismatch(at: &'static str, what: String) -> PlanarError {
    PlanarError::Mismatch { at, what }
}

fn check(source: &LiveSource) -> Result<(), PlanarError> {
    let inputs = source.inputs.len();
    if inputs == 0 || source.shapes.frames.len() != inputs + 1 {
        let shapes = source.shapes.frames.len();
        let what = format!(
            "{inputs} names and {shapes} shapes; expected at least one name, and one shape more \
             than names"
        );
        return Err(mismatch("inputs", what));
    }
    for (f, weights) in source.weights.iter().enumerate() {
        let sound = weights.iter().all(|w| w.abs() <= 1000.0);
        if weights.len() != inputs || !sound {
            let what = format!("frame {f} must hold {inputs} weights between -1000 and 1000");
            return Err(mismatch("weights", what));
        }
    }
    Ok(())
}

/// Quantised shapes, with the weights of the clip as coefficients.
fn motion(source: &LiveSource, numbers: &Numbers, step: f64) -> Option<Quantised> {
    let neutral = numbers.table.row(0);
    let mean = whole_steps(neutral.iter().copied(), step)?;
    let mut components = Vec::new();
    for input in 0..source.inputs.len() {
        let shape = numbers.table.row(input + 1).iter();
        let offsets = shape.zip(neutral).map(|(a, b)| a - b);
        let weights = source.weights.iter().map(|w| f64::from(w[input]));
        let mut coefficients = whole_steps(weights, 1.0 / INPUT_ONE)?;
        coefficients.resize(source.weights.len().max(1), 0);
        components.push(QuantisedComponent {
            scale: step / INPUT_ONE,
            basis: whole_steps(offsets, step)?,
            coefficients,
        });
    }
    Some(Quantised {
        step,
        mean,
        components,
    })
}

/// Worst errors of a single shape.
fn errors(numbers: &Numbers, motion: &Quantised) -> Errors {
    let alone = |input: Option<usize>| {
        let mut row = motion.clone();
        for (i, component) in row.components.iter_mut().enumerate() {
            let weight = if Some(i) == input { INPUT_ONE } else { 0.0 };
            component.coefficients = vec![weight as i32];
        }
        row.row(0.0)
    };
    let inputs = 0..motion.components.len();
    let rows = std::iter::once(None).chain(inputs.map(Some)).enumerate();
    rows.map(|(shape, input)| numbers.errors_of_row(shape, &alone(input)))
        .reduce(|a, b| a.max(&b))
        .unwrap_or(Errors {
            position_px: 0.0,
            light_levels: 0.0,
        })
}
