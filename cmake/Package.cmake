# SPDX-License-Identifier: BSD-3-Clause
# Install and export: `find_package(ra2d)` gives ra2d::kernels (headers) and ra2d::host (library).
# A Kokkos that was built here installs itself, and its own package, into the same prefix.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ra2d)

install(TARGETS ra2d_base ra2d_kernels ra2d_host EXPORT ra2dTargets)
install(TARGETS ra2d)
install(EXPORT ra2dTargets NAMESPACE ra2d:: DESTINATION ${package_dir})
# All headers but the program's own and those that include toml++, HDF5 or Eigen: users of the library need none of
# these. No other header may include one of them (tests/install looks).
set(private_headers "/host/(commands$|base/decompositions[.]|scene_file/toml[.]|model/contact_program[.]|study/clusters[.]|store/(attributes|hdf5|read_back|sealed_hdf5|shock_rows|table|unfinished_file)[.])")
foreach(part kernels host)
  install(DIRECTORY ${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ra2d
          FILES_MATCHING PATTERN "*.hpp" REGEX "${private_headers}" EXCLUDE)
endforeach()
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/ra2d)
# The Python package finds the program from where it stands: PYTHONPATH=PREFIX/share/ra2d.
install(DIRECTORY host/python/ra2d DESTINATION ${CMAKE_INSTALL_DATADIR}/ra2d
        FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "page.html" PATTERN "__pycache__" EXCLUDE)
# The pages, laid out as here, so that their links hold.
install(FILES LICENSE README.md CHANGELOG.md CITATION.cff CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.csv"
        PATTERN "*.ipynb")
install(FILES host/python/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/host/python)
install(FILES bench/accuracy.png DESTINATION ${CMAKE_INSTALL_DOCDIR}/bench)

configure_package_config_file(cmake/ra2dConfig.cmake.in ${PROJECT_BINARY_DIR}/ra2dConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ra2dConfig.cmake ${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
        DESTINATION ${package_dir})
