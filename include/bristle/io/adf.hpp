/// @file
/// Loads scenes in AMBF's description format (ADF) into a world. Opt-in: it needs yaml-cpp, which
/// the CMake target `bristle::adf` links.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_launch.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/world/world.hpp>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Adds the bodies, joints and sensors of a description to a world. docs/adf.md documents each key.
/// Joints and sensors that name a missing body are left out, and reported.
///
/// @throws AdfError that names line, key and rule, if the world refuses a value, a mesh is missing
///         or invalid, or a limit is exceeded. The world is unchanged then.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def = {});

/// Reads a file and adds its documents to a world, one after the other.
/// @throws IoError and AdfError as `load_adf` and `add_adf`.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def = {});

/// Adds the models of a launch file to a world, one after the other.
/// @throws AdfError as above.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const AdfLaunch& launch,
                    const AdfBuildDef<S>& def = {});

/// Reads a launch file and adds the models that it lists to a world.
/// @param which  Numbers of the models in the launch file, from 0, as AMBF's option `-l` has them.
///               Empty: all.
/// @throws IoError and AdfError as `load_adf_launch` and `add_adf`.
template <Scalar S, typename Backend>
AdfScene<S> add_adf_launch(World<S, Backend>& world, const std::filesystem::path& path,
                           const std::vector<std::size_t>& which = {},
                           const AdfBuildDef<S>& def = {});

/// Adds a description to a world in which others are already. Its joints and sensors may name their
/// bodies, too. If a name is known in both, its own body counts.
///
/// @param scene  The others. The description is added to it. If several bodies have one name then,
///               no look-up finds them by it.
/// @throws AdfError as above. World and scene are unchanged then.
template <Scalar S, typename Backend>
void add_adf(World<S, Backend>& world, AdfScene<S>& scene, const detail::AdfModel& model,
             const AdfBuildDef<S>& def = {});

/// Reads a file and adds it to a world in which others are already.
/// @throws IoError and AdfError as above. World and scene are unchanged then.
template <Scalar S, typename Backend>
void add_adf(World<S, Backend>& world, AdfScene<S>& scene, const std::filesystem::path& path,
             const AdfBuildDef<S>& def = {});

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/io/adf/adf_builder.hpp>
#include <bristle/io/adf/adf_launch_reader.hpp>
#include <bristle/io/adf/adf_reader.hpp>

#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// Adds models to a world and a scene, all or none.
template <Scalar S, typename Backend>
void add_models(World<S, Backend>& world, AdfScene<S>& scene, std::span<const AdfModel> models,
                const AdfBuildDef<S>& def) {
  // Works on copies, so that an error changes nothing.
  World<S, Backend> with_models = world;
  AdfScene<S> with_names = scene;
  for (const AdfModel& model : models) {
    AdfBuilder<S, Backend>(with_models, with_names, model, def).build();
  }
  world = std::move(with_models);
  scene = std::move(with_names);
}

}  // namespace detail

template <Scalar S, typename Backend>
void add_adf(World<S, Backend>& world, AdfScene<S>& scene, const detail::AdfModel& model,
             const AdfBuildDef<S>& def) {
  detail::add_models(world, scene, std::span(&model, 1), def);
}

template <Scalar S, typename Backend>
void add_adf(World<S, Backend>& world, AdfScene<S>& scene, const std::filesystem::path& path,
             const AdfBuildDef<S>& def) {
  const std::vector<detail::AdfModel> models = detail::load_adf_documents(path, def.limits);
  detail::add_models(world, scene, std::span(models), def);
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def) {
  AdfScene<S> scene;
  add_adf(world, scene, model, def);
  return scene;
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def) {
  AdfScene<S> scene;
  add_adf(world, scene, path, def);
  return scene;
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const AdfLaunch& launch, const AdfBuildDef<S>& def) {
  AdfScene<S> scene;
  scene.report = launch.report;
  detail::add_models(world, scene, std::span(launch.models), def);
  return scene;
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf_launch(World<S, Backend>& world, const std::filesystem::path& path,
                           const std::vector<std::size_t>& which, const AdfBuildDef<S>& def) {
  return add_adf(world, load_adf_launch(path, which, def.limits), def);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

/// Declares (`extern template`) or defines (`template`) the loaders of scenes for one kind of
/// world.
#define BRISTLE_ADF_FUNCTIONS(instantiate, S, Backend)                                            \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const detail::AdfModel&,        \
                                              const AdfBuildDef<S>&);                             \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const std::filesystem::path&,   \
                                              const AdfBuildDef<S>&);                             \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const AdfLaunch&,               \
                                              const AdfBuildDef<S>&);                             \
  instantiate AdfScene<S> add_adf_launch<S, Backend>(                                             \
      World<S, Backend>&, const std::filesystem::path&, const std::vector<std::size_t>&,          \
      const AdfBuildDef<S>&);                                                                     \
  instantiate void add_adf<S, Backend>(World<S, Backend>&, AdfScene<S>&, const detail::AdfModel&, \
                                       const AdfBuildDef<S>&);                                    \
  instantiate void add_adf<S, Backend>(World<S, Backend>&, AdfScene<S>&,                          \
                                       const std::filesystem::path&, const AdfBuildDef<S>&);

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
