#!/usr/bin/env bash
# The test command: format and lints, Rust unit, property, golden and system tests, documentation examples, the campaign, the page,
# the wheel. Needs a Rust toolchain, a C compiler and Python 3 (with its venv module); fetches everything else itself. With Node the
# page is tested as well, in Chromium where that is there or can be installed.
#
#     ./test.sh          what a change must pass on the way
#     ./test.sh --all    with the long ones: how the language's natives grow with their data, the wheel with clusters, type
#                        checkers and pictures; lints of examples; the book; versions that were withdrawn. .ci/run does this
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
# beside NAME COMMAND...: runs it beside what follows; `with NAME` waits for it, shows what it has printed and ends with it if it failed.
declare -A running
beside() {
    local name="$1"
    shift
    ("$@") >"$target/test-$name.log" 2>&1 &
    running[$name]=$!
}
with() {
    local failed=0
    wait "${running[$1]}" || failed=$?
    unset "running[$1]"
    cat "$target/test-$1.log"
    [ "$failed" -eq 0 ] || exit "$failed"
}
told() {
    [ ${#running[@]} -eq 0 ] || kill "${running[@]}" 2>/dev/null || true
    start ""
    printf '%s\n' "" "seconds by part, $SECONDS in all:" "${parts[@]}"
}
trap told EXIT

# What the parts after the Rust tests need from elsewhere; each of them says what is missing.
fetch() {
    local packages=()
    # Only where this may install something. One test starts the editor nvim with the lines of docs/editors.md; without it that test
    # looks at the lines only.
    if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
        [ "$all" = 0 ] || command -v nvim >/dev/null || packages+=(neovim)
        ! command -v npm >/dev/null || [ -n "${CHROMIUM:-}" ] || command -v chromium >/dev/null || packages+=(chromium)
        [ ${#packages[@]} -eq 0 ] || { apt-get update -qq && apt-get install -y -qq "${packages[@]}" >/dev/null; } || true
    fi
    command -v npm >/dev/null || return 0
    local folder
    for folder in web editors/vscode; do
        [ -d "$folder/node_modules" ] || npm --prefix "$folder" ci --no-audit --no-fund --ignore-scripts --silent || true
    done
}
page() {
    if ! command -v npm >/dev/null; then
        echo "there is no Node: the page was not tested"
    elif [ ! -d web/node_modules ]; then
        echo "the packages of the page cannot be fetched: it was not tested"
    else
        npm --prefix web test --silent
        if [ -n "${CHROMIUM:-}" ] || command -v chromium >/dev/null; then
            npm --prefix web run browser --silent
        else
            echo "there is no Chromium: the page was not tried in a browser"
        fi
    fi
}
extension() {
    if ! command -v npm >/dev/null; then
        echo "there is no Node: the extension was not tested"
    elif [ ! -d editors/vscode/node_modules ]; then
        echo "the packages of the extension cannot be fetched: it was not tested"
    else
        npm --prefix editors/vscode test --silent
    fi
}
examples() {
    # Without nextest they have been among the tests.
    ! cargo nextest --version >/dev/null 2>&1 || cargo test --workspace --doc --quiet
}
campaign() {
    local seconds=2
    [ "$all" = 0 ] || seconds=5
    "$target/debug/dev" campaign --seconds "$seconds" --seed 1 --no-faults
}

beside fetch fetch
start "format"
cargo fmt --all --check

# Lints come with the compiler that makes the tests: everything that follows is compiled by Clippy's, once, instead of being looked at by
# `cargo clippy` first and compiled by rustc after. It makes the same programs; a warning ends the build. (`cargo clippy` hands its
# arguments to it in this variable, too.)
export RUSTC_WORKSPACE_WRAPPER=clippy-driver
export CLIPPY_ARGS=--deny__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__

# One set of features for everything that follows: the programs that tests start (eliteserver, dev) are built with them, and the
# campaign, the peers and the page take these. A bare `cargo build` would compile all our crates once more.
if cargo nextest --version >/dev/null 2>&1; then
    profile=default
    [ "$all" = 0 ] || profile=all
    start "Rust tests: lints and build"
    cargo nextest run --workspace --tests --no-run --cargo-quiet
    with fetch
    start "Rust tests"
    failed=0
    # One more than there are cores: those that talk in real time, one at a time, mostly wait.
    cargo nextest run --workspace --tests --test-threads "$(($(nproc) + 1))" --profile "$profile" --no-fail-fast --hide-progress-bar --status-level retry || failed=$?
    # nextest keeps its reports in the workspace, wherever cargo builds.
    python3 tests/test_report.py "target/nextest/$profile/report.xml"
    [ "$failed" -eq 0 ] || exit "$failed"
else
    with fetch
    start "Rust tests, without nextest"
    cargo test --workspace --quiet --no-fail-fast
fi
export ELITESERVER="$target/debug/eliteserver"

# These compute, on one core; beside them comes what mostly waits: for peers, a browser, an editor.
computing() {
    echo "-- documentation examples"
    examples
    echo "-- campaign: every decoder, the evaluator and its generators; bounded, a line each"
    campaign
}
beside computing computing
start "field buses, sockets and remote calls against peers from PyPI; beside it documentation examples, the campaign"
tests/peers/run.sh
start "the page in the browser: types, lint, unit tests, and in Chromium what people do on it"
page
start "the extension for VS Code: types, lint, grammar, contributions, both servers as the editor drives them, the package"
extension
start "what is left of documentation examples and campaign"
with computing
# With promises about time, so alone.
start "faults around the controller: killed, the disk full or slow, nobody who reads, stopped in every state"
python3 fuzz/faults.py "$ELITESERVER" --seed 1

start "the Python module, without optimisation: with it everything would be built once more"
if [ "$all" = 1 ]; then
    python3 crates/pybind/test.py --debug
else
    # With the features of all crates it is made of what is compiled already; maturin, which builds the wheel, knows those of one crate.
    cargo build --quiet --workspace --lib --tests
    python3 crates/pybind/test.py --library="$target/debug/lib_elitescript.so" --quick
fi

if [ "$all" = 1 ]; then
    # Nothing runs these here, so they are only looked at.
    start "lints of examples and benchmarks"
    cargo check --workspace --quiet --examples --benches
    start "the book of docs/, its links"
    packaging/book.sh
    start "what registries say of the versions in the lock files"
    packaging/audit.py
fi
