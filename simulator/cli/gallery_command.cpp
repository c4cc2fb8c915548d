// rotunda-sim gallery
#include <fmt/format.h>

#include "config/exit_code.h"
#include "simulator/cli/command_line.h"
#include "simulator/gallery.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {

void add_gallery_command(CommandLine& line) {
  auto* command = line.app.add_subcommand("gallery", "write sheets of pictures of people and acts");
  command->footer("Example:\n  rotunda-sim gallery --act walk,jog -o pictures");
  const auto options = std::make_shared<GalleryOptions>();
  const auto output = std::make_shared<std::string>();
  options->people = person_names();
  options->acts = act_names();
  command->add_option("--person", options->people, "whom (all)")->delimiter(',');
  command->add_option("--act", options->acts, "what (all acts)")->delimiter(',');
  command->add_option("-o,--output", *output, "folder to write")->required();
  command->callback([&line, options, output] {
    line.run = [=](const std::stop_token&) -> int {
      write_gallery(*output, *options, [](const std::string& person) { fmt::print(stderr, "{}\n", person); });
      return kDone;
    };
  });
}

}  // namespace rotunda::simulator
