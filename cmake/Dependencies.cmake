# SPDX-License-Identifier: BSD-3-Clause
# What is installed is taken first; Kokkos alone is built here when it is absent, or when its
# archive is named.
set(RA2D_KOKKOS_ARCHIVE "" CACHE FILEPATH
    "A release of Kokkos 5 to build from, instead of one that is installed or fetched")
if(NOT RA2D_BACKEND MATCHES "^(OpenMP|Serial|CUDA|HIP)$")
  message(FATAL_ERROR "RA2D_BACKEND = ${RA2D_BACKEND}: OpenMP, Serial, CUDA or HIP was expected")
endif()
if(RA2D_BACKEND STREQUAL "HIP" AND NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "RA2D_BACKEND = HIP is for ROCm's compiler, not for ${CMAKE_CXX_COMPILER}: configure a new folder with "
                      "--preset hip, or with -DCMAKE_CXX_COMPILER=amdclang++")
endif()
set(kokkos_by_name)  # where the user says that Kokkos is installed
foreach(place "${Kokkos_ROOT}" "$ENV{Kokkos_ROOT}")
  if(place)
    list(APPEND kokkos_by_name "Kokkos_ROOT = ${place}")
  endif()
endforeach()
if(RA2D_KOKKOS_ARCHIVE AND kokkos_by_name)
  message(FATAL_ERROR "RA2D_KOKKOS_ARCHIVE names one Kokkos and ${kokkos_by_name} another: leave one out")
endif()

if(kokkos_by_name)
  unset(Kokkos_DIR CACHE)  # the last one that was found would be taken
  find_package(Kokkos 5.0...<6 QUIET PATHS "${Kokkos_ROOT}" "$ENV{Kokkos_ROOT}" NO_DEFAULT_PATH)
elseif(NOT RA2D_KOKKOS_ARCHIVE AND NOT RA2D_PORTABLE)  # one that nobody named is likely for this machine's processor
  find_package(Kokkos 5.0...<6 QUIET)
endif()
if(Kokkos_FOUND)
  message(STATUS "Kokkos ${Kokkos_VERSION}: ${Kokkos_DIR} (${Kokkos_DEVICES})")
  if(NOT Kokkos_ARCH)
    message(WARNING "This Kokkos was built for no processor in particular. Without its vector and multiply-add instructions "
                    "ra2d runs many times slower. Build Kokkos with -DKokkos_ARCH_NATIVE=ON, or leave it out")
  endif()
  if(RA2D_PORTABLE AND "NATIVE" IN_LIST Kokkos_ARCH)
    message(FATAL_ERROR "The Kokkos in ${Kokkos_DIR} was built for the processor of one machine (NATIVE), RA2D_PORTABLE is "
                        "for many. Leave Kokkos_ROOT out to have one built here")
  endif()
  string(TOUPPER ${RA2D_BACKEND} wanted)
  # Kokkos runs on the strongest of the backends that it was built for; one of OpenMP serves one
  # thread, too.
  if(NOT wanted IN_LIST Kokkos_DEVICES OR ("CUDA" IN_LIST Kokkos_DEVICES AND NOT wanted STREQUAL "CUDA")
     OR ("HIP" IN_LIST Kokkos_DEVICES AND NOT wanted STREQUAL "HIP"))
    message(FATAL_ERROR "The Kokkos in ${Kokkos_DIR} was built for ${Kokkos_DEVICES}, which does not fit "
                        "RA2D_BACKEND = ${RA2D_BACKEND}. Name another backend with -DRA2D_BACKEND=..., name another Kokkos "
                        "with -DKokkos_ROOT=..., or have one built here with -DCMAKE_DISABLE_FIND_PACKAGE_Kokkos=ON")
  endif()
elseif(kokkos_by_name)
  set(considered)
  foreach(config found IN ZIP_LISTS Kokkos_CONSIDERED_CONFIGS Kokkos_CONSIDERED_VERSIONS)
    string(APPEND considered "\n  ${config}: ${found}")
  endforeach()
  if(NOT considered)
    set(considered " nothing")
  endif()
  message(FATAL_ERROR "${kokkos_by_name}: no Kokkos 5 was found. What was found:${considered}")
endif()
if(NOT Kokkos_FOUND)
  include(FetchKokkos)
endif()

# a GPU whose threads work in warps (kernels/warp.hpp)
set(RA2D_WARPS OFF)
if(Kokkos_ENABLE_CUDA OR Kokkos_ENABLE_HIP)
  set(RA2D_WARPS ON)
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(HDF5 1.10.3 REQUIRED COMPONENTS C HL)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)  # its header alone, 0.8 or later
find_path(FFTW3_INCLUDE_DIR fftw3.h REQUIRED)
find_library(FFTW3_LIBRARY fftw3 REQUIRED)  # of double precision
find_path(LIBZIP_INCLUDE_DIR zip.h REQUIRED)  # these three read X3P
find_library(LIBZIP_LIBRARY zip REQUIRED)
find_path(PUGIXML_INCLUDE_DIR pugixml.hpp REQUIRED)
find_library(PUGIXML_LIBRARY pugixml REQUIRED)
find_path(CRYPTO_INCLUDE_DIR openssl/evp.h REQUIRED)
find_library(CRYPTO_LIBRARY crypto REQUIRED)
find_package(MPI QUIET COMPONENTS C)
if(NOT MPI_C_FOUND)
  message(STATUS "MPI: none was found, and so no study can be run under mpirun")
endif()
