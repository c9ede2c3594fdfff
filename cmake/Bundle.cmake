# SPDX-License-Identifier: BSD-3-Clause
# The target `bundle`: one folder, and the same packed, with the program, the tests, the benchmarks,
# the scenes and the shared libraries that a bare x86-64 Linux lacks. bundle/check.sh runs the tests
# and the benchmarks there.
set(RA2D_BUNDLE ${PROJECT_BINARY_DIR}/bundle CACHE PATH "Folder that the target `bundle` makes; packed beside it as .tar.gz")
if(RA2D_SANITIZE OR NOT RA2D_TESTS OR NOT RA2D_BENCH)
  return()
endif()

if(NOT RA2D_PORTABLE)
  # This build is for this machine's processor: a bundle has a build of its own.
  ra2d_write_portable_settings(settings)
  add_custom_target(bundle
    COMMAND ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${PROJECT_BINARY_DIR}/portable -G ${CMAKE_GENERATOR}
            -C ${settings} -DRA2D_PORTABLE=ON -DRA2D_TESTS=ON -DRA2D_BENCH=ON
    COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR}/portable --target bundle
    USES_TERMINAL VERBATIM)
  return()
endif()

set(programs ra2d ra2d_tests ra2d_bench)
set_target_properties(${programs} PROPERTIES INSTALL_RPATH "$ORIGIN/../lib;$ORIGIN/../lib/ra2d")
set(carried COMPONENT bundle EXCLUDE_FROM_ALL)
install(TARGETS ${programs} RUNTIME_DEPENDENCY_SET bundled_libraries RUNTIME DESTINATION bin ${carried})
install(TARGETS faulty_disk LIBRARY DESTINATION lib ${carried})
# but for the C library, which the machine has, and the driver, which is the machine's own
install(RUNTIME_DEPENDENCY_SET bundled_libraries
  PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|mvec|dl|rt|pthread|resolv|util|anl)\\.so" "^libcuda\\.so"
  LIBRARY DESTINATION lib ${carried})
install(DIRECTORY scenes DESTINATION share/ra2d ${carried})
ra2d_install_python(${carried})
install(DIRECTORY tests/host DESTINATION share/ra2d/tests ${carried} FILES_MATCHING PATTERN "*.py")
install(FILES docs/scene.md DESTINATION share/ra2d/docs ${carried})  # what tests read
install(FILES bench/accuracy.csv bench/accuracy-long.csv DESTINATION share/ra2d/bench ${carried})
install(PROGRAMS tests/bundle/check.sh DESTINATION . ${carried})
install(FILES LICENSE tests/bundle/README.txt DESTINATION . ${carried})

# What it was made of, for check.sh to put into its results.
if(Kokkos_ENABLE_CUDA)
  execute_process(COMMAND ${CUDAToolkit_NVCC_EXECUTABLE} --version OUTPUT_VARIABLE nvcc ERROR_QUIET)
  string(REGEX MATCH "release [0-9.]+, V[0-9.]+" nvcc "${nvcc}")
  set(compiled_by "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}, nvcc ${nvcc}")
else()
  set(compiled_by "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
endif()
get_cmake_property(named CACHE_VARIABLES)
list(FILTER named INCLUDE REGEX "^Kokkos_ARCH_")
set(architectures)
foreach(arch IN LISTS named)
  if(${arch})
    string(REPLACE "Kokkos_ARCH_" "" arch ${arch})
    list(APPEND architectures ${arch})
  endif()
endforeach()
if(RA2D_X86_64_V3)
  list(TRANSFORM architectures REPLACE "^HSW$" "x86-64-v3")
endif()
list(JOIN architectures " " architectures)
execute_process(COMMAND getconf GNU_LIBC_VERSION OUTPUT_VARIABLE c_library OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
add_custom_target(bundle
  COMMAND ${CMAKE_COMMAND} -DFOLDER=${RA2D_BUNDLE} -DSTEP=clear -P ${PROJECT_SOURCE_DIR}/cmake/PackBundle.cmake
  COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --component bundle --prefix ${RA2D_BUNDLE} --strip
  COMMAND ${CMAKE_COMMAND} -DFOLDER=${RA2D_BUNDLE} -DCOMMIT_HEADER=${PROJECT_BINARY_DIR}/host/commit.h
          -DVERSION=${PROJECT_VERSION} -DBACKEND=${RA2D_BACKEND} "-DCOMPILER=${compiled_by}" "-DKOKKOS=${Kokkos_VERSION}"
          "-DARCHITECTURES=${architectures}" "-DC_LIBRARY=${c_library}"
          "-DHOST_FLAGS=${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_RELEASE}" -DMARCHES=$<IF:$<BOOL:${RA2D_ONE_MARCH}>,one,all> -P ${PROJECT_SOURCE_DIR}/cmake/PackBundle.cmake
  DEPENDS ${programs} USES_TERMINAL VERBATIM)
