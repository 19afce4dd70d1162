// PLY files: text, and binary in either byte order; any scalar types in any order. The format is described in
// [Turk, The PLY Polygon File Format, 1994].
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "common/mesh/io/formats.h"
#include "common/mesh/io/ply_header.h"
#include "common/mesh/io/soup_builder.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

/// Values of a text body. Every item begins on a new line and ends with it.
class TextBody {
 public:
  static constexpr std::string_view kPlaceUnit = "line";

  TextBody(std::string_view bytes, std::string_view name, const PlyHeader& header) : scanner_(bytes, name) {
    while (scanner_.line_number() < header.lines) scanner_.next_line();
  }

  void begin_element(const PlyElement& element) {
    scanner_.require_items(element.count, element.properties.size(), in_quotes(element.name) + " elements");
  }
  void begin_item(const PlyElement& element, std::int64_t item) {
    do {
      if (scanner_.next_line()) continue;
      scanner_.fail(
          fmt::format("the file ends after {} of {} {} elements", item, element.count, in_quotes(element.name)));
    } while (scanner_.peek().empty());
  }
  void end_item() {
    if (!scanner_.peek().empty()) scanner_.fail("unexpected " + in_quotes(scanner_.peek()) + " at the end of the line");
  }
  std::int64_t list_length(const PlyProperty& property) {
    const std::int64_t length = scanner_.integer(property.name);
    if (length < 0) scanner_.fail(fmt::format("list '{}' has length {}", property.name, length));
    return length;  // every value of it is looked for, so that a wrong length ends with the line
  }
  double real(const PlyProperty& property) { return scanner_.real(property.name); }
  std::int64_t integer(const PlyProperty& property) { return scanner_.integer(property.name); }
  std::size_t place() const { return scanner_.line_number(); }

 private:
  TextScanner scanner_;
};

/// Values of a binary body.
class BinaryBody {
 public:
  static constexpr std::string_view kPlaceUnit = "byte";

  BinaryBody(std::string_view bytes, std::string_view name, const PlyHeader& header)
      : bytes_(bytes),
        name_(name),
        offset_(header.size),
        order_(header.encoding == PlyEncoding::kBigEndian ? std::endian::big : std::endian::little) {}

  void begin_element(const PlyElement& element) {
    const std::size_t size = element.smallest_size();
    if (size > 0) require(element.count, size, in_quotes(element.name) + " elements");
  }
  void begin_item(const PlyElement&, std::int64_t) {}
  void end_item() {}

  std::int64_t list_length(const PlyProperty& property) {
    const std::size_t begin = offset_;
    const auto length = static_cast<std::int64_t>(next(*property.count_type));
    if (length < 0) fail(begin, fmt::format("list '{}' has length {}", property.name, length));
    require(length, size_of(property.type), fmt::format("values of list '{}'", property.name));
    return length;
  }
  double real(const PlyProperty& property) { return next(property.type); }
  std::int64_t integer(const PlyProperty& property) { return static_cast<std::int64_t>(next(property.type)); }
  std::size_t place() const { return offset_; }

 private:
  [[noreturn]] void fail(std::size_t offset, std::string_view message) const {
    throw InputError(name_, fmt::format("byte {}", offset), message);
  }

  void require(std::int64_t count, std::size_t size, std::string_view what) const {
    const std::size_t left = bytes_.size() - offset_;
    if (static_cast<std::uint64_t>(count) <= left / size) return;
    fail(offset_,
         fmt::format("{} {} announced, but only {} bytes follow; the file is truncated or its counts are wrong", count,
                     what, left));
  }

  template <class T>
  double take() {
    if (bytes_.size() - offset_ < sizeof(T)) fail(offset_, "the file ends within a value; it is truncated");
    const T value = load<T>(bytes_.data() + offset_, order_);
    offset_ += sizeof(T);
    return static_cast<double>(value);
  }

  /// Every type fits into a double exactly.
  double next(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return take<std::int8_t>();
      case PlyType::kUint8:
        return take<std::uint8_t>();
      case PlyType::kInt16:
        return take<std::int16_t>();
      case PlyType::kUint16:
        return take<std::uint16_t>();
      case PlyType::kInt32:
        return take<std::int32_t>();
      case PlyType::kUint32:
        return take<std::uint32_t>();
      case PlyType::kFloat32:
        return take<float>();
      case PlyType::kFloat64:
        return take<double>();
    }
    return 0;
  }

  std::string_view bytes_;
  std::string_view name_;
  std::size_t offset_;
  std::endian order_;
};

/// What a channel's value is divided by: integers are shares of their range, with 32-bit ones holding 8 bits.
double channel_scale(PlyType type) {
  if (is_real(type)) return 1;
  return size_of(type) == 2 ? 65535 : 255;
}

/// Reads one vertex or face after the other.
template <class Body>
class ElementReader {
 public:
  ElementReader(Body& body, SoupBuilder& builder, const PlyElement& element)
      : body_(body), builder_(builder), element_(element) {
    has_color_ = element.has(PlyRole::kRed) && element.has(PlyRole::kGreen) && element.has(PlyRole::kBlue);
  }

  void run() {
    body_.begin_element(element_);
    if (element_.properties.empty()) return;  // takes no bytes, whatever the count
    if (element_.name == "vertex") builder_.reserve_vertices(static_cast<std::size_t>(element_.count));
    for (std::int64_t item = 0; item < element_.count; ++item) {
      body_.begin_item(element_, item);
      place_ = body_.place();
      for (const PlyProperty& property : element_.properties) read(property);
      body_.end_item();
      finish_item();
    }
  }

 private:
  void read(const PlyProperty& property) {
    if (property.count_type) {
      read_list(property);
      return;
    }
    const std::size_t begin = body_.place();
    const double value = body_.real(property);
    switch (property.role) {
      case PlyRole::kX:
      case PlyRole::kY:
      case PlyRole::kZ:
        if (!std::isfinite(value)) builder_.fail(begin, fmt::format("coordinate '{}' is not finite", property.name));
        position_[static_cast<int>(property.role) - static_cast<int>(PlyRole::kX)] = value;
        return;
      case PlyRole::kRed:
      case PlyRole::kGreen:
      case PlyRole::kBlue:
        if (!std::isfinite(value)) builder_.fail(begin, fmt::format("colour '{}' is not finite", property.name));
        channels_[static_cast<int>(property.role) - static_cast<int>(PlyRole::kRed)] =
            value / channel_scale(property.type);
        return;
      case PlyRole::kSkipped:
      case PlyRole::kCorners:
        return;
    }
  }

  void read_list(const PlyProperty& property) {
    const std::int64_t length = body_.list_length(property);
    for (std::int64_t entry = 0; entry < length; ++entry) {
      if (property.role == PlyRole::kCorners) {
        const std::size_t begin = body_.place();
        builder_.add_corner(body_.integer(property), begin);
      } else {
        body_.real(property);
      }
    }
  }

  void finish_item() {
    std::optional<Color> color;
    if (has_color_) color = make_color(channels_[0], channels_[1], channels_[2]);
    if (element_.name == "vertex") builder_.add_vertex(position_, color);
    if (element_.name == "face") builder_.end_face(place_, color);
  }

  Body& body_;
  SoupBuilder& builder_;
  const PlyElement& element_;
  bool has_color_ = false;
  std::size_t place_ = 0;
  Point position_ = Point::Zero();
  Point channels_ = Point::Zero();
};

template <class Body>
TriangleSoup read_body(std::string_view bytes, std::string_view name, const PlyHeader& header) {
  Body body(bytes, name, header);
  SoupBuilder builder(name, Body::kPlaceUnit, 0);
  for (const PlyElement& element : header.elements) ElementReader<Body>(body, builder, element).run();
  return builder.finish();
}

}  // namespace

TriangleSoup parse_ply(std::string_view bytes, std::string_view name) {
  const PlyHeader header = parse_ply_header(bytes, name);
  if (header.encoding == PlyEncoding::kText) return read_body<TextBody>(bytes, name, header);
  return read_body<BinaryBody>(bytes, name, header);
}

}  // namespace voxcarve::mesh_io
