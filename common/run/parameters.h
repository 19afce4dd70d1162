// Named, typed parameters, validated as a whole against a schema.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace voxcarve {

enum class ParameterType { kSwitch, kInteger, kReal, kReals, kChoice };

/// "switch", "integer", "real", "reals", "choice".
std::string_view to_string(ParameterType type);

/// A value of one parameter: switch (on, off), integer, real, one of the choices, or a list of reals.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

/// One line of a schema. Build it with the functions below.
struct ParameterSpec {
  std::string name;
  ParameterType type = ParameterType::kReal;
  std::string unit;  ///< "voxels", "diag" (share of the input's bounding-box diagonal), "triangles", ... or ""
  double minimum = -std::numeric_limits<double>::infinity();  ///< of integers and reals, inclusive
  double maximum = std::numeric_limits<double>::infinity();
  ParameterValue default_value;
  std::vector<std::string> choices;
  std::string help;  ///< one line

  static ParameterSpec toggle(std::string name, bool default_value, std::string help);
  static ParameterSpec integer(std::string name, std::string unit, std::int64_t minimum, std::int64_t maximum,
                               std::int64_t default_value, std::string help);
  static ParameterSpec real(std::string name, std::string unit, double minimum, double maximum, double default_value,
                            std::string help);
  /// One real or several, separated by commas; the limits hold for each.
  static ParameterSpec reals(std::string name, std::string unit, double minimum, double maximum,
                             std::vector<double> default_value, std::string help);
  static ParameterSpec choice(std::string name, std::vector<std::string> choices, std::string default_value,
                              std::string help);
};

class Parameters;

/// All parameters of a method or model, and an optional check of their combination.
struct ParameterSchema {
  std::vector<ParameterSpec> specs;
  std::function<void(const Parameters&)> check;  ///< throws ParameterError; may be empty

  const ParameterSpec* find(std::string_view name) const;
  std::vector<std::string> names() const;
};

/// A complete set of values for one schema: what was set, and the default for everything else.
class Parameters {
 public:
  Parameters() = default;

  /// Reads assignments "name=value" in order; a later one wins. Throws ParameterError for an unknown name (with the
  /// nearest known one), a value of the wrong type or out of range, or a combination that the schema's check refuses.
  /// `owner` names whose parameters they are in messages: "nooruddin-turk".
  static Parameters parse(const ParameterSchema& schema, std::span<const std::string> assignments,
                          std::string_view owner);
  static Parameters defaults(const ParameterSchema& schema);

  bool toggle(std::string_view name) const;
  std::int64_t integer(std::string_view name) const;
  double real(std::string_view name) const;
  const std::vector<double>& reals(std::string_view name) const;
  const std::string& choice(std::string_view name) const;
  bool has(std::string_view name) const;

  /// Every name and value in alphabetical order, "a=1 b=on": equal texts mean equal parameters.
  std::string canonical() const;
  const std::map<std::string, ParameterValue, std::less<>>& values() const { return values_; }

 private:
  const ParameterValue& at(std::string_view name) const;
  std::map<std::string, ParameterValue, std::less<>> values_;
};

/// The text of a value as `parse` reads it.
std::string to_string(const ParameterValue& value);

}  // namespace voxcarve
