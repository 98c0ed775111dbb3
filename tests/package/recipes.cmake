# The recipes for package managers fit the tree: they have its version, and the options that they set
# exist. The managers themselves are not run.
# Usage: cmake -DROOT=<tree> [-DRECIPES=<folder>] -P recipes.cmake
# SPDX-License-Identifier: BSD-3-Clause
cmake_minimum_required(VERSION 3.24)

if(NOT DEFINED RECIPES)
  set(RECIPES "${ROOT}/tests/package")
endif()
set(faults 0)
macro(fault text)
  message(NOTICE "${text}")
  math(EXPR faults "${faults} + 1")
endmacro()

file(READ "${ROOT}/include/bristle/core/version.hpp" text)
set(version "")
foreach(part MAJOR MINOR PATCH)
  string(REGEX MATCH "BRISTLE_VERSION_${part} ([0-9]+)" found "${text}")
  list(APPEND version "${CMAKE_MATCH_1}")
endforeach()
list(JOIN version "." version)

file(STRINGS "${ROOT}/CMakeLists.txt" lines REGEX "^option\\(BRISTLE_")
set(options "")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^option\\((BRISTLE_[A-Z_]+) .*" "\\1" option "${line}")
  list(APPEND options "${option}")
endforeach()

# Every option that a recipe names is one of the tree, and what it must turn off is named.
function(check_options recipe text)
  string(REGEX MATCHALL "BRISTLE_[A-Z_]*[A-Z]" names "${text}")
  list(REMOVE_DUPLICATES names)
  # The version, and definitions of targets; BRISTLE_WITH_FCL is one of these, too.
  list(REMOVE_ITEM names BRISTLE_VERSION BRISTLE_COMPILED)
  foreach(name IN LISTS names)
    if(NOT name IN_LIST options)
      fault("${recipe}: CMakeLists.txt has no option ${name}")
    endif()
  endforeach()
  foreach(name BRISTLE_BUILD_TESTS BRISTLE_BUILD_EXAMPLES BRISTLE_BUILD_BENCHMARKS BRISTLE_INSTALL
               BRISTLE_WERROR BRISTLE_BUILD_COMPILED BRISTLE_WITH_FCL BRISTLE_WITH_ADF)
    if(NOT name IN_LIST names)
      fault("${recipe}: leaves ${name} to chance")
    endif()
  endforeach()
  set(faults ${faults} PARENT_SCOPE)
endfunction()

# vcpkg ---------------------------------------------------------------------------------------------

file(READ "${RECIPES}/vcpkg/portfile.cmake" port)
check_options(portfile.cmake "${port}")
file(READ "${RECIPES}/vcpkg/vcpkg.json" manifest)
string(JSON name ERROR_VARIABLE error GET "${manifest}" name)
if(error)
  message(FATAL_ERROR "vcpkg.json: ${error}")
endif()
string(JSON written GET "${manifest}" version)
if(NOT name STREQUAL "bristle" OR NOT written STREQUAL version)
  fault("vcpkg.json: is ${name} ${written}, must be bristle ${version}")
endif()
string(JSON count LENGTH "${manifest}" features)
math(EXPR last "${count} - 1")
set(features "")
foreach(i RANGE ${last})
  string(JSON feature MEMBER "${manifest}" features ${i})
  list(APPEND features "${feature}")
  if(NOT port MATCHES " ${feature} BRISTLE_(WITH|BUILD)_[A-Z]+\n")
    fault("portfile.cmake: the feature ${feature} of vcpkg.json turns no option on")
  endif()
endforeach()
string(REGEX MATCHALL "[a-z]+ BRISTLE_[A-Z_]+\n" mapped "${port}")
list(LENGTH mapped mapped)
if(NOT mapped EQUAL count)
  fault("portfile.cmake: ${mapped} features, ${count} in vcpkg.json")
endif()

# Conan ---------------------------------------------------------------------------------------------

file(READ "${RECIPES}/conan/conanfile.py" recipe)
check_options(conanfile.py "${recipe}")
# Its version it reads itself, by the same pattern.
if(NOT recipe MATCHES "#define BRISTLE_VERSION_{part}" OR recipe MATCHES "\n *version *=")
  fault("conanfile.py: does not read version.hpp")
endif()
foreach(feature IN LISTS features)
  if(NOT recipe MATCHES "\"(with_)?${feature}\": .True, False.,")
    fault("conanfile.py: no option for the feature ${feature} of vcpkg.json")
  endif()
endforeach()
find_program(python python3)
if(python)
  foreach(file conan/conanfile.py conan/test_package/conanfile.py)
    # Compiled in memory: nothing is written beside the recipe.
    execute_process(
      COMMAND "${python}" -c "import sys; compile(open(sys.argv[1]).read(), sys.argv[1], 'exec')"
              "${RECIPES}/${file}"
      RESULT_VARIABLE result ERROR_VARIABLE errors)
    if(NOT result EQUAL 0)
      fault("${file}: ${errors}")
    endif()
  endforeach()
else()
  message(STATUS "python3 is not installed, so the recipe for Conan is not compiled")
endif()

if(faults)
  message(FATAL_ERROR "${faults} faults in recipes")
endif()
message(STATUS "recipes fit version ${version} and ${count} features")
