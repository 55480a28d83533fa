#!/usr/bin/env bash
# The test command: format and lints, Rust unit, property, golden and system tests, documentation examples, faults, the
# page, the Python module. Needs a Rust toolchain, a C compiler and Python 3 (with its venv module); fetches everything
# else itself. With Node the page is tested as well, in Chromium where that is there or can be installed.
#
#     ./test.sh          what a change must pass on the way
#     ./test.sh --all    with the long ones: how the language's natives grow with their data, the campaign, the wheel
#                        with clusters, checkers of types and form, and pictures; lints of examples; the book; versions
#                        that were withdrawn. .ci/run does this
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

# Whatever runs beside this, by name; all of it ends when this does.
declare -A running
# part NAME COMMAND...: what it took, by the clock and of the processor, is told at the end however that comes. One that
# fails ends everything; in a row what follows does not need it and comes all the same.
took="$target/test-took"
: >"$took"
rm -f "$took-failed"
part() {
    local name="$1" began="$SECONDS" status=0
    shift
    echo "== $name"
    # A group of processes of its own, but in a row, which is one already.
    [ "$BASHPID" != "$$" ] || set -m
    # Behind `&` and `wait`, `set -e` holds inside of functions as well, which it does not before `||`.
    (
        set -e
        trap 'times >"$took.$BASHPID"' EXIT
        "$@"
    ) </dev/null &
    set +m
    running[part]=$!
    wait "${running[part]}" || status=$?
    local processor
    processor="$(awk '{ gsub("s", ""); for (k = 1; k <= 2; k++) { split($k, t, "m"); sum += 60 * t[1] + t[2] } }
        END { printf "%.0f", sum }' "$took.${running[part]}")"
    rm -f "$took.${running[part]}"
    unset "running[part]"
    printf '%5d s, %5d s of the processor  %s%s\n' $((SECONDS - began)) "$processor" "$name" \
        "$([ "$status" -eq 0 ] || echo ': FAILED')" >>"$took"
    [ "$BASHPID" != "$$" ] || return "$status"
    [ "$status" -eq 0 ] || : >"$took-failed"
}
# beside NAME COMMAND...: runs it beside what follows; `with NAME` waits for it, shows what it has printed, and
# remembers if it failed.
failed=0
beside() {
    local name="$1"
    shift
    set -m
    (
        set -e
        "$@"
    ) </dev/null >"$target/test-$name.log" 2>&1 &
    set +m
    running[$name]=$!
}
with() {
    wait "${running[$1]}" || failed=1
    unset "running[$1]"
    cat "$target/test-$1.log"
}
told() {
    local job
    for job in "${running[@]}"; do kill -- "-$job" 2>/dev/null || true; done
    printf '\n'
    cat "$took"
    echo "$SECONDS s in all"
}
trap told EXIT

# What the parts after the Rust tests need from elsewhere; each of them says what is missing.
fetch() {
    local packages=()
    # Only where this may install something. One test starts the editor nvim with the lines of docs/editors.md; without
    # it that test looks at the lines only.
    if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
        [ "$all" = 0 ] || command -v nvim >/dev/null || packages+=(neovim)
        ! command -v npm >/dev/null || [ -n "${CHROMIUM:-}" ] || command -v chromium >/dev/null || packages+=(chromium)
        [ ${#packages[@]} -eq 0 ] || { apt-get update -qq && apt-get install -y -qq "${packages[@]}" >/dev/null; } \
            || true
    fi
    command -v npm >/dev/null || return 0
    local folder
    for folder in web editors/vscode; do
        [ -d "$folder/node_modules" ] || npm --prefix "$folder" ci --no-audit --no-fund --ignore-scripts --silent \
            || true
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
module() {
    if [ "$all" = 1 ]; then
        python3 crates/pybind/test.py --debug
    else
        # maturin, which builds the wheel, knows the features of one crate, and would build everything once more.
        python3 crates/pybind/test.py --library="$target/debug/lib_elitescript.so" --quick
    fi
}
campaign() {
    "$target/debug/dev" campaign --seconds 5 --seed 1 --no-faults
}

rust_tests() {
    local profile="$1" status=0
    shift
    cargo nextest run --workspace --tests --profile "$profile" "$@" --no-fail-fast --hide-progress-bar \
        --status-level retry || status=$?
    # nextest keeps its reports in the workspace, wherever cargo builds.
    python3 tests/test_report.py "target/nextest/$profile/report.xml"
    return "$status"
}
# Three rows of work, side by side. First wherever the machine has to choose goes what talks, in real time and with
# promises about time: it mostly waits. What computes takes what is left (`renice`).
TALKING='package(/^(server|controller|io-bus|recorder|robot-client|supervision)$/)
    | (package(dev) & binary(docs))
    | (package(motion) & test(/^clocks::/))'
talking() {
    local which=()
    [ "$all" = 0 ] || which=(--ignore-default-filter)
    [ "$nextest" = 0 ] || part "Rust tests that talk" rust_tests talking "${which[@]}" -E "$TALKING" --test-threads 3
    part "the page: types, lint, unit tests, and in Chromium what people do on it" page
}
visiting() {
    part "faults around the controller: killed, the disk full or slow, nobody who reads, stopped in every state" \
        python3 fuzz/faults.py "$ELITESERVER" --seed 1
    part "field buses, sockets and remote calls against peers from PyPI" tests/peers/run.sh
    part "the extension for VS Code: types, lint, grammar, contributions, both servers as the editor drives them, "\
"the package" extension
    renice -n 5 -p "$BASHPID" >/dev/null
    part "the Python module, without optimisation" module
    if [ "$all" = 1 ]; then
        # All of them: tests/ros2/run.sh by itself.
        part "the node against real ROS 2: topics and services" env -u ELITESERVER tests/ros2/run.sh \
            tests/ros2/test_topics.py
        part "the book of docs/, its links" packaging/book.sh
        part "what registries say of the versions in the lock files" packaging/audit.py
    fi
}
computing() {
    renice -n 5 -p "$BASHPID" >/dev/null
    local profile=default
    [ "$all" = 0 ] || profile=all
    if [ "$nextest" = 1 ]; then
        part "Rust tests that compute" rust_tests "$profile" -E "not ($TALKING)" --test-threads "$(nproc)"
        part "documentation examples" cargo test --workspace --doc --quiet
    fi
    # Those of examples/testing and examples/reference are run by tests; this one checks the programs in cells.
    part "programs of examples/cells" "$ELITESERVER" test examples/cells
    # On the way a bounded number of the campaign's cases is among the tests (dev::cases).
    if [ "$all" = 1 ]; then
        part "campaign: every decoder, the evaluator and its generators; bounded, a line each" campaign
        # Nothing runs these here, so they are only looked at.
        part "lints of examples and benchmarks" cargo check --workspace --quiet --examples --benches
    fi
}

beside fetch fetch
part "format" cargo fmt --all --check

# Lints come with the compiler that makes the tests: everything that follows is compiled by Clippy's, once, instead of
# being looked at by `cargo clippy` first and compiled by rustc after. It makes the same programs; a warning ends the
# build. (`cargo clippy` hands its arguments to it in this variable, too.)
export RUSTC_WORKSPACE_WRAPPER=clippy-driver
export CLIPPY_ARGS=--deny__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__
# What a next compilation could take up is a sixth of the work of this one, and two gigabytes.
export CARGO_INCREMENTAL=0
# Panics tell file and line without line tables.
export CARGO_PROFILE_DEV_DEBUG=false
export ELITESERVER="$target/debug/eliteserver"

# One set of features for everything: the programs that tests start (eliteserver, dev) and the Python module are built
# with those of all crates, and the campaign, the peers and the page take these. A bare `cargo build` would compile all
# our crates once more.
part "lints and build" cargo build --workspace --lib --tests --quiet
with fetch
# Without nextest all tests are one row, and nothing is beside it.
nextest=1
cargo nextest --version >/dev/null 2>&1 || nextest=0
[ "$nextest" = 1 ] || part "Rust tests, without nextest" cargo test --workspace --quiet --no-fail-fast
# With `--all` what talks has the machine for itself; a few minutes are less there than a promise about time that was
# not asked in vain.
together=("talking visiting computing")
[ "$all" = 0 ] || together=(talking "visiting computing")
for rows in "${together[@]}"; do
    for row in $rows; do beside "$row" "$row"; done
    for row in $rows; do with "$row"; done
done
[ ! -e "$took-failed" ] || failed=1
exit "$failed"
