//! Any bytes as program text: lexer, parser, resolver and warnings come to an end, and every finding can be shown.
#![no_main]

use elite_lang::{KnownNames, SourceFile, check, render_human};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let file = SourceFile::new("fuzz.script", String::from_utf8_lossy(data).into_owned());
    let known = KnownNames::new(["movej", "get_actual_joint_positions"]);
    for finding in check(file.clone(), &known).iter().take(20) {
        let fields = finding.fields(&file);
        assert!(fields.line >= 1 && fields.line <= file.line_count() + 1, "{fields:?}");
        assert!(!render_human(finding, &file, false).is_empty());
    }
});
