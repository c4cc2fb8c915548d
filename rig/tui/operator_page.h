#pragma once
// The operator's page: shows the daemon's status on this terminal and passes on what keys ask for.
#include <filesystem>
#include <stop_token>
#include <string>

namespace rotunda::rig {

// Until it is quit, told to stop, or its terminal goes away. Returns the name of the take that is still being recorded
// then, or nothing. Throws InvalidInput where there is no terminal.
std::string run_operator_page(const std::filesystem::path& daemon_socket, std::stop_token stop);

}  // namespace rotunda::rig
