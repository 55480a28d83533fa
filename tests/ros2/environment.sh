#!/usr/bin/env bash
# A real ROS 2 Jazzy for Python from PyPI alone: rclpy with Fast DDS, and type support for the packages that have no
# wheel. Takes some minutes the first time, 330 MB; kept in target/. Prints nothing when it is there.
# usage: environment.sh FOLDER      afterwards FOLDER/python is the interpreter with everything set
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
mkdir -p "$1"
venv="$(cd "$1" && pwd)"
[ -x "$venv/python" ] && exit 0
python=""
for candidate in python3.12 "$HOME"/.pyenv/versions/3.12*/bin/python3.12; do
    if "$candidate" -c 'import sys; raise SystemExit(sys.version_info[:2] != (3, 12))' 2>/dev/null; then
        python="$candidate"
        break
    fi
done
if [ -z "$python" ]; then
    echo "ROS 2 from PyPI needs Python 3.12 with its headers, and there is none" >&2
    exit 3
fi
"$python" -m venv "$venv"
export PATH="$venv/bin:$PATH"
pip install --quiet --disable-pip-version-check 'ros-jazzy-rclpy[fastrtps]' \
    ros-jazzy-{sensor-msgs,trajectory-msgs,std-srvs,geometry-msgs,test-msgs,rosgraph-msgs,visualization-msgs} \
    ros-jazzy-{rosidl-default-generators,rosidl-core-generators,ament-cmake,ament-cmake-ros,ament-package} \
    ros-jazzy-{python-cmake-module,ament-cmake-include-directories,ament-cmake-gmock,ament-cmake-gtest} \
    ros-jazzy-{ament-cmake-pytest,ament-cmake-export-interfaces} \
    catkin_pkg numpy setuptools cmake pytest rosbags mcap mcap-ros2-support
include="$(python -c 'import sysconfig; print(sysconfig.get_path("include"))')"
numpy="$(python -c 'import numpy; print(numpy.get_include())')"
site="$venv/lib/python3.12/site-packages"
# The wheels were made elsewhere and remember where; in a folder that an interrupted run has
# left they may know better already.
{ grep -rl /opt/python/cp312-cp312 "$venv"/share/*/cmake/*.cmake || true; } | xargs -r sed -i \
    -e "s#/opt/python/cp312-cp312/include/python3.12#$include#g" \
    -e "s#/opt/python/cp312-cp312/lib/python3.12/site-packages/numpy/_core/include#$numpy#g"
libraries="$venv/lib:$(find "$site" -maxdepth 1 -name 'ros_*.libs' | tr '\n' ':')"
export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1 AMENT_PREFIX_PATH="$venv" CMAKE_PREFIX_PATH="$venv" PYTHONPATH="$site"
export LD_LIBRARY_PATH="$libraries"
python "$here/interfaces.py" "$venv/interfaces"
for package in tf2_msgs control_msgs eli_common_interface; do
    build="$venv/build_$package"
    cmake -S "$venv/interfaces/$package" -B "$build" -DCMAKE_INSTALL_PREFIX="$venv" -DBUILD_TESTING=OFF \
        -DPython3_EXECUTABLE="$venv/bin/python" -DPYTHON_EXECUTABLE="$venv/bin/python" >"$build.log" 2>&1
    cmake --build "$build" -j1 >>"$build.log" 2>&1
    cmake --install "$build" >>"$build.log" 2>&1
done
cat >"$venv/python" <<PYTHON
#!/usr/bin/env bash
export AMENT_PREFIX_PATH="$venv" PYTHONPATH="$site" LD_LIBRARY_PATH="$libraries"
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
exec "$venv/bin/python" "\$@"
PYTHON
chmod +x "$venv/python"
