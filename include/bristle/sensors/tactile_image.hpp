/// @file
/// Readings of a patch as images, and a history of the last ones.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/sensors/reading.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Quantity shown by the pixels of a tactile image.
enum class TactileChannel : std::uint8_t {
  /// [1] Depth in [0, 1].
  depth,
  /// [N] Normal force.
  normal_force,
  /// [N] Shear along the sensor's t1 and t2.
  shear_1,
  shear_2
};
/// [-] Number of channels.
inline constexpr std::size_t tactile_channel_count = 4;

/// One channel of a patch, row by row. A view: valid as long as its source.
///
/// Row r and column c is the sensor r * columns + c. `sensor_grid` numbers its sensors this way,
/// with count_u columns along side_u and count_v rows along side_v. A patch of any other layout is
/// an image of one row, in the order of its sensors.
template <Scalar S>
struct TactileImage {
  /// [-] Sensors in a column.
  std::size_t rows = 0;
  /// [-] Sensors in a row.
  std::size_t columns = 0;
  /// Pixels, row by row.
  std::span<const S> pixels{};

  /// Pixel at a row and column, both from 0. Not checked.
  [[nodiscard]] S operator()(std::size_t row, std::size_t column) const {
    return pixels[row * columns + column];
  }
};

/// A channel of a reading as an image, without copying it.
/// @param columns  [-] Sensors in a row; 0: all of them.
/// @throws InvalidArgument when they do not fill whole rows.
template <Scalar S>
[[nodiscard]] TactileImage<S> tactile_image(const PatchReading<S>& reading, TactileChannel channel,
                                            std::size_t columns = 0);

/// The last readings of a patch as one array, [frame][channel][row][column]: the observation of a
/// learner, say. `push` does not allocate.
template <Scalar S>
class TactileHistory {
 public:
  /// @param sensors  [-] Number of sensors of the patch, > 0.
  /// @param frames   [-] Readings to keep, > 0.
  /// @throws InvalidArgument naming the argument.
  TactileHistory(std::size_t sensors, std::size_t frames) : sensors_(sensors), frames_(frames) {
    detail::require(sensors > 0, "TactileHistory: sensors", sensors, "must be > 0");
    detail::require(frames > 0, "TactileHistory: frames", frames, "must be > 0");
    constexpr std::size_t most =
        std::numeric_limits<std::ptrdiff_t>::max() / (tactile_channel_count * sizeof(S));
    detail::require(frames <= most / sensors, "TactileHistory: frames", frames,
                    "must be fewer: all frames have to fit into memory");
    values_.resize(frames * tactile_channel_count * sensors);
  }

  /// Appends a reading. Drops the oldest one if all frames are taken.
  /// @throws InvalidArgument when it is of another number of sensors.
  void push(const PatchReading<S>& reading);

  /// Drops all readings, for a new episode, say.
  void clear() { size_ = 0; }

  /// [-] Readings stored, at most the number of frames.
  [[nodiscard]] std::size_t size() const { return size_; }

  /// One channel of the reading pushed `age` pushes ago; 0 is the last.
  /// @throws InvalidArgument when there is none that old, or as `tactile_image`.
  [[nodiscard]] TactileImage<S> image(std::size_t age, TactileChannel channel,
                                      std::size_t columns = 0) const;

  /// [-] Values that `copy_to` writes.
  [[nodiscard]] std::size_t value_count() const { return values_.size(); }
  /// Writes all frames, newest first. Frames not yet taken are zero.
  /// @throws InvalidArgument when `out` does not hold `value_count()`.
  void copy_to(std::span<S> out) const;

 private:
  [[nodiscard]] std::size_t frame_size() const { return tactile_channel_count * sensors_; }
  [[nodiscard]] std::span<const S> frame(std::size_t age) const {
    const std::size_t slot = (newest_ + frames_ - age) % frames_;
    return std::span<const S>(values_).subspan(slot * frame_size(), frame_size());
  }

  std::size_t sensors_, frames_;
  std::size_t size_ = 0;
  std::size_t newest_ = 0;
  detail::DynamicArray<S> values_;
};

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
[[nodiscard]] TactileImage<S> rows_of(std::span<const S> pixels, std::size_t columns) {
  if (columns == 0) columns = std::max<std::size_t>(pixels.size(), 1);
  require(pixels.size() % columns == 0, "tactile_image: columns", columns,
          "must divide the number of sensors, " + std::to_string(pixels.size()));
  return {pixels.size() / columns, columns, pixels};
}

template <Scalar S>
[[nodiscard]] std::array<std::span<const S>, tactile_channel_count> channels_of(
    const PatchReading<S>& reading) {
  return {reading.depth, reading.normal_force, reading.shear_1, reading.shear_2};
}

}  // namespace detail

template <Scalar S>
TactileImage<S> tactile_image(const PatchReading<S>& reading, TactileChannel channel,
                              std::size_t columns) {
  detail::require_enumerator("TactileChannel", channel, TactileChannel::shear_2);
  return detail::rows_of(detail::channels_of(reading)[static_cast<std::size_t>(channel)], columns);
}

template <Scalar S>
void TactileHistory<S>::push(const PatchReading<S>& reading) {
  detail::require(reading.size() == sensors_, "TactileHistory::push: size of the reading",
                  reading.size(), "must be " + std::to_string(sensors_));
  newest_ = (newest_ + 1) % frames_;
  size_ = std::min(size_ + 1, frames_);
  S* out = values_.data() + newest_ * frame_size();
  for (const std::span<const S> channel : detail::channels_of(reading)) {
    out = std::copy(channel.begin(), channel.end(), out);
  }
}

template <Scalar S>
TactileImage<S> TactileHistory<S>::image(std::size_t age, TactileChannel channel,
                                         std::size_t columns) const {
  detail::require(age < size_, "TactileHistory::image: age", age,
                  "must be less than the readings taken, " + std::to_string(size_));
  return detail::rows_of(frame(age).subspan(static_cast<std::size_t>(channel) * sensors_, sensors_),
                         columns);
}

template <Scalar S>
void TactileHistory<S>::copy_to(std::span<S> out) const {
  detail::require(out.size() == values_.size(), "TactileHistory::copy_to: size", out.size(),
                  "must be " + std::to_string(values_.size()));
  for (std::size_t age = 0; age < frames_; ++age) {
    const std::span<S> to = out.subspan(age * frame_size(), frame_size());
    if (age < size_) {
      std::copy_n(frame(age).begin(), frame_size(), to.begin());
    } else {
      std::fill(to.begin(), to.end(), S(0));
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI
