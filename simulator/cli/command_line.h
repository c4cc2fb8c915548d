#pragma once
// The `rotunda-sim` command: a CLI11 application to which each command adds its own. To add one: write
// <name>_command.cpp, declare its add function here, call it in command_line.cpp.
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "simulator/people/performance.h"
#include "simulator/prepared_act.h"
#include "simulator/served_studio.h"

namespace rotunda::simulator {

struct CommandLine {
  CLI::App app{"rotunda-sim: synthetic people before virtual GigE Vision cameras", "rotunda-sim"};
  std::function<int(std::stop_token)> run;  // the chosen command; set by its callback
};

void add_serve_command(CommandLine& line);    // without a subcommand; also --scan and --list
void add_render_command(CommandLine& line);   // render
void add_layout_command(CommandLine& line);   // layout
void add_fault_command(CommandLine& line);    // fault
void add_gallery_command(CommandLine& line);  // gallery

// --person, --act, ...: what was given, over what a rig file or a default says.
struct PerformanceArguments {
  std::optional<std::string> person, act, motion;
  std::optional<std::uint32_t> seed;
  bool travel = false;
};
void add_performance_options(CLI::App& command, PerformanceArguments& arguments);
void apply(const PerformanceArguments& arguments, PerformanceOptions& options);

// --cache, --no-cache, --cache-size.
struct CacheArguments {
  std::optional<std::filesystem::path> folder;
  bool none = false;
  double gigabytes = 20.0;
};
void add_cache_options(CLI::App& command, CacheArguments& arguments);

// --cameras, --size, --aspect, ...: where cameras stand that no file places.
struct LayoutArguments {
  LayoutOptions layout;
  std::pair<int, int> size{720, 576};
  std::vector<double> aspect{1.0};  // above, below
  std::optional<double> radius, subject_height;
  bool whole_volume = false;
};
// `file`, `other_file`: options that say it instead.
void add_layout_options(CLI::App& command, LayoutArguments& arguments, CLI::Option* file = nullptr,
                        CLI::Option* other_file = nullptr);
// Goes through the volume.
bool travels(const PerformanceOptions& performance);
// For whom they look at: who travels needs them farther out, unless the arguments say where they stand.
LayoutOptions layout_of(const LayoutArguments& arguments, const PerformanceArguments& performance = {});

// --screen, --wear, --unevenness, --lateral-colour: what room and lenses are like.
struct StudioArguments {
  std::string screen;
  std::optional<double> wear, unevenness, lateral_colour_px;
};
void add_studio_options(CLI::App& command, StudioArguments& arguments);
void apply(const StudioArguments& arguments, ServedStudio& studio);

// A bar on the terminal, or lines in a pipe, for as long as the function lives.
AheadProgress progress_bar(const std::string& what);

ActOptions act_options(const ServedStudio& studio, const CacheArguments& cache, const std::stop_token& stop);

// Parses, runs and returns the exit code.
int run_rotunda_sim(int argc, const char* const* argv);

}  // namespace rotunda::simulator
