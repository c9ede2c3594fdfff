#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# ./test.sh [--all | --long] [ctest options]: installs what is missing, builds the program with its
# tests, runs them.
# --all: also the benchmarks and the tests that take longest: comparison with CVODE and
#        Boost.Odeint, the lanes of a GPU's warp on a CPU, the interpreter of PTX, kills, damaged
#        files, a full disk, Slurm, the package, the Python types.
# --long: also draws random cases four times as often, and tries the bundle in a bare system.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/house.sh"
cd "$root"

purposes=(run test)
all=OFF long=
if [[ ${1-} == --all || ${1-} == --long ]]; then
  all=ON
  if [[ $1 == --long ]]; then
    long=1
    export RA2D_TEST_LONG=1
    purposes+=(long)
  fi
  shift
fi
need "${purposes[@]}"
quietly configure cmake --preset release -DRA2D_TESTS=ON -DRA2D_BENCH=$all -DRA2D_ALL_TESTS=$all
quietly build cmake --build --preset release
run_tests release "$@"
if [[ $long ]]; then
  quietly bundle cmake --build --preset release --target bundle
  tests/bundle/inspect.sh build/release/bundle
  tests/bundle/bare.sh build/release/bundle
fi
