#!/usr/bin/env bash
# Has the compiler check the program and the Python module for other systems than Linux. Nothing is linked or run.
#
#     packaging/platforms.sh [TARGET]...        x86_64-pc-windows-gnu, aarch64-apple-darwin
#
# Needs Rust and Python 3 with venv; the C compiler for every target is zig, from PyPI. The standard library of a target
# comes from `rustup target add TARGET`. Where that is not to be had, RUST_LIBRARY names the folder `library` of the
# sources of exactly this compiler (packaging/rust-src.sh fetches them on Debian).
set -euo pipefail
cd "$(dirname "$0")/.."

targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(x86_64-pc-windows-gnu aarch64-apple-darwin)
target="${CARGO_TARGET_DIR:-$PWD/target}"
mkdir -p "$target"
target="$(cd "$target" && pwd)"

tools="$target/packaging-venv"
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check ziglang==0.17.1 cargo-zigbuild==0.24.1
export PATH="$tools/bin:$PATH" CARGO_TARGET_DIR="$target/platforms"

sysroot="$(rustc --print sysroot)"
for triple in "${targets[@]}"; do
    library=()
    if [ ! -d "$sysroot/lib/rustlib/$triple/lib" ]; then
        if [ ! -f "${RUST_LIBRARY:-}/std/Cargo.toml" ]; then
            echo "packaging/platforms.sh: the standard library of $triple is not there." \
                "'rustup target add $triple' installs it;" \
                "or RUST_LIBRARY=FOLDER names its sources (packaging/rust-src.sh fetches them)" >&2
            exit 1
        fi
        export RUSTC_BOOTSTRAP=1 __CARGO_TESTS_ONLY_SRC_ROOT="$RUST_LIBRARY"
        library=(-Zbuild-std=std,panic_unwind)
    fi
    # One set of features, as everywhere; the module needs no Python of the target to be checked.
    echo "== $triple"
    RUSTFLAGS="--deny warnings" PYO3_NO_PYTHON=1 cargo-zigbuild check --quiet --locked "${library[@]}" \
        --target "$triple" \
        --package server --package pybind
done
echo "the program and the Python module compile for ${targets[*]}"
