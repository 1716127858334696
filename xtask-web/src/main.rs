//! Writes what a web page loads of a module: `xtask-web MODULE.wasm NAME FOLDER [--fold]` makes `NAME.js`, `NAME.d.ts`
//! and `NAME_bg.wasm`, smaller if it is folded.

#![allow(
    clippy::disallowed_methods,
    reason = "a program for the project's own developers: it reads and writes files"
)]

mod fold;

use anyhow::{Context, Result, bail};
use std::path::Path;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (module, name, folder, is_folded) = match words[..] {
        [module, name, folder] => (module, name, folder, false),
        [module, name, folder, "--fold"] => (module, name, folder, true),
        _ => bail!("usage: xtask-web MODULE.wasm NAME FOLDER [--fold]"),
    };
    let mut made = Bindgen::new();
    made.input_path(module)
        .out_name(name)
        .web(true)?
        .typescript(true)
        .remove_name_section(true)
        .remove_producers_section(true);
    made.generate(folder)
        .with_context(|| format!("cannot make {name} of {module}"))?;
    if !is_folded {
        return Ok(());
    }
    let path = Path::new(folder).join(format!("{name}_bg.wasm"));
    let folded = fold::folded(&std::fs::read(&path)?)
        .with_context(|| format!("cannot fold {}", path.display()))?;
    std::fs::write(&path, folded).with_context(|| path.display().to_string())
}
