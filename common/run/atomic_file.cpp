#include "common/run/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <new>
#include <system_error>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

constexpr std::size_t kMaxTransfer = std::size_t{1} << 30;  // one call moves at most 2 GiB on Linux

std::string reason(int error) {
  return std::generic_category().message(error);
}

/// Closes a descriptor when the scope ends.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

/// Reads until `bytes` is full or the file ends, and returns how many bytes came.
std::size_t read_into(int descriptor, std::string& bytes, const std::string& shown) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(descriptor, bytes.data() + done, std::min(bytes.size() - done, kMaxTransfer));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError("cannot read " + shown + ": " + reason(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::filesystem::path temporary_name(const std::filesystem::path& target) {
  static std::atomic<std::uint64_t> counter{0};
  const std::string unique = std::to_string(::getpid()) + "-" + std::to_string(counter.fetch_add(1));
  // A long target name must leave room for the rest within the 255 bytes that file systems allow.
  return target.parent_path() / ("." + target.filename().string().substr(0, 200) + "." + unique + ".tmp");
}

}  // namespace

std::string read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  const std::string shown = path.string();
  // Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) throw InputError("cannot read " + shown + ": " + reason(errno));
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw InputError("cannot read " + shown + ": " + reason(errno));
  if (S_ISDIR(status.st_mode)) throw InputError("cannot read " + shown + ": it is a folder");
  if (!S_ISREG(status.st_mode)) throw InputError("cannot read " + shown + ": it is not a regular file");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > max_bytes) {
    throw InputError("cannot read " + shown + ": it holds " + format_bytes(size) + ", at most " +
                     format_bytes(max_bytes) + " are read");
  }
  std::string bytes;
  try {
    bytes.resize(static_cast<std::size_t>(size));
  } catch (const std::bad_alloc&) {
    throw ResourceError("cannot read " + shown + ": its " + format_bytes(size) + " do not fit into memory");
  }
  bytes.resize(read_into(file.get(), bytes, shown));
  return bytes;
}

AtomicFile::AtomicFile(const std::filesystem::path& target) : shown_(target), target_(target) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(target, ignored);
  if (std::filesystem::is_directory(status)) fail(EISDIR);
  if (target.filename().empty()) fail(ENOENT);
  constexpr mode_t kReadWriteForAll = 0666;  // narrowed by the user's umask
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(errno);
    return;
  }
  if (std::filesystem::is_symlink(target, ignored)) {
    const std::filesystem::path resolved = std::filesystem::weakly_canonical(target, ignored);
    if (!resolved.empty()) target_ = resolved;
  }
  do {
    temporary_ = temporary_name(target_);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kReadWriteForAll);
  } while (descriptor_ < 0 && errno == EEXIST);  // a leftover of an earlier process with the same number
  if (descriptor_ < 0) {
    const int error = errno;
    temporary_.clear();
    fail(error);
  }
}

AtomicFile::~AtomicFile() {
  discard();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

void AtomicFile::fail(int error) {
  discard();
  throw ResourceError("cannot write " + shown_.string() + ": " + reason(error));
}

void AtomicFile::write(std::string_view bytes) {
  if (descriptor_ < 0) fail(EBADF);
  while (!bytes.empty()) {
    const ssize_t put = ::write(descriptor_, bytes.data(), std::min(bytes.size(), kMaxTransfer));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
}

void AtomicFile::commit() {
  if (descriptor_ < 0) fail(EBADF);
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail(errno);
  if (temporary_.empty()) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  temporary_.clear();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace voxcarve
