// JSON of what the library speaks of.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/run/context.h"
#include "common/run/parameters.h"
#include "methods/method.h"
#include "metrics/metric.h"

namespace voxcarve {

/// Measurements as nested objects, by the dots in their keys. A value that is undefined is null, and its reason stands
/// under the same key in the object "undefined".
nlohmann::ordered_json to_json(const std::vector<Measurement>& measurements);

nlohmann::ordered_json to_json(const ParameterValue& value);
nlohmann::ordered_json to_json(const ParameterSchema& schema);
nlohmann::ordered_json to_json(const Parameters& parameters);
nlohmann::ordered_json to_json(const MethodInfo& info);
nlohmann::ordered_json to_json(const std::vector<StageTiming>& timings);

/// A schema for reading: one line a parameter, indented.
std::string schema_text(const ParameterSchema& schema);

}  // namespace voxcarve
