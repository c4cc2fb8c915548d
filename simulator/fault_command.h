#pragma once
// What rotunda-sim's command line says of faults.
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "simulator/gige/fault_control.h"
#include "simulator/served_studio.h"

namespace rotunda::simulator {

void add_fault_options(CLI::App& app, FaultControlOptions& options);  // --faults and --control
std::vector<std::string> camera_names(const ServedStudio& studio);    // as fault files write them
// Prints what fired, if faults were asked for or could be.
void tell_faults(const FaultControlOptions& options, const std::vector<GigeStats>& stats,
                 const std::vector<std::string>& cameras);

// `rotunda-sim fault SOCKET REQUEST`
struct FaultQuestion {
  std::string socket, request;
};
CLI::App* add_fault_command(CLI::App& app, FaultQuestion& question);
int ask(const FaultQuestion& question);  // prints the answer; the exit code
}  // namespace rotunda::simulator
