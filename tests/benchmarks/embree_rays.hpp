/// @file
/// Rays asked of Embree 3, one by one and in coherent packets of sixteen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <embree3/rtcore.h>
#include <limits>
#include <vector>

namespace bristle::benchmarks {

/// A mesh as Embree holds it, and rays in its frame.
class EmbreeMesh {
 public:
  explicit EmbreeMesh(const TriangleMesh<double>& mesh)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Vec3<double>& v : mesh.vertices) {
      for (const double x : v) *vertices++ = static_cast<float>(x);
    }
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles) {
      corners = std::copy(triangle.begin(), triangle.end(), corners);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  EmbreeMesh(const EmbreeMesh&) = delete;
  EmbreeMesh& operator=(const EmbreeMesh&) = delete;
  ~EmbreeMesh() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  /// The rays that are asked next.
  void clear() { rays_.clear(); }
  void add(const Ray<float>& ray) {
    rays_.push_back({ray.origin.x(), ray.origin.y(), ray.origin.z(), ray.direction.x(),
                     ray.direction.y(), ray.direction.z(), ray.length});
    distance.resize(rays_.size());
  }

  void cast_single() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const Line& line = rays_[i];
      RTCRayHit r{};
      r.ray.org_x = line.x;
      r.ray.org_y = line.y;
      r.ray.org_z = line.z;
      r.ray.dir_x = line.dx;
      r.ray.dir_y = line.dy;
      r.ray.dir_z = line.dz;
      r.ray.tfar = line.length;
      r.ray.mask = ~0u;
      r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &r);
      distance[i] = r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? none : r.ray.tfar;
    }
  }

  void cast_coherent() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (std::size_t first = 0; first < rays_.size(); first += 16) {
      const std::size_t count = std::min<std::size_t>(16, rays_.size() - first);
      alignas(64) int valid[16];
      RTCRayHit16 r;
      for (std::size_t k = 0; k < 16; ++k) {
        const Line& line = rays_[first + std::min(k, count - 1)];
        valid[k] = k < count ? -1 : 0;
        r.ray.org_x[k] = line.x;
        r.ray.org_y[k] = line.y;
        r.ray.org_z[k] = line.z;
        r.ray.dir_x[k] = line.dx;
        r.ray.dir_y[k] = line.dy;
        r.ray.dir_z[k] = line.dz;
        r.ray.tnear[k] = 0;
        r.ray.tfar[k] = line.length;
        r.ray.time[k] = 0;
        r.ray.mask[k] = ~0u;
        r.ray.flags[k] = 0;
        r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect16(valid, scene_, &context, &r);
      for (std::size_t k = 0; k < count; ++k) {
        distance[first + k] = r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID ? none : r.ray.tfar[k];
      }
    }
  }

  /// [m] Of each ray; infinite where it hit nothing.
  std::vector<float> distance;

 private:
  struct Line {
    float x, y, z, dx, dy, dz, length;
  };
  static constexpr float none = std::numeric_limits<float>::infinity();

  RTCDevice device_;
  RTCScene scene_;
  std::vector<Line> rays_;
};

}  // namespace bristle::benchmarks
