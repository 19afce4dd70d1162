#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/run/text.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"
#include "experiments/runner/table.h"
#include "methods/registry.h"

namespace voxcarve {

namespace {

std::string accepted_kinds(const MethodInfo& info) {
  std::vector<std::string> kinds;
  for (const ModelKind kind : info.accepts) kinds.emplace_back(to_string(kind));
  return join(kinds);
}

void list_methods(bool json) {
  if (json) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const Method* method : all_methods()) all.push_back(to_json(method->info()));
    print_json(all);
    return;
  }
  Table table{{"method", "kind", "source", "what it does"}, {}};
  for (const Method* method : all_methods()) {
    const MethodInfo& info = method->info();
    table.rows.push_back(
        {info.name, info.baseline ? "baseline" : "method", info.citation.empty() ? "-" : info.citation, info.summary});
  }
  fmt::print("{}", to_text(table));
}

void show_method(const MethodInfo& info, bool json) {
  if (json) {
    print_json(to_json(info));
    return;
  }
  fmt::print("{}: {}\n  source: {}\n  takes:  {}\n  gives:  {}\n", info.name, info.summary,
             info.citation.empty() ? "none" : info.citation + " (docs/bibliography.bib)", accepted_kinds(info),
             info.closed_manifold ? "a closed, oriented 2-manifold" : "a soup, whatever the input was");
  fmt::print("parameters{}\n{}", info.parameters.specs.empty() ? ": none" : "", schema_text(info.parameters));
}

}  // namespace

void add_methods_command(CLI::App& app) {
  struct Options {
    CommonOptions common;
    std::string name;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("methods", "list the methods, or one method's source, inputs and parameters");
  command->add_option("NAME", options->name, "a method");
  add_common_options(*command, options->common);
  command->callback([options] {
    if (options->name.empty()) {
      list_methods(options->common.json);
    } else {
      show_method(find_method(options->name).info(), options->common.json);
    }
  });
}

}  // namespace voxcarve
