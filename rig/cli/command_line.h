#pragma once
// The `rotunda` command: a CLI11 application to which each family of commands adds its own. To add a family: write
// <family>_commands.cpp, declare its add function here, call it in command_line.cpp.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <stop_token>
#include <string>

namespace rotunda::rig {

struct CommandLine {
  CLI::App app{"Rotunda: capture rigs, takes, and free-viewpoint films made of them", "rotunda"};
  bool json = false;
  std::filesystem::path takes;              // --takes
  std::filesystem::path daemon;             // --daemon
  std::function<int(std::stop_token)> run;  // the chosen command; set by its callback
};

void add_rig_commands(CommandLine& line);                           // rig, cameras
void add_status_command(CLI::App& parent, CommandLine& line);       // status
void add_live_command(CLI::App& rig, CommandLine& line);            // rig live
void add_identify_command(CLI::App& cameras, CommandLine& line);    // cameras identify
void add_take_commands(CommandLine& line);                          // take ...
void add_take_edit_commands(CLI::App& take, CommandLine& line);     // take mark, note, circle, rename, trim
void add_take_check_commands(CLI::App& take, CommandLine& line);    // take verify, recover
void add_take_archive_commands(CLI::App& take, CommandLine& line);  // take archive, restore
void add_plate_command(CommandLine& line);                          // plate
void add_board_command(CommandLine& line);                          // board
void add_calibrate_command(CommandLine& line);                      // calibrate
void add_screen_command(CommandLine& line);                         // screen
void add_recon_commands(CommandLine& line);                         // recon, map
void add_mocap_command(CommandLine& line);                          // mocap
void add_render_command(CommandLine& line);                         // render
void add_play_commands(CommandLine& line);                          // play, show
void add_character_commands(CommandLine& line);                     // character ...
void add_export_command(CommandLine& line);                         // export
void add_animate_command(CommandLine& line);                        // animate
void add_doctor_command(CommandLine& line);                         // doctor
void add_tui_command(CommandLine& line);                            // tui

// Adds a command that works on one take given by name or path.
CLI::App* add_on_take(CLI::App& take, CommandLine& line, const std::string& command, const std::string& what,
                      std::function<int(const std::string&, std::stop_token)> work);

// Where takes lie: --takes, else ROTUNDA_TAKES, else the running daemon's, else ./takes.
std::filesystem::path takes_folder(const CommandLine& line);
// A take by path or by name in storage. Throws InvalidInput that lists where it looked and which takes are there.
std::filesystem::path find_take(const CommandLine& line, const std::string& take);

// Accepts "4s", "500ms", "2min", "1h"; plain numbers are seconds.
CLI::AsNumberWithUnit seconds();
// Accepts "10mm", "1cm", "0.01m"; plain numbers are metres.
CLI::AsNumberWithUnit metres();

// Parses, runs and returns the exit code.
int run_rotunda(int argc, const char* const* argv);

}  // namespace rotunda::rig
