# SPDX-License-Identifier: BSD-3-Clause
# Writes HEADER with the commit of SOURCE, when it is not that of the last time. Run with cmake -P.
set(commit unknown)
if(GIT)
  execute_process(COMMAND ${GIT} describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
                  RESULT_VARIABLE failed)
  if(NOT failed)
    set(commit ${described})
  endif()
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define RA2D_COMMIT \"${commit}\"\n" @ONLY)
