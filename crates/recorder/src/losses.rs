//! What a recording says of itself in `/log` where something is missing, and how a reader finds it again.

/// Source of these log entries.
pub(crate) const SOURCE: &str = "recorder";
const NOTES: &str =
    " messages about programs and registers are missing here: the recording did not keep up";

/// The sentence for `count` dropped messages.
pub(crate) fn annotations_lost_text(count: u64) -> String {
    format!("{count}{NOTES}")
}

/// The sentence for `count` cycles that were lost before cycle `before`.
pub(crate) fn cycles_lost_text(count: u64, before: u64) -> String {
    format!("{count} cycles are missing before cycle {before}: the recording did not keep up")
}

/// Number of dropped messages that a log entry reports; 0 for other entries.
pub(crate) fn parse_annotations_lost(source: &str, message: &str) -> u64 {
    let count = message.strip_suffix(NOTES);
    let count = count.filter(|_| source == SOURCE);
    count.and_then(|count| count.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_is_found_again() {
        assert_eq!(
            parse_annotations_lost(SOURCE, &annotations_lost_text(17)),
            17
        );
        assert_eq!(
            parse_annotations_lost("script", &annotations_lost_text(17)),
            0
        );
        assert_eq!(parse_annotations_lost(SOURCE, &cycles_lost_text(17, 4)), 0);
    }
}
