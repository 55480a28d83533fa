#!/usr/bin/env bash
# Builds the book of docs/ into target/book and looks whether each of its links leads somewhere. Needs Python 3; mdbook
# comes from crates.io, built once into target, where it is not installed.
set -euo pipefail
cd "$(dirname "$0")/.."
version=0.5.4
target="${CARGO_TARGET_DIR:-target}"
mkdir -p "$target"
target="$(cd "$target" && pwd)"
export PATH="$target/tools/bin:$PATH"
if ! mdbook --version 2>/dev/null | grep -q "v${version%.*}\."; then
    # Quick to build: it runs for seconds.
    CARGO_TARGET_DIR="$target/tools/build" CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_LTO=off \
        cargo install mdbook --version "$version" --locked --no-default-features --features search --quiet \
            --root "$target/tools"
    rm -rf "$target/tools/build"
fi
book="$target/book"
rm -rf "$book"
# A warning of mdbook is a page that is not as it was meant.
log="$(mdbook build --dest-dir "$book" 2>&1)" || { echo "$log" >&2; exit 1; }
if grep -qE "WARN|ERROR" <<<"$log"; then
    echo "$log" >&2
    exit 1
fi
python3 packaging/book.py check "$book"
