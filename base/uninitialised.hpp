#pragma once
// Arrays that are written before they are read. Room that is reserved but not written takes no memory from the system.

#include <memory>
#include <utility>
#include <vector>

namespace tern {

/// An allocator that leaves new numbers as they are.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = UninitialisedAllocator<Other>;
  };
  UninitialisedAllocator() = default;
  template <class Other>
  UninitialisedAllocator(const UninitialisedAllocator<Other>&) {}

  template <class Other>
  void construct(Other* place) noexcept {
    ::new (static_cast<void*>(place)) Other;
  }
  template <class Other, class... Values>
  void construct(Other* place, Values&&... values) {
    ::new (static_cast<void*>(place)) Other(std::forward<Values>(values)...);
  }
};

template <class T>
using UninitialisedVector = std::vector<T, UninitialisedAllocator<T>>;

}  // namespace tern
