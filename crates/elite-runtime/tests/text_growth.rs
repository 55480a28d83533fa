//! A walk through a text by `str_at`, `str_sub` and `str_find` grows with its length, not with the square of it:
//! letters of several bytes are not counted from the beginning again and again.

use crate::common;

use std::time::Duration;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use nix::time::{ClockId, clock_gettime};

/// How much longer four times as much may take: 4 in proportion, 16 with the square.
const RATIO_MAX: f64 = 9.0;
/// Seconds in which no square of the larger size fits.
const FAST: f64 = 0.2;
/// Letters of the smaller text.
const LETTERS: usize = 30_000;

const WALKS: &[&str] = &[
    "for i in range(n): str_at(text, i)",
    "for i in range(n - 1, -1, -1): str_at(text, i)",
    "for i in range(n): str_sub(text, i, 2)",
    "for i in range(n): str_at(text, i * 7919 % n)",
    "i = 0\nwhile i >= 0: i = str_find(text, 'b', i + 1)",
    "for i in range(n): str_len(text)",
];

/// Seconds of the processor, of all threads: other work on the machine does not count.
fn processor_time() -> Duration {
    clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

fn seconds(walk: &str, letters: &str, n: usize) -> f64 {
    let text = format!("n = {n}\ntext = {letters:?} * (n // 2)\n{walk}\nprint('done')\n");
    let times = (0..2).map(|_| {
        let before = processor_time();
        let ran = run(&Standing::default(), &text);
        assert!(
            matches!(ran.end, TaskEnd::Finished),
            "{walk}: {:?}",
            ran.end
        );
        assert!(ran.printed.contains("done"), "{walk}: {}", ran.report);
        (processor_time() - before).as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

#[test]
fn walks_through_texts_grow_with_their_length() {
    let mut trouble = Vec::new();
    for walk in WALKS {
        for letters in ["ab", "位b"] {
            let (small, large) = (
                seconds(walk, letters, LETTERS),
                seconds(walk, letters, 4 * LETTERS),
            );
            if large > FAST && large > RATIO_MAX * small {
                trouble.push(format!("{walk} in {letters:?}: {small} s, then {large} s"));
            }
        }
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}
