#include "common/volume/grid_allocator.h"

#include <mutex>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace voxcarve {

namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kLargestKept = 0;  // a block in use again would hide the use of it after it was freed
#else
constexpr std::size_t kLargestKept = std::size_t{256} << 20;
#endif

/// The block that was freed last.
struct Kept {
  std::mutex mutex;
  void* memory = nullptr;
  std::size_t bytes = 0;

  /// The kept block, if it has this size; whatever else was kept goes back to the system.
  void* take(std::size_t wanted) {
    const std::scoped_lock lock(mutex);
    void* block = std::exchange(memory, nullptr);
    if (block == nullptr || bytes == wanted) return block;
    ::operator delete (block, std::align_val_t{kHugePage});
    return nullptr;
  }

  void keep(void* block, std::size_t size) {
    const std::scoped_lock lock(mutex);
    if (memory != nullptr) ::operator delete (memory, std::align_val_t{kHugePage});
    memory = block;
    bytes = size;
  }
};

/// Never destroyed: grids may outlive what is.
Kept& kept() {
  static Kept* const the_block = new Kept;
  return *the_block;
}

std::size_t whole_pages(std::size_t bytes) {
  return (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

}  // namespace

void* allocate_grid(std::size_t bytes) {
  const std::size_t block = whole_pages(bytes);
  if (void* memory = kept().take(block)) return memory;
  void* memory = ::operator new (block, std::align_val_t{kHugePage});
#ifdef __linux__
  madvise(memory, block, MADV_HUGEPAGE);  // a refusal costs nothing but time
#endif
  return memory;
}

void free_grid(void* memory, std::size_t bytes) {
  const std::size_t block = whole_pages(bytes);
  if (block <= kLargestKept) {
    kept().keep(memory, block);
  } else {
    ::operator delete (memory, std::align_val_t{kHugePage});
  }
}

}  // namespace voxcarve
