#include "common/run/errors.h"

namespace voxcarve {

namespace {
std::string place(std::string_view file, std::string_view where, std::string_view message) {
  std::string text(file);
  if (!where.empty()) text.append(", ").append(where);
  return text.append(": ").append(message);
}
}  // namespace

InputError::InputError(std::string_view file, std::string_view where, std::string_view message)
    : InputError(place(file, where, message)) {}

}  // namespace voxcarve
