#include "rig/client.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "config/errors.h"
#include "rig/messages.h"

namespace rotunda::rig {
namespace {

constexpr std::chrono::seconds kAnswerTime{10};

void set_deadline(grpc::ClientContext& context, std::chrono::seconds time) {
  context.set_deadline(std::chrono::system_clock::now() + time);
}

}  // namespace

std::filesystem::path daemon_socket(const std::filesystem::path& given) {
  if (!given.empty()) return std::filesystem::absolute(given);
  if (const char* socket = std::getenv("ROTUNDA_SOCKET"); socket && *socket) return std::filesystem::absolute(socket);
  if (const char* folder = std::getenv("XDG_RUNTIME_DIR"); folder && *folder)
    return std::filesystem::path(folder) / "rotunda.sock";
  return "/run/rotunda.sock";
}

struct RigClient::Connection {
  std::filesystem::path socket;
  std::unique_ptr<v1::Rig::Stub> stub;

  void check(const grpc::Status& status) const {
    if (status.ok()) return;
    if (status.error_code() == grpc::StatusCode::INVALID_ARGUMENT) throw InvalidInput(status.error_message());
    if (status.error_code() == grpc::StatusCode::UNAVAILABLE ||
        status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
      throw DeviceError("rotundad",
                        fmt::format("no daemon answers on {}; start it with: rotundad --rig RIG (or name its "
                                    "socket with --daemon)",
                                    socket.string()));
    throw DeviceError("rotundad", status.error_message());
  }
};

RigClient::RigClient(const std::filesystem::path& socket) : connection_(std::make_unique<Connection>()) {
  connection_->socket = socket;
  connection_->stub =
      v1::Rig::NewStub(grpc::CreateChannel("unix:" + socket.string(), grpc::InsecureChannelCredentials()));
}

RigClient::~RigClient() = default;
RigClient::RigClient(RigClient&&) noexcept = default;

RigStatus RigClient::status() {
  grpc::ClientContext context;
  set_deadline(context, kAnswerTime);
  v1::Status answer;
  connection_->check(connection_->stub->GetStatus(&context, {}, &answer));
  return from_message(answer);
}

TakeProgress RigClient::start_take(const TakeRequest& request,
                                   const std::function<bool(const TakeProgress&)>& on_progress, std::stop_token stop) {
  grpc::ClientContext context;
  const auto stream = connection_->stub->StartTake(&context, to_message(request));
  // The stream ends by itself once the take is closed, so a stop request only has to ask for that.
  std::jthread stopper;
  const std::stop_callback on_stop(stop, [&] {
    stopper = std::jthread([this] {
      grpc::ClientContext stopping;
      set_deadline(stopping, kAnswerTime);
      v1::TakeProgress closed;
      connection_->stub->StopTake(&stopping, {}, &closed);
    });
  });
  v1::TakeProgress message;
  TakeProgress last;
  bool left = false;
  while (!left && stream->Read(&message)) {
    last = from_message(message);
    left = !on_progress(last) && !last.closed;
  }
  if (left) context.TryCancel();
  const auto status = stream->Finish();
  if (!left) connection_->check(status);
  return last;
}

TakeProgress RigClient::stop_take() {
  grpc::ClientContext context;
  set_deadline(context, std::chrono::seconds(60));  // a slow disk may still have seconds of frame sets to take
  v1::TakeProgress closed;
  connection_->check(connection_->stub->StopTake(&context, {}, &closed));
  return from_message(closed);
}

TakeProgress RigClient::annotate_take(const TakeAnnotation& annotation) {
  grpc::ClientContext context;
  set_deadline(context, kAnswerTime);
  v1::TakeProgress progress;
  connection_->check(connection_->stub->AnnotateTake(&context, to_message(annotation), &progress));
  return from_message(progress);
}

PlateReport RigClient::record_plate(std::uint64_t frame_sets) {
  grpc::ClientContext context;
  set_deadline(context, std::chrono::seconds(120));
  v1::RecordPlateRequest request;
  request.set_frame_sets(frame_sets);
  v1::PlateReport report;
  connection_->check(connection_->stub->RecordPlate(&context, request, &report));
  return from_message(report);
}

RigStatus RigClient::set_live(bool on) {
  grpc::ClientContext context;
  set_deadline(context, kAnswerTime);
  v1::SetLiveRequest request;
  request.set_on(on);
  v1::Status status;
  connection_->check(connection_->stub->SetLive(&context, request, &status));
  return from_message(status);
}

}  // namespace rotunda::rig
