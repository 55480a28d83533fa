#!/usr/bin/env bash
# Every test there is: format and lints, Rust unit, property, golden and system tests, documentation examples, the wheel.
# Needs a Rust toolchain, a C compiler and Python 3 (with its venv module); fetches everything else itself. With Node the page is
# tested as well, in Chromium where that is there or can be installed.
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

echo "== The page in the browser: types, lint, unit tests, and in Chromium what people do on it"
if ! command -v npm >/dev/null; then
    echo "there is no Node: the page was not tested"
elif ! { [ -d web/node_modules ] || npm --prefix web ci --no-audit --no-fund --ignore-scripts --silent; }; then
    echo "the packages of the page cannot be fetched: it was not tested"
else
    npm --prefix web test --silent
    if [ -z "${CHROMIUM:-}" ] && ! command -v chromium >/dev/null; then
        # Only where this may install something; elsewhere the tests say what is missing.
        [ "$(id -u)" -ne 0 ] || { apt-get update -qq && apt-get install -y -qq chromium >/dev/null; } || true
    fi
    if [ -n "${CHROMIUM:-}" ] || command -v chromium >/dev/null; then
        ELITESERVER="${CARGO_TARGET_DIR:-$PWD/target}/debug/eliteserver" npm --prefix web run browser --silent
    else
        echo "there is no Chromium: the page was not tried in a browser"
    fi
fi

echo "== The extension for VS Code: types, lint, grammar, contributions, both servers as the editor drives them, the package"
if ! command -v npm >/dev/null; then
    echo "there is no Node: the extension was not tested"
elif ! { [ -d editors/vscode/node_modules ] || npm --prefix editors/vscode ci --no-audit --no-fund --ignore-scripts --silent; }; then
    echo "the packages of the extension cannot be fetched: it was not tested"
else
    ELITESERVER="${CARGO_TARGET_DIR:-$PWD/target}/debug/eliteserver" npm --prefix editors/vscode test --silent
fi

echo "== Python wheel, without optimisation: that takes a release build of everything"
python3 crates/pybind/test.py --debug
