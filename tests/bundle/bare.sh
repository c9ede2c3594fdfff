#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# bare.sh BUNDLE [SECONDS]: runs a bundle's tests and benchmarks in a Debian of nothing but its base
# system, made by debootstrap. As root.
set -euo pipefail
bundle=$(cd "$1" && pwd)
seconds=${2:-300}
[[ $(id -u) == 0 ]] || { echo "bare.sh: only root can make such a system" >&2; exit 1; }
root=$(mktemp -d)
trap 'rm -rf --one-file-system "$root"' EXIT
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | head -n 1)
debootstrap --variant=minbase bookworm "$root" "$mirror" > "$root.log" 2>&1 || { tail -n 20 "$root.log"; exit 1; }
rm -f "$root.log"
tar xzf "$bundle.tar.gz" -C "$root/root"
trap 'umount "$root/proc" 2> /dev/null || true; rm -rf --one-file-system "$root"' EXIT
mount -t proc proc "$root/proc" || echo "bare.sh: no /proc may be mounted here: the tests that need one may fail" >&2
status=0
chroot "$root" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/root \
  "/root/$(basename "$bundle")/check.sh" --budget "$seconds" -o /root/check.json || status=$?
cp "$root/root/check.json" "$bundle-bare.json"
python3 - "$bundle-bare.json" << 'END'
import json, sys
def no_number(name): raise ValueError(name + " is no JSON")
r = json.load(open(sys.argv[1]), parse_constant=no_number)
t, b = r["tests"], r["benchmarks"]
failed = [(s.get("suite"), s["output"]) for s in t["suites"] if s["state"] == "failed"]
assert not failed, failed
assert t["suites_passed"] + t["suites_out_of_time"] + t["suites_not_run"] == len(t["suites"])
assert t["tests_run"] > 700 or t["suites_out_of_time"] + t["suites_not_run"] > 0, t["tests_run"]
assert b["failed"] == 0 and b["passed"] > 0
assert all("result" in c for c in b["cases"] if c["state"] == "passed")
print(f'bare: {t["tests_run"]} tests ran, {t["tests_skipped"]} skipped; {b["passed"]} benchmarks')
END
exit $status
