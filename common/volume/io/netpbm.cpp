// PBM and PGM, plain and raw: https://netpbm.sourceforge.net/doc/. In PBM 1 is black and counts as interior.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/run/text_scanner.h"
#include "common/volume/io/samples.h"

namespace voxcarve::volume_io {

namespace {

class NetpbmReader {
 public:
  NetpbmReader(std::string_view bytes, std::string_view name) : bytes_(bytes), name_(name) {}

  VolumeFile run() {
    if (bytes_.size() < 2 || bytes_[0] != 'P') fail("this is no PBM or PGM file");
    kind_ = bytes_[1];
    if (kind_ == '3' || kind_ == '6') fail("colour images (PPM) are not supported; convert it to PGM or PNG");
    if (kind_ != '1' && kind_ != '2' && kind_ != '4' && kind_ != '5') fail("this is no PBM or PGM file");
    offset_ = 2;
    width_ = header_number("the width");
    height_ = header_number("the height");
    const bool is_grey = kind_ == '2' || kind_ == '5';
    if (is_grey) maximum_ = header_number("the largest grey value");
    if (maximum_ > 65535) fail("the largest grey value exceeds 65535");
    check_size();
    values_.resize(static_cast<std::size_t>(width_ * height_));
    if (kind_ == '4' || kind_ == '5') {
      // Exactly one blank stands between the header and the pixels.
      if (offset_ >= bytes_.size() || !is_blank(bytes_[offset_])) fail("a blank is missing after the header");
      ++offset_;
      kind_ == '4' ? read_raw_bits() : read_raw_grey();
    } else {
      kind_ == '1' ? read_plain_bits() : read_plain_grey();
    }
    VolumeFile file = image_volume(width_, height_, values_);
    if (!is_grey) keep_bits(file);
    return file;
  }

 private:
  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  [[noreturn]] void fail(std::string_view message) const {
    throw InputError(name_, fmt::format("byte {}", offset_), message);
  }

  void skip_blanks_and_comments() {
    while (offset_ < bytes_.size() && (is_blank(bytes_[offset_]) || bytes_[offset_] == '#')) {
      if (bytes_[offset_] == '#') {
        offset_ = std::min(bytes_.find_first_of("\r\n", offset_), bytes_.size());
      } else {
        ++offset_;
      }
    }
  }

  std::int64_t number(std::string_view what) {
    skip_blanks_and_comments();
    std::size_t end = offset_;
    while (end < bytes_.size() && !is_blank(bytes_[end]) && bytes_[end] != '#') ++end;
    const std::string_view token = bytes_.substr(offset_, end - offset_);
    if (token.empty()) fail(fmt::format("the file ends where {} is expected; it is truncated", what));
    const std::optional<std::int64_t> value = parse_integer(token);
    if (!value || *value < 0) fail(fmt::format("{} is not a number: {}", what, in_quotes(token)));
    offset_ = end;
    return *value;
  }

  std::int64_t header_number(std::string_view what) {
    const std::int64_t value = number(what);
    if (value < 1) fail(fmt::format("{} is {}", what, value));
    return value;
  }

  /// Bytes that one row takes at least.
  std::int64_t row_size() const {
    if (kind_ == '4') return width_ / 8 + (width_ % 8 == 0 ? 0 : 1);
    return kind_ == '5' && maximum_ > 255 ? 2 * width_ : width_;
  }

  void check_size() const {
    const auto available = static_cast<std::int64_t>(bytes_.size() - offset_);
    if (width_ > 8 * available || height_ > available || row_size() > available / height_) {
      fail(fmt::format(
          "an image of {} x {} exceeds the {} bytes that follow; the file is truncated or its sizes are wrong", width_,
          height_, available));
    }
  }

  void read_raw_bits() {
    require(row_size() * height_);
    for (std::int64_t row = 0; row < height_; ++row) {
      for (std::int64_t column = 0; column < width_; ++column) {
        const auto byte =
            static_cast<unsigned char>(bytes_[offset_ + static_cast<std::size_t>(row * row_size() + column / 8)]);
        values_[static_cast<std::size_t>(row * width_ + column)] = static_cast<float>((byte >> (7 - column % 8)) & 1);
      }
    }
  }

  void read_raw_grey() {
    require(row_size() * height_);
    for (std::size_t pixel = 0; pixel < values_.size(); ++pixel) {
      const char* const at = bytes_.data() + offset_ + (maximum_ > 255 ? 2 * pixel : pixel);
      set_grey(pixel,
               maximum_ > 255 ? load<std::uint16_t>(at, std::endian::big) : load<std::uint8_t>(at, std::endian::big));
    }
  }

  /// Digits need no blanks between them.
  void read_plain_bits() {
    for (float& value : values_) {
      skip_blanks_and_comments();
      if (offset_ >= bytes_.size()) fail("the file ends before the last pixel; it is truncated");
      const char digit = bytes_[offset_];
      if (digit != '0' && digit != '1') fail("a pixel is neither 0 nor 1: " + in_quotes(bytes_.substr(offset_, 1)));
      value = digit == '1' ? 1.0F : 0.0F;
      ++offset_;
    }
  }

  void read_plain_grey() {
    for (std::size_t pixel = 0; pixel < values_.size(); ++pixel) set_grey(pixel, number("a pixel"));
  }

  void set_grey(std::size_t pixel, std::int64_t value) {
    if (value > maximum_)
      fail(fmt::format("pixel {} has grey value {}, above the largest, {}", pixel, value, maximum_));
    values_[pixel] = static_cast<float>(static_cast<double>(value) * 255.0 / static_cast<double>(maximum_));
  }

  void require(std::int64_t size) const {
    if (size > static_cast<std::int64_t>(bytes_.size() - offset_))
      fail("the file ends before the last pixel; it is truncated");
  }

  /// Bits say what they mean even where all of them are equal.
  void keep_bits(VolumeFile& file) const {
    const bool all_equal = std::ranges::all_of(values_, [this](float value) { return value == values_[0]; });
    if (all_equal) std::ranges::fill(file.values.values, values_[0]);
  }

  std::string_view bytes_;
  std::string_view name_;
  char kind_ = 0;
  std::size_t offset_ = 0;
  std::int64_t width_ = 0;
  std::int64_t height_ = 0;
  std::int64_t maximum_ = 1;
  std::vector<float> values_;
};

}  // namespace

VolumeFile parse_netpbm(std::string_view bytes, std::string_view name) {
  return NetpbmReader(bytes, name).run();
}

}  // namespace voxcarve::volume_io
