#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# ./run.sh [SCENE.toml] [options]: installs what is missing, builds, and runs `ra2d run` on the
# scene. Options are those of `ra2d run`. Without a scene: the paper's, with the scheme `adaptive`
# instead of the paper's own.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/house.sh"

if [[ $# == 0 || $1 == -* ]]; then
  set -- "$root/scenes/dang2012.toml" --set time.scheme=adaptive "$@"
fi

need run
build=$root/build/release
if [[ ! -f $build/build.ninja ]]; then
  quietly configure cmake -S "$root" --preset release -DRA2D_TESTS=OFF -DRA2D_BENCH=OFF
fi
quietly build cmake --build "$build" --target ra2d
exec "$build/ra2d" run "$@"
