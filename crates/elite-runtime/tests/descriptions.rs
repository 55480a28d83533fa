//! Every builtin is described in both languages.

use elite_runtime::builtins::all;
use messages::Language;

fn is_chinese(text: &str) -> bool {
    text.chars().any(|c| ('\u{4e00}'..='\u{9fff}').contains(&c))
}

#[test]
fn every_function_is_described_in_chinese() {
    for builtin in all() {
        let name = builtin.name;
        let summary = builtin.summary.in_language(Language::Chinese);
        assert!(is_chinese(summary), "{name}");
        for parameter in builtin.params {
            let meaning = parameter.meaning;
            let chinese = meaning.in_language(Language::Chinese);
            assert!(
                meaning.english().is_empty() || is_chinese(chinese),
                "{name}: {meaning:?}"
            );
        }
        // Types alone are written alike.
        let returns = builtin.returns;
        let is_prose = returns.english().contains(' ') && returns.english().len() > 24;
        let chinese = returns.in_language(Language::Chinese);
        assert!(!is_prose || is_chinese(chinese), "{name}: {returns:?}");
    }
}
