// Nearly Raw Raster Data: http://teem.sourceforge.net/nrrd/format.html. Two or three axes; raw, gzip and text data,
// attached or in one file of their own.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"
#include "common/volume/io/samples.h"

namespace voxcarve::volume_io {

namespace {

/// A key of our own: the grid's corner, which the centre of the first sample does not always give back exactly.
constexpr std::string_view kCornerKey = "voxcarve_lower_corner";

constexpr std::array<std::pair<std::string_view, SampleType>, 42> kTypeNames{{
    {"signed char", SampleType::kInt8},
    {"int8", SampleType::kInt8},
    {"int8_t", SampleType::kInt8},
    {"uchar", SampleType::kUint8},
    {"unsigned char", SampleType::kUint8},
    {"uint8", SampleType::kUint8},
    {"uint8_t", SampleType::kUint8},
    {"short", SampleType::kInt16},
    {"short int", SampleType::kInt16},
    {"signed short", SampleType::kInt16},
    {"signed short int", SampleType::kInt16},
    {"int16", SampleType::kInt16},
    {"int16_t", SampleType::kInt16},
    {"ushort", SampleType::kUint16},
    {"unsigned short", SampleType::kUint16},
    {"unsigned short int", SampleType::kUint16},
    {"uint16", SampleType::kUint16},
    {"uint16_t", SampleType::kUint16},
    {"int", SampleType::kInt32},
    {"signed int", SampleType::kInt32},
    {"int32", SampleType::kInt32},
    {"int32_t", SampleType::kInt32},
    {"uint", SampleType::kUint32},
    {"unsigned int", SampleType::kUint32},
    {"uint32", SampleType::kUint32},
    {"uint32_t", SampleType::kUint32},
    {"longlong", SampleType::kInt64},
    {"long long", SampleType::kInt64},
    {"long long int", SampleType::kInt64},
    {"signed long long", SampleType::kInt64},
    {"signed long long int", SampleType::kInt64},
    {"int64", SampleType::kInt64},
    {"int64_t", SampleType::kInt64},
    {"ulonglong", SampleType::kUint64},
    {"unsigned long long", SampleType::kUint64},
    {"unsigned long long int", SampleType::kUint64},
    {"uint64", SampleType::kUint64},
    {"uint64_t", SampleType::kUint64},
    {"float", SampleType::kFloat32},
    {"float32", SampleType::kFloat32},
    {"double", SampleType::kFloat64},
    {"float64", SampleType::kFloat64},
}};

/// A vector "(1,0,0)"; "none" and what is malformed give nothing.
std::optional<Point> parse_vector(std::string_view text) {
  if (!text.starts_with('(') || !text.ends_with(')')) return std::nullopt;
  const std::vector<std::string> parts = split(text.substr(1, text.size() - 2), ',');
  if (parts.size() < 2 || parts.size() > 3) return std::nullopt;
  Point vector = Point::Zero();
  for (std::size_t axis = 0; axis < parts.size(); ++axis) {
    TextScanner word(parts[axis], "");
    const std::optional<double> value = parse_real(word.stream_token());
    if (!value) return std::nullopt;
    vector[static_cast<Eigen::Index>(axis)] = *value;
  }
  return vector;
}

class NrrdReader {
 public:
  NrrdReader(std::string_view bytes, std::string_view name, const DataLoader& data)
      : bytes_(bytes), name_(name), data_(data), scanner_(bytes, name) {}

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

  /// The lines up to the first empty one, or to the end of a header with data of its own.
  void read_fields() {
    if (!scanner_.next_line() || scanner_.line().size() != 8 || !scanner_.line().starts_with("NRRD000")) {
      scanner_.fail("this is no NRRD file: it does not begin with 'NRRD000' and a version");
    }
    while (scanner_.next_line()) {
      const std::string_view line = scanner_.line();
      if (line.empty()) {
        data_begin_ = scanner_.offset();
        return;
      }
      if (line.starts_with('#')) continue;
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos) scanner_.fail("expected 'field: value', found " + in_quotes(line));
      const bool is_key = line.substr(colon).starts_with(":=");
      std::string field(line.substr(0, colon));
      if (!is_key) field = to_lower(field);
      TextScanner value(line.substr(colon + (is_key ? 2 : 1)), name_);
      value.next_line();
      (is_key ? keys_ : fields_)
          .insert_or_assign(std::move(field), Field{std::string(value.rest()), scanner_.line_number()});
    }
    data_begin_ = bytes_.size();
  }

  const Field* find(std::string_view name, std::string_view other = "") const {
    auto found = fields_.find(name);
    if (found == fields_.end() && !other.empty()) found = fields_.find(other);
    return found == fields_.end() ? nullptr : &found->second;
  }

  const Field& require(std::string_view name) const {
    const Field* const field = find(name);
    if (field == nullptr) throw InputError(fmt::format("{}: the header has no field '{}'", name_, name));
    return *field;
  }

  std::int64_t parse_count(const Field& field, std::string_view text) const {
    const std::optional<std::int64_t> value = parse_integer(text);
    if (!value) fail(field, "not an integer: " + in_quotes(text));
    return *value;
  }

  void read_layout() {
    const Field& dimension = require("dimension");
    axes_ = parse_count(dimension, dimension.value);
    if (axes_ != 2 && axes_ != 3)
      fail(dimension, fmt::format("{} axes; only volumes of 3 and images of 2 are supported", axes_));
    const Field& sizes = require("sizes");
    const std::vector<std::string> words = words_of(sizes);
    for (std::size_t axis = 0; axis < words.size(); ++axis) {
      layout_.dims[static_cast<Eigen::Index>(axis)] = parse_count(sizes, words[axis]);
    }
    const Field& type = require("type");
    const std::string type_name = to_lower(type.value);
    const auto* const found =
        std::ranges::find(kTypeNames, std::string_view(type_name), &std::pair<std::string_view, SampleType>::first);
    if (found == kTypeNames.end()) fail(type, "unknown sample type " + in_quotes(type.value));
    layout_.type = found->second;
  }

  /// The words of a field that has one an axis.
  std::vector<std::string> words_of(const Field& field) const {
    std::vector<std::string> words;
    TextScanner scanner(field.value, name_);
    for (std::string_view word = scanner.stream_token(); !word.empty(); word = scanner.stream_token())
      words.emplace_back(word);
    if (static_cast<std::int64_t>(words.size()) != axes_)
      fail(field, fmt::format("{} values for {} axes", words.size(), axes_));
    return words;
  }

  std::vector<double> reals_of(const Field& field) const {
    std::vector<double> values;
    for (const std::string& word : words_of(field)) {
      const std::optional<double> value = parse_real(word);
      if (!value) fail(field, "not a number: " + in_quotes(word));
      values.push_back(*value);
    }
    return values;
  }

  void read_geometry() {
    const Field* const directions = find("space directions");
    const Field* const spacings = find("spacings");
    if (directions != nullptr) {
      read_directions(*directions);
    } else if (spacings != nullptr) {
      const std::vector<double> values = reals_of(*spacings);
      for (std::size_t axis = 0; axis < values.size(); ++axis) {
        // "not a number" is the format's way to say unknown.
        if (!std::isnan(values[axis])) layout_.spacing[static_cast<Eigen::Index>(axis)] = values[axis];
      }
    }
    if (const Field* const origin = find("space origin")) {
      layout_.first_sample = parse_vector(origin->value);
      if (!layout_.first_sample) fail(*origin, "the origin is not of the form (x,y,z): " + in_quotes(origin->value));
    } else if (const Field* const mins = find("axis mins", "axismins")) {
      read_axis_mins(*mins);
    }
    const auto corner = keys_.find(kCornerKey);
    if (corner != keys_.end()) layout_.lower_corner = parse_vector(corner->second.value);
  }

  /// One vector an axis. Their lengths are the spacings; a volume that they turn or mirror stays as it is stored.
  void read_directions(const Field& field) {
    std::string text = field.value;
    // Vectors may be written with blanks inside.
    for (std::size_t at = text.find(", "); at != std::string::npos; at = text.find(", ")) text.erase(at + 1, 1);
    const std::vector<std::string> words = words_of({text, field.line});
    bool axis_parallel = true;
    for (Eigen::Index axis = 0; axis < axes_; ++axis) {
      const std::optional<Point> direction = parse_vector(words[static_cast<std::size_t>(axis)]);
      if (!direction)
        fail(field,
             "an axis without a direction of the form (x,y,z): " + in_quotes(words[static_cast<std::size_t>(axis)]));
      layout_.spacing[axis] = direction->stableNorm();
      axis_parallel = axis_parallel && (*direction)[axis] == layout_.spacing[axis];
    }
    if (!axis_parallel)
      notices_.emplace_back("the file's space directions turn or mirror the axes; the volume is kept as it is stored");
  }

  /// The least position along each axis: of the first sample, or of its cell's border.
  void read_axis_mins(const Field& field) {
    const Field* const centers = find("centers", "centerings");
    const std::vector<std::string> centerings =
        centers != nullptr ? words_of(*centers) : std::vector<std::string>(3, "node");
    const std::vector<double> mins = reals_of(field);
    layout_.first_sample = Point::Zero();
    for (Eigen::Index axis = 0; axis < axes_; ++axis) {
      const auto index = static_cast<std::size_t>(axis);
      if (std::isnan(mins[index])) continue;
      const double to_center = to_lower(centerings[index]) == "cell" ? 0.5 * layout_.spacing[axis] : 0.0;
      (*layout_.first_sample)[axis] = mins[index] + to_center;
    }
  }

  std::int64_t skip(std::string_view name, std::string_view other) const {
    const Field* const field = find(name, other);
    if (field == nullptr) return 0;
    const std::int64_t value = parse_count(*field, field->value);
    if (value < (name == "byte skip" ? -1 : 0)) fail(*field, fmt::format("cannot skip {}", value));
    return value;
  }

  /// The bytes that the samples stand in: after the header, or in a file that it names. Lines are skipped here.
  std::string_view locate_data(std::size_t& begin) {
    std::string_view data = bytes_.substr(data_begin_);
    begin = data_begin_;
    if (const Field* const file = find("data file", "datafile")) {
      if (to_lower(file->value).starts_with("list") || file->value.find('%') != std::string::npos) {
        fail(*file, "data spread over several files are not supported");
      }
      if (!data_) fail(*file, "data in a file of their own are not available here");
      detached_ = data_(file->value);
      data = detached_;
      begin = 0;
    }
    const std::size_t size = data.size();
    for (std::int64_t lines = skip("line skip", "lineskip"); lines > 0; --lines) {
      const std::size_t newline = data.find('\n');
      if (newline == std::string_view::npos)
        throw InputError(fmt::format("{}: the data end within the lines to skip", name_));
      data.remove_prefix(newline + 1);
    }
    begin += size - data.size();
    return data;
  }

  void read_byte_order() {
    if (size_of(layout_.type) == 1) return;
    const Field& field = require("endian");
    const std::string order = to_lower(field.value);
    if (order != "little" && order != "big") fail(field, "unknown byte order " + in_quotes(field.value));
    layout_.order = order == "little" ? std::endian::little : std::endian::big;
  }

  VolumeFile read_samples() {
    const Field& field = require("encoding");
    const std::string encoding = to_lower(field.value);
    const bool text = encoding == "ascii" || encoding == "text" || encoding == "txt";
    const bool gzip = encoding == "gzip" || encoding == "gz";
    if (!text && !gzip && encoding != "raw")
      fail(field, fmt::format("unsupported encoding {}; known are raw, gzip and ascii", in_quotes(field.value)));
    if (!text) read_byte_order();
    std::size_t begin = 0;
    std::string_view data = locate_data(begin);
    const auto size = static_cast<std::size_t>(count_samples(layout_, name_)) * size_of(layout_.type);
    const std::int64_t skipped = skip("byte skip", "byteskip");
    if (gzip) return read_gzip(data, size, skipped);
    // -1 means that the samples are the last bytes of the file.
    if (skipped < 0 && data.size() < size) require_samples(layout_, data.size(), name_);
    const std::size_t front = skipped < 0 ? data.size() - size : static_cast<std::size_t>(skipped);
    if (front > data.size()) throw InputError(fmt::format("{}: the data end within the bytes to skip", name_));
    data.remove_prefix(front);
    return text ? decode_text(layout_, data, name_) : decode_binary(layout_, data, name_, begin + front);
  }

  VolumeFile read_gzip(std::string_view data, std::size_t size, std::int64_t skipped) {
    if (skipped < 0) throw InputError(fmt::format("{}: byte skip -1 needs raw data", name_));
    // No deflate stream holds more than 1032 times its size.
    const std::size_t most = 1032 * data.size();
    require_samples(layout_, most, name_);
    const auto front = static_cast<std::size_t>(skipped);
    if (front > most) throw InputError(fmt::format("{}: the data end within the bytes to skip", name_));
    const std::string raw = inflate(data, front + size, name_);
    return decode_binary(layout_, std::string_view(raw).substr(front), name_, front);
  }

  std::string_view bytes_;
  std::string_view name_;
  const DataLoader& data_;
  TextScanner scanner_;
  std::map<std::string, Field, std::less<>> fields_;
  std::map<std::string, Field, std::less<>> keys_;
  std::size_t data_begin_ = 0;
  std::string detached_;
  std::int64_t axes_ = 0;
  VolumeLayout layout_;
  std::vector<std::string> notices_;
};

}  // namespace

VolumeFile parse_nrrd(std::string_view bytes, std::string_view name, const DataLoader& data) {
  return NrrdReader(bytes, name, data).run();
}

std::string serialize_nrrd(const RawVolume& volume) {
  const auto vector = [](const Point& p) {
    return fmt::format("({},{},{})", format_real(p[0]), format_real(p[1]), format_real(p[2]));
  };
  const GridFrame& frame = volume.frame;
  const double size = frame.voxel_size;
  std::string bytes = "NRRD0004\n# written by voxcarve\n";
  bytes += volume.type == SampleType::kFloat32 ? "type: float\nendian: little\n" : "type: uint8\n";
  bytes +=
      fmt::format("dimension: 3\nspace dimension: 3\nsizes: {} {} {}\n", frame.dims[0], frame.dims[1], frame.dims[2]);
  bytes +=
      fmt::format("space directions: {} {} {}\n", vector({size, 0, 0}), vector({0, size, 0}), vector({0, 0, size}));
  bytes += "centers: cell cell cell\nkinds: domain domain domain\nencoding: raw\n";
  bytes += fmt::format("space origin: {}\n{}:={}\n\n", vector(frame.center(Index3::Zero())), kCornerKey,
                       vector(frame.origin));
  return bytes += volume.bytes;
}

}  // namespace voxcarve::volume_io
