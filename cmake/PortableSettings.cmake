# SPDX-License-Identifier: BSD-3-Clause
# ra2d_write_portable_settings(NAME): writes a file for `cmake -C`, with the compiler and the
# libraries of this build, for a build of its own with RA2D_PORTABLE=ON. NAME is set to the file.
# The targets `bundle` and `package` make such builds, as this one is for this machine's processor.
function(ra2d_write_portable_settings name)
  set(settings ${PROJECT_BINARY_DIR}/portable-settings.cmake)
  set(text "set(CMAKE_BUILD_TYPE Release CACHE STRING \"\" FORCE)\n")
  foreach(setting CMAKE_PREFIX_PATH CMAKE_C_COMPILER CMAKE_CXX_COMPILER CMAKE_C_COMPILER_LAUNCHER
          CMAKE_CXX_COMPILER_LAUNCHER HDF5_ROOT Eigen3_DIR
          fmt_DIR CLI11_DIR tomlplusplus_DIR nlohmann_json_DIR GTest_DIR benchmark_DIR RANDOM123_INCLUDE_DIR XXHASH_INCLUDE_DIR
          FFTW3_INCLUDE_DIR FFTW3_LIBRARY LIBZIP_INCLUDE_DIR LIBZIP_LIBRARY PUGIXML_INCLUDE_DIR PUGIXML_LIBRARY
          CRYPTO_INCLUDE_DIR CRYPTO_LIBRARY
          SUNDIALS_INCLUDE_DIR ODEINT_INCLUDE_DIR)
    if(${setting})
      string(APPEND text "set(${setting} \"${${setting}}\" CACHE STRING \"\")\n")
    endif()
  endforeach()
  foreach(setting RA2D_MAINTAINER RA2D_BACKEND RA2D_BUNDLE RA2D_ONE_MARCH RA2D_KOKKOS_ARCHIVE Kokkos_ROOT FETCHCONTENT_SOURCE_DIR_KOKKOS)
    string(APPEND text "set(${setting} \"${${setting}}\" CACHE STRING \"\" FORCE)\n")  # empty ones, too
  endforeach()
  file(CONFIGURE OUTPUT ${settings} CONTENT "${text}" @ONLY)
  set(${name} ${settings} PARENT_SCOPE)
endfunction()
