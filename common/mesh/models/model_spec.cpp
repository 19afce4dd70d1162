#include "common/mesh/models/model_spec.h"

#include "common/run/text.h"

namespace voxcarve {

ModelSpec parse_model_spec(std::string_view spec) {
  const std::size_t question = spec.find('?');
  const std::string_view query = question == std::string_view::npos ? "" : spec.substr(question + 1);
  return {spec.substr(0, question), split(query, '&')};
}

}  // namespace voxcarve
