/// @file
/// The growing array of the library's own working data.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <new>
#include <type_traits>
#include <utility>

/// BRISTLE_CHECK_INDEX(index, size): stops a program whose index is out of range, where it asks the
/// same of the standard library.
#if defined(_GLIBCXX_ASSERTIONS)
#define BRISTLE_CHECK_INDEX(index, size) ((index) < (size) ? void() : std::abort())
#else
#define BRISTLE_CHECK_INDEX(index, size) void()
#endif

namespace bristle::inline BRISTLE_ABI::detail {

/// Gives back memory of elements.
inline void free_elements(void* memory, std::size_t alignment) noexcept {
  if (alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__) {
    ::operator delete(memory, std::align_val_t(alignment));
  } else {
    ::operator delete(memory);
  }
}

/// Memory of elements that no array owns yet, or any more. It knows nothing of them, so that it is
/// compiled once.
struct ElementMemory {
  /// Gets memory, or throws std::bad_alloc.
  /// @param count       [-] Number of elements.
  /// @param size        [bytes] Size of one.
  /// @param alignment_  [bytes] A power of two.
  ElementMemory(std::size_t count, std::size_t size, std::size_t alignment_)
      : capacity(count), alignment(alignment_) {
    // A number of bytes that cannot be counted is more than there can be.
    const std::size_t bytes = count > PTRDIFF_MAX / size ? std::size_t{PTRDIFF_MAX} : count * size;
    data = alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__
               ? ::operator new(bytes, std::align_val_t(alignment))
               : ::operator new(bytes);
  }
  ElementMemory(const ElementMemory&) = delete;
  ElementMemory& operator=(const ElementMemory&) = delete;
  ~ElementMemory() { free_elements(data, alignment); }

  void* data;
  std::size_t capacity;
  std::size_t alignment;
};

/// Tells iterators from counts. `std::input_iterator` does the same in ten milliseconds of compile
/// time for each type.
template <typename It>
concept ElementIterator = requires(It it) {
  *it;
};

/// A growing array with the names of `std::vector`, for data that no user sees.
///
/// It exists for the sake of compile time: the library has arrays of a hundred types, and of
/// `std::vector` each takes a compiler sixty functions and 2.5 MB (decision 0045). It casts where
/// others call std::move, for the same reason. Unlike std::vector,
/// - iterators are pointers,
/// - elements must move without a throw, as they do without a strong guarantee,
/// - `resize` and `assign` double the capacity, too, where they grow. So varying sizes (contacts of
///   a pile) soon stay below it, and a warmed-up step allocates nothing.
///
/// @tparam alignment  [bytes] Where the first element lies: at a multiple of this.
template <typename T, std::size_t alignment = alignof(T)>
class DynamicArray {
  static_assert(alignment >= alignof(T));

 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  DynamicArray() = default;
  explicit DynamicArray(std::size_t count) : DynamicArray() { resize(count); }
  DynamicArray(std::size_t count, const T& value) : DynamicArray() { assign(count, value); }
  DynamicArray(std::initializer_list<T> values) : DynamicArray() {
    assign(values.begin(), values.end());
  }
  template <ElementIterator It>
  DynamicArray(It first, It last) : DynamicArray() {
    assign(first, last);
  }
  DynamicArray(const DynamicArray& other) : DynamicArray() { *this = other; }
  DynamicArray(DynamicArray&& other) noexcept
      : data_(other.data_), size_(other.size_), capacity_(other.capacity_) {
    other.forget();
  }
  DynamicArray& operator=(const DynamicArray& other) {
    if (this != &other) assign(other.begin(), other.end());
    return *this;
  }
  DynamicArray& operator=(DynamicArray&& other) noexcept {
    if (this != &other) {
      end_from(0);
      free_elements(data_, alignment);
      data_ = other.data_;
      size_ = other.size_;
      capacity_ = other.capacity_;
      other.forget();
    }
    return *this;
  }
  ~DynamicArray() {
    end_from(0);
    free_elements(data_, alignment);
  }

  void swap(DynamicArray& other) noexcept {
    DynamicArray kept(static_cast<DynamicArray&&>(other));
    other = static_cast<DynamicArray&&>(*this);
    *this = static_cast<DynamicArray&&>(kept);
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }

  [[nodiscard]] T* data() noexcept { return data_; }
  [[nodiscard]] const T* data() const noexcept { return data_; }
  [[nodiscard]] T* begin() noexcept { return data_; }
  [[nodiscard]] const T* begin() const noexcept { return data_; }
  [[nodiscard]] T* end() noexcept { return data_ + size_; }
  [[nodiscard]] const T* end() const noexcept { return data_ + size_; }

  [[nodiscard]] T& operator[](std::size_t i) noexcept {
    BRISTLE_CHECK_INDEX(i, size_);
    return data_[i];
  }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept {
    BRISTLE_CHECK_INDEX(i, size_);
    return data_[i];
  }
  [[nodiscard]] T& front() noexcept { return (*this)[0]; }
  [[nodiscard]] const T& front() const noexcept { return (*this)[0]; }
  [[nodiscard]] T& back() noexcept { return (*this)[size_ - 1]; }
  [[nodiscard]] const T& back() const noexcept { return (*this)[size_ - 1]; }

  /// Makes room for exactly this many elements where there is less.
  void reserve(std::size_t count) {
    if (count <= capacity_) return;
    ElementMemory memory(count, sizeof(T), alignment);
    trade(memory);
  }

  /// Ends the last elements, or adds some with all members at their default values.
  void resize(std::size_t count) {
    end_from(count);
    make_room(count);
    for (; size_ < count; ++size_) ::new (static_cast<void*>(end())) T();
  }

  /// As the other, with copies of a value that lies outside the array.
  void resize(std::size_t count, const T& value) {
    end_from(count);
    make_room(count);
    for (; size_ < count; ++size_) ::new (static_cast<void*>(end())) T(value);
  }

  void clear() noexcept { end_from(0); }

  /// Becomes `count` copies of a value that lies outside the array.
  void assign(std::size_t count, const T& value) {
    end_from(count);
    make_room(count);
    // Their life begins with the assignment. One loop then writes all.
    if constexpr (std::is_trivially_copyable_v<T>) size_ = count;
    std::fill(begin(), end(), value);
    resize(count, value);
  }

  /// Becomes a copy of a range that lies outside the array. Elements that exist are assigned to,
  /// and so keep memory that they own.
  template <ElementIterator It>
  void assign(It first, It last) {
    const auto count = static_cast<std::size_t>(std::distance(first, last));
    end_from(count);
    make_room(count);
    if constexpr (is_copied_by_bytes<It>) {
      if (count > 0) std::memcpy(static_cast<void*>(data_), first, count * sizeof(T));
      size_ = count;
    } else {
      for (T& element : *this) element = *first++;
      append(first, last);
    }
  }

  /// Adds copies of a range that lies outside the array.
  template <ElementIterator It>
  void append(It first, It last) {
    make_room(size_ + static_cast<std::size_t>(std::distance(first, last)));
    for (; first != last; ++first, ++size_) ::new (static_cast<void*>(end())) T(*first);
  }

  void push_back(const T& value) { emplace_back(value); }
  void push_back(T&& value) { emplace_back(static_cast<T&&>(value)); }

  /// Adds an element made of arguments. They may refer to elements of the array.
  template <typename... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    if (size_ == capacity_) {
      ElementMemory memory(std::max<std::size_t>(1, 2 * capacity_), sizeof(T), alignment);
      ::new (static_cast<void*>(static_cast<T*>(memory.data) + size_))
          T(static_cast<Arguments&&>(arguments)...);
      trade(memory);
    } else {
      ::new (static_cast<void*>(end())) T(static_cast<Arguments&&>(arguments)...);
    }
    return data_[size_++];
  }

  void pop_back() noexcept {
    BRISTLE_CHECK_INDEX(0, size_);
    end_from(size_ - 1);
  }

  /// Puts an element before another, or at the end.
  void insert(const T* before, T value) {
    const std::ptrdiff_t place = before - data_;
    emplace_back(static_cast<T&&>(value));
    std::rotate(data_ + place, end() - 1, end());
  }

  /// Takes out the elements from `first` to before `last`.
  void erase(const T* first, const T* last) {
    if (first == last) return;  // No element is moved onto itself.
    T* const kept = std::move(data_ + (last - data_), end(), data_ + (first - data_));
    end_from(static_cast<std::size_t>(kept - data_));
  }
  void erase(const T* element) { erase(element, element + 1); }

  /// Takes out the elements for which a condition holds, and returns their number.
  template <typename Condition>
  friend std::size_t erase_if(DynamicArray& array, Condition condition) {
    const std::size_t before = array.size();
    array.erase(std::remove_if(array.begin(), array.end(), condition), array.end());
    return before - array.size();
  }

  [[nodiscard]] friend bool operator==(const DynamicArray& a, const DynamicArray& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  template <typename It>
  static constexpr bool is_copied_by_bytes =
      std::is_trivially_copyable_v<T> && (std::is_same_v<It, T*> || std::is_same_v<It, const T*>);

  /// Makes room for at least this many elements; doubles where there is less.
  void make_room(std::size_t count) {
    if (count > capacity_) reserve(std::max(count, 2 * capacity_));
  }

  /// Ends all elements from a number on. Does nothing where there are fewer.
  void end_from(std::size_t count) noexcept {
    if constexpr (std::is_trivially_destructible_v<T>) {
      size_ = std::min(size_, count);
    } else {
      while (size_ > count) data_[--size_].~T();
    }
  }

  /// Moves the elements to other memory, and gives theirs for it.
  void trade(ElementMemory& memory) noexcept {
    static_assert(std::is_nothrow_destructible_v<T>);
    T* const target = static_cast<T*>(memory.data);
    if constexpr (std::is_trivially_copyable_v<T>) {
      if (size_ > 0) std::memcpy(memory.data, data_, size_ * sizeof(T));
    } else {
      for (std::size_t i = 0; i < size_; ++i) {
        ::new (static_cast<void*>(target + i)) T(static_cast<T&&>(data_[i]));
        data_[i].~T();
      }
    }
    memory.data = data_;
    data_ = target;
    capacity_ = memory.capacity;
  }

  /// Owns nothing any more.
  void forget() noexcept {
    data_ = nullptr;
    size_ = 0;
    capacity_ = 0;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// An array in which each vector register is loaded from one cache line. Memory that is aligned for
/// scalars alone begins 16 bytes behind a line, and then every wide load crosses two.
template <typename T>
using LineArray = DynamicArray<T, 64>;

}  // namespace bristle::inline BRISTLE_ABI::detail
