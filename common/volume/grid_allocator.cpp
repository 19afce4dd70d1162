#include "common/volume/grid_allocator.h"

#include <algorithm>
#include <iterator>
#include <mutex>

#ifdef __linux__
#include <sys/mman.h>
#endif

#include "common/run/address_sanitizer.h"

namespace voxcarve {

namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;

/// Of freed blocks. Nothing under the sanitizer: a block in use again would hide the use of it after it was freed.
constexpr std::size_t kMostKept = kAddressSanitizer ? 0 : std::size_t{256} << 20;

/// At least one: blocks of nothing are blocks too.
std::size_t whole_pages(std::size_t bytes) {
  return (std::max<std::size_t>(bytes, 1) + kHugePage - 1) / kHugePage * kHugePage;
}

/// Blocks in use, counted, and blocks that were freed, kept.
class Blocks {
 public:
  Blocks() { kept_.reserve(kMostKept / kHugePage); }  // so that freeing never allocates

  void* take(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    void* memory = take_kept(bytes);
    if (memory == nullptr) {
      // What is kept may fill up the most that was ever in use at once, but never adds to it.
      give_back_until(std::max(used_ + bytes, most_used_) - used_ - bytes);
      memory = ::operator new (bytes, std::align_val_t{kHugePage}, std::nothrow);
      if (memory == nullptr) {
        give_back_until(0);
        memory = ::operator new (bytes, std::align_val_t{kHugePage});
      }
#ifdef __linux__
      madvise(memory, bytes, MADV_HUGEPAGE);  // a refusal costs nothing but time
#endif
    }
    used_ += bytes;
    most_used_ = std::max(most_used_, used_);
    return memory;
  }

  void put(void* memory, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    used_ -= bytes;
    if (bytes > kMostKept) {
      give_back({memory, bytes});
      return;
    }
    give_back_until(kMostKept - bytes);
    kept_.push_back({memory, bytes});
    kept_bytes_ += bytes;
  }

 private:
  struct Block {
    void* memory;
    std::size_t bytes;
  };

  /// The block of this size that was freed last, or none.
  void* take_kept(std::size_t bytes) {
    const auto newest = std::find_if(kept_.rbegin(), kept_.rend(), [&](const Block& b) { return b.bytes == bytes; });
    if (newest == kept_.rend()) return nullptr;
    void* memory = newest->memory;
    kept_.erase(std::next(newest).base());
    kept_bytes_ -= bytes;
    return memory;
  }

  /// To the system, the oldest first.
  void give_back_until(std::size_t bytes) {
    std::size_t gone = 0;
    for (; kept_bytes_ > bytes; ++gone) {
      kept_bytes_ -= kept_[gone].bytes;
      give_back(kept_[gone]);
    }
    kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(gone));
  }

  static void give_back(const Block& block) {
    ::operator delete (block.memory, std::align_val_t{kHugePage});
  }

  std::mutex mutex_;
  std::vector<Block> kept_;  ///< in the order in which they were freed
  std::size_t kept_bytes_ = 0;
  std::size_t used_ = 0;
  std::size_t most_used_ = 0;
};

/// Never destroyed: grids may outlive what is.
Blocks& blocks() {
  static Blocks* const the_blocks = new Blocks;
  return *the_blocks;
}

}  // namespace

void* allocate_grid(std::size_t bytes) {
  return blocks().take(whole_pages(bytes));
}

void free_grid(void* memory, std::size_t bytes) {
  blocks().put(memory, whole_pages(bytes));
}

}  // namespace voxcarve
