#!/usr/bin/env bash
# The node against real ROS 2 (rclpy with Fast DDS, from PyPI), on the loopback interface.
# ELITESERVER names a binary with the feature ros2; without it the debug build is used, and built first.
set -euo pipefail
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
status=0
tests/ros2/environment.sh "$target/ros2-venv" || status=$?
if [ "$status" = 3 ]; then
    echo "not tried: the node against rclpy"
    exit 0
fi
[ "$status" = 0 ] || exit "$status"
if [ -z "${ELITESERVER:-}" ]; then
    cargo build --quiet --package server --features ros2
    ELITESERVER="$(cd "$target" && pwd)/debug/eliteserver"
fi
export ELITESERVER
exec "$target/ros2-venv/python" -m pytest -q -p no:cacheprovider tests/ros2 "$@"
