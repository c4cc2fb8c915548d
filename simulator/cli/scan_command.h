#pragma once
// rotunda-sim --scan PERSON -o scan.ply
#include "simulator/cli/command_line.h"

namespace rotunda::simulator {

struct ScanArguments {
  std::string person, output, flaws;
  std::size_t triangles = 264'000;
};
void add_scan_options(CLI::App& app, ScanArguments& arguments);

// Writes the person in the A-pose; of `performance` only the seed counts.
int write_scan(const ScanArguments& arguments, const PerformanceArguments& performance);

}  // namespace rotunda::simulator
