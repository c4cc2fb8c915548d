// rotunda take archive | restore: takes compressed without loss, and back.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/take/take_archive.h"
#include "capture/take/take_restore.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string last_name(const fs::path& folder) {
  const auto path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

void tell_archive(const capture::TakeArchiveResult& result, const fs::path& archive, double seconds) {
  const auto before = static_cast<double>(result.bytes_before), after = static_cast<double>(result.bytes_after);
  fmt::print(
      "{}: {} frames compressed in {:.1f} s, {:.1f} MB became {:.1f} MB ({:.0f} %)\n"
      "  the recorded files were made again from it and are the same, bit for bit\n"
      "  it is a take like any other (verify, recon, export); as it was recorded: rotunda take restore {}\n",
      archive.string(), result.frames, seconds, before / 1e6, after / 1e6, 100.0 * after / before, archive.string());
  if (result.damaged > 0)
    fmt::print("  {} of the frames were damaged before; they are kept as they are\n", result.damaged);
}

int archive(const CommandLine& line, const std::string& name, const fs::path& to, std::stop_token stop) {
  const auto take = find_take(line, name);
  const auto folder = to / last_name(take);
  const auto begun = std::chrono::steady_clock::now();
  capture::TakeArchiveResult result;
  {
    Progress bar("archiving");
    result = capture::archive_take(
        take, folder, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, std::move(stop));
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  if (line.json)
    fmt::print("{}\n", json{{"archive", folder.string()},
                            {"frames", result.frames},
                            {"damaged", result.damaged},
                            {"bytes_before", result.bytes_before},
                            {"bytes_after", result.bytes_after},
                            {"seconds", seconds}}
                           .dump(2));
  else
    tell_archive(result, folder, seconds);
  return result.damaged > 0 ? kDoneWithLoss : kDone;
}

int restore(const CommandLine& line, const std::string& name, const std::string& new_name, std::stop_token stop) {
  const auto from = find_take(line, name);
  const auto folder = takes_folder(line) / (new_name.empty() ? last_name(from) : new_name);
  capture::TakeInfo info;
  {
    Progress bar("restoring");
    info = capture::restore_take(
        from, folder, [&](std::size_t done, std::size_t total) { bar.update(done, total); }, std::move(stop));
  }
  if (line.json)
    fmt::print("{}\n", json{{"name", info.name}, {"folder", folder.string()}, {"frame_sets", info.frame_sets}}.dump(2));
  else
    fmt::print("take {}: every file as it was recorded, by its SHA-256\n  {}\n", info.name, folder.string());
  return kDone;
}

}  // namespace

void add_take_archive_commands(CLI::App& take, CommandLine& line) {
  auto to = std::make_shared<fs::path>();
  auto* app = add_on_take(
      take, line, "archive", "compresses a take without loss, checks it, and keeps the original",
      [&line, to](const std::string& name, std::stop_token stop) { return archive(line, name, *to, std::move(stop)); });
  app->add_option("--to", *to, "the folder that gets it, under the take's name")->required();
  app->footer(
      "FFV1, mosaics split into their four colours. Every frame is decoded again and compared before it counts.\n"
      "Example:\n  rotunda take archive demo --to /mnt/archive\n  rotunda recon /mnt/archive/demo");
  auto new_name = std::make_shared<std::string>();
  app = add_on_take(take, line, "restore", "an archived take as it was recorded, bit for bit",
                    [&line, new_name](const std::string& name, std::stop_token stop) {
                      return restore(line, name, *new_name, std::move(stop));
                    });
  app->add_option("-o", *new_name, "its name in storage; that of the archive if not given");
  app->footer(
      "Example:\n  rotunda take restore /mnt/archive/demo\n  rotunda take restore /mnt/archive/demo -o demo-again");
}

}  // namespace rotunda::rig
