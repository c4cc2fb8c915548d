#include "rig/daemon/rig_service.h"

#include <fcntl.h>
#include <grpcpp/grpcpp.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <atomic>

#include "config/errors.h"
#include "rig/messages.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

grpc::Status refusal() {
  try {
    throw;
  } catch (const InvalidInput& error) {
    return {grpc::StatusCode::INVALID_ARGUMENT, error.what()};
  } catch (const std::exception& error) {
    return {grpc::StatusCode::FAILED_PRECONDITION, error.what()};
  }
}

class RigService final : public v1::Rig::Service {
 public:
  explicit RigService(RigDaemon& daemon) : daemon_(daemon) {}
  void end_streams() { ending_ = true; }

  grpc::Status GetStatus(grpc::ServerContext*, const v1::StatusRequest*, v1::Status* answer) override {
    *answer = to_message(daemon_.status());
    return grpc::Status::OK;
  }

  grpc::Status StartTake(grpc::ServerContext* context, const v1::StartTakeRequest* request,
                         grpc::ServerWriter<v1::TakeProgress>* writer) override {
    try {
      const auto take = daemon_.start_take(from_message(*request));
      auto progress = take->progress();
      while (writer->Write(to_message(progress)) && !progress.closed && !context->IsCancelled() && !ending_)
        progress = take->wait_for_change(progress, 200ms);
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

  grpc::Status AnnotateTake(grpc::ServerContext*, const v1::AnnotateTakeRequest* request,
                            v1::TakeProgress* answer) override {
    try {
      *answer = to_message(daemon_.annotate_take(from_message(*request)));
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

  grpc::Status RecordPlate(grpc::ServerContext*, const v1::RecordPlateRequest* request,
                           v1::PlateReport* answer) override {
    try {
      *answer = to_message(daemon_.record_plate(request->frame_sets()));
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

  grpc::Status SetLive(grpc::ServerContext*, const v1::SetLiveRequest* request, v1::Status* answer) override {
    try {
      daemon_.set_live(request->on());
      *answer = to_message(daemon_.status());
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

  grpc::Status WatchLive(grpc::ServerContext* context, const v1::WatchLiveRequest* request,
                         grpc::ServerWriter<v1::LivePacket>* writer) override {
    auto* surfaces = daemon_.surfaces();
    if (!surfaces) return {grpc::StatusCode::FAILED_PRECONDITION, "this daemon makes no live surfaces (--no-surfaces)"};
    LiveViewer viewer(*surfaces, request->pictures());
    while (!context->IsCancelled() && !ending_)
      if (const auto packet = viewer.next(200ms); packet && !writer->Write(to_message(*packet))) break;
    return grpc::Status::OK;
  }

  grpc::Status WatchMotion(grpc::ServerContext* context, const v1::WatchMotionRequest*,
                           grpc::ServerWriter<v1::MotionFrame>* writer) override {
    if (!daemon_.surfaces())
      return {grpc::StatusCode::FAILED_PRECONDITION,
              "this daemon keys nothing while cameras run (--no-surfaces), which motion capture needs"};
    constexpr int kSilence = 10;  // turns, then it says why nothing comes
    MotionWatcher watcher(daemon_.mocap());
    for (int turns = 1; !context->IsCancelled() && !ending_; ++turns) {
      const auto frame = watcher.next(200ms);
      if (!frame && (turns < kSilence || daemon_.mocap().is_fed())) continue;
      turns = 0;
      if (!writer->Write(frame ? to_message(*frame) : to_message(nothing_to_follow()))) break;
    }
    return grpc::Status::OK;
  }

  grpc::Status Identify(grpc::ServerContext*, const v1::IdentifyRequest* request, v1::IdentifyAnswer* answer) override {
    try {
      *answer = to_message(daemon_.identify(from_message(*request)));
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

  grpc::Status StopTake(grpc::ServerContext*, const v1::StopTakeRequest*, v1::TakeProgress* answer) override {
    try {
      *answer = to_message(daemon_.stop_take());
      return grpc::Status::OK;
    } catch (...) {
      return refusal();
    }
  }

 private:
  MotionFrame nothing_to_follow() const {
    MotionFrame frame;
    frame.exposure = frame.made = capture::RigClock::now();
    const auto problem = daemon_.surfaces()->status().problem;
    frame.motion.why = problem.empty() ? "no frame sets come; have the cameras triggered: rotunda rig live" : problem;
    return frame;
  }

  RigDaemon& daemon_;
  std::atomic<bool> ending_ = false;
};

capture::UniqueFd lock_file(const std::filesystem::path& socket) {
  const auto file = socket.string() + ".lock";
  capture::UniqueFd lock(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!lock) throw DeviceError("rotundad", "cannot make " + file + "; name another socket with --socket");
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw DeviceError("rotundad",
                      "another daemon serves " + socket.string() + "; stop it, or give this one its own with --socket");
  return lock;
}

}  // namespace

SocketLock::SocketLock(std::filesystem::path socket) : socket_(std::move(socket)), file_(lock_file(socket_)) {}

struct RigServer::Parts {
  RigService service;
  std::unique_ptr<grpc::Server> server;
};

RigServer::RigServer(RigDaemon& daemon, const SocketLock& lock) : parts_(new Parts{RigService(daemon), nullptr}) {
  const auto& socket = lock.socket();
  grpc::ServerBuilder builder;
  builder.AddListeningPort("unix:" + socket.string(), grpc::InsecureServerCredentials());
  builder.RegisterService(&parts_->service);
  const auto before = umask(0077);
  parts_->server = builder.BuildAndStart();
  umask(before);
  if (!parts_->server) throw DeviceError("rotundad", "cannot listen on " + socket.string());
}

RigServer::~RigServer() {
  parts_->service.end_streams();
  parts_->server->Shutdown(std::chrono::system_clock::now() + 2s);
}

}  // namespace rotunda::rig
