//! `cargo xtask web`: the modules for web pages, with what JavaScript and TypeScript need of them.
//!
//! All are built from one crate. The generator of the JavaScript is a program of its own (`xtask-web`), which is
//! compiled when a module is made.

use crate::platform;
use crate::processes::{output, run};
use crate::wasm_build::{PACKAGE, SIMD, TARGET, build_dev};
use crate::workspace::{cargo, root, target};
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The file that the crate of the modules is compiled to.
const COMPILED: &str = "articula_wasm.wasm";

/// Where the modules are put, as part of the package `@articula/core`.
const FOLDER: &str = "web/packages/core/wasm";

/// Page of the sizes; its rows are in a CSV file beside it.
const PAGE: &str = "docs/results/web-sizes.md";
const ROWS: &str = "docs/results/web-sizes.csv";

/// A module.
struct Module {
    name: &'static str,
    contents: &'static str,
    /// Most bytes that it may take, compressed by brotli.
    limit: usize,
}

const PLAY: Module = Module {
    name: "play",
    contents: "opening of GLB and VRM files, figures, crowds",
    limit: 600_000,
};

const TOOLS: Module = Module {
    name: "tools",
    contents: "preparing, converting, retargeting and describing files of all formats",
    limit: 1_460_000,
};

const STREAM: Module = Module {
    name: "stream",
    contents: "characters of a server while they arrive",
    limit: 1_100_000,
};

const PUBLISH: Module = Module {
    name: "publish",
    contents: "2D output, portraits, streams, packaging, lighter files, motions of faces, voices, evaluation, benchmark",
    limit: 2_300_000,
};

const MODULES: [&Module; 4] = [&PLAY, &TOOLS, &STREAM, &PUBLISH];

/// Modules that a page loads of which it has a file that is not prepared, and what they may take together.
const USUAL: [&Module; 2] = [&PLAY, &TOOLS];
const USUAL_LIMIT: usize = 2_000_000;

/// What was asked for.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct WebOptions {
    /// Build as the tests do, in less time.
    dev: bool,
    /// Renew the page of the sizes.
    write: bool,
}

impl WebOptions {
    /// Reads `[--dev | --write]`; `None` for anything else.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        match words {
            [] => Some(Self::default()),
            ["--dev"] => Some(Self {
                dev: true,
                write: false,
            }),
            ["--write"] => Some(Self {
                dev: false,
                write: true,
            }),
            _ => None,
        }
    }
}

/// Builds the modules and prints their sizes.
pub(crate) fn web(options: &WebOptions) -> Result<()> {
    if options.dev {
        ensure!(platform::add(TARGET), NO_TARGET);
        let folder = dev_modules()?;
        println!("{}", folder.display());
        return Ok(());
    }
    if let Some(why) = release_modules()? {
        anyhow::bail!(why);
    }
    let sizes: Result<Vec<_>> = MODULES.into_iter().map(Size::of).collect();
    let sizes = sizes?;
    print!("{}\n{}", table(&sizes), together(&sizes));
    if options.write {
        std::fs::write(root().join(PAGE), page(&sizes)).context(PAGE)?;
        std::fs::write(root().join(ROWS), rows(&sizes)).context(ROWS)?;
    }
    Ok(())
}

const NO_TARGET: &str =
    "the target wasm32-unknown-unknown is not installed, and rustup could not add it";

/// Builds the modules as pages are to have them; says why if it cannot.
pub(crate) fn release_modules() -> Result<Option<String>> {
    if !platform::add(TARGET) {
        return Ok(Some(NO_TARGET.to_owned()));
    }
    for module in MODULES {
        let words = ["build", "--quiet", "--profile", "web", "-p", PACKAGE];
        let features = ["--no-default-features", "--features", module.name];
        run(cargo()
            .args(words)
            .args(["--target", TARGET])
            .args(features)
            .env("RUSTFLAGS", SIMD))?;
        generate(&target().join(TARGET).join("web"), module, true)?;
    }
    Ok(None)
}

/// Builds the modules as the tests in node are built, with the library compiled once for all, and returns their
/// folder.
pub(crate) fn dev_modules() -> Result<PathBuf> {
    for module in MODULES {
        // Each alone: what another one has, pages do not find in it either.
        build_dev(Some(module.name))?;
        // It takes seconds, so of the modules that are tested one is folded.
        generate(&platform::built(TARGET), module, module.name == PLAY.name)?;
    }
    Ok(root().join(FOLDER))
}

/// Tests the modules of a folder in node. `steps` are the lines of [`LIBRARY`](platform::LIBRARY) on this machine, and `prepared`
/// is the file that it wrote.
pub(crate) fn test(folder: &Path, steps: &str, prepared: &Path) -> Result<()> {
    let tests = root().join("crates").join(PACKAGE).join("tests");
    output(
        Command::new("node")
            .arg("--test")
            .args(MODULES.map(|module| tests.join(module.name).with_extension("mjs")))
            .env("ARTICULA_WASM", folder)
            .env("ARTICULA_STEPS", steps)
            .env("ARTICULA_PREPARED", prepared),
    )?;
    Ok(())
}

/// Makes the JavaScript, the declaration and the final module of what was compiled into a folder; functions with the
/// same code are one if it is folded.
fn generate(compiled: &Path, module: &Module, is_folded: bool) -> Result<()> {
    let words = ["run", "--quiet", "-p", "xtask-web", "--"];
    run(cargo()
        .args(words)
        .arg(compiled.join(COMPILED))
        .arg(module.name)
        .arg(root().join(FOLDER))
        .args(is_folded.then_some("--fold")))
}

/// Bytes of a module as served plain, by gzip (9) and by brotli (11), and of its JavaScript.
struct Size {
    module: &'static Module,
    bytes: [usize; 3],
    script: usize,
}

impl Size {
    fn of(module: &'static Module) -> Result<Self> {
        let folder = root().join(FOLDER);
        let built = folder.join(format!("{}_bg.wasm", module.name));
        let script = folder.join(module.name).with_extension("js");
        let said = output(Command::new("node").args(["-e", COMPRESS]).arg(built))?;
        let bytes: Vec<usize> = said
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            module,
            bytes: bytes.try_into().ok().context("node prints three sizes")?,
            script: std::fs::read(script)?.len(),
        })
    }

    fn brotli(&self) -> usize {
        self.bytes[2]
    }
}

/// Prints the sizes of a file, in node.
const COMPRESS: &str = "
const zlib = require('zlib');
const bytes = require('fs').readFileSync(process.argv[1]);
const { BROTLI_PARAM_QUALITY, BROTLI_PARAM_LGWIN, BROTLI_PARAM_SIZE_HINT } = zlib.constants;
const params = { [BROTLI_PARAM_QUALITY]: 11, [BROTLI_PARAM_LGWIN]: 24, [BROTLI_PARAM_SIZE_HINT]: bytes.length };
const sizes = [bytes, zlib.gzipSync(bytes, { level: 9 }), zlib.brotliCompressSync(bytes, { params })];
console.log(sizes.map((all) => all.length).join(' '));
";

/// The sizes as lines of a table.
fn table(sizes: &[Size]) -> String {
    let mut text = String::from(
        "| module | contents | bytes | gzip | brotli | limit | JavaScript |\n| --- | --- | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for size in sizes {
        let Module {
            name,
            contents,
            limit,
            ..
        } = size.module;
        let [raw, gzip, brotli] = size.bytes.map(kilobytes);
        let missed = if size.brotli() > *limit {
            " **missed**"
        } else {
            ""
        };
        let (limit, script) = (kilobytes(*limit), kilobytes(size.script));
        text += &format!(
            "| {name} | {contents} | {raw} | {gzip} | {brotli}{missed} | {limit} | {script} |\n"
        );
    }
    text
}

/// What the usual modules take together, in a sentence.
fn together(sizes: &[Size]) -> String {
    let is_usual = |size: &&Size| USUAL.iter().any(|usual| usual.name == size.module.name);
    let bytes: usize = sizes.iter().filter(is_usual).map(Size::brotli).sum();
    let missed = match bytes > USUAL_LIMIT {
        true => " (**missed**)",
        false => "",
    };
    format!(
        "{} together: {} by brotli{missed}; the limit is {}.\n",
        USUAL.map(|module| module.name).join(" and "),
        kilobytes(bytes),
        kilobytes(USUAL_LIMIT)
    )
}

/// Thousands of bytes.
fn kilobytes(bytes: usize) -> String {
    format!("{:.0} kB", bytes as f64 / 1e3)
}

fn page(sizes: &[Size]) -> String {
    format!(
        "# Sizes of the modules for web pages

Written by `cargo xtask web --write`; the method is in [the page of the modules](../web.md). Modules have vector
instructions and neither names nor debug information; kB are thousands of bytes, gzip is level 9, brotli quality 11.
JavaScript is what belongs to a module, not compressed. A page loads `play`; `tools` when a file is to be prepared,
`stream` in place of `play` for characters of a server, and `publish` for its own purposes.

{}
{}",
        table(sizes),
        together(sizes)
    )
}

fn rows(sizes: &[Size]) -> String {
    let mut text = String::from("module,bytes,gzip_bytes,brotli_bytes,limit_bytes,script_bytes\n");
    for size in sizes {
        let Module { name, limit, .. } = size.module;
        let [raw, gzip, brotli] = size.bytes;
        text += &format!("{name},{raw},{gzip},{brotli},{limit},{}\n", size.script);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_the_chore() {
        let write = WebOptions {
            write: true,
            ..WebOptions::default()
        };
        assert_eq!(WebOptions::parse(&["--write"]), Some(write));
        assert_eq!(WebOptions::parse(&[]), Some(WebOptions::default()));
        assert_eq!(WebOptions::parse(&["--dev", "--write"]), None);
    }

    #[test]
    fn a_module_over_its_limit_is_marked() {
        let size = |brotli| Size {
            module: &PLAY,
            bytes: [2_000_400, 700_000, brotli],
            script: 48_000,
        };
        let told = table(&[size(599_000), size(601_000)]);
        assert!(told.contains("| 2000 kB | 700 kB | 599 kB | 600 kB | 48 kB |\n"));
        assert!(told.contains("| 601 kB **missed** | 600 kB |"));
        let tools = |brotli| Size {
            module: &TOOLS,
            ..size(brotli)
        };
        let said = together(&[size(600_000), tools(1_400_000)]);
        assert_eq!(
            said,
            "play and tools together: 2000 kB by brotli; the limit is 2000 kB.\n"
        );
        assert!(together(&[size(600_000), tools(1_400_001)]).contains("missed"));
        assert!(rows(&[size(1)]).ends_with("play,2000400,700000,1,600000,48000\n"));
    }
}
