#include "methods/hagbi_elsana/stream_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <string_view>

#include "common/run/atomic_file.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

constexpr std::string_view kMagic = "VOXCARVE";
constexpr std::uint32_t kVersion = 1;
constexpr std::uint64_t kHeader = 32;
constexpr std::uint64_t kChecksum = 4;
constexpr std::uint32_t kNone = Complement::kNone;

/// Sends bytes to a file, and keeps their checksum.
class Writer {
 public:
  explicit Writer(AtomicFile& file) : file_(file) {}

  template <class T>
  void put(T value) {
    append_little_endian(buffer_, value);
    if (buffer_.size() >= kBuffer) flush();
  }
  void put_text(std::string_view text) {
    buffer_.append(text);
    flush();
  }
  void finish() {
    flush();
    append_little_endian(buffer_, static_cast<std::uint32_t>(checksum_));
    file_.write(buffer_);
  }

 private:
  static constexpr std::size_t kBuffer = std::size_t{1} << 20;

  void flush() {
    checksum_ = crc32_z(checksum_, reinterpret_cast<const Bytef*>(buffer_.data()), buffer_.size());
    file_.write(buffer_);
    buffer_.clear();
  }

  AtomicFile& file_;
  std::string buffer_;
  uLong checksum_ = crc32_z(0, nullptr, 0);
};

/// Takes numbers from a file's bytes, whose length was checked.
class Reader {
 public:
  Reader(std::string_view bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  template <class T>
  T take() {
    const T value = load<T>(bytes_.data() + at_, std::endian::little);
    at_ += sizeof(T);
    return value;
  }
  template <class T, std::size_t N>
  void take_into(std::array<T, N>& values) {
    for (T& value : values) value = take<T>();
  }
  std::string take_text(std::size_t length) {
    const std::string text(bytes_.substr(at_, length));
    at_ += length;
    return text;
  }

 private:
  std::string_view bytes_;
  std::size_t at_;
};

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

/// Do two tetrahedra that name each other share that face, seen from either side?
bool fit_together(const Complement& mesh, std::uint32_t t, int i, std::uint32_t other) {
  const auto& back = mesh.neighbors[other];
  for (int j = 0; j < 4; ++j) {
    if (back[static_cast<std::size_t>(j)] != t) continue;
    const Triangle face = mesh.face(t, i);
    Triangle seen = mesh.face(other, j);
    std::swap(seen[0], seen[1]);  // counterclockwise from the first one's side
    for (int turn = 0; turn < 3; ++turn) {
      if (face == seen) return mesh.is_wall(t, i) == mesh.is_wall(other, j);
      std::ranges::rotate(seen, seen.begin() + 1);
    }
  }
  return false;
}

/// Whatever is not checked here could lead extraction astray.
std::string inconsistency(const Complement& mesh) {
  const auto points = static_cast<std::uint32_t>(mesh.points.size());
  for (const Point& point : mesh.points) {
    if (!point.allFinite()) return "a coordinate is not finite";
  }
  for (const std::uint32_t solid : mesh.solid_of_point) {
    if (solid != kNone && solid >= points) return "a point lies on a component that there is not";
  }
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const auto here = [&](const char* what) { return "tetrahedron " + std::to_string(t) + " " + what; };
    TetrahedronCorners corners = mesh.corners[t];
    const bool ghost = mesh.is_ghost(t);
    if (ghost != (corners[3] == Complement::kFar)) return here("is a ghost where it should be none, or the other way");
    for (std::size_t c = 0; c < (ghost ? 3U : 4U); ++c) {
      if (corners[c] >= points) return here("has a corner that is no point");
    }
    std::ranges::sort(corners);
    if (std::ranges::adjacent_find(corners) != corners.end()) return here("has a corner twice");
    if (mesh.walls[t] > 15 || (ghost && (mesh.walls[t] & 7) != 0)) return here("has walls that it cannot have");
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t other = mesh.neighbors[t][static_cast<std::size_t>(i)];
      if (other == Complement::kSolid && !(ghost && i < 3)) continue;
      if (other >= mesh.size() || other == t || !fit_together(mesh, t, i, other)) {
        return here("does not fit its neighbours");
      }
    }
  }
  return "";
}

}  // namespace

bool is_stream_file(const std::filesystem::path& path) {
  return to_lower(path.extension().string()) == ".vcs";
}

void write_stream(const CarvingStream& stream, const std::filesystem::path& path) {
  const Complement& mesh = stream.complement();
  AtomicFile file(path);
  Writer writer(file);
  writer.put_text(kMagic);
  for (const std::size_t number :
       {std::size_t{kVersion}, stream.provenance().size(), mesh.points.size(), std::size_t{mesh.model_points},
        mesh.corners.size(), std::size_t{mesh.first_ghost}}) {
    writer.put(static_cast<std::uint32_t>(number));
  }
  writer.put_text(stream.provenance());
  for (const Point& point : mesh.points) {
    for (const double coordinate : point) writer.put(coordinate);
  }
  for (const std::uint32_t solid : mesh.solid_of_point) writer.put(solid);
  for (const auto& corners : mesh.corners) {
    for (const std::uint32_t corner : corners) writer.put(corner);
  }
  for (const auto& around : mesh.neighbors) {
    for (const std::uint32_t neighbor : around) writer.put(neighbor);
  }
  for (const std::uint8_t walls : mesh.walls) writer.put(walls);
  for (std::uint32_t t = 0; t < mesh.first_ghost; ++t) writer.put(stream.steps()[t]);
  writer.finish();
  file.commit();
}

CarvingStream read_stream(const std::filesystem::path& path, RunContext& context) {
  const std::string bytes = read_file(path);
  if (!std::string_view(bytes).starts_with(kMagic)) refuse(path, "is no carving stream");
  if (bytes.size() < kHeader + kChecksum) refuse(path, "ends within its header");
  Reader reader(bytes, kMagic.size());
  const auto version = reader.take<std::uint32_t>();
  if (version != kVersion) {
    refuse(path, "is a carving stream of version " + std::to_string(version) + "; this program reads version " +
                     std::to_string(kVersion));
  }
  const auto provenance = reader.take<std::uint32_t>();
  const auto points = reader.take<std::uint32_t>();
  const auto model_points = reader.take<std::uint32_t>();
  const auto tetrahedra = reader.take<std::uint32_t>();
  const auto first_ghost = reader.take<std::uint32_t>();
  const std::uint64_t length = kHeader + provenance + std::uint64_t{28} * points + std::uint64_t{33} * tetrahedra +
                               std::uint64_t{4} * first_ghost + kChecksum;
  if (bytes.size() != length) {
    refuse(path, "holds " + std::to_string(bytes.size()) + " bytes where its header says " + std::to_string(length));
  }
  const uLong checksum =
      crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size() - kChecksum);
  if (load<std::uint32_t>(bytes.data() + bytes.size() - kChecksum, std::endian::little) != checksum) {
    refuse(path, "was altered: its checksum is not that of its bytes");
  }
  if (model_points > points || first_ghost > tetrahedra || first_ghost == tetrahedra) {
    refuse(path, "its header contradicts itself");
  }
  Stage stage(context, "reading the stream", 2);
  context.require_memory(bytes.size() * 2 + CarvingStream::memory(tetrahedra), "the carving stream");
  std::string text = reader.take_text(provenance);
  Complement mesh;
  mesh.model_points = model_points;
  mesh.first_ghost = first_ghost;
  mesh.points.resize(points);
  for (Point& point : mesh.points) {
    for (double& coordinate : point) coordinate = reader.take<double>();
  }
  mesh.solid_of_point.resize(points);
  for (std::uint32_t& solid : mesh.solid_of_point) solid = reader.take<std::uint32_t>();
  mesh.corners.resize(tetrahedra);
  for (auto& corners : mesh.corners) reader.take_into(corners);
  mesh.neighbors.resize(tetrahedra);
  for (auto& around : mesh.neighbors) reader.take_into(around);
  mesh.walls.resize(tetrahedra);
  for (std::uint8_t& walls : mesh.walls) walls = reader.take<std::uint8_t>();
  std::vector<std::uint32_t> step(tetrahedra, 0);
  for (std::uint32_t t = 0; t < first_ghost; ++t) step[t] = reader.take<std::uint32_t>();
  stage.advance(1);
  if (const std::string reason = inconsistency(mesh); !reason.empty()) refuse(path, reason);
  stage.advance(1);
  try {
    return CarvingStream(std::move(mesh), std::move(step), std::move(text), context);
  } catch (const InputError& error) {
    refuse(path, error.what());
  }
}

}  // namespace voxcarve
