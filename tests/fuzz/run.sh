#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: tests/fuzz/run.sh SECONDS [text|sdf|x3p|map|checkpoint|ledger|study ...] Builds the fuzzers
#        of the readers of profiles, maps, checkpoints and studies with libFuzzer and the address
#        and undefined-behaviour sanitizers, and runs each for so long. What ends one is left in
#        build/fuzz. Status 1 if there is any, 0 also where no clang is. RA2D_FUZZ_SEED (default: 1)
#        is where libFuzzer's draws begin, 0 for a place of its own each time: so the checks of one
#        commit end in the same way twice, and whoever hunts can hunt elsewhere.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
seconds=${1:?usage: run.sh SECONDS [text|sdf|x3p|map|checkpoint|ledger|study ...]}
shift
targets=("${@:-}")
[[ $# -gt 0 ]] || targets=(text sdf x3p map checkpoint ledger study)
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

# a use after a return is looked for only where it is asked for
export ASAN_OPTIONS=detect_stack_use_after_return=1
flags=(-std=c++20 -O1 -g -Wall -Wextra -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -I.)
# toml++ 3.3 shifts by more than a number has, and takes no notice of what comes of it
shifts() { grep -q 'toml.hpp\|reader.hpp' "$1" && echo -fno-sanitize=shift-exponent; return 0; }
# what runs beside this script does not hear a Ctrl-C
stop_all() { for pid in $(jobs -p); do pkill -P "$pid" || true; kill "$pid" || true; done 2> /dev/null; }
trap stop_all EXIT
trap 'exit 130' INT TERM
# COMMAND with each of the words, as many side by side as there are processors. Fails if any of them
# does.
side_by_side() {  # COMMAND WORD...
  local command=$1 failed=0 pids=() word pid
  for word in "${@:2}"; do
    while (($(jobs -rp | wc -l) >= $(nproc))); do wait -n || true; done
    "$command" "$word" &
    pids+=($!)
  done
  for pid in "${pids[@]}"; do wait "$pid" || failed=1; done
  return "$failed"
}

object_of() { echo "$build/$(basename "$1" .cpp).o"; }
compile() {
  local object
  object=$(object_of "$1")
  [[ $object -nt $1 && -z $(find host -name '*.hpp' -newer "$object") ]] ||
    "$clang" "${flags[@]}" $(shifts "$1") -c "$1" -o "$object"
}
sources=(host/base/{text,hash,units}.cpp host/system/{input_file,machine_memory,partial_file,output_file}.cpp host/device/saved_state.cpp host/store/sealed_file.cpp
  host/run/checkpoint_bytes.cpp host/study/{ledger,study_file,study_folder,scene_key}.cpp
  host/scene_file/{reader,key_facts,key_table}.cpp host/scene/{scene,schemes}.cpp host/surface/{areal,form,height_map,map_file,map_npy,map_text,md5,profile,profile_lines,profile_sdf,profile_text,profile_x3p,repeated_place,text_dialect,zip_archive}.cpp)
side_by_side compile "${sources[@]}"
rm -f "$build/readers.a"
for source in "${sources[@]}"; do object_of "$source"; done | xargs ar rcs "$build/readers.a"  # each takes what it needs

fuzz() {
  local target=$1
  "$clang" "${flags[@]}" -fsanitize=fuzzer "tests/fuzz/fuzz_$target.cpp" "$build/readers.a" -o "$build/fuzz_$target" \
    -lfmt -lzip -lpugixml -lcrypto
  mkdir -p "$build/corpus_$target"  # what is found goes there, and not into the tree
  if ! "$build/fuzz_$target" -seed="${RA2D_FUZZ_SEED:-1}" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=64 \
    -max_len=8192 -print_final_stats=1 -artifact_prefix="$build/$target-" "$build/corpus_$target" \
    "tests/fuzz/corpus/$target" > "$build/$target.log" 2>&1; then
    tail -n 60 "$build/$target.log"
    return 1
  fi
  echo "fuzz_$target, $seconds s:" $(grep -E 'number_of_executed_units|peak_rss_mb' "$build/$target.log")
}
side_by_side fuzz "${targets[@]}"
