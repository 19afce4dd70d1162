#include "common/volume/grid_allocator.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace voxcarve {

void advise_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  madvise(memory, bytes, MADV_HUGEPAGE);
#endif
}

}  // namespace voxcarve
