# SPDX-License-Identifier: BSD-3-Clause
# Run by ctest as it starts (ra2d_add_cases in tests/CMakeLists.txt): makes tests of the cases of a
# program of GoogleTest. A process takes longer to start than most cases to run, under sanitizers
# many times as long. So up to ten cases of a suite share one; a failing case is named in the
# output. With RA2D_TEST_CASES=1 in the environment each case has its own process and name. program,
# prefix, filter: the executable, what the names begin with, the filter of the cases left_out: a
# file of regular expressions, one a line, of names that are left out; or empty properties: of all
# these tests
if(NOT EXISTS "${program}")
  add_test("${prefix}not_built" "${program}")  # which fails
  return()
endif()
execute_process(COMMAND "${program}" --gtest_list_tests "--gtest_filter=${filter}" OUTPUT_VARIABLE listed
                RESULT_VARIABLE failed TIMEOUT 60)
if(NOT failed STREQUAL "0")
  add_test("${prefix}list" "${program}" --gtest_list_tests)  # says why
  return()
endif()

set(most 10)
if("$ENV{RA2D_TEST_CASES}")
  set(most 1)
endif()
set(unwanted)
if(left_out)
  file(STRINGS "${left_out}" unwanted REGEX "^[^#]")
endif()
# one by one: a regular expression of CMake has at most 31 parentheses
function(is_left_out name out)
  foreach(pattern IN LISTS unwanted)
    if("${name}" MATCHES "${pattern}")
      set(${out} TRUE PARENT_SCOPE)
      return()
    endif()
  endforeach()
  set(${out} FALSE PARENT_SCOPE)
endfunction()

string(REGEX REPLACE " *#[^\n]*" "" listed "${listed}")  # the values of parameters
string(REPLACE "\n" ";" listed "${listed}")
set(suites)
foreach(line IN LISTS listed)
  if(line MATCHES "^([^ ]+)[.]$")
    set(suite ${CMAKE_MATCH_1})
    list(APPEND suites ${suite})
    set(cases_${suite})
  elseif(line MATCHES "^  ([^ ]+)$")
    set(case ${suite}.${CMAKE_MATCH_1})
    is_left_out("${prefix}${case}" omitted)
    if(NOT omitted)
      list(APPEND cases_${suite} ${case})
    endif()
  endif()
endforeach()

set(names)
foreach(suite IN LISTS suites)
  set(cases ${cases_${suite}})
  list(LENGTH cases count)
  math(EXPR parts "(${count} + ${most} - 1) / ${most}")
  set(part 0)
  while(part LESS parts)
    math(EXPR first "${part} * ${most}")
    math(EXPR part "${part} + 1")
    list(SUBLIST cases ${first} ${most} these)
    if(most EQUAL 1)
      set(name "${prefix}${these}")
    elseif(parts EQUAL 1)
      set(name "${prefix}${suite}")
    else()
      set(name "${prefix}${suite}_${part}/${parts}")
    endif()
    list(JOIN these ":" these)
    add_test("${name}" "${program}" "--gtest_filter=${these}")
    list(APPEND names "${name}")
  endwhile()
endforeach()
if(names)
  set_tests_properties(${names} PROPERTIES ${properties})
endif()
