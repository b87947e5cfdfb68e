//! Pages that are linked exist.

use std::fs;
use std::path::{Path, PathBuf};

use adcs_tests::repository;

/// Markdown files of the repository outside of crates (whose pages rustdoc checks).
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![repository("README.md"), repository("missions/README.md")];
    let docs = fs::read_dir(repository("docs")).expect("docs");
    pages.extend(docs.map(|entry| entry.expect("an entry").path()));
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages
}

/// Targets of links and images that are files.
fn linked_files(text: &str) -> Vec<&str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets
        .map(|target| target.split('#').next().unwrap_or_default())
        .filter(|target| !target.is_empty() && !target.contains("://"))
        .collect()
}

#[test]
fn every_link_of_a_page_leads_to_a_file() {
    let mut followed = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page is text");
        for target in linked_files(&text) {
            let file = page.parent().unwrap_or(Path::new("")).join(target);
            assert!(file.exists(), "{}: no {target}", page.display());
            followed += 1;
        }
    }
    assert!(followed > 20, "{followed} links");
}

#[test]
fn every_page_of_the_book_is_in_its_contents() {
    let contents = fs::read_to_string(repository("docs/SUMMARY.md")).expect("the contents");
    for page in pages() {
        let name = page.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        if page.parent() == Some(&repository("docs")) && name != "SUMMARY.md" {
            assert!(contents.contains(&format!("({name})")), "{name} is not in docs/SUMMARY.md");
        }
    }
}
