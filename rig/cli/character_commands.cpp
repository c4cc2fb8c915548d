// rotunda character build, show, edit: motion graphs out of takes.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "capture/take/take.h"
#include "config/errors.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "recon/motion/character.h"
#include "rig/cli/character_report.h"
#include "rig/cli/clip_choice.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct BuildArguments {
  std::vector<std::string> takes;
  fs::path output;
  recon::CharacterOptions options;
};

// What all names begin with, up to an underscore: "alex_" of alex_walk, alex_idle-walk.
std::string common_prefix(const std::vector<std::string>& names) {
  std::string prefix = names.front();
  for (const auto& name : names) {
    const auto differs = std::mismatch(prefix.begin(), prefix.end(), name.begin(), name.end()).first;
    prefix.erase(differs, prefix.end());
  }
  const auto underscore = prefix.rfind('_');
  return names.size() < 2 || underscore == std::string::npos ? "" : prefix.substr(0, underscore + 1);
}

// Of a geometry video's file nobody knows.
std::string rig_of(const CommandLine& line, const std::string& take) {
  return fs::is_regular_file(take) ? "" : capture::read_take_info(find_take(line, take)).rig;
}

// TAKE, or NAME=TAKE.
std::vector<recon::CharacterTake> chosen_takes(const CommandLine& line, const std::vector<std::string>& words) {
  std::vector<recon::CharacterTake> takes;
  std::vector<std::string> unnamed;
  for (const auto& word : words) {
    const auto equals = fs::exists(word) ? std::string::npos : word.find('=');
    const auto take = equals == std::string::npos ? word : word.substr(equals + 1);
    const auto video = find_video(line, take);
    auto stem = fs::is_regular_file(take) ? fs::path(take).stem().string() : fs::path(take).filename().string();
    if (equals == std::string::npos) unnamed.push_back(stem);
    takes.push_back({equals == std::string::npos ? "" : word.substr(0, equals), stem, video, rig_of(line, take)});
  }
  const auto prefix = unnamed.empty() ? "" : common_prefix(unnamed);
  for (auto& take : takes)
    if (take.name.empty()) take.name = take.take.substr(prefix.size());
  for (const auto& take : takes)
    if (take.name.empty() || take.name.find_first_of("/\\:{}[],#&*!|>'\"%@` ") != std::string::npos)
      throw InvalidInput(
          fmt::format("\"{}\" cannot be a clip's name; name it on the command line: NAME=TAKE", take.name));
  return takes;
}

int build(const CommandLine& line, const BuildArguments& arguments, std::stop_token stop) {
  auto options = arguments.options;
  options.name = fs::absolute(arguments.output).filename().string();
  options.stop = std::move(stop);
  recon::CharacterReport report;
  {
    Progress bar("character " + options.name);
    options.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
      bar.update(done, total, what);
    };
    report = recon::build_character(chosen_takes(line, arguments.takes), fs::absolute(arguments.output), options);
  }
  if (line.json) {
    auto told = graph_report(report.graph);
    told["told"] = report.told;
    fmt::print("{}\n", told.dump(2));
  } else {
    print_graph(report.graph);
    for (const auto& one : report.told) fmt::print("{}\n", one);
  }
  return kDone;
}

int edit(const CommandLine& line, const fs::path& character, bool check_only) {
  const auto file = recon::graph_of(character);
  if (!recon::is_character(character)) recon::open_character(character);  // says so
  const char* editor = std::getenv("EDITOR");
  if (!check_only && editor && *editor) {
    const auto command = fmt::format("{} '{}'", editor, file.string());
    if (file.string().find('\'') != std::string::npos || std::system(command.c_str()) != 0)
      throw InvalidInput(fmt::format(
          "the editor \"{}\" failed; change {} yourself, then: rotunda character edit --check", editor, file.string()));
  }
  const auto graph = recon::mend_character(character);
  if (line.json)
    fmt::print("{}\n", graph_report(graph).dump(2));
  else
    print_graph(graph);
  return kDone;
}

void add_build(CLI::App& parent, CommandLine& line) {
  auto arguments = std::make_shared<BuildArguments>();
  auto* app = parent.add_subcommand("build", "makes a character of one person's takes");
  app->add_option(
         "takes", arguments->takes,
         "reconstructed takes (or geometry videos) of states, such as walk, and transitions, such as walk-jog; "
         "NAME=TAKE gives another name than the take's")
      ->required();
  app->add_option("-o,--output", arguments->output, "the character's folder")->required();
  app->add_option("--blend", arguments->options.blend, "frames blended at a seam")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  app->footer(
      "Take names lose what they all begin with: alex_walk, alex_idle become walk, idle.\n"
      "Example:\n  rotunda character build -o alex alex_idle alex_walk alex_idle-walk alex_walk-idle");
  app->callback([&line, arguments] {
    line.run = [&line, arguments](std::stop_token stop) { return build(line, *arguments, std::move(stop)); };
  });
}

void add_show(CLI::App& parent, CommandLine& line) {
  auto shown = std::make_shared<ShownCharacter>();
  auto* app = parent.add_subcommand("show", "what a character can do, and what every seam costs");
  app->add_option("character", shown->folder, "its folder")->required();
  app->add_option("--picture", shown->picture, "draw the graph, with frames in its nodes (PNG)");
  app->add_option("--similarity", shown->similarity, "draw how alike all frames are, the seams ringed (PNG)");
  app->footer("Example:\n  rotunda character show alex --picture graph.png");
  app->callback(
      [&line, shown] { line.run = [&line, shown](std::stop_token) { return show_character(line, *shown); }; });
}

void add_edit(CLI::App& parent, CommandLine& line) {
  auto character = std::make_shared<fs::path>();
  auto check = std::make_shared<bool>(false);
  auto* app = parent.add_subcommand("edit", "opens graph.yaml in $EDITOR, checks it, works its seams out anew");
  app->add_option("character", *character, "its folder")->required();
  app->add_flag("--check", *check, "it was changed already: only check and work out");
  app->footer("Without EDITOR in the environment nothing is opened.\nExample:\n  rotunda character edit alex");
  app->callback([&line, character, check] {
    line.run = [&line, character, check](std::stop_token) { return edit(line, *character, *check); };
  });
}

}  // namespace

void add_character_commands(CommandLine& line) {
  auto* app = line.app.add_subcommand("character", "people who can be steered: motion graphs made of takes");
  app->require_subcommand(1);
  app->footer("Example:\n  rotunda character build -o alex alex_idle alex_walk alex_idle-walk alex_walk-idle");
  add_build(*app, line);
  add_show(*app, line);
  add_edit(*app, line);
}

}  // namespace rotunda::rig
