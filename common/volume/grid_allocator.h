// Memory for grids of voxels.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace voxcarve {

/// Memory for a large grid, on huge pages where the system has them: its first touch then takes fewer page faults (a
/// seventh of the time on physical memory; under a virtual machine whose host has taken the memory back it can take
/// longer than with small pages). Even so the system's clearing of new pages costs as much as a fast pass over the
/// grid, so blocks that were freed are kept, 256 MiB in all, for the next grids of about their sizes; the oldest go
/// back first, and all that would raise the most memory that grids have held at once. What is kept is no grid, so no
/// declaration to a memory budget counts it: it lies beside whatever else is made later, such as a mesh, until a grid
/// or the system takes it. All goes back when the system has no more to give. Thread-safe. Throws std::bad_alloc.
void* allocate_grid(std::size_t bytes);
/// Takes back what `allocate_grid(bytes)` gave.
void free_grid(void* memory, std::size_t bytes);

/// Large grids lie on huge pages. A vector's `resize(count)`, its constructor from a count alone and `emplace_back()`
/// leave new values as they are found instead of writing zeros that the next pass overwrites; every way to make values
/// that is given one sets them.
template <class T>
class GridAllocator {
 public:
  using value_type = T;

  GridAllocator() = default;
  template <class Other>
  GridAllocator(const GridAllocator<Other>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    return static_cast<T*>(bytes < kLargeGrid ? ::operator new(bytes) : allocate_grid(bytes));
  }
  void deallocate(T* memory, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < kLargeGrid) {
      ::operator delete(memory);
    } else {
      free_grid(memory, bytes);
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
  static constexpr std::size_t kLargeGrid = std::size_t{1} << 21;  // a huge page
};

template <class T>
using GridValues = std::vector<T, GridAllocator<T>>;

}  // namespace voxcarve
