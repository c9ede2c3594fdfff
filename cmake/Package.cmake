# SPDX-License-Identifier: BSD-3-Clause
# Install and export: `find_package(ra2d)` gives ra2d::kernels (headers) and ra2d::host (library).
# The component `runtime` is what users of the program need. A Kokkos that was built here installs
# itself, and its own package, into the same prefix, outside of it.
include(CMakePackageConfigHelpers)
include(PortableSettings)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ra2d)
set(runtime COMPONENT runtime)
set(development COMPONENT development)

# ra2d_install_python(OPTION...): the Python package. It finds the program from where it stands:
# PYTHONPATH=PREFIX/share/ra2d.
function(ra2d_install_python)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/host/python/ra2d DESTINATION ${CMAKE_INSTALL_DATADIR}/ra2d ${ARGN}
          FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "page.html" PATTERN "__pycache__" EXCLUDE)
endfunction()

install(TARGETS ra2d_base ra2d_kernels ra2d_host EXPORT ra2dTargets ${development})
install(EXPORT ra2dTargets NAMESPACE ra2d:: DESTINATION ${package_dir} ${development})
# All headers but the program's own and those that include toml++, HDF5 or Eigen: users of the
# library need none of these. No other header may include one of them (tests/install looks).
set(private_headers "/host/(commands$|base/decompositions[.]|scene_file/toml[.]|model/contact_program[.]|study/clusters[.]|store/(attributes|hdf5|read_back|sealed_hdf5|shock_rows|table|unfinished_file)[.])")
foreach(part kernels host)
  install(DIRECTORY ${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ra2d ${development}
          FILES_MATCHING PATTERN "*.hpp" REGEX "${private_headers}" EXCLUDE)
endforeach()
configure_package_config_file(cmake/ra2dConfig.cmake.in ${PROJECT_BINARY_DIR}/ra2dConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ra2dConfig.cmake ${PROJECT_BINARY_DIR}/ra2dConfigVersion.cmake
        DESTINATION ${package_dir} ${development})

install(TARGETS ra2d RUNTIME_DEPENDENCY_SET packed_libraries RUNTIME ${runtime})
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/ra2d ${runtime})
ra2d_install_python(${runtime})
# The pages, laid out as here, so that their links hold.
install(FILES LICENSE README.md CHANGELOG.md CITATION.cff CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} ${runtime})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} ${runtime}
        FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.csv" PATTERN "*.ipynb")
install(FILES host/python/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/host/python ${runtime})
install(FILES bench/accuracy.png DESTINATION ${CMAKE_INSTALL_DOCDIR}/bench ${runtime})

# Manual pages and completions, written by the program itself.
set(manuals ${PROJECT_BINARY_DIR}/manuals)
set(write_manuals COMMAND ra2d --write-manuals ${manuals} ${PROJECT_SOURCE_DIR}/docs/scene.md)
if(RA2D_WARPS)  # where there is no driver of a card, the program does not start
  set(write_manuals COMMAND $<TARGET_FILE:ra2d> --write-manuals ${manuals} ${PROJECT_SOURCE_DIR}/docs/scene.md
      || ${CMAKE_COMMAND} -E echo "ra2d does not start here: there are no manual pages")
endif()
add_custom_command(OUTPUT ${manuals}/made
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manuals}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manuals}
  ${write_manuals}
  COMMAND ${CMAKE_COMMAND} -E touch ${manuals}/made
  DEPENDS ra2d ${PROJECT_SOURCE_DIR}/docs/scene.md)
add_custom_target(ra2d_manuals ALL DEPENDS ${manuals}/made)
install(DIRECTORY ${manuals}/ DESTINATION ${CMAKE_INSTALL_DATADIR} ${runtime} PATTERN made EXCLUDE)

if(RA2D_SANITIZE OR NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()
# Packages: NAME.tar.gz, which stands in any folder and brings its shared libraries, and a .deb
# where dpkg-dev is.
if(RA2D_PORTABLE)
  set_target_properties(ra2d PROPERTIES INSTALL_RPATH "$ORIGIN/../lib/ra2d")
endif()
install(RUNTIME_DEPENDENCY_SET packed_libraries
  # but for the C library, which the machine has, and the driver, which is the machine's own
  PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|mvec|dl|rt|pthread|resolv|util|anl)\\.so" "^libcuda\\.so"
  LIBRARY DESTINATION lib/ra2d COMPONENT libraries EXCLUDE_FROM_ALL)
# Debian's python3 looks into dist-packages.
install(CODE [[
  set(folder $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/python3/dist-packages)
  file(MAKE_DIRECTORY ${folder})
  file(CREATE_LINK ../../../share/ra2d/ra2d ${folder}/ra2d SYMBOLIC)
  file(GLOB pages $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/man/man*/ra2d*)
  execute_process(COMMAND gzip -9nf ${pages} COMMAND_ERROR_IS_FATAL ANY)
]] COMPONENT debian EXCLUDE_FROM_ALL)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE license)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/copyright @ONLY CONTENT [[ra2d is under the BSD-3-Clause license below. The program in this package is
linked with FFTW, which is under the GNU General Public License, version 2 or
later: the program as a whole is passed on under the terms of that license
(/usr/share/common-licenses/GPL-2).

@license@]])
install(FILES ${PROJECT_BINARY_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT debian EXCLUDE_FROM_ALL)

find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
find_program(GZIP gzip)
set(CPACK_GENERATOR TGZ)
if(DPKG_SHLIBDEPS AND GZIP)
  list(APPEND CPACK_GENERATOR DEB)
endif()
set(built_for "any x86-64 processor with AVX2 and FMA (since 2013 to 2015)")
set(kind)
if(NOT RA2D_X86_64_V3)
  set(built_for "the machine that built it, and processors with the same instructions")
  set(kind "-native")
endif()
set(CPACK_COMPONENTS_GROUPING ALL_COMPONENTS_IN_ONE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_NAME ra2d)
set(CPACK_PACKAGE_VENDOR "The ra2d authors")
set(RA2D_MAINTAINER "The ra2d authors" CACHE STRING "Who makes the .deb: Name <address>")
set(CPACK_PACKAGE_CONTACT "${RA2D_MAINTAINER}")
set(CPACK_PACKAGE_FILE_NAME ra2d-${PROJECT_VERSION}-linux-${CMAKE_SYSTEM_PROCESSOR}${kind})
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/PackageKinds.cmake)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
if(kind)
  set(CPACK_DEBIAN_PACKAGE_RELEASE 1native)
endif()
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-h5py, python3-jinja2, python3-matplotlib, python3-numpy, python3-pandas, python3-scipy, python3-soundfile, python3-xarray, python3-xxhash")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "friction noise of rough surfaces")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Two beams with rough faces slide past each other. Their asperities collide,
and each collision rings the beams' modes. From a scene come the vibration
level with its error, every shock, pictures, sound and a page.

Pictures, sound, pages and the Python package ra2d need the recommended
packages. The program is built for
${built_for}.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/postinst ${PROJECT_SOURCE_DIR}/cmake/debian/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
if(RA2D_PORTABLE)
  include(CPack)  # which makes the target `package`
  return()
endif()
# This build is for this machine's processor: the packages have a build of their own. A package of
# this build is named "native", for this machine and for tests/package.
set(CPACK_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/native-package/CPackConfig.cmake)
set(CPACK_SOURCE_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/native-package/CPackSourceConfig.cmake)
include(CPack)
ra2d_write_portable_settings(settings)
add_custom_target(package
  COMMAND ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${PROJECT_BINARY_DIR}/package -G ${CMAKE_GENERATOR}
          -C ${settings} -DRA2D_PORTABLE=ON -DRA2D_TESTS=OFF -DRA2D_BENCH=OFF
          -DCPACK_OUTPUT_FILE_PREFIX=${PROJECT_BINARY_DIR}
  COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR}/package --target package
  USES_TERMINAL VERBATIM)
