//! Relative links lead to files that are there, and to headings in them.

use crate::markdown::{name, pages, read};

#[test]
fn every_link_leads_somewhere() {
    let mut lost = Vec::new();
    let mut followed = 0;
    for page in pages() {
        for (link, line) in read(&page).links {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            followed += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone(),
                _ => page.parent().unwrap().join(file),
            };
            let is_there = match anchor {
                "" => target.exists(),
                _ => target.is_file() && read(&target).anchors.contains(anchor),
            };
            if !is_there {
                lost.push(format!("{}:{line}: {link}", name(&page)));
            }
        }
    }
    assert!(followed > 100, "only {followed} links were found");
    assert!(lost.is_empty(), "links that lead nowhere: {lost:#?}");
}
