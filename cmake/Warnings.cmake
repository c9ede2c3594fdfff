# SPDX-License-Identifier: BSD-3-Clause
# How our own targets are compiled (private to them, never exported).
add_library(ra2d_strict INTERFACE)
target_compile_options(ra2d_strict INTERFACE
  $<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang>:-Wall;-Wextra;-Werror>)
# what a designated initialiser leaves out has its default
target_compile_options(ra2d_strict INTERFACE
  $<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang>:-Wno-missing-field-initializers>)
# GCC 12 reports its own AVX-512 headers (GCC bug 105593)
target_compile_options(ra2d_strict INTERFACE
  $<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-uninitialized;-Wno-maybe-uninitialized>)
if(RA2D_SANITIZE)
  target_compile_options(ra2d_strict INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(ra2d_strict INTERFACE -fsanitize=address,undefined)
endif()
