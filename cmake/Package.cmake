# SPDX-License-Identifier: BSD-3-Clause
# Install and export: `find_package(ra2d)` gives ra2d::kernels (headers) and ra2d::host (library).
include(CMakePackageConfigHelpers)
install(TARGETS ra2d_kernels ra2d_host EXPORT ra2d_targets)
install(TARGETS ra2d)
foreach(part kernels host)
  install(DIRECTORY ${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ra2d
          FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/ra2d)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(EXPORT ra2d_targets NAMESPACE ra2d:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/ra2d)
configure_package_config_file(cmake/ra2dConfig.cmake.in ${PROJECT_BINARY_DIR}/ra2dConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/ra2d)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ra2dConfig.cmake ${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/ra2d)
