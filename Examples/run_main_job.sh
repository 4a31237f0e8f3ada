#!/bin/sh
# Runs the main job with the plugin of a build: run_main_job.sh BUILD_FOLDER OUTPUT_FOLDER [RANKS]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
mkdir -p "$2"
output=$(cd "$2" && pwd)
ranks=${3:-2}

# Open MPI asks for both in containers, where everybody is root.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
plugin=$(find "$build" -name ScalableIsosurface.so | head -n 1)
if [ -z "$plugin" ]; then
  echo "$build: there is no ScalableIsosurface.so; build the project with ParaView first" >&2
  exit 1
fi
exec xvfb-run -a -s "-noreset" mpirun --oversubscribe -n "$ranks" \
  pvbatch "$here/main_job.py" --plugin "$plugin" --output "$output"
