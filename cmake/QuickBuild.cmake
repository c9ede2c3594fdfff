# SPDX-License-Identifier: BSD-3-Clause
# What makes a build from scratch short.

# Compiles the .cpp files of a folder together, at most so many at once: headers and templates that
# they share are compiled once. Files that include Eigen, or JSON, are compiled with the others that
# do: each of these takes seconds. A name in the unnamed namespace of one file then stands for all
# that are compiled together.
function(ra2d_compile_by_folder target most)
  if(NOT RA2D_BY_FOLDER)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(NOT source MATCHES "[.]cpp$")
      continue()
    endif()
    cmake_path(GET source PARENT_PATH path)
    cmake_path(GET path FILENAME group)
    ra2d_heavy_library(${source} library)
    if(library)
      set(group ${library})
    endif()
    set(limit ${most})
    if(group STREQUAL "Eigen")
      set(limit 5)  # as one they would be what a build waits for
    endif()
    math(EXPR part "0${count_${group}} / ${limit}")
    math(EXPR count_${group} "0${count_${group}} + 1")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group}_${part})
  endforeach()
endfunction()

# Sets NAME to "Eigen" or "nlohmann" when the source includes one of them itself.
function(ra2d_heavy_library source name)
  file(STRINGS ${source} found REGEX "^#include <(Eigen|nlohmann)/" LIMIT_COUNT 1)
  string(REGEX REPLACE ".*<(.+)/.*" "\\1" found "${found}")
  set(${name} "${found}" PARENT_SCOPE)
endfunction()

# Optimises a target with -O1 or -O2, where a release build would take -O3: a third and a tenth less
# time to compile. Under sanitizers -O1 becomes -O0, which takes two fifths less.
function(ra2d_optimise target level)
  if(RA2D_SANITIZE AND level STREQUAL "-O1")
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU,Clang>:-O0>)
  endif()
  if(CMAKE_CXX_FLAGS_RELEASE MATCHES "-O3")
    target_compile_options(${target} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANG_AND_ID:CXX,GNU,Clang>>:${level}>)
    # With -O1 alone GCC writes no vzeroupper: libm and libstdc++ are then called with dirty AVX
    # registers, and take several times as long.
    target_compile_options(${target} PRIVATE
      $<$<AND:$<CONFIG:Release>,$<COMPILE_LANG_AND_ID:CXX,GNU>>:-fexpensive-optimizations>)
  endif()
endfunction()

# GCC frees memory while it compiles. Not below 1 GB: that takes a tenth of its time.
add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=1000000>)
