#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>

#include "common/run/errors.h"
#include "common/volume/io/samples.h"

namespace voxcarve::volume_io {

namespace {

/// Decompresses zlib or gzip data piece by piece, into memory that does not depend on what a header promises.
class Inflater {
 public:
  explicit Inflater(std::string_view data) : data_(data) {
    constexpr int kZlibOrGzip = 15 + 32;  // the largest window, and the header says which
    valid_ = inflateInit2(&stream_, kZlibOrGzip) == Z_OK;
  }
  ~Inflater() {
    if (valid_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// The next piece; empty when the data end or are broken.
  std::string_view next() {
    if (!valid_ || ended_) return {};
    stream_.next_out = buffer_.data();
    stream_.avail_out = static_cast<uInt>(buffer_.size());
    while (stream_.avail_out > 0 && !ended_) {
      if (stream_.avail_in == 0) feed();
      const int status = ::inflate(&stream_, Z_NO_FLUSH);
      if (status == Z_STREAM_END) {
        complete_ = ended_ = true;
      } else if (status != Z_OK) {
        ended_ = true;
      }
    }
    return {reinterpret_cast<const char*>(buffer_.data()), buffer_.size() - stream_.avail_out};
  }

  /// True once the stream ended as it should, checksum included.
  bool complete() const { return complete_; }

 private:
  void feed() {
    const std::size_t size = std::min<std::size_t>(data_.size(), std::numeric_limits<uInt>::max() / 2);
    // zlib does not write through next_in; its interface predates const.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data_.data()));
    stream_.avail_in = static_cast<uInt>(size);
    data_.remove_prefix(size);
  }

  std::string_view data_;
  z_stream stream_{};
  std::array<Bytef, std::size_t{1} << 16> buffer_{};
  bool valid_ = false;
  bool ended_ = false;
  bool complete_ = false;
};

}  // namespace

std::string inflate(std::string_view data, std::size_t size, std::string_view name) {
  Inflater inflater(data);
  std::string result;
  while (result.size() < size) {
    const std::string_view piece = inflater.next();
    if (piece.empty()) break;
    result.append(piece.substr(0, std::min(piece.size(), size - result.size())));
  }
  if (result.size() < size) {
    throw InputError(std::string(name) + ": the compressed data end or are broken after " +
                     std::to_string(result.size()) + " of " + std::to_string(size) + " bytes");
  }
  return result;
}

std::optional<std::size_t> inflated_size(std::string_view data, std::size_t limit) {
  Inflater inflater(data);
  std::size_t size = 0;
  for (std::string_view piece = inflater.next(); !piece.empty(); piece = inflater.next()) {
    size += piece.size();
    if (size > limit) return size;
  }
  return inflater.complete() ? std::optional(size) : std::nullopt;
}

}  // namespace voxcarve::volume_io
