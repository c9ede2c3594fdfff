# SPDX-License-Identifier: BSD-3-Clause
# Empties FOLDER (-DSTEP=clear), or writes FOLDER/about and packs FOLDER into FOLDER.tar.gz. Run
# with cmake -P.
if(STEP STREQUAL "clear")
  file(GLOB content ${FOLDER}/*)
  if(content AND NOT EXISTS ${FOLDER}/about)
    message(FATAL_ERROR "RA2D_BUNDLE = ${FOLDER}: there is something else in this folder, which a bundle would replace. "
                        "Name a folder of its own")
  endif()
  file(REMOVE_RECURSE ${FOLDER} ${FOLDER}.tar.gz)
  return()
endif()
file(STRINGS ${COMMIT_HEADER} commit REGEX "RA2D_COMMIT")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" commit "${commit}")
file(WRITE ${FOLDER}/about "version ${VERSION}
commit ${commit}
backend ${BACKEND}
compiler ${COMPILER}
host_flags ${HOST_FLAGS}
marches ${MARCHES}
kokkos ${KOKKOS}
architectures ${ARCHITECTURES}
c_library ${C_LIBRARY}
")
get_filename_component(parent ${FOLDER} DIRECTORY)
get_filename_component(name ${FOLDER} NAME)
execute_process(COMMAND ${CMAKE_COMMAND} -E tar czf ${name}.tar.gz ${name} WORKING_DIRECTORY ${parent}
                COMMAND_ERROR_IS_FATAL ANY)
file(SIZE ${FOLDER}.tar.gz size)
math(EXPR size "(${size} + 999999) / 1000000")
message(STATUS "${FOLDER}.tar.gz: ${size} MB")
