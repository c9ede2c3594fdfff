#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs the tests of a bundle, then its benchmarks, and writes all that came out into one JSON file.
# Needs bash, awk and the usual small tools, nothing else.
set -u
shopt -s nullglob
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
budget=600
output=ra2d-check.json
only=

usage() {
  cat << END
./check.sh [--budget SECONDS] [--only tests|benchmarks] [-o FILE.json]

Runs the tests, then the benchmarks, and writes what came out into one JSON file [$output].
--budget: about how long it may take in all [$budget]. The tests may take two thirds of it, the benchmarks what is
then left. One suite of tests may take a sixth of the tests' time, one benchmark a tenth of the rest: what takes longer
is "out of time", what has no time left is "not run".
Exit status: 0 all that ran passed; 1 something failed; 2 the request is wrong; 4 the file cannot be written.
END
}
wrong() { echo "check.sh: $*" >&2; exit 2; }
while [[ $# -gt 0 ]]; do
  case $1 in
    -h | --help) usage; exit 0 ;;
    --budget)
      budget=${2-}
      [[ $budget =~ ^[1-9][0-9]{0,6}$ ]] || wrong "--budget $budget: whole seconds were expected"
      shift 2
      ;;
    --only)
      only=${2-}
      [[ $only == tests || $only == benchmarks ]] || wrong "--only $only: tests or benchmarks was expected"
      shift 2
      ;;
    -o)
      output=${2-}
      [[ -n $output ]] || wrong "-o: a file was expected"
      shift 2
      ;;
    *) usage >&2; wrong "unknown option $1" ;;
  esac
done
# of a link, what it leads to is replaced; and nothing but a file
output=$(readlink -f -- "$output") && [[ ! -e $output || -f $output ]] || wrong "-o: no file can be written there"
# an earlier file of this name stays until the new one is whole
: > "$output.partial" || { echo "check.sh: cannot write $output" >&2; exit 4; }
exec < /dev/null

work=$(mktemp -d "${TMPDIR:-/tmp}/ra2d_check_XXXXXX") || exit 4
sampler=
interrupted=false
finish() {
  [[ -n $sampler ]] && kill "$sampler" 2> /dev/null
  rm -rf "$work" "$output.partial"
}
trap finish EXIT
interrupt() { # ends what runs, and writes what there is
  trap '' INT TERM
  echo "check.sh: interrupted" >&2
  interrupted=true
  local children
  children=$(jobs -p)
  # shellcheck disable=SC2086
  [[ -n $children ]] && kill $children 2> /dev/null
  sleep 1
  write_results
  exit 130
}
trap interrupt INT TERM
now() { date +%s; }
begun=$(now)

export RA2D_PROGRAM=$here/bin/ra2d RA2D_SOURCE_DIR=$here/share/ra2d RA2D_FAULTY_DISK=$here/lib/libfaulty_disk.so
if python3 -c 'import h5py, netCDF4, xarray, xxhash' 2> /dev/null; then RA2D_PYTHON=$(command -v python3); else RA2D_PYTHON=; fi
export RA2D_PYTHON

about() { sed -n "s/^$1 //p" "$here/about"; }
quote() { # standard input as a JSON string
  tr -d '\000-\010\013-\037' | sed -e 's/\\/\\\\/g' -e 's/"/\\"/g' -e 's/\t/\\t/g' |
    awk 'BEGIN { printf "\"" } NR > 1 { printf "\\n" } { printf "%s", $0 } END { printf "\"" }'
}
string() { printf '%s' "$1" | quote; }

# ---- the machine

ask_card() { nvidia-smi --format=csv,noheader,nounits --query-gpu="$1" 2> /dev/null; }

machine() {
  local cpu memory
  cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)
  memory=$(awk '/^MemTotal/ { printf "%.0f", $2 * 1024 }' /proc/meminfo)
  printf '{"processor": %s, "cores": %d, "memory": %s, "system": %s, "c_library": %s, "python": %s,\n' \
    "$(string "$cpu")" "$(nproc)" "${memory:-null}" "$(uname -srm | quote)" \
    "$(getconf GNU_LIBC_VERSION 2> /dev/null | quote)" "$(string "$RA2D_PYTHON")"
  printf '  "cards": ['
  local first=1
  local cards
  # of a driver that does not answer, its complaint is no card
  if command -v nvidia-smi > /dev/null && cards=$(ask_card name,driver_version,memory.total,compute_cap,clocks.sm,clocks.mem,clocks.max.sm,clocks.max.mem,power.limit,mig.mode.current); then
    local name driver memory capability sm_now memory_now sm_most memory_most power mode
    while IFS=, read -r name driver memory capability sm_now memory_now sm_most memory_most power mode; do
      [[ -n $name ]] || continue
      ((first)) || printf ', '
      first=0
      printf '{"name": %s, "driver": %s, "memory_MiB": %s, "compute_capability": %s, "clock_MHz": %s, ' \
        "$(string "$name")" "$(string "${driver# }")" "$(string "${memory# }")" "$(string "${capability# }")" \
        "$(string "${sm_now# }")"
      printf '"memory_clock_MHz": %s, "most_clock_MHz": %s, "most_memory_clock_MHz": %s, "power_limit_W": %s, "mig": %s}' \
        "$(string "${memory_now# }")" "$(string "${sm_most# }")" "$(string "${memory_most# }")" \
        "$(string "${power# }")" "$(string "${mode# }")"
    done <<< "$cards"
  fi
  printf ']}'
}

# What the card's clock does meanwhile: [seconds since the start, MHz, memory MHz, W, degrees C]
watch_clocks() {
  while ask_card clocks.sm,clocks.mem,power.draw,temperature.gpu > "$work/clock"; do
    sed -n "1s/^/$(($(now) - begun)), /p" "$work/clock" >> "$work/clocks"
    sleep 5
  done
}

# ---- one part of a test program, or one benchmark, in a process of its own: a crash costs that
# part alone

# run_part KIND PROGRAM PART FILE SECONDS [argument...]: writes FILE.part (one JSON object) and
# FILE.state
run_part() {
  local kind=$1 program=$2 part=$3 file=$4 seconds=$5 start status state took child
  shift 5
  start=$(date +%s%N)
  timeout -k 5 "$seconds" "$here/bin/$program" "$@" > "$file.out" 2>&1 < /dev/null &
  child=$!
  ((BASH_SUBSHELL > 0)) && trap 'kill $child' TERM
  wait $child
  status=$?
  took=$(awk "BEGIN { printf \"%.3f\", ($(date +%s%N) - $start) / 1e9 }")
  state=passed
  # 137 is a kill: by timeout when it was late, by the system (out of memory, say) when it was not
  if [[ $status == 124 ]] || { [[ $status == 137 ]] && ((${took%.*} >= seconds)); }; then
    state='out of time'
  elif [[ $status == 143 ]]; then
    state=interrupted
  elif [[ $status != 0 || $(tail -n 1 "$file.json" 2> /dev/null) != '}' ]]; then
    state=failed
  fi
  grep -q '"error_occurred": true' "$file.json" 2> /dev/null && state=failed
  {
    printf '{"program": %s, "%s": %s, "state": "%s", "exit": %d, "seconds": %s' \
      "$(string "$program")" "$kind" "$(string "$part")" "$state" "$status" "$took"
    if [[ $state != passed ]]; then
      [[ $kind == suite ]] && printf ', "tests_passed": %d' "$(grep -c '^\[       OK \]' "$file.out")"
      printf ', "output": %s' "$(grep -v '^\[       OK \]' "$file.out" | tail -n 60 | quote)"
    fi
    if [[ $(tail -n 1 "$file.json" 2> /dev/null) == '}' ]]; then # of a crash it is cut off
      printf ',\n "result": '
      sed -E 's/: -?(NaN|Infinity)(,?)$/: null\2/' "$file.json" # which are no JSON
    fi
    printf '}'
  } > "$file.whole"
  mv "$file.whole" "$file.part"
  echo "$state" > "$file.state"
  [[ $state == passed ]] || echo "check.sh: $program, $part: $state" >&2
}

join() { # the parts with this prefix, in order, as a JSON list
  local part separator=
  printf '['
  for part in "$work/$1"*.part; do
    printf '%s\n' "$separator"
    cat "$part"
    separator=,
  done
  printf ']'
}
count() { cat /dev/null "$work/$1"*.state | grep -c "^$2\$"; }
running() { jobs -rp | grep -cvx "${sampler:-none}"; }

not_run() { # KIND PROGRAM PART FILE
  printf '{"program": "%s", "%s": %s, "state": "not run", "seconds": 0}' "$2" "$1" "$(string "$3")" > "$4.part"
  echo 'not run' > "$4.state"
}

# list PROGRAM FILE ARGUMENT...: what a program has, into FILE.names; one that does not even start
# is a failed part
list() {
  local program=$1 file=$2 status
  shift 2
  timeout -k 5 120 "$here/bin/$program" "$@" > "$file.names" 2> "$file.out" < /dev/null
  status=$?
  [[ $status == 0 ]] && return
  printf '{"program": %s, "state": "failed", "exit": %d, "seconds": 0, "output": %s}' "$(string "$program $*")" $status \
    "$(tail -n 40 "$file.out" | quote)" > "$file.part"
  echo failed > "$file.state"
  echo "check.sh: $program does not start: $(head -n 3 "$file.out")" >&2
  return 1
}

run_tests() {
  local end=$1 jobs number=0 program=ra2d_tests suite left file most
  most=$(((end - $(now)) / 6 + 1))
  jobs=$(nproc)
  [[ $(about backend) == CUDA && $jobs -gt 8 ]] && jobs=8 # each has its own context on the card
  export RA2D_TEST_THREADS=1
  file=$work/test-list
  list "$program" "$file" --gtest_list_tests || return
  while read -r suite; do
    while (($(running) >= jobs)); do wait -n; done
    left=$((end - $(now)))
    ((++number))
    file=$work/test-$(printf %04d $number)
    if ((left < 1)); then
      not_run suite "$program" "${suite%.}" "$file"
      continue
    fi
    run_part suite "$program" "${suite%.}" "$file" $((left < most ? left : most)) --gtest_filter="$suite*" \
      --gtest_output="json:$file.json" &
  done < <(sed -n 's/^\([^ ].*\.\)\( .*\)*$/\1/p' "$work/test-list.names" | sort -u)
  while (($(running) > 0)); do wait -n; done
}

run_benchmarks() {
  local end=$1 number=0 program name left file pattern size most
  most=$(((end - $(now)) / 10 + 1))
  for size in small whole; do # of every kind first the smallest
    for program in throughput march schemes adaptive ready; do
      file=$work/bench-$program
      if [[ $size == small ]]; then list ra2d_bench "$file" "$program" --benchmark_list_tests || continue; fi
      [[ -s $file.names ]] || continue
      while read -r name; do
        if [[ $name == */small* ]]; then [[ $size == small ]] || continue; else [[ $size == whole ]] || continue; fi
        left=$((end - $(now)))
        ((++number))
        file=$work/bench-$(printf %04d $number)
        if ((left < 1)); then
          not_run case ra2d_bench "$program $name" "$file"
          continue
        fi
        pattern=$(printf '%s' "$name" | sed 's/[][().*+?^$|{}\\]/\\&/g')
        if [[ $program == throughput || $name == */batch* ]]; then unset OMP_NUM_THREADS; else export OMP_NUM_THREADS=1; fi
        run_part case ra2d_bench "$program $name" "$file" $((left < most ? left : most)) "$program" \
          --benchmark_filter="^$pattern\$" --benchmark_repetitions=3 --benchmark_out="$file.json" --benchmark_out_format=json
      done < "$work/bench-$program.names"
    done
  done
  unset OMP_NUM_THREADS
}

# ---- what came out

summary() { # NAME PREFIX SECONDS
  printf '%-11s %4d passed, %d failed, %d out of time, %d not run, in %d s\n' "$1" "$(count "$2" passed)" \
    "$(count "$2" failed)" "$(count "$2" 'out of time')" "$(count "$2" 'not run')" "$3"
}

write_results() {
  local took passed skipped failures key
  took=$(($(now) - begun))
  [[ -n $tests_took ]] || tests_took=$took
  passed=$(cat /dev/null "$work"/test-*.json | grep -c '"result": "COMPLETED"')
  skipped=$(cat /dev/null "$work"/test-*.json | grep -c '"result": "SKIPPED"')
  failures=$(cat /dev/null "$work"/test-*.json | grep -c '"failures": \[')
  {
    printf '{"ra2d": {'
    for key in version commit backend compiler host_flags marches kokkos architectures c_library; do
      printf '"%s": %s, ' $key "$(string "$(about $key)")"
    done
    printf '"says": %s},\n' "$(head -n 3 "$work/version" | quote)"
    printf '"date": "%s", "seconds": %d, "budget": %d, "interrupted": %s,\n"machine": ' "$(date -u +%Y-%m-%dT%H:%M:%SZ)" $took "$budget" $interrupted
    cat "$work/machine"
    printf ',\n"clocks": {"columns": ["s", "MHz", "memory MHz", "W", "C"], "rows": ['
    awk '{
      gsub(/[^0-9.,]/, "")
      n = split($0, column, ",")
      for (i = 1; i <= n; ++i) printf "%s%s", (i > 1 ? ", " : NR > 1 ? ", [" : "["), (column[i] == "" ? "null" : column[i])
      printf "]"
    }' "$work/clocks"
    printf ']},\n"tests": {"seconds": %d, "tests_run": %d, "tests_failed": %d, "tests_skipped": %d, ' \
      $tests_took $((passed)) $((failures)) $((skipped))
    printf '"suites_passed": %d, "suites_failed": %d, "suites_out_of_time": %d, "suites_not_run": %d, "suites": ' \
      "$(count test- passed)" "$(count test- failed)" "$(count test- 'out of time')" "$(count test- 'not run')"
    join test-
    printf '},\n"benchmarks": {"seconds": %d, "passed": %d, "failed": %d, "out_of_time": %d, "not_run": %d, "cases": ' \
      $((took - tests_took)) "$(count bench- passed)" "$(count bench- failed)" "$(count bench- 'out of time')" "$(count bench- 'not run')"
    join bench-
    printf '}}\n'
  } > "$output.partial" && mv "$output.partial" "$output" || { echo "check.sh: cannot write $output" >&2; exit 4; }
  [[ $only == benchmarks ]] || summary "test suites" test- $tests_took
  [[ $only == benchmarks ]] || printf '%-11s %4d ran, %d failed, %d skipped\n' "  tests" "$passed" "$failures" "$skipped"
  [[ $only == tests ]] || summary benchmarks bench- $((took - tests_took))
  echo "written to $output"
}

# ---- all of it

tests_took=
: > "$work/clocks"
if command -v nvidia-smi > /dev/null; then
  watch_clocks &
  sampler=$!
fi
machine > "$work/machine"
if ! timeout -k 5 60 "$here/bin/ra2d" --version > "$work/version" 2>&1; then
  echo "check.sh: the program does not start here: $(cat "$work/version")" >&2
  echo "check.sh: it was built for $(about c_library) or newer, AVX2 and FMA; a build for CUDA needs an NVIDIA driver" >&2
fi
[[ $only == benchmarks ]] || run_tests $((begun + (${#only} ? budget : budget * 2 / 3)))
tests_took=$(($(now) - begun))
[[ $only == tests ]] || run_benchmarks $((begun + budget))
write_results
[[ $(count test- failed) == 0 && $(count bench- failed) == 0 ]]
