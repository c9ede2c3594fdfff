# SPDX-License-Identifier: BSD-3-Clause
# What is installed is taken first; Kokkos alone is fetched, by hash, when it is absent.
find_package(Kokkos 5.0...<6 QUIET)
if(Kokkos_FOUND)
  message(STATUS "Kokkos ${Kokkos_VERSION}: ${Kokkos_DIR}")
else()
  include(FetchKokkos)
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(HDF5 1.10 REQUIRED COMPONENTS C HL)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
