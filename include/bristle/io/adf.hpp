/// @file
/// Loads scenes in AMBF's description format (ADF) into a world. Opt-in: it needs yaml-cpp, which
/// the CMake target `bristle::adf` links.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/world/world.hpp>

#include <filesystem>

namespace bristle::inline BRISTLE_ABI {

/// Adds the bodies, joints and sensors of a description to a world. docs/adf.md documents each key.
/// Joints and sensors that name a missing body are left out, and reported.
///
/// @throws AdfError that names line, key and rule, if the world refuses a value, a mesh is missing
///         or invalid, or a limit is exceeded. The world is unchanged then.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def = {});

/// Reads a file and adds it to a world.
/// @throws IoError and AdfError as `load_adf` and `add_adf`.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def = {});

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/io/adf/adf_builder.hpp>
#include <bristle/io/adf/adf_reader.hpp>

#include <utility>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def) {
  // Works on a copy, so that an error changes nothing.
  World<S, Backend> with_model = world;
  AdfScene<S> scene = detail::AdfBuilder<S, Backend>(with_model, model, def).build();
  world = std::move(with_model);
  return scene;
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def) {
  return add_adf(world, detail::load_adf(path, def.limits), def);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

/// Declares (`extern template`) or defines (`template`) the loaders of scenes for one kind of
/// world.
#define BRISTLE_ADF_FUNCTIONS(instantiate, S, Backend)                                          \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const detail::AdfModel&,      \
                                              const AdfBuildDef<S>&);                           \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const std::filesystem::path&, \
                                              const AdfBuildDef<S>&);

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_ADF_FUNCTIONS(extern template, float, AnalyticBackend)
BRISTLE_ADF_FUNCTIONS(extern template, double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_ADF_FUNCTIONS(extern template, float, FclBackend)
BRISTLE_ADF_FUNCTIONS(extern template, double, FclBackend)
#endif

}  // namespace bristle::inline BRISTLE_ABI
#endif
