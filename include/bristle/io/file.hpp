/// @file
/// Reads and writes whole files, with errors that name the cause.
///
/// Paths are strings, as the C library opens them. A std::filesystem::path becomes one by itself on
/// POSIX, and by `string()` elsewhere. Its header would cost whoever includes the library a fifth
/// of a second.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileCloser>;

[[noreturn]] inline void raise_file_error(const std::string& path, const char* what) {
  const int cause = errno;
  std::string text = what;
  if (cause != 0) text += std::string(": ") + std::strerror(cause);
  raise(IoError(path, 0, text));
}

}  // namespace detail

/// Returns all bytes of a file.
///
/// @throws IoError if the file does not exist, is a directory or a stream without a size, or cannot
///         be read.
[[nodiscard]] inline std::string read_file(const std::string& path) {
  errno = 0;
  const detail::OpenFile file(std::fopen(path.c_str(), "rb"));
  if (!file) detail::raise_file_error(path, "cannot be opened for reading");
  const bool is_at_end = std::fseek(file.get(), 0, SEEK_END) == 0;
  const long size = is_at_end ? std::ftell(file.get()) : -1;
  if (size < 0) detail::raise_file_error(path, "has no size");
  std::rewind(file.get());
  // In parts that grow: a directory says that it is larger than any memory, and has no first byte.
  std::string bytes;
  const std::size_t all = static_cast<std::size_t>(size);
  while (bytes.size() < all) {
    const std::size_t known = bytes.size();
    bytes.resize(std::min(all, std::max<std::size_t>(2 * known, 1 << 16)));
    const std::size_t part = bytes.size() - known;
    if (std::fread(bytes.data() + known, 1, part, file.get()) != part) {
      detail::raise_file_error(path, "cannot be read to its end");
    }
  }
  return bytes;
}

/// Writes a file, replacing an existing one.
///
/// @throws IoError if it cannot be written in full.
inline void write_file(const std::string& path, std::string_view bytes) {
  errno = 0;
  detail::OpenFile file(std::fopen(path.c_str(), "wb"));
  if (!file) detail::raise_file_error(path, "cannot be opened for writing");
  const bool is_written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  // What the buffer still holds is written by closing.
  const bool is_closed = std::fclose(file.release()) == 0;
  if (!is_written || !is_closed) detail::raise_file_error(path, "cannot be written to its end");
}

}  // namespace bristle::inline BRISTLE_ABI
