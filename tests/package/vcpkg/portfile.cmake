# An overlay port of the tree that it stands in:
#   vcpkg install bristle --overlay-ports=<tree>/tests/package/vcpkg
# A registry's copy gets the source by vcpkg_from_github instead, at the tag of the release.
# SPDX-License-Identifier: BSD-3-Clause
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(
    OUT_FEATURE_OPTIONS FEATURE_OPTIONS
    FEATURES
        adf BRISTLE_WITH_ADF
        compiled BRISTLE_BUILD_COMPILED
        fcl BRISTLE_WITH_FCL
)

if("compiled" IN_LIST FEATURES)
    # It names no symbols for export from a DLL.
    if(VCPKG_TARGET_IS_WINDOWS)
        vcpkg_check_linkage(ONLY_STATIC_LIBRARY)
    endif()
else()
    # Headers are the same in every configuration.
    set(VCPKG_BUILD_TYPE release)
endif()

vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        ${FEATURE_OPTIONS}
        -DBRISTLE_BUILD_BENCHMARKS=OFF
        -DBRISTLE_BUILD_EXAMPLES=OFF
        -DBRISTLE_BUILD_TESTS=OFF
        -DBRISTLE_INSTALL=ON
        -DBRISTLE_WERROR=OFF
)
vcpkg_cmake_install()
if("compiled" IN_LIST FEATURES)
    vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/bristle)
endif()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/bristle)
vcpkg_fixup_pkgconfig()

file(REMOVE_RECURSE
    "${CURRENT_PACKAGES_DIR}/debug/include"
    "${CURRENT_PACKAGES_DIR}/debug/share"
    "${CURRENT_PACKAGES_DIR}/share/doc"
)

file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
