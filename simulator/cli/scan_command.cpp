#include "simulator/cli/scan_command.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/exit_code.h"
#include "recon/mesh/mesh_file.h"
#include "simulator/people/person.h"
#include "simulator/scan/scan.h"

namespace rotunda::simulator {

void add_scan_options(CLI::App& app, ScanArguments& arguments) {
  auto* scan = app.add_option("--scan", arguments.person, "write a dense coloured scan of this person in the A-pose");
  auto* output = app.add_option("-o,--output", arguments.output, "the scan's file, PLY")->needs(scan);
  app.add_option("--triangles", arguments.triangles, "of the scan (264000)")
      ->check(CLI::Range(1000, 20'000'000))
      ->needs(scan);
  app.add_option("--flaws", arguments.flaws, "a real scanner's: noise,holes,misaligned-partials")->needs(scan);
  scan->needs(output);
}

int write_scan(const ScanArguments& arguments, const PerformanceArguments& performance) {
  const ScanOptions options{.triangles = arguments.triangles,
                            .flaws = scan_flaws_from(arguments.flaws),
                            .seed = performance.seed.value_or(1)};
  const auto ours = person_names();
  const bool is_ours = std::find(ours.begin(), ours.end(), arguments.person) != ours.end();
  const auto person = make_performance({.person = arguments.person, .act = is_ours ? "a-pose" : ""});  // a file's rest
  const auto scan = scan_of(person->surfaces_at(0.0).front(), person->figures().front().texture, options);
  recon::write_ply(arguments.output, scan);
  fmt::print("{}: {} triangles, {} vertices\n", arguments.output, scan.triangles.size(), scan.positions.size());
  return kDone;
}

}  // namespace rotunda::simulator
