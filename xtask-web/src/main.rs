//! Writes what a web page loads of a module: `xtask-web MODULE.wasm NAME FOLDER` makes `NAME.js`, `NAME.d.ts` and
//! `NAME_bg.wasm`.

use anyhow::{Context, Result, bail};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [module, name, folder] = &words[..] else {
        bail!("usage: xtask-web MODULE.wasm NAME FOLDER");
    };
    let mut made = Bindgen::new();
    made.input_path(module)
        .out_name(name)
        .web(true)?
        .typescript(true)
        .remove_name_section(true)
        .remove_producers_section(true);
    made.generate(folder)
        .with_context(|| format!("cannot make {name} of {module}"))
}
