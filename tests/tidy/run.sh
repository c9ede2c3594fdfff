#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# clang-tidy (.clang-tidy) over host/ and, with it, the kernels that the device's files include:
# run.sh [FILE...] The marches are the same templates eight times: two of them, one of each loop,
# stand for all.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v clang-tidy > /dev/null || { echo "clang-tidy is not here: apt-get install clang-tidy"; exit 1; }
started=$SECONDS
database=build/tidy
cmake --preset release -B $database -DRA2D_BY_FOLDER=OFF -DRA2D_TESTS=OFF -DRA2D_BENCH=OFF > /dev/null
# without the precompiled headers, which are the other compiler's
sed -i -E 's/-Winvalid-pch -include [^ ]*cmake_pch\.hxx//' $database/compile_commands.json
files=("$@")
if ((${#files[@]} == 0)); then
  mapfile -t files < <(git ls-files 'host/*.cpp')
  files+=($database/host/generated/march_{implicit,adaptive}_few.cpp)
fi
status=0
printf '%s\n' "${files[@]}" |
  xargs -P "$(nproc)" -I{} clang-tidy -p $database --quiet {} 2> $database/stderr || status=1
# each file's count of what was suppressed in headers of others, and nothing else, is no message
grep -vE '^[0-9]+ (warning|error)s?( and [0-9]+ errors?)? generated\.$|^$' $database/stderr || true
echo "${#files[@]} files in $((SECONDS - started)) s"
exit $status
