#pragma once
// rotunda-sim --faults, --control, and `rotunda-sim fault SOCKET REQUEST`
#include "simulator/cli/command_line.h"
#include "simulator/gige/fault_control.h"

namespace rotunda::simulator {

void add_fault_options(CLI::App& app, FaultControlOptions& options);  // --faults and --control
// Prints what fired, if faults were asked for or could be.
void tell_faults(const FaultControlOptions& options, const std::vector<GigeStats>& stats,
                 const std::vector<std::string>& cameras);

}  // namespace rotunda::simulator
