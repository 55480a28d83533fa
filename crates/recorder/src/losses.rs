//! What a recording says of itself in `/log` where something is missing, and how a reader finds it again.

use messages::{Text, text};

/// Source of these log entries.
pub(crate) const SOURCE: &str = "recorder";
const NOTES: &str =
    " messages about programs and registers are missing here: the recording did not keep up";

/// The sentence for `count` dropped messages.
pub(crate) fn annotations_lost_text(count: u64) -> Text {
    Text::new(
        format!("{count}{NOTES}"),
        format!("此处缺少 {count} 条关于程序和寄存器的消息：记录跟不上"),
    )
}

/// The sentence for `count` cycles that were lost before cycle `before`.
pub(crate) fn cycles_lost_text(count: u64, before: u64) -> Text {
    text!(
        "{count} cycles are missing before cycle {before}: the recording did not keep up",
        "第 {before} 周期之前缺少 {count} 个周期：记录跟不上"
    )
}

/// Number of dropped messages that a log entry reports; 0 for other entries.
pub(crate) fn parse_annotations_lost(source: &str, message: &Text) -> u64 {
    let count = message.english().strip_suffix(NOTES);
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
