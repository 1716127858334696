//! `cargo xtask studio`: the program with the pages of the studio inside.

use crate::heartbeat::{told, with_heartbeat};
use crate::outcome::Outcome;
use crate::processes::run;
use crate::workspace::{cargo, root, target};
use crate::{web, web_pages};
use anyhow::Result;
use std::io::IsTerminal;
use std::process::{Command, Stdio};

/// Address of the server, and of the page that shows what it serves.
const ADDRESS: &str = "127.0.0.1:8080";
const PAGE: &str = "http://127.0.0.1:8080/studio/#stream";

/// Programs that open an address in a browser.
const OPENERS: [&str; 3] = ["xdg-open", "open", "explorer"];

/// Builds the release program with the pages inside; without Node says so and builds nothing.
pub(crate) fn build() -> Result<Outcome> {
    if let skipped @ Outcome::Skipped(_) = told("packages", web_pages::install)? {
        return Ok(skipped);
    }
    // The program makes the character with which the pages begin.
    release(&[])?;
    println!("building the modules for web pages (some minutes the first time)");
    if let Some(why) = told("modules", web::release_modules)? {
        return Ok(Outcome::Skipped(why));
    }
    told("pages", web_pages::embed)?;
    release(&["--features", "studio"])?;
    Ok(Outcome::Done)
}

fn release(features: &[&str]) -> Result<()> {
    let words = ["build", "--release", "-p", "articula-cli"];
    with_heartbeat("building", || run(cargo().args(words).args(features)))
}

/// Serves a folder of characters and opens the studio over them until the program is interrupted; without a terminal
/// says how.
pub(crate) fn open(folder: &str) -> Result<()> {
    let program = target().join("release/articula");
    if !std::io::stdout().is_terminal() {
        println!(
            "{} serve {folder} --addr {ADDRESS} serves them with the studio at {PAGE}",
            program.display()
        );
        return Ok(());
    }
    println!("the studio is at {PAGE}");
    open_in_browser();
    let words = ["serve", folder, "--addr", ADDRESS];
    run(Command::new(program).args(words).current_dir(root()))
}

/// Asks the desktop for it; who has none opens the address by hand.
fn open_in_browser() {
    for opener in OPENERS {
        let mut call = Command::new(opener);
        let call = call.arg(PAGE).stdout(Stdio::null()).stderr(Stdio::null());
        if call.spawn().is_ok() {
            return;
        }
    }
}
