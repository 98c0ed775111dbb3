# What a user of the library meets: at most MAX_TYPES types outside of `namespace detail`, each of
# them named by an example or a page.
# Usage: cmake -DROOT=<tree> [-DMAX_TYPES=110] [-DLIST=ON] -P surface.cmake
# SPDX-License-Identifier: BSD-3-Clause
include("${CMAKE_CURRENT_LIST_DIR}/lines.cmake")

if(NOT DEFINED MAX_TYPES)
  set(MAX_TYPES 110)
endif()

# Words of all pages and examples: a record of a decision or a measurement does not tell a user
# how to use anything.
list_files(pages "README.md" "docs/*.md" "examples/*.cpp" "examples/*.hpp")
list(FILTER pages EXCLUDE REGEX "^docs/(decisions|measurements|changelog)")
set(words "")
foreach(page IN LISTS pages)
  file(READ "${ROOT}/${page}" text)
  string(REGEX MATCHALL "[A-Z][A-Za-z0-9]+" found "${text}")
  list(REMOVE_DUPLICATES found)
  list(APPEND words ${found})
endforeach()
list(REMOVE_DUPLICATES words)

list_files(headers "include/bristle/*.hpp")
set(types "")
foreach(header IN LISTS headers)
  set(is_public OFF)
  set(number 0)
  read_lines("${ROOT}/${header}" lines)
  foreach(line IN LISTS lines)
    math(EXPR number "${number} + 1")
    if(line MATCHES "^namespace bristle::inline BRISTLE_ABI {")
      set(is_public ON)
    elseif(line MATCHES "^namespace detail {" OR line MATCHES "^}  // namespace bristle")
      set(is_public OFF)
    elseif(line STREQUAL "}  // namespace detail")
      set(is_public ON)
    elseif(is_public AND line MATCHES "^(struct|class|enum class|using|concept) ([A-Z][A-Za-z0-9]*)(.*)$")
      set(kind "${CMAKE_MATCH_1}")
      set(type "${CMAKE_MATCH_2}")
      if(kind MATCHES "struct|class" AND CMAKE_MATCH_3 MATCHES "${SEMICOLON}$")
        continue()  # only declared
      endif()
      if(type IN_LIST types)
        continue()  # a specialisation
      endif()
      list(APPEND types "${type}")
      if(LIST)
        message(STATUS "${type} (${header})")
      endif()
      if(NOT type IN_LIST words)
        violation("${header}:${number}" "${type} is for users, and no page or example names it: name \
it, or move it to `detail`")
      endif()
    endif()
  endforeach()
endforeach()
list(LENGTH types count)
if(count GREATER MAX_TYPES)
  violation("include/bristle/bristle.hpp:1" "${count} types for users, more than ${MAX_TYPES}")
endif()
conclude("${count} types for users")
