#!/usr/bin/env bash
# Field buses, sockets and remote calls against peers from PyPI, in a virtual environment under target/.
# ELITESERVER names the binary; without it the debug build is used, and built first.
set -euo pipefail
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="$target/peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
fi
"$venv/bin/pip" install --quiet --disable-pip-version-check \
    "pymodbus==3.8.6" "pyserial==3.5" "websockets==17.4" "protobuf==7.36.2" "prometheus_client==0.26.0" \
    "mcap==1.6.0" "mcap-protobuf-support==0.6.0" "mcp==2.3.0" "kubernetes-validate==1.37.0"
if [ -z "${ELITESERVER:-}" ]; then
    cargo build --quiet --package server
    ELITESERVER="$(cd "$target" && pwd)/debug/eliteserver"
fi
export ELITESERVER
exec "$venv/bin/python" -m unittest discover --start-directory tests/peers "$@"
