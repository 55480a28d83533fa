#!/bin/sh
# Builds a fuzz target with the stable compiler's own coverage counters and runs it: run.sh TARGET SECONDS
# Crashing inputs are left in fuzz/artifacts. Targets are the files of fuzz_targets and ports/fuzz_targets.
set -eu
cd "$(dirname "$0")"
target=$1
seconds=$2
passes="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters"
passes="$passes -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1"
host=$(rustc -vV | sed -n 's/^host: //p')
RUSTFLAGS="$passes --cfg fuzzing" cargo build --release --target "$host" --workspace --bin "$target"
mkdir -p "corpus/$target" "artifacts"
case "$target" in
lexer | parser | evaluator) language="-dict=tokens.dict ../tests/scripts" ;;
primary | interpreter) language="../tests/scripts" ;;
*) language="" ;;
esac
# shellcheck disable=SC2086 # options, in words
exec "${CARGO_TARGET_DIR:-target}/$host/release/$target" "corpus/$target" $language \
    -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=4096 -artifact_prefix=artifacts/ \
    -print_final_stats=1
