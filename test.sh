#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# ./test.sh [ctest options]: installs what is missing, builds everything and runs every test.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$root/cmake/house.sh"
cd "$root"

need run test
quietly configure cmake --preset release -DRA2D_TESTS=ON -DRA2D_BENCH=ON
quietly build cmake --build --preset release
ctest --preset release --parallel "$(nproc)" "$@"
