#include "rig/client.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>

#include "config/errors.h"
#include "rig/messages.h"

namespace rotunda::rig {
namespace {

constexpr std::chrono::seconds kAnswerTime{10};
constexpr std::chrono::seconds kPictureTime{60};  // going live, a picture of every camera, blinking

// A daemon that comes back is found at once: gRPC's own patience between attempts grows to minutes. An attempt itself
// (gRPC's minimal reconnect time) may take a busy machine seconds.
std::shared_ptr<grpc::Channel> connect(const std::filesystem::path& socket) {
  constexpr int kFirst_ms = 200, kMost_ms = 1000, kAttempt_ms = 10000;
  constexpr int kMostBytes = 64 << 20;  // a live surface of the finest cells, with pictures
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirst_ms);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kAttempt_ms);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMost_ms);
  arguments.SetMaxReceiveMessageSize(kMostBytes);
  return grpc::CreateCustomChannel("unix:" + socket.string(), grpc::InsecureChannelCredentials(), arguments);
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
  std::mutex mutex;  // of what follows
  std::set<grpc::ClientContext*> calls;
  bool hung_up = false;

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

// A call that can be hung up on while it waits.
class RigClient::Call {
 public:
  explicit Call(Connection& connection) : connection_(connection) {
    const std::lock_guard lock(connection_.mutex);
    connection_.calls.insert(&context);
    if (connection_.hung_up) context.TryCancel();
  }
  Call(Connection& connection, std::chrono::seconds time) : Call(connection) {
    context.set_deadline(std::chrono::system_clock::now() + time);
  }
  ~Call() {
    const std::lock_guard lock(connection_.mutex);
    connection_.calls.erase(&context);
  }

  // Reads until `use` returns false or `stop` is asked.
  template <class Message, class Use>
  void read(grpc::ClientReader<Message>& stream, const Use& use, const std::stop_token& stop) {
    const std::stop_callback on_stop(stop, [&] { context.TryCancel(); });
    Message message;
    bool left = false;
    while (!left && stream.Read(&message)) left = !use(from_message(message));
    if (left) context.TryCancel();
    const auto status = stream.Finish();
    if (!left && !stop.stop_requested()) connection_.check(status);
  }

  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  grpc::ClientContext context;

 private:
  Connection& connection_;
};

RigClient::RigClient(const std::filesystem::path& socket) : connection_(std::make_unique<Connection>()) {
  connection_->socket = socket;
  connection_->stub = v1::Rig::NewStub(connect(socket));
}

void RigClient::hang_up() {
  const std::lock_guard lock(connection_->mutex);
  connection_->hung_up = true;
  for (auto* call : connection_->calls) call->TryCancel();
}

RigClient::~RigClient() = default;
RigClient::RigClient(RigClient&&) noexcept = default;

RigStatus RigClient::status() {
  Call call(*connection_, kAnswerTime);
  v1::Status answer;
  connection_->check(connection_->stub->GetStatus(&call.context, {}, &answer));
  return from_message(answer);
}

TakeProgress RigClient::start_take(const TakeRequest& request,
                                   const std::function<bool(const TakeProgress&)>& on_progress, std::stop_token stop) {
  Call call(*connection_);
  const auto stream = connection_->stub->StartTake(&call.context, to_message(request));
  // The stream ends by itself once the take is closed, so a stop request only has to ask for that.
  std::jthread stopper;
  const std::stop_callback on_stop(stop, [&] {
    stopper = std::jthread([this] {
      Call stopping(*connection_, kAnswerTime);
      v1::TakeProgress closed;
      connection_->stub->StopTake(&stopping.context, {}, &closed);
    });
  });
  v1::TakeProgress message;
  TakeProgress last;
  bool left = false;
  while (!left && stream->Read(&message)) {
    last = from_message(message);
    left = !on_progress(last) && !last.closed;
  }
  if (left) call.context.TryCancel();
  const auto status = stream->Finish();
  if (!left) connection_->check(status);
  return last;
}

TakeProgress RigClient::stop_take() {
  Call call(*connection_, std::chrono::seconds(60));  // a slow disk may still have seconds of frame sets to take
  v1::TakeProgress closed;
  connection_->check(connection_->stub->StopTake(&call.context, {}, &closed));
  return from_message(closed);
}

TakeProgress RigClient::annotate_take(const TakeAnnotation& annotation) {
  Call call(*connection_, kAnswerTime);
  v1::TakeProgress progress;
  connection_->check(connection_->stub->AnnotateTake(&call.context, to_message(annotation), &progress));
  return from_message(progress);
}

PlateReport RigClient::record_plate(std::uint64_t frame_sets) {
  Call call(*connection_, std::chrono::seconds(120));
  v1::RecordPlateRequest request;
  request.set_frame_sets(frame_sets);
  v1::PlateReport report;
  connection_->check(connection_->stub->RecordPlate(&call.context, request, &report));
  return from_message(report);
}

RigStatus RigClient::set_live(bool on) {
  Call call(*connection_, kAnswerTime);
  v1::SetLiveRequest request;
  request.set_on(on);
  v1::Status status;
  connection_->check(connection_->stub->SetLive(&call.context, request, &status));
  return from_message(status);
}

std::vector<IdentifiedCamera> RigClient::identify(const IdentifyRequest& request) {
  Call call(*connection_, kPictureTime);
  v1::IdentifyAnswer answer;
  connection_->check(connection_->stub->Identify(&call.context, to_message(request), &answer));
  return from_message(answer);
}

void RigClient::watch_live(bool pictures, const std::function<bool(LivePacket&&)>& on_packet, std::stop_token stop) {
  Call call(*connection_);
  v1::WatchLiveRequest request;
  request.set_pictures(pictures);
  call.read(*connection_->stub->WatchLive(&call.context, request), on_packet, stop);
}

void RigClient::watch_motion(const std::function<bool(MotionFrame&&)>& on_frame, std::stop_token stop) {
  Call call(*connection_);
  call.read(*connection_->stub->WatchMotion(&call.context, {}), on_frame, stop);
}

}  // namespace rotunda::rig
