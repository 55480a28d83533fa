#!/usr/bin/env bash
# Every test there is: format and lints, Rust unit, property, golden and system tests, documentation examples, the wheel.
# Needs a Rust toolchain, a C compiler and Python 3 (with its venv module); fetches everything else itself.
set -euo pipefail
cd "$(dirname "$0")"

echo "== format and lints"
cargo fmt --all --check
cargo clippy --all-targets --quiet -- --deny warnings

echo "== Rust tests"
if cargo nextest --version >/dev/null 2>&1; then
    failed=0
    cargo nextest run --no-fail-fast --hide-progress-bar --status-level retry || failed=$?
    python3 tests/second_tries.py "${CARGO_TARGET_DIR:-target}/nextest/default/report.xml"
    [ "$failed" -eq 0 ] || exit "$failed"
    cargo test --doc --quiet
else
    cargo test --quiet --no-fail-fast
fi

echo "== Campaign: every decoder, the evaluator and its generators, then faults around the controller; bounded, a line each"
cargo build --quiet
"${CARGO_TARGET_DIR:-target}/debug/dev" campaign --seconds 5 --seed 1 --binary "${CARGO_TARGET_DIR:-target}/debug/eliteserver"

echo "== The border between threads, every interleaving"
target="${CARGO_TARGET_DIR:-target}"
CARGO_TARGET_DIR="$target/loom" RUSTFLAGS="--cfg elite_loom" cargo test --quiet --package motion-api --lib

echo "== Field buses, sockets and remote calls against peers from PyPI"
tests/peers/run.sh

echo "== Python wheel, without optimisation: that takes a release build of everything"
python3 crates/pybind/test.py --debug
