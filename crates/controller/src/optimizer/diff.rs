//! A unified diff of a text in which lines were changed and dropped, none moved.

use core::fmt::Write;

/// Lines around a change that are shown.
const CONTEXT: usize = 3;

/// The diff of a text with what became of each of its lines; `None` for one that is gone. Empty without changes.
pub(super) fn unified(name: &str, lines: &[(&str, Option<String>)]) -> String {
    let is_changed = |at: usize| lines[at].1.as_deref() != Some(lines[at].0);
    let changed: Vec<usize> = (0..lines.len()).filter(|at| is_changed(*at)).collect();
    let mut text = String::new();
    let mut rest = changed.as_slice();
    if !rest.is_empty() {
        // Writing into a text cannot fail.
        let _ = writeln!(text, "--- {name}\n+++ {name} (optimized)");
    }
    while let Some(&first) = rest.first() {
        let near = |at: &usize, next: &usize| next - at <= 2 * CONTEXT;
        let count = 1 + rest
            .windows(2)
            .take_while(|pair| near(&pair[0], &pair[1]))
            .count();
        let last = rest[count - 1];
        rest = &rest[count..];
        let from = first.saturating_sub(CONTEXT);
        let to = (last + CONTEXT + 1).min(lines.len());
        let dropped =
            |range: core::ops::Range<usize>| range.filter(|at| lines[*at].1.is_none()).count();
        let new_from = from - dropped(0..from);
        let new_count = to - from - dropped(from..to);
        let _ = writeln!(
            text,
            "@@ -{},{} +{},{new_count} @@",
            from + 1,
            to - from,
            new_from + usize::from(new_count > 0)
        );
        let mut at = from;
        while at < to {
            if !is_changed(at) {
                let _ = writeln!(text, " {}", lines[at].0);
                at += 1;
                continue;
            }
            let end = (at..to).find(|at| !is_changed(*at)).unwrap_or(to);
            for (old, _) in &lines[at..end] {
                let _ = writeln!(text, "-{old}");
            }
            for new in lines[at..end].iter().filter_map(|(_, new)| new.as_ref()) {
                let _ = writeln!(text, "+{new}");
            }
            at = end;
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_and_dropped_lines_are_shown_with_what_is_around() {
        let old = [
            "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m",
        ];
        let lines: Vec<(&str, Option<String>)> = old
            .iter()
            .map(|line| match *line {
                "b" => (*line, Some("B".to_owned())),
                "c" => (*line, None),
                "m" => (*line, Some("M".to_owned())),
                _ => (*line, Some((*line).to_owned())),
            })
            .collect();
        let expected = "--- x\n+++ x (optimized)\n@@ -1,6 +1,5 @@\n a\n-b\n-c\n+B\n d\n e\n f\n@@ -10,4 +9,4 @@\n j\n\
                        \x20k\n l\n-m\n+M\n";
        assert_eq!(unified("x", &lines), expected);
        assert_eq!(unified("x", &lines[3..5]), "");
    }
}
