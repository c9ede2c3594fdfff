# SPDX-License-Identifier: BSD-3-Clause
# Kokkos 5.0.2 by its hash: from the upstream release or from the Debian mirror that apt is
# configured with, which carries the same file. Built as part of the project.
include(FetchContent)
set(kokkos_version 5.0.2)
set(kokkos_urls
    https://github.com/kokkos/kokkos/releases/download/${kokkos_version}/kokkos-${kokkos_version}.tar.gz)
find_program(APT_GET apt-get)
if(APT_GET)
  execute_process(COMMAND ${APT_GET} indextargets --format "$(REPO_URI)"
                  OUTPUT_VARIABLE mirrors ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(REPLACE "\n" ";" mirrors "${mirrors}")
  list(REMOVE_DUPLICATES mirrors)
  foreach(mirror IN LISTS mirrors)
    string(REGEX REPLACE "/+$" "" mirror "${mirror}")
    list(APPEND kokkos_urls ${mirror}/pool/main/k/kokkos/kokkos_${kokkos_version}.orig.tar.gz)
  endforeach()
endif()

set(Kokkos_ENABLE_SERIAL ON CACHE BOOL "")
if(RA2D_BACKEND STREQUAL "OpenMP")
  set(Kokkos_ENABLE_OPENMP ON CACHE BOOL "")
elseif(RA2D_BACKEND STREQUAL "CUDA")
  set(Kokkos_ENABLE_CUDA ON CACHE BOOL "")
  # Hopper, unless the user names another: -DKokkos_ARCH_AMPERE80=ON. Also when the build folder is used again.
  get_cmake_property(named CACHE_VARIABLES)
  list(FILTER named INCLUDE REGEX
       "^Kokkos_ARCH_(MAXWELL|PASCAL|VOLTA|TURING|AMPERE|ADA|HOPPER|BLACKWELL)[0-9]+$")
  if(RA2D_CUDA_ARCH_BY_DEFAULT)
    list(REMOVE_ITEM named Kokkos_ARCH_HOPPER90)
  endif()
  set(by_default ON)
  foreach(arch IN LISTS named)
    if(${arch})
      set(by_default OFF)
    endif()
  endforeach()
  if(by_default OR RA2D_CUDA_ARCH_BY_DEFAULT)
    set(Kokkos_ARCH_HOPPER90 ${by_default} CACHE BOOL "Compile for compute capability 9.0" FORCE)
  endif()
  set(RA2D_CUDA_ARCH_BY_DEFAULT ${by_default} CACHE INTERNAL "Nobody named a GPU architecture")
elseif(NOT RA2D_BACKEND STREQUAL "Serial")
  message(FATAL_ERROR "RA2D_BACKEND = ${RA2D_BACKEND}: OpenMP, Serial or CUDA was expected")
endif()
option(Kokkos_ARCH_NATIVE "Compile for the processor of this machine" ON)

FetchContent_Declare(Kokkos SYSTEM  # first: CMake 3.25 takes it for a value elsewhere
  URL ${kokkos_urls}
  URL_HASH SHA256=188817bb452ca805ee8701f1c5adbbb4fb83dc8d1c50624566a18a719ba0fa5e
  DOWNLOAD_DIR ${PROJECT_SOURCE_DIR}/build/downloads
  DOWNLOAD_EXTRACT_TIMESTAMP ON
  OVERRIDE_FIND_PACKAGE)
message(STATUS "Kokkos: none installed, building ${kokkos_version} (${RA2D_BACKEND})")
FetchContent_MakeAvailable(Kokkos)
