# SPDX-License-Identifier: BSD-3-Clause
# Kokkos built as part of the project: from the archive that the user names, or from the first of
# these releases that can be had, by its hash, from the upstream project or from the Debian mirror
# that apt is configured with, which carries the same file. Mirrors keep one release at a time.
# 5.0.2 is the one that is tested here.
include(FetchContent)
include(KokkosArchive)
set(releases
    5.0.2=188817bb452ca805ee8701f1c5adbbb4fb83dc8d1c50624566a18a719ba0fa5e
    5.0.1=cf7d8515ca993229929be9f051aecd8f93cde325adac8a4f82ed6848adace218
    5.0.0=c45f3e19c3eb71fc8b7210cb04cac658015fc1839e7cc0571f7406588ff9bcef
    5.1.1=8bdbee0f0ac383436743ad8a9e3e928705b34b31a25a92dc5179c52a3aa98519
    5.1.0=7bdbdfc88033ed7d940c7940ed8919e1f2b78a9656c69276beb76ad45c41ec4e
    5.2.2=d6557aaef39302282a15f9c770433d1fcdf4e961dfd6d9ed726b9d0d0f546b9f
    5.2.1=3f754c99aa6130b1dd6520d904db7b2fd44ed618cd91e0dfd921956f23f6812d
    5.2.0=54993e0682d80b78939bbf260490f8cf31428bb883c0309961369997f15d94df)

if(RA2D_KOKKOS_ARCHIVE)
  get_filename_component(archive ${RA2D_KOKKOS_ARCHIVE} ABSOLUTE BASE_DIR ${CMAKE_BINARY_DIR})
  ra2d_check_archive(${archive} version ${PROJECT_BINARY_DIR}/kokkos-archive)
  file(SHA256 ${archive} hash)
  set(source URL ${archive})
  if(NOT "${version}=${hash}" IN_LIST releases)
    message(STATUS "Kokkos: ${archive} is none of the releases whose hashes are known here (SHA-256 ${hash})")
  endif()
elseif(FETCHCONTENT_SOURCE_DIR_KOKKOS)  # CMake's own way to name an unpacked one
  set(version ${FETCHCONTENT_SOURCE_DIR_KOKKOS})
  set(source)
else()
  set(addresses https://github.com/kokkos/kokkos/releases/download/{version}/kokkos-{version}.tar.gz)
  find_program(APT_GET apt-get)
  if(APT_GET)
    execute_process(COMMAND ${APT_GET} indextargets --format "$(REPO_URI)"
                    OUTPUT_VARIABLE mirrors ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REPLACE "\n" ";" mirrors "${mirrors}")
    list(REMOVE_DUPLICATES mirrors)
    foreach(mirror IN LISTS mirrors)
      string(REGEX REPLACE "/+$" "" mirror "${mirror}")
      list(APPEND addresses ${mirror}/pool/main/k/kokkos/kokkos_{version}.orig.tar.gz)
    endforeach()
  endif()
  ra2d_first_archive(archive version hash tried RELEASES ${releases} ADDRESSES ${addresses}
                     FOLDER ${PROJECT_SOURCE_DIR}/build/downloads)
  if(NOT archive)
    message(FATAL_ERROR "Kokkos 5 is not installed (or was not found), and none of its releases could be fetched:\n"
                        "${tried}\n"
                        "Do one of these:\n"
                        "  fetch a release 5.x (kokkos-5.x.y.tar.gz of github.com/kokkos/kokkos/releases) where "
                        "there is a network, and configure with -DRA2D_KOKKOS_ARCHIVE=FILE\n"
                        "  name an installed Kokkos 5 with -DKokkos_ROOT=FOLDER")
  endif()
  set(source URL ${archive} URL_HASH SHA256=${hash})
endif()

set(Kokkos_ENABLE_SERIAL ON CACHE BOOL "")
if(RA2D_BACKEND STREQUAL "OpenMP")
  set(Kokkos_ENABLE_OPENMP ON CACHE BOOL "")
elseif(RA2D_BACKEND STREQUAL "HIP")  # Kokkos asks the machine for its GPU where nobody names one
  set(Kokkos_ENABLE_HIP ON CACHE BOOL "")
  set(Kokkos_ENABLE_ROCTHRUST OFF CACHE BOOL "")  # for sorting
elseif(RA2D_BACKEND STREQUAL "CUDA")
  set(Kokkos_ENABLE_CUDA ON CACHE BOOL "")
  # Hopper, unless the user names another: -DKokkos_ARCH_AMPERE80=ON. Also when the build folder is
  # used again.
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
endif()

if(RA2D_X86_64_V3)
  set(Kokkos_ARCH_NATIVE OFF CACHE BOOL "" FORCE)
  set(Kokkos_ARCH_HSW ON CACHE BOOL "" FORCE)  # AVX2 and FMA; the flags are made x86-64-v3's below
  set(RA2D_ARCH_BY_PORTABLE ON CACHE INTERNAL "Both were set here")
else()
  if(RA2D_ARCH_BY_PORTABLE)  # in this folder, the last time
    unset(Kokkos_ARCH_NATIVE CACHE)
    unset(Kokkos_ARCH_HSW CACHE)
    unset(RA2D_ARCH_BY_PORTABLE CACHE)
  endif()
  option(Kokkos_ARCH_NATIVE "Compile for the processor of this machine" ON)
endif()

FetchContent_Declare(Kokkos SYSTEM  # first: CMake 3.25 takes it for a value elsewhere
  ${source} DOWNLOAD_EXTRACT_TIMESTAMP ON OVERRIDE_FIND_PACKAGE)
message(STATUS "Kokkos: building ${version} (${RA2D_BACKEND})")
if(RA2D_BACKEND MATCHES "^(CUDA|HIP)$")
  FetchContent_MakeAvailable(Kokkos)
else()
  # Kokkos installs scripts that drive nvcc, and has no switch for it. Here nobody needs them: they
  # go to a folder of their own, which the same installation removes again.
  set(CMAKE_INSTALL_BINDIR ${CMAKE_INSTALL_LIBDIR}/kokkos-scripts)
  set(CMAKE_UNITY_BUILD ${RA2D_BY_FOLDER})  # its headers take most of the time that its files take to compile
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 10)
  FetchContent_MakeAvailable(Kokkos)
  unset(CMAKE_UNITY_BUILD)
  unset(CMAKE_UNITY_BUILD_BATCH_SIZE)
  install(CODE "file(REMOVE_RECURSE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")")
  unset(CMAKE_INSTALL_BINDIR)  # the cache has the user's
endif()
set(Kokkos_VERSION ${version})

if(RA2D_PORTABLE AND RA2D_BACKEND STREQUAL "CUDA")
  find_package(CUDAToolkit REQUIRED)
  set_target_properties(CUDA PROPERTIES INTERFACE_LINK_LIBRARIES "CUDA::cuda_driver;CUDA::cudart_static")
endif()
if(RA2D_X86_64_V3)
  foreach(property COMPILE_OPTIONS INTERFACE_COMPILE_OPTIONS LINK_OPTIONS INTERFACE_LINK_OPTIONS)
    get_target_property(options kokkoscore ${property})
    string(REPLACE "-march=core-avx2" "-march=x86-64-v3" options "${options}")
    string(REPLACE "-mtune=core-avx2" "-mtune=generic" options "${options}")
    set_target_properties(kokkoscore PROPERTIES ${property} "${options}")
  endforeach()
endif()
