// rotunda-sim layout
#include "capture/calibration_file.h"
#include "config/exit_code.h"
#include "simulator/cli/command_line.h"

namespace rotunda::simulator {

void add_layout_command(CommandLine& line) {
  auto* command = line.app.add_subcommand("layout", "write the calibration of a simulated studio");
  command->footer("Example:\n  rotunda-sim layout --cameras 10 --size 1280x960 -o calibration.yaml");
  const auto layout = std::make_shared<LayoutArguments>();
  const auto output = std::make_shared<std::string>();
  add_layout_options(*command, *layout);
  command->add_option("-o,--output", *output, "file to write")->required();
  command->callback([&line, layout, output] {
    line.run = [=](const std::stop_token&) {
      capture::write_calibration(*output, camera_layout(layout_of(*layout)));
      return kDone;
    };
  });
}

}  // namespace rotunda::simulator
