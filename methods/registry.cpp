#include "methods/registry.h"

#include <memory>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"

// One line a method: X(f) stands for `std::unique_ptr<Method> f()`, defined in the method's own folder.
#define VOXCARVE_METHODS(X) \
  X(make_nooruddin_turk)    \
  X(make_he_lowpass)        \
  X(make_mason)             \
  X(make_hagbi_elsana)      \
  X(make_identity)          \
  X(make_qslim)             \
  X(make_dilate)            \
  X(make_erode)             \
  X(make_open)              \
  X(make_close)             \
  X(make_round)             \
  X(make_fillet)            \
  X(make_rf)                \
  X(make_fr)                \
  X(make_pair_collapse)     \
  X(make_vertex_clustering) \
  X(make_alpha_wrap)

namespace voxcarve {

#define VOXCARVE_DECLARE(make) std::unique_ptr<Method> make();
VOXCARVE_METHODS(VOXCARVE_DECLARE)
#undef VOXCARVE_DECLARE

const std::vector<const Method*>& all_methods() {
  static const std::vector<std::unique_ptr<Method>> kOwned = [] {
    std::vector<std::unique_ptr<Method>> owned;
#define VOXCARVE_MAKE(make) owned.push_back(make());
    VOXCARVE_METHODS(VOXCARVE_MAKE)
#undef VOXCARVE_MAKE
    return owned;
  }();
  static const std::vector<const Method*> kMethods = [] {
    std::vector<const Method*> methods;
    for (const auto& method : kOwned) methods.push_back(method.get());
    return methods;
  }();
  return kMethods;
}

const Method& find_method(std::string_view name) {
  std::vector<std::string> names;
  for (const Method* method : all_methods()) {
    if (method->info().name == name) return *method;
    names.push_back(method->info().name);
  }
  throw ParameterError("there is no method '" + std::string(name) + "'" + suggestion(name, names) +
                       " (voxcarve methods lists them)");
}

}  // namespace voxcarve
