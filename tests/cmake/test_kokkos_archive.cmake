# SPDX-License-Identifier: BSD-3-Clause
# Which archive of Kokkos is taken (cmake/KokkosArchive.cmake). Run with cmake -DSOURCE=...
# -DFOLDER=... -P.
cmake_minimum_required(VERSION 3.25)
include(${SOURCE}/cmake/KokkosArchive.cmake)

if(DEFINED CHECK)  # the child of expect_refusal
  ra2d_check_archive(${CHECK} version ${FOLDER}/look)
  return()
endif()

function(expect_equal actual expected)
  if(NOT "${actual}" STREQUAL "${expected}")
    message(SEND_ERROR "'${actual}' where '${expected}' was expected")
  endif()
endfunction()
function(expect_match actual expected)
  if(NOT "${actual}" MATCHES "${expected}")
    message(SEND_ERROR "'${actual}' does not match '${expected}'")
  endif()
endfunction()

file(REMOVE_RECURSE ${FOLDER})
set(mirror ${FOLDER}/mirror)
function(make_archive name version)
  string(REGEX MATCH "^([0-9]+)\\.([0-9]+)\\.([0-9]+)$" matched ${version})
  file(WRITE ${FOLDER}/made/kokkos-${version}/CMakeLists.txt
       "set(Kokkos_VERSION_MAJOR ${CMAKE_MATCH_1})\nset(Kokkos_VERSION_MINOR ${CMAKE_MATCH_2})\n"
       "set(Kokkos_VERSION_PATCH ${CMAKE_MATCH_3})\n")
  file(MAKE_DIRECTORY ${mirror})
  execute_process(COMMAND ${CMAKE_COMMAND} -E tar czf ${mirror}/${name} kokkos-${version}
                  WORKING_DIRECTORY ${FOLDER}/made COMMAND_ERROR_IS_FATAL ANY)
endfunction()
foreach(version 5.8.0 5.9.1 4.7.0)
  make_archive(kokkos-${version}.tar.gz ${version})
  file(SHA256 ${mirror}/kokkos-${version}.tar.gz hash_${version})
endforeach()
set(gone 0000000000000000000000000000000000000000000000000000000000000000)
set(releases 5.9.2=${gone} 5.9.1=${hash_5.9.1} 5.8.0=${hash_5.8.0})
set(here file://${mirror}/kokkos-{version}.tar.gz)
set(nowhere file://${FOLDER}/nowhere/kokkos-{version}.tar.gz)

# the first that can be had
ra2d_first_archive(file version hash tried RELEASES ${releases} ADDRESSES ${nowhere} ${here} FOLDER ${FOLDER}/a)
expect_equal("${file}" ${FOLDER}/a/kokkos-5.9.1.tar.gz)
expect_equal("${version}" 5.9.1)
expect_equal("${hash}" ${hash_5.9.1})

# what is there already needs no address; no partial file was left
ra2d_first_archive(file version hash tried RELEASES ${releases} FOLDER ${FOLDER}/a)
expect_equal("${version}" 5.9.1)
file(GLOB left RELATIVE ${FOLDER}/a ${FOLDER}/a/*)
expect_equal("${left}" kokkos-5.9.1.tar.gz)

# what is there but damaged is fetched again
file(WRITE ${FOLDER}/a/kokkos-5.9.1.tar.gz "damaged")
ra2d_first_archive(file version hash tried RELEASES ${releases} ADDRESSES ${here} FOLDER ${FOLDER}/a)
expect_equal("${version}" 5.9.1)
file(SHA256 ${file} actual)
expect_equal(${actual} ${hash_5.9.1})

# another file under the release's name is not taken
ra2d_first_archive(file version hash tried RELEASES 5.9.1=${gone} 5.8.0=${hash_5.8.0} ADDRESSES ${here} FOLDER ${FOLDER}/b)
expect_equal("${version}" 5.8.0)
ra2d_first_archive(file version hash tried RELEASES 5.9.1=${gone} ADDRESSES ${here} FOLDER ${FOLDER}/c)
expect_equal("${file}" "")
expect_match("${tried}" "kokkos-5.9.1.tar.gz: another file than the release \\(SHA-256 ${hash_5.9.1}\\)")

# each address that was tried is named; a host that cannot be reached is asked once
ra2d_first_archive(file version hash tried RELEASES ${releases} ADDRESSES ${nowhere} http://127.0.0.1:1/{version} FOLDER ${FOLDER}/d)
expect_equal("${file}" "")
string(REGEX MATCHALL "nowhere/kokkos-5" files "${tried}")
string(REGEX MATCHALL "127\\.0\\.0\\.1" hosts "${tried}")
list(LENGTH files files)
list(LENGTH hosts hosts)
expect_equal(${files} 3)
expect_equal(${hosts} 1)

# an archive that the user names
ra2d_check_archive(${mirror}/kokkos-5.8.0.tar.gz version ${FOLDER}/look)
expect_equal("${version}" 5.8.0)
function(expect_refusal file reason)
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE=${SOURCE} -DFOLDER=${FOLDER} -DCHECK=${file} -P ${CMAKE_CURRENT_LIST_FILE}
                  RESULT_VARIABLE status ERROR_VARIABLE text)
  expect_equal("${status}" 1)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")
  expect_match("${text}" "${reason}.*kokkos-5\\.x\\.y\\.tar\\.gz")
endfunction()
expect_refusal(${mirror}/none.tar.gz "there is no such file")
expect_refusal(${mirror} "there is no such file")
expect_refusal(${mirror}/kokkos-4.7.0.tar.gz "it holds Kokkos 4\\.7\\.0")
file(WRITE ${mirror}/text.tar.gz "no archive")
expect_refusal(${mirror}/text.tar.gz "it cannot be unpacked")
file(WRITE ${FOLDER}/made/other/README "nothing")
execute_process(COMMAND ${CMAKE_COMMAND} -E tar czf ${mirror}/other.tar.gz other WORKING_DIRECTORY ${FOLDER}/made)
expect_refusal(${mirror}/other.tar.gz "no Kokkos is in it")
file(REMOVE_RECURSE ${FOLDER})
