# The target bristle::compiled: worlds, haptic loops, host patches, backends and loaders in float and
# double, compiled once, with the kernels of a step for every instruction set in BRISTLE_KERNELS.
# Static or shared, as BUILD_SHARED_LIBS has it.
# SPDX-License-Identifier: BSD-3-Clause

# Kernels of sets other than the baseline need a linker that can make all symbols of an object local:
# then no function that was compiled for wide registers takes the place of one that all use.
set(bristle_wide_sets "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$" AND CMAKE_SYSTEM_NAME STREQUAL "Linux"
   AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang" AND CMAKE_OBJCOPY)
  execute_process(COMMAND "${CMAKE_LINKER}" --help OUTPUT_VARIABLE linker_help ERROR_QUIET)
  if(linker_help MATCHES "--force-group-allocation")
    set(bristle_wide_sets v3 v4)
  endif()
endif()
set(BRISTLE_KERNELS "${bristle_wide_sets}" CACHE STRING
    "Instruction sets besides the baseline that bristle::compiled has kernels for: v3, v4")

set(BRISTLE_COMPILED_FLAGS "" CACHE STRING
    "Flags of bristle::compiled after those of the build type, such as -O2")
mark_as_advanced(BRISTLE_COMPILED_FLAGS)

# What a step computes is compiled for each instruction set: kernels in each scalar, and what they ask
# of the backends in both at once.
set(bristle_kernels_of_scalar kernels.cpp)
set(bristle_queries_of_both geometry/backends/backend_queries.cpp)
# Most of the compile time of these is reading the same headers: they are compiled as one file.
set(small geometry/backends/backend_makers.cpp geometry/meshes/terrain.cpp
          geometry/shapes/quickhull.cpp hosts/host_sensors.cpp io/glb.cpp io/mesh_file.cpp
          sensors/placement.cpp)
# Everything in the baseline.
set(bristle_sources_of_scalar ${bristle_kernels_of_scalar} world/world.cpp)
set(bristle_sources_of_both ${bristle_queries_of_both} ${small})
set(bristle_optional_fcl "")
if(TARGET bristle::fcl)
  set(bristle_optional_fcl bristle::fcl)
endif()

list(TRANSFORM small PREPEND "${CMAKE_CURRENT_LIST_DIR}/")
set_source_files_properties(${small} PROPERTIES UNITY_GROUP small)
# Kernels and world are one file where tests are, too, which takes a fifth less. Without tests they
# are apart, since many processors are done sooner with more files.
if(BRISTLE_BUILD_TESTS AND BRISTLE_JOIN_TESTS)
  set_source_files_properties("${CMAKE_CURRENT_LIST_DIR}/kernels.cpp"
                              "${CMAKE_CURRENT_LIST_DIR}/world/world.cpp"
                              PROPERTIES UNITY_GROUP of_scalar)
endif()

# What all of the library is compiled with. No fused multiply-adds: all instruction sets round alike.
function(bristle_compiled_options target)
  if(PROJECT_IS_TOP_LEVEL)
    bristle_program_options(${target})
  endif()
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF)
  target_link_libraries(${target} PRIVATE bristle ${bristle_optional_fcl})
  target_compile_definitions(${target} PRIVATE BRISTLE_COMPILED)
  target_compile_options(
    ${target} PRIVATE ${BRISTLE_COMPILED_FLAGS} $<$<CXX_COMPILER_ID:GNU,Clang>:-ffp-contract=off>
                      $<$<BOOL:${BRISTLE_BUILD_FUZZERS}>:-fsanitize=fuzzer-no-link>)
endfunction()

# Makes an object library of `ARGN` for the instruction set `set`, in `scalar` or in "both".
function(bristle_add_objects target scalar set)
  list(TRANSFORM ARGN PREPEND "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/")
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${ARGN})
  bristle_compiled_options(${target})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  target_compile_definitions(${target} PRIVATE BRISTLE_KERNELS=${set})
  if(scalar STREQUAL "both")
    target_compile_definitions(${target} PRIVATE BRISTLE_WITH_DEFINITIONS)
  else()
    target_compile_definitions(${target} PRIVATE BRISTLE_INSTANTIATE=${scalar})
  endif()
endfunction()

# Adds kernels for the instruction set `set` to `library`: one object that exports two plain functions
# and nothing else. Once for each set: its parts have names of their own.
function(bristle_add_kernels library set)
  bristle_add_objects(bristle_both_${set} both ${set} ${bristle_queries_of_both})
  foreach(scalar float double)
    bristle_add_objects(bristle_${scalar}_${set} ${scalar} ${set} ${bristle_kernels_of_scalar})
  endforeach()
  set(objects "")
  foreach(part both float double)
    target_compile_options(
      bristle_${part}_${set} PRIVATE -march=x86-64-${set} -fno-lto
                                     $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
    list(APPEND objects $<TARGET_OBJECTS:bristle_${part}_${set}>)
  endforeach()
  set(joined "${CMAKE_CURRENT_BINARY_DIR}/bristle_kernels_${set}_joined.o")
  set(object "${CMAKE_CURRENT_BINARY_DIR}/bristle_kernels_${set}.o")
  add_custom_command(
    OUTPUT "${object}"
    COMMAND "${CMAKE_LINKER}" -r --force-group-allocation -o "${joined}" ${objects}
    COMMAND "${CMAKE_OBJCOPY}" --keep-global-symbol=bristle_kernels_float_${set}
            --keep-global-symbol=bristle_kernels_double_${set} "${joined}" "${object}"
    DEPENDS ${objects}
    COMMENT "Closing the kernels for x86-64-${set}"
    COMMAND_EXPAND_LISTS VERBATIM)
  set_source_files_properties("${object}" PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
  target_sources(${library} PRIVATE "${object}")
  string(TOUPPER "${set}" name)
  target_compile_definitions(${library} PRIVATE BRISTLE_KERNELS_${name})
  set_property(TARGET ${library} APPEND PROPERTY BRISTLE_CLOSED_OBJECTS "${object}")
  add_dependencies(${library} bristle_both_${set} bristle_float_${set} bristle_double_${set})
endfunction()

# Makes `library` of what is compiled for the baseline, and of kernels for each set in `ARGN`.
function(bristle_add_compiled library type)
  add_library(${library} ${type} "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/core/instruction_set.cpp")
  bristle_compiled_options(${library})
  target_link_libraries(${library} PUBLIC bristle PRIVATE ${bristle_optional_fcl})
  target_compile_definitions(${library} PUBLIC BRISTLE_COMPILED)
  foreach(part both float double)
    target_sources(${library} PRIVATE $<TARGET_OBJECTS:bristle_${part}>)
  endforeach()
  foreach(set IN LISTS ARGN)
    bristle_add_kernels(${library} ${set})
  endforeach()
endfunction()

set(type STATIC)
if(BUILD_SHARED_LIBS)
  set(type SHARED)
endif()
bristle_add_objects(bristle_both both baseline ${bristle_sources_of_both})
foreach(scalar float double)
  bristle_add_objects(bristle_${scalar} ${scalar} baseline ${bristle_sources_of_scalar})
endforeach()
bristle_add_compiled(bristle_compiled ${type} ${BRISTLE_KERNELS})
add_library(bristle::compiled ALIAS bristle_compiled)
set_target_properties(bristle_compiled PROPERTIES EXPORT_NAME compiled OUTPUT_NAME bristle)

# bristle::compiled_adf: the loaders of scenes, over yaml-cpp ----------------------------------------

if(TARGET bristle::adf)
  add_library(bristle_compiled_adf ${type})
  add_library(bristle::compiled_adf ALIAS bristle_compiled_adf)
  bristle_compiled_options(bristle_compiled_adf)
  foreach(scalar float double)
    bristle_add_objects(bristle_adf_${scalar} ${scalar} baseline io/adf.cpp)
    target_link_libraries(bristle_adf_${scalar} PRIVATE bristle::adf)
    target_sources(bristle_compiled_adf PRIVATE $<TARGET_OBJECTS:bristle_adf_${scalar}>)
  endforeach()
  target_link_libraries(bristle_compiled_adf PUBLIC bristle_compiled PRIVATE bristle::adf)
  set_target_properties(bristle_compiled_adf PROPERTIES EXPORT_NAME compiled_adf
                                                        OUTPUT_NAME bristle_adf)
endif()
