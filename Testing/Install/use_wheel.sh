#!/bin/sh
# Installs a wheel with pip in an empty environment, and uses it beside whatever else this Python has. Usage:
#   use_wheel.sh WHEEL [PYTHON]
# Nothing is downloaded: NumPy is the system's. Testing/Systems/on_debian.sh brings it to other releases.
set -eu
[ $# -ge 1 ] || {
  sed -n '2,4p' "$0" | sed 's/^# \{0,1\}//'
  exit 2
}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${2:-python3}" -m venv --system-site-packages "$folder/venv"
"$folder/venv/bin/pip" install -q --no-index --no-deps "$1"
"$folder/venv/bin/python" -B "$(dirname "$0")/use_wheel.py"
"$folder/venv/bin/pip" uninstall -q -y scalable-isosurface
[ -z "$(find "$folder/venv" -name '*scalable_isosurface*')" ] || {
  echo "use_wheel.sh: uninstalling leaves files" >&2
  exit 1
}
