// Whole files in, whole files out: a reader that refuses what is no file, and a writer that leaves no partial file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace voxcarve {

/// The largest file that is read, in bytes: 8 GiB.
inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{8} << 30;

/// The bytes of a file. Throws InputError when there is no such file, when it is no regular file or cannot be read, or
/// when it holds more than `max_bytes`; ResourceError when memory does not hold it.
std::string read_file(const std::filesystem::path& path, std::uint64_t max_bytes = kMaxFileBytes);

/// A file that appears under its name all at once. Bytes go to a temporary file in the same folder, which `commit`
/// renames; without a commit the destructor removes it, so a failure leaves what was there before. A symbolic link is
/// followed. Where the target is a device or a pipe ("/dev/stdout") there is nothing to rename and bytes go there at
/// once.
class AtomicFile {
 public:
  /// Throws ResourceError "cannot write PATH: reason" when the folder does not exist or may not be written to.
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends. Throws ResourceError, for instance when the disk is full.
  void write(std::string_view bytes);
  /// Closes the file and gives it its name. Throws ResourceError.
  void commit();

 private:
  [[noreturn]] void fail(int error);
  void discard() noexcept;

  std::filesystem::path shown_;      ///< the name as it was given, for messages
  std::filesystem::path target_;     ///< with links followed
  std::filesystem::path temporary_;  ///< empty when bytes go straight to the target
  int descriptor_ = -1;
};

/// Writes a whole file, or nothing. Throws ResourceError.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace voxcarve
