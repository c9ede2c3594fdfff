#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# inspect.sh BUNDLE: whether a bundle carries what a bare machine lacks, and nothing that would not
# run there.
set -euo pipefail
bundle=$(cd "$1" && pwd)
fail() { echo "inspect.sh: $*" >&2; exit 1; }

for file in check.sh README.txt LICENSE about share/ra2d/scenes/dang2012.toml share/ra2d/chart_style.py \
  share/ra2d/tests/host/check_result.py bin/ra2d bin/ra2d_tests bin/ra2d_bench; do
  [[ -e $bundle/$file ]] || fail "$file is missing"
done

# what every machine has: the C library; and where there is a card, the driver
theirs='ld-linux|linux-vdso|lib(c|m|mvec|dl|rt|pthread|resolv|util|anl|cuda)\.so'
for program in "$bundle"/bin/*; do
  name=$(basename "$program")
  while read -r library _ place _; do
    if [[ $library =~ $theirs ]]; then continue; fi
    place=$(readlink -f "$place")
    [[ $place == "$bundle"/lib/* ]] || fail "$name: $library is found at '$place', not in the bundle"
  done < <(env -u LD_LIBRARY_PATH ldd "$program")
  needed=$(readelf -d "$program" | grep NEEDED)
  # but for Debian's benchmark library, which is a shared one
  if [[ $name != ra2d_bench && $needed =~ libstdc|libgcc_s|libcudart ]]; then fail "$name: a runtime is not linked in"; fi
  # x86-64-v3 has no 512-bit registers
  wide=$(objdump -d --no-show-raw-insn "$program" | grep -c '%zmm' || true)
  [[ $wide == 0 ]] || fail "$name holds AVX-512 code"
done
size=$(stat -c %s "$bundle.tar.gz")
((size < 60000000)) || fail "packed it is $size bytes, more than 60 MB"
echo "bundle: $(find "$bundle/lib" -type f | wc -l) libraries, $((size / 1000000)) MB packed, built for $(sed -n 's/^architectures //p' "$bundle/about")"
