#!/usr/bin/env bash
# Durations of random movej against PyPI `ruckig`, in the virtual environment of the other peers.
# ELITE_PROGRAMS is the number of programs an arm, 12 unless it is set.
set -euo pipefail
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="$target/peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
fi
"$venv/bin/pip" install --quiet --disable-pip-version-check "ruckig==0.19.4"
table="$(mktemp)"
trap 'rm -f "$table"' EXIT
ELITE_DURATIONS="$table" cargo test --quiet --package motion --test random_programs -- --nocapture
"$venv/bin/python" tests/peers/movej_oracle.py "$table"
