# The tree that this recipe stands in, as a package of Conan 2:
#   conan create <tree>/tests/package/conan
# A registry's copy gets the source from conandata.yml instead, and its version from config.yml.
# SPDX-License-Identifier: BSD-3-Clause
import os
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir

required_conan_version = ">=2.0"


class BristleConan(ConanFile):
    name = "bristle"
    description = "Tactile sensing by resistive sensors, for grasping in rigid-body simulation"
    license = "BSD-3-Clause"
    topics = ("simulation", "robotics", "grasping", "tactile", "haptics")
    settings = "os", "arch", "compiler", "build_type"
    package_type = "library"
    options = {
        "shared": [True, False],
        "fPIC": [True, False],
        "compiled": [True, False],
        "with_fcl": [True, False],
        "with_adf": [True, False],
    }
    default_options = {
        "shared": False,
        "fPIC": True,
        "compiled": True,
        "with_fcl": False,
        "with_adf": False,
    }

    @property
    def _tree(self):
        return os.path.abspath(os.path.join(self.recipe_folder, "..", "..", ".."))

    def set_version(self):
        header = os.path.join(self._tree, "include", "bristle", "core", "version.hpp")
        text = load(self, header)
        parts = [re.search(rf"#define BRISTLE_VERSION_{part} (\d+)", text).group(1)
                 for part in ("MAJOR", "MINOR", "PATCH")]
        self.version = ".".join(parts)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "include/*"):
            copy(self, pattern, src=self._tree, dst=self.export_sources_folder)

    def config_options(self):
        if self.settings.os == "Windows":
            self.options.rm_safe("fPIC")

    def configure(self):
        if not self.options.compiled:
            self.package_type = "header-library"
            self.options.rm_safe("fPIC")
            self.options.rm_safe("shared")
        elif self.options.shared:
            self.options.rm_safe("fPIC")

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        if self.options.with_fcl:
            self.requires("fcl/0.7.0", transitive_headers=True, transitive_libs=True)
            self.requires("libccd/2.1", transitive_headers=True, transitive_libs=True)
        if self.options.with_adf:
            self.requires("yaml-cpp/0.8.0", transitive_headers=True, transitive_libs=True)

    def package_id(self):
        if not self.info.options.compiled:
            # Headers; which others they include, the options say.
            self.info.settings.clear()

    def validate(self):
        check_min_cppstd(self, 20)
        if self.settings.os == "Windows" and self.options.get_safe("shared"):
            raise ConanInvalidConfiguration("bristle names no symbols for export from a DLL")

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["BRISTLE_BUILD_COMPILED"] = bool(self.options.compiled)
        toolchain.cache_variables["BRISTLE_WITH_FCL"] = bool(self.options.with_fcl)
        toolchain.cache_variables["BRISTLE_WITH_ADF"] = bool(self.options.with_adf)
        toolchain.cache_variables["BRISTLE_BUILD_BENCHMARKS"] = False
        toolchain.cache_variables["BRISTLE_BUILD_EXAMPLES"] = False
        toolchain.cache_variables["BRISTLE_BUILD_TESTS"] = False
        toolchain.cache_variables["BRISTLE_INSTALL"] = True
        toolchain.cache_variables["BRISTLE_WERROR"] = False
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder,
             dst=os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        # Conan makes its own.
        rmdir(self, os.path.join(self.package_folder, "lib", "cmake"))
        rmdir(self, os.path.join(self.package_folder, "lib", "pkgconfig"))
        rmdir(self, os.path.join(self.package_folder, "share"))

    def _add(self, name, requires, defines=(), libs=()):
        """Adds the target bristle::<name>, as the CMake build exports it."""
        component = self.cpp_info.components[name]
        component.set_property("cmake_target_name", f"bristle::{name}")
        package = "bristle" if name == "bristle" else f"bristle-{name}".replace("_", "-")
        component.set_property("pkg_config_name", package)
        component.requires = list(requires)
        component.defines = list(defines)
        component.libs = list(libs)
        component.bindirs = []
        if not libs:
            component.libdirs = []

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "bristle")
        # Not bristle::bristle, which is the component of the headers alone.
        self.cpp_info.set_property("cmake_target_name", "bristle::all")
        self.cpp_info.set_property("pkg_config_name", "bristle-all")
        fcl = ["fcl::fcl", "libccd::libccd"] if self.options.with_fcl else []
        adf = ["yaml-cpp::yaml-cpp"] if self.options.with_adf else []
        self._add("bristle", ["eigen::eigen"])
        if fcl:
            self._add("fcl", ["bristle", *fcl], ["BRISTLE_WITH_FCL"])
        if adf:
            self._add("adf", ["bristle", *adf])
        if self.options.compiled:
            self._add("compiled", ["bristle", *fcl], ["BRISTLE_COMPILED"], ["bristle"])
        if self.options.compiled and adf:
            self._add("compiled_adf", ["compiled", *adf], ["BRISTLE_COMPILED"], ["bristle_adf"])
