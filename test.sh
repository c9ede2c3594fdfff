#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# ./test.sh [--long] [ctest options]: installs what is missing, builds everything and runs every test.
# --long: random cases are drawn four times as often, and the bundle is tried in a bare system.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/house.sh"
cd "$root"

purposes=(run test)
long=
if [[ ${1-} == --long ]]; then
  shift
  long=1
  export RA2D_TEST_LONG=1
  purposes+=(long)
fi
need "${purposes[@]}"
quietly configure cmake --preset release -DRA2D_TESTS=ON -DRA2D_BENCH=ON
quietly build cmake --build --preset release
run_tests release "$@"
if [[ $long ]]; then
  quietly bundle cmake --build --preset release --target bundle
  tests/bundle/inspect.sh build/release/bundle
  tests/bundle/bare.sh build/release/bundle
fi
