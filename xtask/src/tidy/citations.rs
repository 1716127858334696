//! Rules on what texts refer to: pages that comments cite, and numbers that the readme states.

use super::Fault;
use super::tree::Tree;

const README: &str = "README.md";

/// Folder of the pages that the evaluation runs write.
const RESULTS: &str = "docs/results/";

/// Finds comments that cite a page which is not in the repository.
///
/// A citation is a path with a folder that ends in `.md`, from the root of the repository.
pub(crate) fn cited_pages(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.sources() {
        for (index, line) in text.lines().enumerate() {
            let Some((_, comment)) = line.split_once("//") else {
                continue;
            };
            for cited in paths(comment).filter(|p| p.contains('/') && p.ends_with(".md")) {
                if !tree.has(cited.trim_start_matches("../")) {
                    let what = format!("cites {cited}, which is not in the repository");
                    faults.push(Fault::line(path, index + 1, what));
                }
            }
        }
    }
    faults
}

/// Finds numbers of the readme's list of results that the linked page does not have.
pub(crate) fn readme_results(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    let Some(readme) = tree.text(README) else {
        return faults;
    };
    for (line, item) in items(readme) {
        let Some((said, link)) = item.split_once(&format!("]({RESULTS}")) else {
            continue;
        };
        let page = format!("{RESULTS}{}", link.split(')').next().unwrap_or_default());
        let stated: Vec<String> = numbers(tree.text(&page).unwrap_or_default()).collect();
        for number in numbers(said).filter(|n| !stated.contains(n)) {
            let what = format!("{number} does not occur in {page}");
            faults.push(Fault::line(README, line, what));
        }
    }
    faults
}

/// Items of lists, each as one line, with the number of the line that it starts at.
fn items(text: &str) -> Vec<(usize, String)> {
    let mut items: Vec<(usize, String)> = Vec::new();
    let mut is_open = false;
    for (index, line) in text.lines().enumerate() {
        if line.starts_with("- ") {
            items.push((index + 1, line.to_owned()));
            is_open = true;
        } else if let Some((_, item)) = items.last_mut().filter(|_| is_open)
            && line.starts_with("  ")
        {
            item.push(' ');
            item.push_str(line.trim());
        } else {
            is_open = false;
        }
    }
    items
}

/// Words made of the letters of paths.
fn paths(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || "_-./".contains(c)))
        .map(|word| word.trim_end_matches('.'))
}

/// Decimal numbers, without the commas between thousands; digits within a word are none.
fn numbers(text: &str) -> impl Iterator<Item = String> {
    text.split(|c: char| c.is_whitespace() || "()|`;:/[]".contains(c))
        .map(|word| word.trim_end_matches([',', '.', '%']).replace(',', ""))
        .filter(|word| {
            word.parse::<f64>().is_ok() && word.starts_with(|c: char| c.is_ascii_digit())
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_may_cite_only_what_is_there() {
        let cited = |text| {
            let source = format!("//! Source: `{text}` part 3.\n");
            let files = [("a.rs", source.as_str()), ("docs/methods/a.md", "")];
            cited_pages(&Tree::of(&files)).len()
        };
        assert_eq!(cited("docs/methods/a.md"), 0);
        assert_eq!(cited("../docs/methods/a.md"), 0);
        assert_eq!(cited("notes/a.md"), 1);
        assert_eq!(cited("a.md"), 0);
    }

    #[test]
    fn numbers_of_the_readme_stand_in_their_pages() {
        let faults = |said| {
            let readme = format!("- **A**: {said}\n  ([run](docs/results/a.md))\n\n7 elsewhere\n");
            let page = "| 10000 | 1.32 | 52.5 % |\n";
            let files = [(README, readme.as_str()), ("docs/results/a.md", page)];
            readme_results(&Tree::of(&files)).len()
        };
        assert_eq!(faults("10,000 in 1.32 ms, 52.5 % in 2D"), 0);
        assert_eq!(faults("10,000 in 1.31 ms"), 1);
    }
}
