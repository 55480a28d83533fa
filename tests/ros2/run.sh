#!/usr/bin/env bash
# The node against real ROS 2 (rclpy with Fast DDS, from PyPI), on the loopback interface.
# ELITESERVER names a binary with the feature ros2; without it one is built, in a folder of its own because others use
# the one without.
# usage: run.sh [ARGUMENT OF PYTEST…]      without arguments all tests
set -euo pipefail
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
status=0
timeout 1200 tests/ros2/environment.sh "$target/ros2-venv" || status=$?
if [ "$status" != 0 ]; then
    echo "not tried: the node against rclpy, which could not be installed here"
    exit 0
fi
if [ -z "${ELITESERVER:-}" ]; then
    CARGO_TARGET_DIR="$target/ros2" cargo build --quiet --package server --features ros2
    ELITESERVER="$(cd "$target" && pwd)/ros2/debug/eliteserver"
fi
export ELITESERVER
[ $# -gt 0 ] || set -- tests/ros2
# Discovery takes as long as the machine is busy: what fails is tried once more.
"$target/ros2-venv/python" -m pytest -q -o cache_dir="$target/ros2-cache" "$@" ||
    exec "$target/ros2-venv/python" -m pytest -q -o cache_dir="$target/ros2-cache" --last-failed "$@"
