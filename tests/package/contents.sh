#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# contents.sh CPACK CONFIG PYTHON: makes the packages of a build that is finished, and looks at what
# they hold. PYTHON may be empty. Exit status 9: there is no dpkg-deb here.
set -euo pipefail
cpack=$1 config=$2 python=$3
command -v dpkg-deb > /dev/null && command -v dpkg-shlibdeps > /dev/null || { echo "no dpkg-dev here"; exit 9; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "$*"; exit 1; }
unset RA2D

"$cpack" --config "$config" -B "$folder" -D CPACK_OUTPUT_FILE_PREFIX="$folder" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip > "$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
deb=$(ls "$folder"/*.deb) tar=$(ls "$folder"/*.tar.gz)
native=no
[[ $config == */native-package/* ]] && native=yes

# ---- the .deb
field() { dpkg-deb --field "$deb" "$1"; }
[[ $(field Package) == ra2d ]] || fail "it is called $(field Package)"
for library in libc6 libhdf5 libfftw3-double3 libpugixml1 libzip4; do
  [[ $(field Depends) == *$library* ]] || fail "it does not depend on $library: $(field Depends)"
done
for module in numpy h5py xarray pandas matplotlib jinja2 soundfile scipy xxhash; do
  [[ ", $(field Recommends)," == *" python3-$module,"* ]] || fail "it does not recommend python3-$module"
done
# code for one machine's processor is named
if [[ $native == yes ]]; then
  [[ $deb == *native* && $tar == *native* && $(field Description) == *"the machine that built it"* ]] ||
    fail "a native package is not named so: $deb"
else
  [[ $deb != *native* && $(field Description) == *"any x86-64 processor with AVX2"* ]] || fail "named wrongly: $deb"
fi
dpkg-deb --fsys-tarfile "$deb" | tar t | sed 's|^\./||' | sort > "$folder/held"
has() { grep -qxF -- "$1" "$folder/held" || fail "the package lacks $1"; }
has usr/bin/ra2d
has usr/lib/python3/dist-packages/ra2d
has usr/share/ra2d/ra2d/__init__.py
has usr/share/ra2d/scenes/dang2012.toml
for page in README.md docs/scene.md docs/installing.md copyright; do has usr/share/doc/ra2d/$page; done
for page in man1/ra2d.1 man1/ra2d-run.1 man1/ra2d-study-merge.1 man5/ra2d-scene.5; do has usr/share/man/$page.gz; done
has usr/share/bash-completion/completions/ra2d
has usr/share/zsh/site-functions/_ra2d
has usr/share/fish/vendor_completions.d/ra2d.fish
# nothing of Kokkos, for developers, or made by Python
! grep -niE 'kokkos|desul|/include/|/cmake/|\.cmake$|\.a$|\.hpp$|__pycache__|\.pyc$|launch_compiler|nvcc_wrapper|/tests?/' "$folder/held" ||
  fail "it holds what users do not need"
[[ $(grep -c '^usr/bin/.' "$folder/held") == 1 ]] || fail "it has other programs"
! dpkg-deb --fsys-tarfile "$deb" | tar tv | awk '$2 != "root/root" || substr($1, 6, 1) == "w" || substr($1, 9, 1) == "w"' |
  grep -v '^l' || fail "these do not belong to root, or others may write them"

mkdir "$folder/root"
dpkg-deb --extract "$deb" "$folder/root"
drop=share/ra2d/scenes/drop.toml
cd "$folder"
root/usr/bin/ra2d run "root/usr/$drop" --set scene.duration=1e-3 --quiet -o deb.h5
if [[ -n $python ]]; then
  found=$(PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$folder/root/usr/lib/python3/dist-packages "$python" -c \
    'import ra2d, ra2d.program; print(ra2d.program.find())')
  [[ $found == "$folder/root/usr/bin/ra2d" ]] || fail "the package ra2d finds $found"
fi

# ---- the .tar.gz: in any folder, with its libraries
mkdir "$folder/any place"
tar xf "$tar" -C "$folder/any place"
place=$(echo "$folder/any place"/ra2d-*)
[[ $(cd "$place" && echo *) == "bin lib share" ]] || fail "the .tar.gz has $(ls "$place")"
"$place/bin/ra2d" run "$place/$drop" --set scene.duration=1e-3 --quiet -o tar.h5
[[ -e "$place/share/man/man1/ra2d-run.1" && -e "$place/share/ra2d/ra2d/__init__.py" ]] || fail "the .tar.gz lacks pages"
compgen -G "$place/lib/ra2d/libhdf5*" > /dev/null || fail "the .tar.gz lacks its libraries"
if [[ $native == no ]]; then
  ldd "$place/bin/ra2d" | grep "$place.*libhdf5" > /dev/null || fail "it does not take the libraries that it brings"
fi
echo "$(basename "$deb"): $(grep -vc '/$' "$folder/held") files; $(basename "$tar")"
