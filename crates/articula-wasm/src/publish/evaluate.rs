//! Evaluation of motion level of detail, as the program `articula lod` does it.

use super::Publisher;
use crate::error::{Fault, Result};
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::Figure;
use articula::build::evaluate::{EvaluationSetup, Method, MethodOptions, SkinPxVariant};
use articula::core::Rig;
use articula::core::loa::LoaExpression;
use articula::evaluate::{DISTANCES_M, EvaluatedClip, MethodRow, NamedMethod, ParameterChoice};
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

/// Most frames of a clip and most distances.
const MAX_FRAMES: usize = 100_000;
const MAX_DISTANCES: usize = 100;

/// Options of `evaluate`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Evaluate {
    clip: Option<String>,
    method: Option<String>,
    loa: Option<String>,
    distances: Vec<f32>,
    calibrate_px: Option<f32>,
    beta: Option<f32>,
}

/// What an evaluation says.
#[derive(Debug, Serialize)]
struct Evaluated {
    clip: String,
    frames: usize,
    rows: Vec<MethodRow>,
}

#[wasm_bindgen]
impl Publisher {
    /// Plays a clip under a method of motion level of detail and measures what it saves and shows at each distance;
    /// returns JSON: `{clip, frames, rows: […]}`, with rows as in `articula lod --json`. `options` is JSON: `{clip?:
    /// string, method?: string, loa?: string, distances?: number[], calibratePx?: number, beta?: number}`; methods are
    /// those of the program, "all" for all of them, `loa` is an expression, which alone decides, and `beta`, 0 to 1, weighs
    /// orientation against angular velocity in the method "thesis".
    pub fn evaluate(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<String, JsValue> {
        let options: Evaluate = read(options.as_deref())?;
        options.check()?;
        let loa = options.loa.as_deref().map(str::parse::<LoaExpression>);
        let loa = loa
            .transpose()
            .map_err(|e| Fault::argument(format!("loa: {e}")))?;
        let mut refused = None;
        let made = run(progress, name, |work| {
            let figure = Figure::new(open_alone(bytes, name)?)?;
            let Some(clip) = figure.clip(options.clip.as_deref())? else {
                refused = Some(Fault::argument(format!("{name}: the file has no clip")));
                return Ok(String::new());
            };
            let methods = match options.methods(&figure.asset.rig, loa.as_ref()) {
                Ok(methods) => methods,
                Err(fault) => {
                    refused = Some(fault);
                    return Ok(String::new());
                }
            };
            let frames = figure.asset.clips[clip].frames();
            if frames > MAX_FRAMES {
                let what = format!("{name}: {frames} frames, at most {MAX_FRAMES} are evaluated");
                refused = Some(Fault::too_large(what));
                return Ok(String::new());
            }
            let scene = EvaluatedClip {
                figure: &figure,
                clip,
                setup: EvaluationSetup::default(),
                options: options.parameters(),
            };
            let tables = scene.tables(&methods, options.distances(), options.tuning(), work)?;
            let evaluated = Evaluated {
                clip: figure.asset.clips[clip].name.clone(),
                frames: figure.asset.clips[clip].at_key_rate().frames(),
                rows: tables.into_iter().flat_map(|table| table.rows).collect(),
            };
            serde_json::to_string(&evaluated).map_err(|e| articula::Error::Write(Box::new(e)))
        })?;
        match refused {
            Some(fault) => Err(fault.into()),
            None => Ok(made),
        }
    }
}

impl Evaluate {
    fn check(&self) -> Result<()> {
        let allowed = |d: &f32| (0.01..=100_000.0).contains(d);
        if self.distances.len() > MAX_DISTANCES || !self.distances.iter().all(allowed) {
            let what = format!("distances: give at most {MAX_DISTANCES}, each of 0.01 to 100000 m");
            return Err(Fault::argument(what));
        }
        weight(self.beta)?;
        match self.calibrate_px {
            Some(px) if !(px > 0.0 && px.is_finite()) => Err(Fault::argument(format!(
                "calibratePx: {px} found, expected pixels above 0"
            ))),
            _ => Ok(()),
        }
    }

    fn parameters(&self) -> MethodOptions {
        let mut options = MethodOptions::default();
        if let Some(beta) = self.beta {
            options.thesis.beta = beta;
        }
        options
    }

    fn distances(&self) -> &[f32] {
        match &self.distances[..] {
            [] => &DISTANCES_M,
            given => given,
        }
    }

    fn tuning(&self) -> ParameterChoice {
        match self.calibrate_px {
            Some(px) => ParameterChoice::Calibrated(px),
            None => ParameterChoice::Usual,
        }
    }

    fn methods(&self, rig: &Rig, loa: Option<&LoaExpression>) -> Result<Vec<NamedMethod>> {
        if let (Some(expression), Some(text)) = (loa, &self.loa) {
            let joints = expression.joints(rig);
            let joints = joints.map_err(|e| Fault::argument(format!("loa: {e}")))?;
            return Ok(vec![NamedMethod::fixed(text, joints)]);
        }
        let one = |method: Method| vec![NamedMethod::from(method)];
        Ok(match self.method.as_deref().unwrap_or("skin-px") {
            "skin-px" => one(Method::SkinPx(SkinPxVariant::Hold)),
            "skin-px-tables" => one(Method::SkinPx(SkinPxVariant::Tables)),
            "thesis" => one(Method::Thesis),
            "ahn" => one(Method::Ahn),
            "pc" => one(Method::PrincipalComponents),
            "skip-hold" => one(Method::SkipHold),
            "skip-lerp" => one(Method::SkipLerp),
            "loa" => vec![NamedMethod::complexity_levels(rig)],
            "all" => NamedMethod::all(rig),
            other => {
                return Err(Fault::argument(format!(
                    "method: \"{other}\"; known are \"skin-px\", \"skin-px-tables\", \"thesis\", \"ahn\", \"pc\", \"skip-hold\", \"skip-lerp\", \"loa\" and \"all\""
                )));
            }
        })
    }
}

/// A weight of 0 to 1, if one is given.
pub(super) fn weight(beta: Option<f32>) -> Result<Option<f32>> {
    match beta {
        Some(beta) if !(0.0..=1.0).contains(&beta) => Err(Fault::argument(format!(
            "beta: {beta} found, expected 0 to 1"
        ))),
        beta => Ok(beta),
    }
}
