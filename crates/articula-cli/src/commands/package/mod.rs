//! `articula package IN ITEM/`: packages a character as a digital item, a folder of streams that can be
//! cut.

mod folder;
pub(crate) mod report;

use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::formats::Limits;
use articula::item::{
    CarriedFile, FaceMotion, MANIFEST, PackageOptions, documents, package_in_stages,
};
use articula::{Data, clip_resampling};
use clap::Args;
use folder::ItemFolder;
use report::ItemReport;
use std::path::{Path, PathBuf};

/// Arguments of `package`.
#[derive(Debug, Args)]
pub(crate) struct PackageArgs {
    /// Character file (.glb, .gltf, .vrm, .bvh, ...)
    file: PathBuf,
    /// Folder of the item; it is made if it does not exist
    #[arg(value_name = "ITEM")]
    item: PathBuf,
    /// Motion of the face, a .fap, .afp or .fba file (repeatable)
    #[arg(long, value_name = "F.fap")]
    face: Vec<PathBuf>,
    /// File that the item carries whole, such as sound or a picture (repeatable)
    #[arg(long, value_name = "FILE")]
    with: Vec<PathBuf>,
    /// Maximum number of mesh levels, from all triangles down to 1.5 % of them
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=16))]
    levels: u16,
    /// Name of a clip to package (repeatable) [default: all]
    #[arg(long, value_name = "NAME")]
    clip: Vec<String>,
    /// Make no forms in 2D
    #[arg(long)]
    no_2d: bool,
    #[command(flatten)]
    names: ReadArgs,
}

/// Packages the character and prints what the item holds.
pub(crate) fn run(args: &PackageArgs, console: &Console) -> anyhow::Result<()> {
    if files::is_no_folder(&args.item) {
        let what = format!(
            "{}: this is a file; name a folder",
            files::shown(&args.item)
        );
        return Err(fault::usage(what));
    }
    let manifest = args.item.join(MANIFEST);
    let outputs = args.item.is_dir().then_some(manifest.as_path());
    console.files.plan(args.inputs(), outputs)?;
    let options = args.options()?;
    let opened = open::motion(&console.files, &args.file, &args.names)?;
    let bytes_in = opened.bytes() as u64;
    let warnings = open::warnings(opened.warnings());
    let character = opened.character().clone();
    let mut folder = ItemFolder::new(&console.files, &args.item);
    let item = console.work(|work| {
        package_in_stages(opened, &options, work, &mut |stage| {
            folder.write(stage, Vec::new())
        })
    })?;
    folder.write(&item, documents(&item)?)?;
    // After the stages, none of which waits for it.
    let mut resampling = clip_resampling(&character)?;
    if !options.clips.is_empty() {
        resampling.retain(|clip| options.clips.contains(&clip.clip));
    }
    let report = ItemReport {
        bytes_in: Some(bytes_in),
        resampling,
        warnings,
        ..ItemReport::new(files::shown(&args.item), &item)
    };
    console.result(&report, ItemReport::text)
}

impl PackageArgs {
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let named = [&self.file].into_iter().chain(&self.face).chain(&self.with);
        named.map(PathBuf::as_path).chain(self.names.inputs())
    }

    /// The options of the library, with the files that the flags name.
    fn options(&self) -> anyhow::Result<PackageOptions> {
        let limits = Limits::default();
        let faces = self.face.iter().map(|path| self.face_motion(path));
        let with = self.with.iter().map(|path| {
            let name = path.file_name().unwrap_or_default();
            Ok(CarriedFile {
                name: name.to_string_lossy().into_owned(),
                bytes: files::read(path, limits.bytes)?,
            })
        });
        Ok(PackageOptions {
            mesh_levels: usize::from(self.levels),
            clips: self.clip.clone(),
            faces: faces.collect::<anyhow::Result<_>>()?,
            with: with.collect::<anyhow::Result<_>>()?,
            flat: !self.no_2d,
            ..PackageOptions::default()
        })
    }

    fn face_motion(&self, path: &Path) -> anyhow::Result<FaceMotion> {
        let shown = files::shown(path);
        let refused = || {
            let what = "expected facial animation parameters, a .fap, .afp or .fba file";
            fault::usage(format!("--face {shown}: {what}"))
        };
        let format = files::data_format(path).ok_or_else(refused)?;
        match open::data(path, format, &self.names)?.data {
            Data::Fap(clip) => Ok(FaceMotion { file: shown, clip }),
            _ => Err(refused()),
        }
    }
}
