#!/usr/bin/env bash
# The test command: format and lints, Rust unit, property, golden and system tests, documentation examples, the campaign, the page,
# the wheel. Needs a Rust toolchain, a C compiler and Python 3 (with its venv module); fetches everything else itself. With Node the
# page is tested as well, in Chromium where that is there or can be installed.
#
#     ./test.sh          what a change must pass on the way
#     ./test.sh --all    with the long ones: how the language's natives grow with their data, the wheel with clusters, type
#                        checkers and pictures; the book; versions that were withdrawn. .ci/run does this
set -euo pipefail
cd "$(dirname "$0")"
all=0
case "${1:-}" in
"") ;;
--all) all=1 ;;
*)
    echo "test.sh: what is '$1'? There is --all" >&2
    exit 2
    ;;
esac
target="${CARGO_TARGET_DIR:-target}"
mkdir -p "$target"
target="$(cd "$target" && pwd)"

# How long each part took, told at the end however that comes.
parts=()
part=
began="$SECONDS"
start() {
    [ -z "$part" ] || parts+=("$(printf '%5d s  %s' $((SECONDS - began)) "$part")")
    part="$1" began="$SECONDS"
    [ -z "$1" ] || echo "== $1"
}
told() {
    start ""
    printf '%s\n' "" "seconds by part, $SECONDS in all:" "${parts[@]}"
}
trap told EXIT

start "format and lints"
cargo fmt --all --check
cargo clippy --all-targets --quiet -- --deny warnings

# One set of features for everything that follows: the programs that tests start (eliteserver, dev) are built with them, and the
# campaign, the peers and the page take these. A bare `cargo build` would compile all our crates once more.
if cargo nextest --version >/dev/null 2>&1; then
    profile=default
    [ "$all" = 0 ] || profile=all
    if [ "$all" = 1 ] && [ "$(id -u)" -eq 0 ] && ! command -v nvim >/dev/null; then
        # One test starts this editor with the lines of docs/editors.md; without it that test looks at the lines only.
        { apt-get update -qq && apt-get install -y -qq neovim >/dev/null; } || true
    fi
    start "Rust tests: build"
    # The examples are compiled by the lints only.
    cargo nextest run --tests --no-run --cargo-quiet
    start "Rust tests"
    failed=0
    cargo nextest run --tests --profile "$profile" --no-fail-fast --hide-progress-bar --status-level retry || failed=$?
    # nextest keeps its reports in the workspace, wherever cargo builds.
    python3 tests/test_report.py "target/nextest/$profile/report.xml"
    [ "$failed" -eq 0 ] || exit "$failed"
    start "documentation examples"
    cargo test --doc --quiet
else
    start "Rust tests, without nextest"
    cargo test --quiet --no-fail-fast
fi
export ELITESERVER="$target/debug/eliteserver"

start "campaign: every decoder, the evaluator and its generators, then faults around the controller; bounded, a line each"
seconds=2
[ "$all" = 0 ] || seconds=5
"$target/debug/dev" campaign --seconds "$seconds" --seed 1 --binary "$ELITESERVER"

start "field buses, sockets and remote calls against peers from PyPI"
tests/peers/run.sh

start "the page in the browser: types, lint, unit tests, and in Chromium what people do on it"
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
        npm --prefix web run browser --silent
    else
        echo "there is no Chromium: the page was not tried in a browser"
    fi
fi

start "the extension for VS Code: types, lint, grammar, contributions, both servers as the editor drives them, the package"
if ! command -v npm >/dev/null; then
    echo "there is no Node: the extension was not tested"
elif ! { [ -d editors/vscode/node_modules ] || npm --prefix editors/vscode ci --no-audit --no-fund --ignore-scripts --silent; }; then
    echo "the packages of the extension cannot be fetched: it was not tested"
else
    npm --prefix editors/vscode test --silent
fi

start "Python wheel, without optimisation: that takes a release build of everything"
if [ "$all" = 1 ]; then
    python3 crates/pybind/test.py --debug
else
    python3 crates/pybind/test.py --debug --quick
fi

if [ "$all" = 1 ]; then
    start "the book of docs/, its links"
    packaging/book.sh
    start "what registries say of the versions in the lock files"
    packaging/audit.py
fi
