// rotunda take mark | note | circle | rename | trim: what is said of takes, and parts of them.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "capture/take/take_copy.h"
#include "capture/take/take_edit.h"
#include "config/exit_code.h"
#include "config/progress.h"
#include "rig/cli/command_line.h"
#include "rig/cli/frame_range.h"
#include "rig/client.h"

namespace rotunda::rig {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

int tell(const CommandLine& line, const json& answer, const std::string& words) {
  fmt::print("{}\n", line.json ? answer.dump(2) : words);
  return kDone;
}

int mark_moment(const CommandLine& line, const std::string& text) {
  const auto take = RigClient(daemon_socket(line.daemon)).annotate_take({.mark = text.empty() ? "mark" : text});
  return tell(line, {{"name", take.name}, {"marks", take.marks}},
              fmt::format("take {}: mark {} at frame set {}", take.name, take.marks, take.frame_sets));
}

// A take that is recorded belongs to its daemon; any other is edited where it lies.
int annotate(const CommandLine& line, const std::string& name, const TakeAnnotation& annotation) {
  const auto folder = find_take(line, name);
  const auto info = capture::read_take_info(folder);
  if (info.state == capture::TakeState::recording && !capture::is_interrupted(folder, info))
    RigClient(daemon_socket(line.daemon)).annotate_take(annotation);
  else
    capture::edit_take(folder, {.note = annotation.note, .circled = annotation.circled});
  json answer{{"name", info.name}};
  if (annotation.note) answer["note"] = *annotation.note;
  if (annotation.circled) answer["circled"] = *annotation.circled;
  const auto words = annotation.note       ? "note: " + *annotation.note
                     : *annotation.circled ? "circled"
                                           : "no longer circled";
  return tell(line, answer, fmt::format("take {}: {}", info.name, words));
}

int rename(const CommandLine& line, const std::string& name, const std::string& new_name) {
  const auto folder = capture::rename_take(find_take(line, name), new_name);
  return tell(line, {{"name", new_name}, {"folder", folder.string()}},
              fmt::format("take {} is now {}", name, folder.string()));
}

int trim(const CommandLine& line, const std::string& name, const std::string& range, const std::string& new_name,
         std::stop_token stop) {
  const auto folder = find_take(line, name);
  const capture::TakeReader take(folder);
  capture::TakeInfo info;
  {
    Progress bar("copying");
    info = capture::copy_take(
        take, {.folder = folder.parent_path() / new_name, .frame_sets = frame_range(range)},
        [&](std::size_t done, std::size_t total) { bar.update(done, total); }, std::move(stop));
  }
  tell(line, {{"name", info.name}, {"frame_sets", info.frame_sets}, {"complete", info.complete_sets}},
       fmt::format("take {}: {} frame sets of {}, which stays as it is", info.name, info.frame_sets, name));
  return info.complete_sets < info.frame_sets ? kDoneWithLoss : kDone;
}

void add_mark(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("mark", "marks this moment in the running take");
  auto text = std::make_shared<std::string>();
  app->add_option("text", *text, "what happened");
  app->footer("Example:\n  rotunda take mark 'slipped, second half is fine'");
  app->callback([&line, text] { line.run = [&line, text](std::stop_token) { return mark_moment(line, *text); }; });
}

void add_note(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("note", "changes a take's note, also while it is recorded");
  auto name = std::make_shared<std::string>(), text = std::make_shared<std::string>();
  app->add_option("take", *name, "a take's name in storage, or its path")->required();
  app->add_option("text", *text, "the note")->required();
  app->footer("Example:\n  rotunda take note demo 'the best of the morning'");
  app->callback([&line, name, text] {
    line.run = [&line, name, text](std::stop_token) { return annotate(line, *name, {.note = *text}); };
  });
}

void add_circle(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("circle", "circles a take: the one to use");
  auto name = std::make_shared<std::string>();
  auto off = std::make_shared<bool>(false);
  app->add_option("take", *name, "a take's name in storage, or its path")->required();
  app->add_flag("--off", *off, "no longer");
  app->footer("Example:\n  rotunda take circle demo");
  app->callback([&line, name, off] {
    line.run = [&line, name, off](std::stop_token) { return annotate(line, *name, {.circled = !*off}); };
  });
}

void add_rename(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("rename", "gives a take another name; never over another take");
  auto name = std::make_shared<std::string>(), new_name = std::make_shared<std::string>();
  app->add_option("take", *name, "a take's name in storage, or its path")->required();
  app->add_option("name", *new_name, "its new name")->required();
  app->footer("Example:\n  rotunda take rename take001 walk-anna");
  app->callback([&line, name, new_name] {
    line.run = [&line, name, new_name](std::stop_token) { return rename(line, *name, *new_name); };
  });
}

void add_trim(CLI::App& take, CommandLine& line) {
  auto* app = take.add_subcommand("trim", "makes a take of a part of another, bit for bit");
  auto name = std::make_shared<std::string>(), range = std::make_shared<std::string>(),
       new_name = std::make_shared<std::string>();
  app->add_option("take", *name, "a take's name in storage, or its path")->required();
  app->add_option("frames", *range, "A:B, half open")->required();
  app->add_option("-o", *new_name, "the new take's name")->required();
  app->footer(
      "Triggers and times stay as they were; the other take is only read.\n"
      "Example:\n  rotunda take trim demo 25:75 -o demo-kick");
  app->callback([&line, name, range, new_name] {
    line.run = [&line, name, range, new_name](std::stop_token stop) {
      return trim(line, *name, *range, *new_name, std::move(stop));
    };
  });
}

}  // namespace

void add_take_edit_commands(CLI::App& take, CommandLine& line) {
  add_mark(take, line);
  add_note(take, line);
  add_circle(take, line);
  add_rename(take, line);
  add_trim(take, line);
}

}  // namespace rotunda::rig
