# SPDX-License-Identifier: BSD-3-Clause
# RA2D_PORTABLE: programs for other machines than the one that builds them, as from a login node or
# in a bundle.
set(RA2D_X86_64_V3 OFF)  # host code for every x86-64 processor with AVX2 and FMA
if(RA2D_PORTABLE AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  set(RA2D_X86_64_V3 ON)
endif()

add_library(ra2d_runtimes INTERFACE)  # how programs are linked
if(RA2D_PORTABLE)
  # No shared library of C++, so that there is one C++ runtime, in the program: of fmt the headers
  # serve.
  add_compile_definitions(FMT_HEADER_ONLY)
  add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang>:-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=>)
  target_link_options(ra2d_runtimes INTERFACE -static-libgcc -static-libstdc++)
  # The libraries that are carried along find one another only by a path that is also theirs
  # (DT_RPATH, not RUNPATH).
  add_link_options(LINKER:--as-needed LINKER:--disable-new-dtags)
endif()
