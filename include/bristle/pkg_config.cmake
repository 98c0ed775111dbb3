# Installs the targets for builds that ask pkg-config: bristle, bristle-fcl, bristle-compiled and
# bristle-compiled-adf, each with the definitions that its target exports. They find their prefix from
# where they stand. FCL's own file is not required by them, since it sets C++11 for all.
# SPDX-License-Identifier: BSD-3-Clause

# Installs `name`.pc under `dir`, lib/ or share/.
function(bristle_install_pc name dir description requires cflags libs)
  file(RELATIVE_PATH to_prefix "/${dir}/pkgconfig" "/")
  string(REGEX REPLACE "/$" "" to_prefix "${to_prefix}")
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY CONTENT [=[
prefix=${pcfiledir}/@to_prefix@
includedir=${prefix}/@CMAKE_INSTALL_INCLUDEDIR@
libdir=${prefix}/@CMAKE_INSTALL_LIBDIR@

Name: @name@
Description: @description@
Version: @PROJECT_VERSION@
Requires: @requires@
Cflags: @cflags@
Libs: @libs@
]=])
  install(FILES "${PROJECT_BINARY_DIR}/${name}.pc" DESTINATION "${dir}/pkgconfig")
endfunction()

# Installs `name`.pc for the library `target`; `needs` are the libraries that a static one was compiled
# with.
function(bristle_install_library_pc name target description requires needs)
  get_target_property(library ${target} OUTPUT_NAME)
  get_target_property(type ${target} TYPE)
  set(libs "-L\${libdir} -l${library}")
  if(type STREQUAL "STATIC_LIBRARY" AND needs)
    string(APPEND libs " ${needs}")
  endif()
  bristle_install_pc(${name} "${CMAKE_INSTALL_LIBDIR}" "${description}" "${requires}"
                     "-DBRISTLE_COMPILED" "${libs}")
endfunction()

bristle_install_pc(bristle "${CMAKE_INSTALL_DATADIR}" "${PROJECT_DESCRIPTION}" "eigen3 >= 3.4"
                   "-I\${includedir}" "")
set(fcl_libs "")
if(TARGET bristle_fcl)
  set(fcl_libs "-lfcl -lccd")
  get_target_property(type fcl TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    string(APPEND fcl_libs " -loctomap -loctomath")
  endif()
  bristle_install_pc(bristle-fcl "${CMAKE_INSTALL_DATADIR}" "bristle with its FCL backend" bristle
                     "-DBRISTLE_WITH_FCL" "-L\${libdir} ${fcl_libs}")
endif()
if(TARGET bristle_compiled)
  bristle_install_library_pc(bristle-compiled bristle_compiled "bristle, compiled once" bristle
                             "${fcl_libs}")
endif()
if(TARGET bristle_compiled_adf)
  bristle_install_library_pc(bristle-compiled-adf bristle_compiled_adf
                             "bristle's scene files, compiled once" bristle-compiled "-lyaml-cpp")
endif()
