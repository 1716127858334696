//! Flags of `crowd` that say how clips are stored, what poses come from, and which palettes are written.

use articula::crowd::{Backend, CacheUse};
use clap::{Args, ValueEnum};

/// Storage of clips and format of palettes.
#[derive(Debug, Clone, Args)]
pub(super) struct StorageArgs {
    /// Storage of clips: 32-bit floats or 16-bit integers
    #[arg(long, value_enum, default_value = "float")]
    pub(super) storage: StorageName,
    /// Format of a palette matrix: 48, 24, 32 or 16 bytes
    #[arg(long, value_enum, default_value = "matrix")]
    pub(super) form: FormName,
    /// Palette matrices: one per joint, or one per skin binding including the inverse bind matrix
    /// [default: skin where poses may be cached, else joints]
    #[arg(long, value_enum)]
    pub(super) palette: Option<MatricesName>,
    /// Source of poses. auto: evaluated, or blended from cached ones where that is cheaper within
    /// the tolerance; records: the same, with cached poses blended by the GPU from records of 16
    /// bytes; own: evaluated for each character
    #[arg(long, value_enum, default_value = "auto")]
    pub(super) source: SourceName,
    /// Instruction set; all give the same bits [default: the fastest]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    pub(super) backend: Option<Backend>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StorageName {
    Float,
    Short,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum FormName {
    Matrix,
    Half,
    Rigid,
    HalfRigid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MatricesName {
    Joints,
    Skin,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SourceName {
    Auto,
    Records,
    Own,
}

impl StorageArgs {
    /// Whether the form of palettes can be cached.
    pub(super) fn is_cacheable(&self) -> bool {
        matches!(self.form, FormName::Matrix | FormName::Half)
    }

    /// Use of the pose cache that the source asks for.
    pub(super) fn cache(&self) -> CacheUse {
        match self.source {
            SourceName::Auto => CacheUse::Cpu,
            SourceName::Records => CacheUse::Gpu,
            SourceName::Own => CacheUse::Never,
        }
    }
}

fn backend(text: &str) -> Result<Backend, String> {
    let here = Backend::ALL.into_iter().filter(|b| b.is_available());
    let found = text.parse().ok().filter(|b: &Backend| b.is_available());
    found.ok_or_else(|| {
        let here: Vec<String> = here.map(|b| b.to_string()).collect();
        format!("this machine has {}", here.join(", "))
    })
}
