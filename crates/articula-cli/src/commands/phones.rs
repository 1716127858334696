//! The phones of a text, by the program `espeak-ng`.

use anyhow::{Context, bail};
use std::process::Command;

/// Longest text.
const MAX_BYTES: usize = 100_000;

/// The phones of a text in the symbols of the IPA; between words an empty one, where a pause may be.
///
/// # Errors
/// If espeak-ng is not installed, does not know the language or finds no phone.
pub(crate) fn of_text(text: &str, language: &str) -> anyhow::Result<Vec<String>> {
    if text.len() > MAX_BYTES {
        bail!("--text: {} bytes; 100,000 are read at most", text.len());
    }
    let made = Command::new("espeak-ng")
        .args(["-q", "--ipa", "--sep=_", "-v", language, "--"])
        .arg(text)
        .output()
        .context("--text: espeak-ng, which knows how words are spoken, could not be run; install it (Debian: apt install espeak-ng), or give --phones")?;
    if !made.status.success() {
        let why = String::from_utf8_lossy(&made.stderr);
        let why = why.lines().next().unwrap_or("no reason given");
        bail!("--text: espeak-ng: {why}; `espeak-ng --voices` lists the languages");
    }
    let phones = separated(&String::from_utf8_lossy(&made.stdout));
    if phones.is_empty() {
        bail!("--text: espeak-ng finds no phone in it");
    }
    Ok(phones)
}

/// The phones of what espeak-ng prints: words by spaces, clauses by lines, phones by `_`.
fn separated(ipa: &str) -> Vec<String> {
    let known = |phone: &&str| articula::speech::phones_of_ipa(phone).is_some();
    let mut phones: Vec<String> = Vec::new();
    for word in ipa.split_whitespace() {
        let of_word = word.split('_').filter(known);
        phones.extend(of_word.map(str::to_owned));
        phones.push(String::new());
    }
    while phones.last().is_some_and(String::is_empty) {
        phones.pop();
    }
    phones
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_parted_by_places_for_pauses() {
        let phones = separated(" h_ə_l_ˈəʊ w_ˈɜː_l_d\n (en)_x\n");
        assert_eq!(
            phones,
            [
                "h", "ə", "l", "ˈəʊ", "", "w", "ˈɜː", "l", "d", "", "(en)", "x"
            ]
        );
        assert!(separated(" \n").is_empty());
    }
}
