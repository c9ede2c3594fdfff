#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: tests/fuzz/run.sh SECONDS [text|sdf|x3p|checkpoint|ledger|study ...]
# Builds the fuzzers of the readers of profiles, checkpoints and studies with libFuzzer and the address and
# undefined-behaviour sanitizers, and runs each for so long. What ends one is left in build/fuzz. Status 1 if there is
# any, 0 also where no clang is. RA2D_FUZZ_SEED (default: 1) is where libFuzzer's draws begin, 0 for a place of its own
# each time: so the checks of one commit end in the same way twice, and whoever hunts can hunt elsewhere.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=${1:?usage: run.sh SECONDS [text|sdf|x3p|checkpoint|ledger|study ...]}
shift
targets=("${@:-}")
[[ $# -gt 0 ]] || targets=(text sdf x3p checkpoint ledger study)
build=$root/build/fuzz
mkdir -p "$build"
cd "$root"

clang=
for name in clang++ clang++-{20..14}; do
  command -v "$name" > /dev/null || continue
  if echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
    "$name" -x c++ -fsanitize=fuzzer,address,undefined - -o "$build/probe" 2> /dev/null; then
    clang=$name
    break
  fi
done
[[ -n $clang ]] || { echo "no clang with libFuzzer here (Debian: clang-14, libclang-rt-14-dev): left out"; exit 0; }

flags=(-std=c++20 -O1 -g -Wall -Wextra -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -I.)
# toml++ 3.3 shifts by more than a number has, and takes no notice of what comes of it
shifts() { grep -q 'toml.hpp\|reader.hpp' "$1" && echo -fno-sanitize=shift-exponent; return 0; }
objects=()
for source in host/{text,partial_file,output_file}.cpp host/device/saved_state.cpp host/store/sealed_file.cpp \
  host/run/checkpoint_bytes.cpp host/study/{ledger,study_file,study_folder,scene_key}.cpp \
  host/scene_file/reader.cpp host/scene/{scene,schemes}.cpp host/surface/{areal,md5,profile,profile_lines,profile_sdf,profile_text,profile_x3p,zip_archive}.cpp; do
  object=$build/$(basename "$source" .cpp).o
  objects+=("$object")
  [[ $object -nt $source && -z $(find host -name '*.hpp' -newer "$object") ]] ||
    "$clang" "${flags[@]}" $(shifts "$source") -c "$source" -o "$object"
done
rm -f "$build/readers.a"
ar rcs "$build/readers.a" "${objects[@]}"  # of which each takes what it needs

for target in "${targets[@]}"; do
  "$clang" "${flags[@]}" -fsanitize=fuzzer "tests/fuzz/fuzz_$target.cpp" "$build/readers.a" -o "$build/fuzz_$target" \
    -lfmt -lzip -lpugixml -lcrypto
  mkdir -p "$build/corpus_$target"  # what is found goes there, and not into the tree
  echo "fuzz_$target: $seconds s"
  if ! "$build/fuzz_$target" -seed="${RA2D_FUZZ_SEED:-1}" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=64 \
    -max_len=8192 -print_final_stats=1 -artifact_prefix="$build/$target-" "$build/corpus_$target" \
    "tests/fuzz/corpus/$target" > "$build/$target.log" 2>&1; then
    tail -n 60 "$build/$target.log"
    exit 1
  fi
  grep -E 'number_of_executed_units|peak_rss_mb' "$build/$target.log"
done
