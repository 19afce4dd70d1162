// Memory for grids of voxels.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace voxcarve {

/// Asks the system for huge pages behind `bytes` at `memory`, where it knows them: the first touch of a grid then takes
/// fewer page faults (a seventh of the time on physical memory; under a virtual machine whose host has taken the memory
/// back it can take longer than with small pages). Never fails; a refusal costs nothing but time.
void advise_huge_pages(void* memory, std::size_t bytes);

/// Large grids lie on huge pages. A vector's `resize` leaves new values as they are found instead of writing zeros
/// that the next pass overwrites; every other way to make values sets them.
template <class T>
class GridAllocator {
 public:
  using value_type = T;

  GridAllocator() = default;
  template <class Other>
  GridAllocator(const GridAllocator<Other>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < kHugePage) return static_cast<T*>(::operator new(bytes));
    void* memory = ::operator new (bytes, std::align_val_t{kHugePage});
    advise_huge_pages(memory, bytes);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (count * sizeof(T) < kHugePage) {
      ::operator delete(memory);
    } else {
      ::operator delete (memory, std::align_val_t{kHugePage});
    }
  }

  template <class Value>
  void construct(Value* place) {
    ::new (static_cast<void*>(place)) Value;
  }
  template <class Value, class... Arguments>
  void construct(Value* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) Value(std::forward<Arguments>(arguments)...);
  }

  bool operator==(const GridAllocator&) const { return true; }

 private:
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;
};

template <class T>
using GridValues = std::vector<T, GridAllocator<T>>;

}  // namespace voxcarve
