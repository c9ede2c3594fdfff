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
  # What a target is watched for. Only the marches are watched for null pointers and for alignment
  # as well (RA2D_ALL_SANITIZERS): a null pointer ends a program anyway, and these two are most of
  # what all checks of undefined behaviour take to compile.
  define_property(TARGET PROPERTY RA2D_SANITIZERS INITIALIZE_FROM_VARIABLE RA2D_SANITIZERS)
  set(RA2D_ALL_SANITIZERS -fsanitize=address,undefined)
  set(RA2D_SANITIZERS ${RA2D_ALL_SANITIZERS} -fno-sanitize=null,alignment)
  target_compile_options(ra2d_strict INTERFACE
    $<TARGET_PROPERTY:RA2D_SANITIZERS> -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(ra2d_strict INTERFACE ${RA2D_ALL_SANITIZERS})
  # GCC before 14 places what needs 64 bytes wrongly on the stack that finds uses after a return, so
  # that AVX-512 ends the program (GCC bug 110027). The fuzzers look for such uses, compiled by
  # clang.
  target_compile_options(ra2d_strict INTERFACE
    $<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,14>>:--param=asan-use-after-return=0>)
endif()
