#!/bin/sh
# Builds the fuzz targets with the stable compiler's own coverage counters and runs one: run.sh TARGET SECONDS
# `cargo dev targets` lists them. Crashing inputs are left in fuzz/artifacts; for a generated target
# `cargo dev show TARGET FILE` prints the program that such an input stands for.
set -eu
cd "$(dirname "$0")"
target=$1
seconds=$2
passes="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
passes="$passes -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
passes="$passes -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1"
host=$(rustc -vV | sed -n 's/^host: //p')
features=""
dictionary=""
case "$target" in
lexer | evaluator) features="--no-default-features" dictionary="-dict=tokens.dict" ;;
parser | library | containers | chains | stacks | growth) features="--no-default-features" ;;
esac
# shellcheck disable=SC2086 # options, in words
RUSTFLAGS="$passes --cfg fuzzing" cargo build --release --target "$host" --bin any $features
mkdir -p "corpus/$target" artifacts
(cd .. && cargo dev seeds "$target" "fuzz/corpus/$target")
export FUZZ_TARGET="$target"
# shellcheck disable=SC2086 # options, in words
exec "${CARGO_TARGET_DIR:-target}/$host/release/any" "corpus/$target" $dictionary \
    -max_total_time="$seconds" -timeout=30 -rss_limit_mb=3000 -max_len=4096 -artifact_prefix=artifacts/ \
    -print_final_stats=1
