// The program `voxcarve`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "common/run/errors.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/session.h"

namespace {

/// One line, whatever a file name or an argument holds.
int fail(voxcarve::ExitCode code, std::string message) {
  std::ranges::replace_if(
      message, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  fmt::print(stderr, "voxcarve: {}\n", message);
  return static_cast<int>(code);
}

int run(int argc, char** argv) {
  CLI::App app("Compares voxel and carving approaches to simplifying the topology of meshes.", "voxcarve");
  app.set_version_flag("--version", "voxcarve " + voxcarve::version());
  app.require_subcommand(1);
  app.footer("Exit codes: 0 done, 2 usage, 3 bad input, 4 resource, 5 method failed, 130 cancelled.");
  voxcarve::add_methods_command(app);
  voxcarve::add_models_command(app);
  voxcarve::add_run_command(app);
  voxcarve::add_extract_command(app);
  voxcarve::add_measure_command(app);
  voxcarve::add_compare_command(app);
  voxcarve::add_render_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    return fail(voxcarve::ExitCode::kUsage, std::string(error.what()) + " (voxcarve --help)");
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    return fail(voxcarve::ExitCode::kResource, "cannot write to standard output");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  voxcarve::handle_interrupts();
  try {
    return run(argc, argv);
  } catch (const voxcarve::Error& error) {
    return fail(error.exit_code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(voxcarve::ExitCode::kResource, "memory ran out; lower the resolution or set --memory");
  } catch (const std::exception& error) {
    return fail(voxcarve::ExitCode::kMethod, std::string("internal error, please report it: ") + error.what());
  }
}
