#pragma once
// The faults of a running studio: schedules a script when it begins to serve, answers requests for more, and tells
// what fired. docs/simulator-faults.md has the requests and answers.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "simulator/gige/control_socket.h"
#include "simulator/gige/fault_script.h"
#include "simulator/gige/gige_studio.h"

namespace rotunda::simulator {

struct FaultControlOptions {
  std::filesystem::path script;  // none if empty
  std::filesystem::path socket;  // none if empty
};

class FaultControl {
 public:
  // Reads the script: throws as load_fault_script does. `cameras` are the studio's names, in its order.
  FaultControl(FaultControlOptions options, std::vector<std::string> cameras);

  // The script's times count from now on. Opens the socket: throws as ControlSocket does. `studio` is lent until this
  // is gone or stopped.
  void start(GigeStudio& studio);
  void stop();  // closes the socket

  const std::vector<std::string>& cameras() const { return cameras_; }

 private:
  FaultControlOptions options_;
  std::vector<std::string> cameras_;
  FaultScript script_;
  std::unique_ptr<ControlSocket> socket_;
};

// One JSON object: {"ok": true, ...} or {"ok": false, "error": "..."}. Never throws for a bad request.
std::string answer_fault_request(GigeStudio& studio, const std::vector<std::string>& cameras, const std::string& line);

// What fired, a line a camera: "cam03: packet_loss 41, silence 7"; "no fault fired" if none did.
std::string fault_summary(const std::vector<GigeStats>& stats, const std::vector<std::string>& cameras);

}  // namespace rotunda::simulator
