#include "experiments/cli/json_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/run/text.h"

namespace voxcarve {

using Json = nlohmann::ordered_json;

Json to_json(const std::vector<Measurement>& measurements) {
  Json json = Json::object();
  Json undefined = Json::object();
  for (const Measurement& measurement : measurements) {
    Json* place = &json;
    for (const std::string& part : split(measurement.key, '.')) place = &(*place)[part];
    if (const auto* reason = std::get_if<Undefined>(&measurement.value)) {
      *place = nullptr;
      undefined[measurement.key] = reason->reason;
    } else {
      std::visit(
          [&](const auto& value) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, Undefined>) *place = value;
          },
          measurement.value);
    }
  }
  if (!undefined.empty()) json["undefined"] = undefined;
  return json;
}

Json to_json(const ParameterValue& value) {
  return std::visit([](const auto& held) { return Json(held); }, value);
}

Json to_json(const ParameterSchema& schema) {
  Json json = Json::array();
  for (const ParameterSpec& spec : schema.specs) {
    Json item = {{"name", spec.name}, {"type", to_string(spec.type)}, {"unit", spec.unit}};
    if (!spec.choices.empty()) item["choices"] = spec.choices;
    if (std::isfinite(spec.minimum)) item["minimum"] = spec.minimum;
    if (std::isfinite(spec.maximum)) item["maximum"] = spec.maximum;
    item["default"] = to_json(spec.default_value);
    item["help"] = spec.help;
    json.push_back(item);
  }
  return json;
}

Json to_json(const Parameters& parameters) {
  Json json = Json::object();
  for (const auto& [name, value] : parameters.values()) json[name] = to_json(value);
  return json;
}

Json to_json(const MethodInfo& info) {
  Json kinds = Json::array();
  for (const ModelKind kind : info.accepts) kinds.push_back(to_string(kind));
  return {{"name", info.name},
          {"summary", info.summary},
          {"citation", info.citation},
          {"accepts", kinds},
          {"baseline", info.baseline},
          {"closed_manifold", info.closed_manifold},
          {"parameters", to_json(info.parameters)}};
}

Json to_json(const std::vector<StageTiming>& timings) {
  Json json = Json::array();
  for (const StageTiming& timing : timings) {
    json.push_back(
        {{"stage", timing.stage}, {"seconds", timing.seconds}, {"items", timing.items}, {"bytes", timing.bytes}});
  }
  return json;
}

std::string schema_text(const ParameterSchema& schema) {
  std::string text;
  for (const ParameterSpec& spec : schema.specs) {
    std::string domain;
    if (!spec.choices.empty()) {
      domain = join(spec.choices, "|");
    } else {
      domain =
          fmt::format("{} .. {}", format_real(spec.minimum), std::isinf(spec.maximum) ? "" : format_real(spec.maximum));
    }
    text +=
        fmt::format("  {:<14} {:<28} default {:<10} {}{}\n", spec.name,
                    domain + (spec.unit.empty() ? "" : " " + spec.unit), to_string(spec.default_value), spec.help, "");
  }
  return text;
}

}  // namespace voxcarve
