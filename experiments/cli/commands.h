// The commands of the program, one function each: it adds itself to the application and runs from a callback.
#pragma once

namespace CLI {
class App;
}

namespace voxcarve {

void add_methods_command(CLI::App& app);
void add_models_command(CLI::App& app);
void add_run_command(CLI::App& app);
void add_extract_command(CLI::App& app);
void add_measure_command(CLI::App& app);
void add_compare_command(CLI::App& app);
void add_render_command(CLI::App& app);

}  // namespace voxcarve
