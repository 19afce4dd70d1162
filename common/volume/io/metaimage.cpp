// MetaImage, the format of ITK: https://itk.org/Wiki/MetaIO/Documentation. Two or three axes, one channel; raw, zlib
// and text data, after the header or in one file of their own.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"
#include "common/volume/io/samples.h"

namespace voxcarve::volume_io {

namespace {

/// A key of our own: the grid's corner, which the centre of the first sample does not always give back exactly.
constexpr std::string_view kCornerKey = "VoxcarveLowerCorner";

/// "Long" has 32 bits in this format.
constexpr std::array<std::pair<std::string_view, SampleType>, 12> kTypeNames{{{"MET_CHAR", SampleType::kInt8},
                                                                              {"MET_UCHAR", SampleType::kUint8},
                                                                              {"MET_SHORT", SampleType::kInt16},
                                                                              {"MET_USHORT", SampleType::kUint16},
                                                                              {"MET_INT", SampleType::kInt32},
                                                                              {"MET_UINT", SampleType::kUint32},
                                                                              {"MET_LONG", SampleType::kInt32},
                                                                              {"MET_ULONG", SampleType::kUint32},
                                                                              {"MET_LONG_LONG", SampleType::kInt64},
                                                                              {"MET_ULONG_LONG", SampleType::kUint64},
                                                                              {"MET_FLOAT", SampleType::kFloat32},
                                                                              {"MET_DOUBLE", SampleType::kFloat64}}};

class MetaImageReader {
 public:
  MetaImageReader(std::string_view bytes, std::string_view name, const DataLoader& data)
      : bytes_(bytes), name_(name), data_(data) {}

  VolumeFile run() {
    read_fields();
    read_layout();
    read_geometry();
    count_samples(layout_, name_);
    check_geometry(layout_, name_);
    VolumeFile file = read_samples();
    place(layout_, name_, file);
    file.notices.insert(file.notices.begin(), notices_.begin(), notices_.end());
    return file;
  }

 private:
  struct Field {
    std::string value;
    std::size_t line = 0;
  };

  [[noreturn]] void fail(const Field& field, std::string_view message) const {
    throw InputError(name_, fmt::format("line {}", field.line), message);
  }

  /// The header ends with the line that says where the data are.
  void read_fields() {
    TextScanner scanner(bytes_, name_);
    while (scanner.next_line()) {
      if (scanner.peek().empty()) continue;
      const std::string_view line = scanner.line();
      const std::size_t equals = line.find('=');
      if (equals == std::string_view::npos) scanner.fail("expected 'key = value', found " + in_quotes(line));
      TextScanner key(line.substr(0, equals), name_);
      TextScanner value(line.substr(equals + 1), name_);
      key.next_line();
      value.next_line();
      const std::string_view key_text = key.rest();
      fields_.insert_or_assign(std::string(key_text), Field{std::string(value.rest()), scanner.line_number()});
      if (key_text != "ElementDataFile") continue;
      data_begin_ = scanner.offset();
      return;
    }
    scanner.fail("the file ends before 'ElementDataFile'");
  }

  const Field* find(std::string_view key) const {
    const auto found = fields_.find(key);
    return found == fields_.end() ? nullptr : &found->second;
  }

  const Field& require(std::string_view key) const {
    const Field* const field = find(key);
    if (field == nullptr) throw InputError(fmt::format("{}: the header has no key '{}'", name_, key));
    return *field;
  }

  bool flag(std::string_view key, bool otherwise) const {
    const Field* const field = find(key);
    if (field == nullptr) return otherwise;
    const std::string value = to_lower(field->value);
    if (value != "true" && value != "false" && value != "1" && value != "0") {
      fail(*field, "neither True nor False: " + in_quotes(field->value));
    }
    return value == "true" || value == "1";
  }

  std::int64_t integer(const Field& field) const {
    const std::optional<std::int64_t> value = parse_integer(field.value);
    if (!value) fail(field, "not an integer: " + in_quotes(field.value));
    return *value;
  }

  /// One number an axis; `Read` is parse_integer or parse_real.
  template <class Vector, class Read>
  void read_axes(const Field& field, Read read, Vector& vector) const {
    TextScanner scanner(field.value, name_);
    for (Eigen::Index axis = 0; axis < axes_; ++axis) {
      const std::string_view word = scanner.stream_token();
      const auto value = read(word);
      if (!value) fail(field, fmt::format("{} numbers expected, found {}", axes_, in_quotes(word)));
      vector[axis] = *value;
    }
  }

  void read_layout() {
    const Field& dims = require("NDims");
    axes_ = integer(dims);
    if (axes_ != 2 && axes_ != 3)
      fail(dims, fmt::format("{} axes; only volumes of 3 and images of 2 are supported", axes_));
    read_axes(require("DimSize"), parse_integer, layout_.dims);
    const Field& type = require("ElementType");
    const auto* const found =
        std::ranges::find(kTypeNames, std::string_view(type.value), &std::pair<std::string_view, SampleType>::first);
    if (found == kTypeNames.end()) fail(type, "unsupported sample type " + in_quotes(type.value));
    layout_.type = found->second;
    const Field* const channels = find("ElementNumberOfChannels");
    if (channels != nullptr && integer(*channels) != 1) fail(*channels, "only volumes of one channel are supported");
    const bool big = flag("BinaryDataByteOrderMSB", flag("ElementByteOrderMSB", false));
    layout_.order = big ? std::endian::big : std::endian::little;
  }

  void read_geometry() {
    const Field* spacing = find("ElementSpacing");
    if (spacing == nullptr) spacing = find("ElementSize");
    if (spacing != nullptr) read_axes(*spacing, parse_real, layout_.spacing);
    for (const std::string_view key : {"Offset", "Position", "Origin"}) {
      const Field* const origin = find(key);
      if (origin == nullptr || layout_.first_sample) continue;
      layout_.first_sample = Point::Zero();
      read_axes(*origin, parse_real, *layout_.first_sample);
    }
    if (const Field* const corner = find(kCornerKey)) {
      layout_.lower_corner = Point::Zero();
      read_axes(*corner, parse_real, *layout_.lower_corner);
    }
    for (const std::string_view key : {"TransformMatrix", "Rotation", "Orientation"}) {
      const Field* const matrix = find(key);
      if (matrix == nullptr || is_identity(*matrix)) continue;
      notices_.emplace_back("the file's transform turns or mirrors the axes; the volume is kept as it is stored");
      return;
    }
  }

  bool is_identity(const Field& field) const {
    TextScanner scanner(field.value, name_);
    for (std::int64_t entry = 0; entry < axes_ * axes_; ++entry) {
      const std::optional<double> value = parse_real(scanner.stream_token());
      if (!value) fail(field, fmt::format("{} numbers expected", axes_ * axes_));
      if (*value != (entry % (axes_ + 1) == 0 ? 1.0 : 0.0)) return false;
    }
    return true;
  }

  VolumeFile read_samples() {
    const Field& file = fields_.find("ElementDataFile")->second;
    std::string_view data = bytes_.substr(data_begin_);
    std::size_t begin = data_begin_;
    std::string detached;
    if (to_lower(file.value) != "local") {
      if (to_lower(file.value).starts_with("list") || file.value.find('%') != std::string::npos) {
        fail(file, "data spread over several files are not supported");
      }
      if (!data_) fail(file, "data in a file of their own are not available here");
      detached = data_(file.value);
      data = detached;
      begin = 0;
    }
    const auto size = static_cast<std::size_t>(count_samples(layout_, name_)) * size_of(layout_.type);
    const std::size_t front = bytes_to_skip(data.size(), size);
    data.remove_prefix(front);
    if (!flag("BinaryData", true)) return decode_text(layout_, data, name_);
    if (!flag("CompressedData", false)) return decode_binary(layout_, data, name_, begin + front);
    // No deflate stream holds more than 1032 times its size.
    require_samples(layout_, 1032 * data.size(), name_);
    return decode_binary(layout_, inflate(data, size, name_), name_, 0);
  }

  /// -1 means that the samples are the last bytes of the file.
  std::size_t bytes_to_skip(std::size_t available, std::size_t size) const {
    const Field* const field = find("HeaderSize");
    if (field == nullptr) return 0;
    const std::int64_t skipped = integer(*field);
    if (skipped < -1) fail(*field, fmt::format("cannot skip {} bytes", skipped));
    if (skipped == -1) {
      require_samples(layout_, available, name_);
      return available - size;
    }
    if (static_cast<std::size_t>(skipped) > available) fail(*field, "the data end within the bytes to skip");
    return static_cast<std::size_t>(skipped);
  }

  std::string_view bytes_;
  std::string_view name_;
  const DataLoader& data_;
  std::map<std::string, Field, std::less<>> fields_;
  std::size_t data_begin_ = 0;
  std::int64_t axes_ = 0;
  VolumeLayout layout_;
  std::vector<std::string> notices_;
};

}  // namespace

VolumeFile parse_metaimage(std::string_view bytes, std::string_view name, const DataLoader& data) {
  return MetaImageReader(bytes, name, data).run();
}

std::string metaimage_header(const RawVolume& volume, std::string_view data_file) {
  const auto vector = [](const Point& p) {
    return fmt::format("{} {} {}", format_real(p[0]), format_real(p[1]), format_real(p[2]));
  };
  const GridFrame& frame = volume.frame;
  std::string text = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n";
  text += "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n";
  text += fmt::format("Offset = {}\n{} = {}\n", vector(frame.center(Index3::Zero())), kCornerKey, vector(frame.origin));
  text += fmt::format("ElementSpacing = {}\n", vector(Point::Constant(frame.voxel_size)));
  text += fmt::format("DimSize = {} {} {}\n", frame.dims[0], frame.dims[1], frame.dims[2]);
  text += volume.type == SampleType::kFloat32 ? "ElementType = MET_FLOAT\n" : "ElementType = MET_UCHAR\n";
  return text += fmt::format("ElementDataFile = {}\n", data_file);
}

}  // namespace voxcarve::volume_io
