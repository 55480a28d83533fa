#!/bin/sh
# Parts of a cell beside MuJoCo from PyPI, in a virtual environment of its own, on scenes that no closed form describes.
#     benches/cell/run.sh [SCENE...]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
venv="$target/cell-venv"
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -c 'import mujoco' 2>/dev/null || "$venv/bin/pip" install --quiet numpy mujoco
exec "$venv/bin/python" "$here/mujoco_scenes.py" "${ELITESERVER:-$target/release/eliteserver}" "$@"
