# SPDX-License-Identifier: BSD-3-Clause
# What run.sh, test.sh and .ci/run share. They are bash; this file is sourced by them, with `root`
# set.

say() { echo "ra2d: $*" >&2; }
fail() { say "$*"; exit 1; }

# need PURPOSE...: installs the packages of cmake/packages.txt that serve one of these and are
# missing.
need() {
  local purpose package missing=() wanted=()
  while read -r purpose package; do
    [[ " $* " == *" $purpose "* ]] && wanted+=("$package")
  done < "$root/cmake/packages.txt"
  if ! command -v apt-get > /dev/null || ! command -v dpkg-query > /dev/null; then
    [[ -d $root/build/release ]] && return  # it has been configured before
    say "there is no apt here to install with. Needed, by their names in Debian: ${wanted[*]}"
    command -v cmake > /dev/null && command -v ninja > /dev/null || fail "cmake and ninja were not found"
    return
  fi
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | sort) \
    <(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' "${wanted[@]}" 2> /dev/null | sed -n 's/^ii //p' | sort))
  [[ ${#missing[@]} == 0 ]] && return
  local as=()
  if [[ $(id -u) != 0 ]]; then
    command -v sudo > /dev/null ||
      fail "these packages are missing, and only root can install them: ${missing[*]}"
    as=(sudo)
  fi
  say "installing ${missing[*]}"
  local log
  log=$(mktemp)
  local apt=("${as[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300)
  # the package lists on a machine may be older than its mirror, or absent
  if ! "${apt[@]}" update > "$log" 2>&1 ||
    ! without_services "${as[*]}" "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >> "$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    fail "these packages could not be installed: ${missing[*]}"
  fi
  rm -f "$log"
}

# without_services AS COMMAND...: runs an installation, as AS, that starts no daemons (tests bring
# Slurm's packages).
without_services() (
  as=$1 policy=/usr/sbin/policy-rc.d
  shift
  if [[ ! -e $policy ]]; then
    trap '$as rm -f $policy' EXIT
    printf '#!/bin/sh\nexit 101\n' | $as tee $policy > /dev/null
    $as chmod 755 $policy
  fi
  "$@"
)

# quietly NAME COMMAND...: runs it with its output in build/NAME.log, which is shown only when it
# fails. After a moment it says what it is at and which step it has reached, in a file every 15 s.
quietly() {
  local name=$1 log="$root/build/$1.log" watch status=0 begun=$SECONDS
  shift
  mkdir -p "$root/build"
  : > "$log"
  follow "$name" "$log" &
  watch=$!
  # one at a time: several runs may be started together
  flock "$root/build/lock" "$@" > "$log" 2>&1 < /dev/null || status=$?
  kill $watch 2> /dev/null || true
  wait $watch 2> /dev/null || true
  [[ -t 2 ]] && printf '\r\033[K' >&2
  if [[ $status != 0 ]]; then
    cat "$log" >&2
    fail "$name failed"
  fi
  [[ $((SECONDS - begun)) -le 1 ]] || say "$name: $((SECONDS - begun)) s"
}
# What a log of ninja has reached: "212 of 407", else its last line.
reached() {
  tail -n 1 "$1" | sed -E 's/^\[([0-9]+)\/([0-9]+)\].*/\1 of \2/' | cut -c 1-60
}
follow() {
  local begun=$SECONDS pause=15
  sleep 1 > /dev/null 2>&1
  if [[ -t 2 ]]; then pause=0.5; else say "$1 ..."; fi
  while kill -0 $$ 2> /dev/null; do
    if [[ -t 2 ]]; then
      printf '\r\033[Kra2d: %s: %s, %d s' "$1" "$(reached "$2")" $((SECONDS - begun)) >&2
      sleep $pause > /dev/null 2>&1
    else
      sleep $pause > /dev/null 2>&1
      say "$1: $(reached "$2")"
    fi
  done
}

# run_tests PRESET [OPTION of ctest]...: all tests of a build, as many at a time as there are
# processors, and which cases of GoogleTest skipped themselves: ctest says so of whole tests alone.
run_tests() {
  local log="$root/build/$1/Testing/Temporary/LastTest.log" status=0
  # one more at a time than there are processors: some wait for files and for other processes
  ctest --preset "$1" --parallel $(($(nproc) + 1)) "${@:2}" || status=$?
  if [[ -e $log ]]; then
    echo "$(grep -c '^\[       OK \]' "$log") cases of GoogleTest passed. Skipped themselves:"
    sed -n 's/^\[  SKIPPED \] \([^ ]*\)$/  \1/p' "$log" | sort -u
  fi
  return $status
}
