#include "common/run/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

template <class Number>
std::optional<Number> read_number(std::string_view text) {
  Number value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string range_text(const ParameterSpec& spec) {
  const std::string low = std::isinf(spec.minimum) ? "" : " of at least " + format_real(spec.minimum);
  const std::string high = std::isinf(spec.maximum) ? "" : " and at most " + format_real(spec.maximum);
  const std::string kind = spec.type == ParameterType::kInteger ? "an integer"
                           : spec.type == ParameterType::kReals ? "real numbers, separated by commas, each"
                                                                : "a real number";
  return kind + low + high + (spec.unit.empty() ? "" : " (" + spec.unit + ")");
}

std::optional<double> read_real(const ParameterSpec& spec, std::string_view text) {
  const auto value = read_number<double>(text);
  if (!value || !std::isfinite(*value) || *value < spec.minimum || *value > spec.maximum) return std::nullopt;
  return value;
}

/// One real or several, separated by commas; nothing when one does not fit.
std::optional<ParameterValue> read_reals(const ParameterSpec& spec, std::string_view text) {
  std::vector<double> values;
  for (;;) {
    const std::size_t comma = text.find(',');
    const auto value = read_real(spec, text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    text.remove_prefix(comma + 1);
  }
}

/// The value that `text` means for `spec`, or nothing when it does not fit.
std::optional<ParameterValue> read_value(const ParameterSpec& spec, std::string_view text) {
  switch (spec.type) {
    case ParameterType::kSwitch:
      if (text == "on" || text == "true" || text == "1") return true;
      if (text == "off" || text == "false" || text == "0") return false;
      return std::nullopt;
    case ParameterType::kInteger: {
      const auto value = read_number<std::int64_t>(text);
      if (!value || static_cast<double>(*value) < spec.minimum || static_cast<double>(*value) > spec.maximum)
        return std::nullopt;
      return *value;
    }
    case ParameterType::kReal: {
      const auto value = read_real(spec, text);
      if (!value) return std::nullopt;
      return *value;
    }
    case ParameterType::kReals:
      return read_reals(spec, text);
    case ParameterType::kChoice:
      if (std::ranges::find(spec.choices, text) == spec.choices.end()) return std::nullopt;
      return std::string(text);
  }
  return std::nullopt;
}

std::string expectation(const ParameterSpec& spec) {
  switch (spec.type) {
    case ParameterType::kSwitch:
      return "on or off";
    case ParameterType::kChoice:
      return "one of " + join(spec.choices);
    default:
      return range_text(spec);
  }
}

}  // namespace

std::string_view to_string(ParameterType type) {
  switch (type) {
    case ParameterType::kSwitch:
      return "switch";
    case ParameterType::kInteger:
      return "integer";
    case ParameterType::kReal:
      return "real";
    case ParameterType::kReals:
      return "reals";
    case ParameterType::kChoice:
      return "choice";
  }
  return "";
}

std::string to_string(const ParameterValue& value) {
  if (const auto* on = std::get_if<bool>(&value)) return *on ? "on" : "off";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* real = std::get_if<double>(&value)) return format_real(*real);
  if (const auto* reals = std::get_if<std::vector<double>>(&value)) {
    std::vector<std::string> texts;
    for (const double real : *reals) texts.push_back(format_real(real));
    return join(texts, ",");
  }
  return std::get<std::string>(value);
}

ParameterSpec ParameterSpec::toggle(std::string name, bool default_value, std::string help) {
  ParameterSpec spec;
  spec.name = std::move(name);
  spec.type = ParameterType::kSwitch;
  spec.default_value = default_value;
  spec.choices = {"off", "on"};
  spec.help = std::move(help);
  return spec;
}

ParameterSpec ParameterSpec::integer(std::string name, std::string unit, std::int64_t minimum, std::int64_t maximum,
                                     std::int64_t default_value, std::string help) {
  ParameterSpec spec;
  spec.name = std::move(name);
  spec.type = ParameterType::kInteger;
  spec.unit = std::move(unit);
  spec.minimum = static_cast<double>(minimum);
  spec.maximum = static_cast<double>(maximum);
  spec.default_value = default_value;
  spec.help = std::move(help);
  return spec;
}

ParameterSpec ParameterSpec::real(std::string name, std::string unit, double minimum, double maximum,
                                  double default_value, std::string help) {
  ParameterSpec spec;
  spec.name = std::move(name);
  spec.type = ParameterType::kReal;
  spec.unit = std::move(unit);
  spec.minimum = minimum;
  spec.maximum = maximum;
  spec.default_value = default_value;
  spec.help = std::move(help);
  return spec;
}

ParameterSpec ParameterSpec::reals(std::string name, std::string unit, double minimum, double maximum,
                                   std::vector<double> default_value, std::string help) {
  ParameterSpec spec = real(std::move(name), std::move(unit), minimum, maximum, 0, std::move(help));
  spec.type = ParameterType::kReals;
  spec.default_value = std::move(default_value);
  return spec;
}

ParameterSpec ParameterSpec::choice(std::string name, std::vector<std::string> choices, std::string default_value,
                                    std::string help) {
  ParameterSpec spec;
  spec.name = std::move(name);
  spec.type = ParameterType::kChoice;
  spec.choices = std::move(choices);
  spec.default_value = std::move(default_value);
  spec.help = std::move(help);
  return spec;
}

const ParameterSpec* ParameterSchema::find(std::string_view name) const {
  const auto found = std::ranges::find(specs, name, &ParameterSpec::name);
  return found == specs.end() ? nullptr : &*found;
}

std::vector<std::string> ParameterSchema::names() const {
  std::vector<std::string> all;
  for (const ParameterSpec& spec : specs) all.push_back(spec.name);
  return all;
}

Parameters Parameters::defaults(const ParameterSchema& schema) {
  Parameters parameters;
  for (const ParameterSpec& spec : schema.specs) parameters.values_[spec.name] = spec.default_value;
  return parameters;
}

Parameters Parameters::parse(const ParameterSchema& schema, std::span<const std::string> assignments,
                             std::string_view owner) {
  Parameters parameters = defaults(schema);
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
      throw ParameterError("'" + assignment + "' is not of the form name=value");
    }
    const std::string name = assignment.substr(0, equals);
    const std::string text = assignment.substr(equals + 1);
    const ParameterSpec* spec = schema.find(name);
    if (spec == nullptr) {
      throw ParameterError(std::string(owner) + " has no parameter '" + name + "'" + suggestion(name, schema.names()));
    }
    const auto value = read_value(*spec, text);
    if (!value) {
      throw ParameterError(std::string(owner) + ": " + name + "=" + text + " must be " + expectation(*spec));
    }
    parameters.values_[name] = *value;
  }
  if (schema.check) schema.check(parameters);
  return parameters;
}

const ParameterValue& Parameters::at(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) throw ParameterError("parameter '" + std::string(name) + "' is not in the schema");
  return found->second;
}

bool Parameters::toggle(std::string_view name) const {
  return std::get<bool>(at(name));
}
std::int64_t Parameters::integer(std::string_view name) const {
  return std::get<std::int64_t>(at(name));
}
double Parameters::real(std::string_view name) const {
  return std::get<double>(at(name));
}
const std::vector<double>& Parameters::reals(std::string_view name) const {
  return std::get<std::vector<double>>(at(name));
}
const std::string& Parameters::choice(std::string_view name) const {
  return std::get<std::string>(at(name));
}
bool Parameters::has(std::string_view name) const {
  return values_.find(name) != values_.end();
}

std::string Parameters::canonical() const {
  std::string text;
  for (const auto& [name, value] : values_) {
    if (!text.empty()) text += ' ';
    text += name + "=" + to_string(value);
  }
  return text;
}

}  // namespace voxcarve
