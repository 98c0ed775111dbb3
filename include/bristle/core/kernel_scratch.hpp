/// @file
/// Scratch memory of kernels, as seen by code that only calls them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// A table of kernels, chosen at construction, and a scratch object for its functions. It holds no
/// state: a copy makes its own scratch object. A moved-from object may only be destroyed or
/// assigned to.
///
/// @tparam Kernels  Has `make_scratch()` and `delete_scratch(scratch)`.
template <typename Kernels>
class KernelScratch {
 public:
  explicit KernelScratch(const Kernels& kernels)
      : kernels_(&kernels), scratch_(kernels.make_scratch()) {}
  KernelScratch(const KernelScratch& other) : KernelScratch(*other.kernels_) {}
  KernelScratch(KernelScratch&& other) noexcept
      : kernels_(other.kernels_), scratch_(std::exchange(other.scratch_, nullptr)) {}
  KernelScratch& operator=(KernelScratch other) noexcept {
    std::swap(kernels_, other.kernels_);
    std::swap(scratch_, other.scratch_);
    return *this;
  }
  ~KernelScratch() {
    if (scratch_ != nullptr) kernels_->delete_scratch(scratch_);
  }

  [[nodiscard]] const Kernels& kernels() const { return *kernels_; }
  [[nodiscard]] void* get() const { return scratch_; }

 private:
  const Kernels* kernels_;
  void* scratch_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
