//! Motions as streams that can be cut, with the documents by which they are.

use super::Publisher;
use super::packaged::PackagedFile;
use crate::error::{Fault, Result};
use crate::long_options::read;
use crate::opening::{open_alone, open_options};
use crate::progress::{ProgressCallback, run};
use articula::clip_streams::unit_tree;
use articula::convert::{AbpProfile, AfpProfile, ConvertOptions, convert, write_faps};
use articula::item::{AQOS, AdaptOptions, PackageOptions, PartKind, aqos, package};
use articula::stream::StreamLimits;
use articula::stream::abp1::Abp1Options;
use articula::stream::abp2::{Grouping, MotionOptions};
use articula::stream::afp1::Afp1Options;
use articula::stream::afp2::Afp2Options;
use articula::stream::description::{Context, GbsdOptions, write_gbsd};
use articula::{CharacterFile, Data, DataFormat, Executor, Format, open_data};
use serde::Deserialize;
use wasm_bindgen::prelude::*;

/// Files with their names.
type Files = Vec<(String, Vec<u8>)>;

#[wasm_bindgen]
impl Publisher {
    /// Encodes a clip of a character as a stream, and describes it: the files are the stream (.abp), its description
    /// (.gbsd.xml) and, with a tolerance, "aqos.xml", the table of what is sent at which rate of the character with this
    /// clip. `options` is JSON: `{clip?: string}` with the quantiser of ABP-1, `quantizer: number` (1 to 31), `power?:
    /// number` (0 to 7) and `interpolated?: number` (0 to 31), or the tolerance of ABP-2, `toleranceMm?: number`,
    /// `tiers?: number` (1 to 8) and `groupBy?: "loa" | "region" | "joint"`; without a clip the first.
    pub fn encode(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> std::result::Result<Vec<PackagedFile>, JsValue> {
        let options: Encode = read(options.as_deref())?;
        options.check()?;
        let files = run(progress, name, |work| {
            let opened = open_alone(bytes, name)?;
            match options.quantizer {
                Some(quantizer) => options.quantised(opened, quantizer, work),
                None => options.layered(opened, work),
            }
        })?;
        let files = files.ok_or_else(|| no_motion(name))?;
        Ok(files.into_iter().map(PackagedFile::new).collect())
    }

    /// Encodes facial animation parameters (.fap, .afp, .fba) as a stream (.afp), and describes it (.gbsd.xml). `options`
    /// is JSON: the quantiser of AFP-1, `quantizer: number` (1 to 31), or the tolerance of AFP-2, `toleranceMm?: number`
    /// and `tiers?: number` (1 to 8).
    #[wasm_bindgen(js_name = encodeFace)]
    pub fn encode_face(
        motion: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> std::result::Result<Vec<PackagedFile>, JsValue> {
        let options: Encode = read(options.as_deref())?;
        options.check()?;
        let format = DataFormat::from_name(name).filter(|format| format.has_faps());
        let Some(format) = format else {
            let what = "facial animation parameters are .fap, .afp and .fba files";
            return Err(Fault::argument(format!("{name}: {what}")).into());
        };
        let files = run(progress, name, |_| {
            let read = open_data(motion, name, format, &open_options())?;
            let Data::Fap(clip) = &read.data else {
                return Ok(None);
            };
            let stream = write_faps(clip, DataFormat::Afp, &options.of_face())?.bytes;
            described(&stem(name), "afp", stream).map(Some)
        })?;
        let files = files.ok_or_else(|| no_motion(name))?;
        Ok(files.into_iter().map(PackagedFile::new).collect())
    }
}

/// Options of `encode` and `encodeFace`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Encode {
    clip: Option<String>,
    quantizer: Option<u8>,
    power: u8,
    interpolated: u8,
    tolerance_mm: Option<f64>,
    tiers: Option<usize>,
    group_by: GroupBy,
}

/// What joints have in common that are cut together.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum GroupBy {
    Loa,
    #[default]
    Region,
    Joint,
}

impl Encode {
    fn check(&self) -> Result<()> {
        let within = |what: &str, value: f64, least: f64, most: f64| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            let what = format!("options: {what} must be {least} to {most}, found {value}");
            Err(Fault::argument(what))
        };
        within("quantizer", self.quantizer.unwrap_or(1).into(), 1.0, 31.0)?;
        within("power", self.power.into(), 0.0, 7.0)?;
        within("interpolated", self.interpolated.into(), 0.0, 31.0)?;
        within("toleranceMm", self.tolerance_mm.unwrap_or(1.0), 0.001, 65.0)?;
        within("tiers", self.tiers.unwrap_or(1) as f64, 1.0, 8.0)
    }

    /// A stream of bones, whose values have steps.
    fn quantised(
        &self,
        opened: CharacterFile,
        quantizer: u8,
        work: &Executor<'_>,
    ) -> articula::Result<Option<Files>> {
        let options = ConvertOptions {
            clip: self.clip.clone(),
            abp: Some(AbpProfile::Abp1(Abp1Options {
                quantizer,
                power: self.power,
                interpolated: self.interpolated,
                ..Abp1Options::default()
            })),
            ..ConvertOptions::default()
        };
        let made = convert(opened, Format::Abp, &options, work)?;
        let name = made.clips.first().map_or("clip", String::as_str);
        described(&plain(name), "abp", made.written.bytes).map(Some)
    }

    /// A stream of layers within errors, and the table of what is sent of them.
    fn layered(
        &self,
        opened: CharacterFile,
        work: &Executor<'_>,
    ) -> articula::Result<Option<Files>> {
        let first = opened.character().clips.first();
        let clip = self.clip.clone().or_else(|| first.map(|c| c.name.clone()));
        let usual = PackageOptions::default();
        let options = PackageOptions {
            mesh_levels: 1,
            clips: clip.into_iter().collect(),
            motion: self.of_motion(&usual.motion),
            flat: false,
            ..usual
        };
        let item = package(opened, &options, work)?;
        let mut parts = item.manifest.parts.iter();
        let motion = parts.find(|part| part.kind == PartKind::BodyMotion);
        let Some(file) = motion.and_then(|part| part.file.as_deref()) else {
            return Ok(None);
        };
        let stream = item.file(file).unwrap_or_default();
        let table = aqos(&item, &Context::default(), &AdaptOptions::default())?;
        let name = file.rsplit('/').next().unwrap_or(file);
        let mut files = described(&stem(name), "abp", stream.to_vec())?;
        files.push((AQOS.to_owned(), table.write().into_bytes()));
        Ok(Some(files))
    }

    fn of_motion(&self, usual: &MotionOptions) -> MotionOptions {
        MotionOptions {
            tolerance_metres: self.tolerance_metres().unwrap_or(usual.tolerance_metres),
            tiers: self.tiers.unwrap_or(usual.tiers),
            grouping: match self.group_by {
                GroupBy::Loa => Grouping::Loa,
                GroupBy::Region => Grouping::LoaRegion,
                GroupBy::Joint => Grouping::Joint,
            },
            ..usual.clone()
        }
    }

    fn of_face(&self) -> AfpProfile {
        if let Some(quantizer) = self.quantizer {
            return AfpProfile::Afp1(Afp1Options {
                quantizer,
                ..Afp1Options::default()
            });
        }
        let usual = Afp2Options::default();
        AfpProfile::Afp2(Afp2Options {
            tolerance_metres: self.tolerance_metres().unwrap_or(usual.tolerance_metres),
            tiers: self.tiers.unwrap_or(usual.tiers),
            ..usual
        })
    }

    fn tolerance_metres(&self) -> Option<f64> {
        self.tolerance_mm.map(|mm| 1e-3 * mm)
    }
}

/// A stream under a name, and its description.
fn described(stem: &str, extension: &str, stream: Vec<u8>) -> articula::Result<Files> {
    let name = format!("{stem}.{extension}");
    let options = GbsdOptions {
        bitstream: Some(name.clone()),
    };
    let description = write_gbsd(&unit_tree(&stream, &StreamLimits::default())?, &options)?;
    let of = description_of(&name);
    Ok(vec![(name, stream), (of, description.into_bytes())])
}

fn description_of(stream: &str) -> String {
    format!("{}.gbsd.xml", stem(stream))
}

/// The name of a file without its extension.
fn stem(file: &str) -> String {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    plain(stem)
}

/// A name of the characters that items have in theirs.
fn plain(name: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let characters = name.chars().map(|c| if is_plain(c) { c } else { '_' });
    characters.collect()
}

fn no_motion(name: &str) -> Fault {
    Fault::argument(format!("{name}: there is no motion to encode"))
}
