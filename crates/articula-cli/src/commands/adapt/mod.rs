//! `articula adapt ITEM/ OUT/`: decides what of a digital item suits a context, and cuts it to that.

mod context;
mod report;
mod trace;
mod xsltproc;

use crate::console::Console;
use crate::{fault, files};
use anyhow::Context as _;
use articula::formats::Limits;
use articula::item::{
    AdaptOptions, AdaptedItem, Item, ItemCut, MANIFEST, adapt, adapt_by_description, decide,
    decide_by_table, documents,
};
use articula::stream::DescriptionLimits;
use articula::stream::description::{Aqos, Context};
use clap::{Args, ValueEnum};
use context::{ContextArgs, FinestParts};
use report::{AdaptReport, DECISION, Decided};
use std::path::{Path, PathBuf};
use std::time::Instant;
use trace::TraceArgs;

/// What cuts the streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// Unit indices and bytes alone
    Native,
    /// Descriptions (gBSD), transformed by the stylesheet in the installed xsltproc
    Xslt,
}

/// Arguments of `adapt`.
#[derive(Debug, Args)]
pub(crate) struct AdaptArgs {
    /// Folder of a digital item, made by package or adapt
    #[arg(value_name = "ITEM")]
    item: PathBuf,
    /// Folder of what is sent: an item, or a form in 2D; without it the decision is only printed
    #[arg(value_name = "OUT")]
    out: Option<PathBuf>,
    /// Time to transfer the item, in seconds; with the bandwidth it gives the bytes
    #[arg(long, value_name = "SECS", default_value_t = 2.0, value_parser = context::above_0)]
    wait_secs: f64,
    /// Most bytes to send
    #[arg(long, value_name = "BYTES")]
    max_bytes: Option<u64>,
    /// Finest that is sent: tier=K of motions, face-loa=K (0, very low, to 3, high), mesh-level=L, where
    /// 0 is the finest tier and mesh level; and texture=PX, the longer side of a texture
    #[arg(long, value_name = "KEY=N,…", value_parser = context::limits)]
    limit: Option<FinestParts>,
    /// Decide by a table (AQoS) in place of the joint choice: levels, region mask and tier by the
    /// bandwidth
    #[arg(long, value_name = "F.xml", conflicts_with = "max_bytes")]
    aqos: Option<PathBuf>,
    /// Name of a clip to send (repeatable) [default: all]
    #[arg(long, value_name = "NAME")]
    clip: Vec<String>,
    /// What cuts the streams; both give the same bytes
    #[arg(long, value_enum, default_value_t = Engine::Native)]
    engine: Engine,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    context: ContextArgs,
}

/// Decides, cuts, writes and reports.
pub(crate) fn run(args: &AdaptArgs, console: &Console) -> anyhow::Result<()> {
    if !files::is_item(&args.item) {
        let what = format!(
            "{}: this is no digital item (no {MANIFEST}); make one by articula package",
            files::shown(&args.item)
        );
        return Err(fault::usage(what));
    }
    if let Some(out) = &args.out {
        if files::is_no_folder(out) {
            let what = format!("{}: this is a file; name a folder", files::shown(out));
            return Err(fault::usage(what));
        }
        if out.canonicalize().ok() == args.item.canonicalize().ok() {
            let what = format!(
                "{}: this is the item itself; name another folder",
                files::shown(out)
            );
            return Err(fault::usage(what));
        }
    }
    args.trace.check()?;
    let outputs = args.outputs();
    let outputs = outputs.iter().map(PathBuf::as_path);
    console
        .files
        .plan(args.inputs(), outputs.chain(args.trace.output()))?;
    let finest = args.limit.unwrap_or_default();
    if args.aqos.is_some() && (finest.texture_px.is_some() || finest.tier > 0) {
        let what = "--limit tier and texture are of the joint choice; leave them or --aqos out";
        return Err(fault::usage(what));
    }
    let context = args.context.context(&finest)?;
    let options = AdaptOptions {
        wait_secs: args.wait_secs,
        max_bytes: args.max_bytes,
        finest_tier: finest.tier,
        max_texture_px: finest.texture_px,
        ..AdaptOptions::default()
    };
    let whole = console.files.open_item(&args.item, &Limits::default())?;
    let item = whole.with_clips(&args.clip)?;
    if let Some(trace) = args.trace.file() {
        let item = (&item, files::shown(&args.item));
        return args.trace.run(trace, item, &context, &options, console);
    }
    let start = Instant::now();
    let decided = args.decided(&item, &context, &options)?;
    let decided_secs = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let adapted = args.adapted(&item, &decided)?;
    let cut_secs = start.elapsed().as_secs_f64();
    let report = AdaptReport::new(
        files::shown(&args.item),
        (&whole, &item, &adapted),
        &decided,
        args.engine,
        [decided_secs, cut_secs],
    );
    if let Some(out) = &args.out {
        write(out, &adapted, &report, console)?;
    }
    console.result(&report, AdaptReport::text)
}

impl AdaptArgs {
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let documents = self.context.files().chain(self.aqos.as_deref());
        documents.chain(self.trace.file())
    }

    /// What is kept, and why.
    fn decided(
        &self,
        item: &Item,
        context: &Context,
        options: &AdaptOptions,
    ) -> anyhow::Result<Decided> {
        let Some(path) = &self.aqos else {
            return Ok(Decided::Jointly(Box::new(decide(item, context, options)?)));
        };
        let limits = DescriptionLimits::default();
        let bytes = files::read(path, limits.bytes)?;
        let aqos = Aqos::read(&bytes, &limits).with_context(|| files::shown(path))?;
        let by_table =
            decide_by_table(item, &aqos, context, options).with_context(|| files::shown(path))?;
        Ok(Decided::ByTable(by_table.0, by_table.1))
    }

    /// The cut item.
    fn adapted(&self, item: &Item, decided: &Decided) -> anyhow::Result<AdaptedItem> {
        let cut: &ItemCut = decided.cut().with_context(|| {
            let what = decided.least().unwrap_or_default();
            let remedy = "allow more bytes, or more time by --wait-secs";
            let item = files::shown(&self.item);
            format!("{item}: nothing of the item fits{what}; {remedy}")
        })?;
        Ok(match self.engine {
            Engine::Native => adapt(item, cut)?,
            Engine::Xslt => {
                let mut xsltproc = xsltproc::Xsltproc::new(&self.item)?;
                adapt_by_description(item, cut, &mut |description, parameters| {
                    xsltproc.transform(description, parameters)
                })?
            }
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        let out = self.out.iter().filter(|out| out.is_dir());
        out.flat_map(|out| [out.join(MANIFEST), out.join(DECISION)])
            .collect()
    }
}

/// Writes what is sent, and the decision about it.
fn write(
    out: &Path,
    adapted: &AdaptedItem,
    report: &AdaptReport,
    console: &Console,
) -> anyhow::Result<()> {
    let mut written: Vec<(String, Vec<u8>)> = match adapted {
        AdaptedItem::Layers(item) => item.files().into_iter().chain(documents(item)?).collect(),
        AdaptedItem::Flat { files, .. } => files.clone(),
    };
    written.push((DECISION.to_owned(), serde_json::to_vec_pretty(report)?));
    files::write_folder(&console.files, out, written)?;
    Ok(())
}
